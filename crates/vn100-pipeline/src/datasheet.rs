//! A data sheet's noise figures, and what a measurement says of them.

use std::f64::consts::{LN_2, PI};

use imu_noise::{Claim, Parameter, Sensor, StreamFactor, Term, Verdict};

use crate::{
    assessment::{Assessment, ChannelAssessment, Onboard},
    figure::Figure,
    snapshot::Snapshot,
};

/// What a maker says of a sensor's noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Datasheet {
    /// The sensor.
    pub name: String,
    /// How far the figures can be trusted.
    pub note: Option<String>,
    /// Its figures.
    pub figures: Vec<DatasheetFigure>,
}

/// One figure of a data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasheetFigure {
    /// The kind of sensor.
    pub sensor: Sensor,
    /// The parameter.
    pub term: Term,
    /// What is claimed, in SI units.
    pub claim: Claim,
    /// The figure is the minimum of the Allan deviation, not divided by 0.664: what most sheets call bias instability.
    pub is_minimum: bool,
    /// The figure as printed, such as `typical 0.0035 deg/s/sqrt(Hz)`.
    pub printed: String,
    /// Where it was found.
    pub source: Option<String>,
}

/// What a measurement says of one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureVerdict {
    /// The figure.
    pub figure: DatasheetFigure,
    /// The verdict.
    pub verdict: Verdict,
    /// The parameter as measured, in the figure's convention, in SI units.
    pub measured: Parameter,
    /// What the stream does to it.
    pub stream: StreamFactor,
    /// From where to where a sensor at the figure reads in this stream, in SI units.
    pub expected: (f64, f64),
}

/// √(2 ln 2/π): the flat part of the Allan deviation of flicker noise with B = 1.
fn floor_of_flicker() -> f64 {
    (2.0 * LN_2 / PI).sqrt()
}

impl Datasheet {
    /// What `assessment` says of every figure, channel by channel in the order of the layout; none for channels without figures.
    #[must_use]
    pub fn judge(&self, assessment: &Assessment) -> Vec<Vec<FigureVerdict>> {
        let of_channel = |channel: &ChannelAssessment| {
            let Some(noise) = &channel.noise else { return Vec::new() };
            let figures = self.figures.iter().filter(|figure| figure.sensor == noise.sensor);
            figures.filter_map(|figure| Some(figure.judge(&noise.parameter(figure.term)?, channel.onboard))).collect()
        };
        assessment.channels.iter().map(of_channel).collect()
    }

    /// The noise of a sensor that is as it should be: each parameter in SI units (magnetic field in gauss), with B as the model has it, by
    /// the lower end of what is typical, or by the limit where nothing is.
    #[must_use]
    pub fn typical_noise(&self, sensor: Sensor) -> Vec<(Term, f64)> {
        self.typical_figures(sensor).map(|figure| (figure.term, figure.parameter())).collect()
    }

    /// The figures behind [`typical_noise`](Self::typical_noise), in its order.
    pub fn typical_figures(&self, sensor: Sensor) -> impl Iterator<Item = &DatasheetFigure> {
        Term::ALL.into_iter().filter_map(move |term| {
            let mut figures = self.figures.iter().filter(|figure| figure.sensor == sensor && figure.term == term);
            let first = figures.clone().next();
            figures.find(|figure| matches!(figure.claim, Claim::Typical { .. })).or(first)
        })
    }
}

impl DatasheetFigure {
    /// The parameter of the model that reads as printed, by the lower end of what is typical.
    fn parameter(&self) -> f64 {
        let (Claim::Limit(printed) | Claim::Typical { from: printed, .. }) = self.claim;
        printed / self.convention()
    }

    /// So many times the parameter of the model is printed.
    fn convention(&self) -> f64 {
        if self.is_minimum && self.term == Term::BiasInstability { floor_of_flicker() } else { 1.0 }
    }

    fn judge(&self, parameter: &Parameter, onboard: Option<Onboard>) -> FigureVerdict {
        let times = |value: Option<f64>| value.map(|value| value * self.convention());
        let measured = Parameter {
            status: parameter.status,
            value: times(parameter.value),
            lower: times(parameter.lower),
            upper: times(parameter.upper),
        };
        // only white noise folds
        let stream = match onboard.filter(|_| self.term == Term::White) {
            Some(onboard) => StreamFactor {
                factor: onboard.white_factor(),
                uncertainty: Onboard::UNCERTAINTY,
                is_known: onboard.window_known,
            },
            None => StreamFactor::ONE,
        };
        FigureVerdict {
            verdict: self.claim.judge(&measured, &stream),
            expected: self.claim.expected(&stream),
            figure: self.clone(),
            measured,
            stream,
        }
    }
}

/// Why not all verdicts on `figure` are a pass, by channel; empty where all are. One of `verdicts` belongs to each channel of the
/// snapshot's layout.
#[must_use]
pub fn not_passed(
    figure: &Figure,
    snapshot: &Snapshot,
    verdicts: &[Vec<FigureVerdict>],
) -> Vec<(String, Option<Verdict>)> {
    let layout = snapshot.layout.as_ref().map_or(&[][..], |layout| &layout.channels);
    let concerned: Vec<_> = layout.iter().zip(verdicts).filter(|(channel, _)| figure.concerns(channel)).collect();
    if concerned.is_empty() {
        return vec![(figure.to_string(), None)];
    }
    let mut reasons = Vec::new();
    for (channel, verdicts) in concerned {
        let mut of_term = verdicts.iter().filter(|verdict| verdict.figure.term == figure.term).peekable();
        if of_term.peek().is_none() {
            reasons.push((channel.name.to_string(), None));
        }
        let worse = of_term.filter(|verdict| verdict.verdict != Verdict::Pass);
        reasons.extend(worse.map(|verdict| (channel.name.to_string(), Some(verdict.verdict))));
    }
    reasons
}

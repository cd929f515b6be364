//! Data sheets, and verdicts of an assessment against one.

use std::f64::consts::{LN_2, PI};

use imu_noise::{BoxcarWindow, Claim, Parameter, Sensor, StreamFactor, Term, Verdict, curve_minimum};

use crate::{
    assessment::{Assessment, ChannelAssessment, ChannelNoise, Onboard},
    noise_figure::NoiseFigure,
    snapshot::{RateFrom, Snapshot},
};

/// What a maker says of a sensor's noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Datasheet {
    /// The sensor.
    pub name: String,
    /// How far the figures can be trusted.
    pub note: Option<String>,
    /// What the sensor does before it sends a sample, where this program does not know the sensor.
    pub onboard: Option<SheetOnboard>,
    /// Its figures.
    pub figures: Vec<DatasheetFigure>,
}

/// What a sensor does to gyroscope and accelerometer before it sends a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetOnboard {
    /// Refreshes per second, above 0.
    pub refresh_hz: f64,
    /// Refreshes averaged; 1 averages nothing.
    pub window: u32,
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
    /// The minimum of the Allan deviation, what most sheets call bias instability:
    /// [`curve_minimum`].
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
    /// Why that is not known; `None` where it is.
    pub unknown: Option<StreamUnknown>,
    /// From where to where a sensor at the figure reads in this stream, in SI units.
    pub expected: (f64, f64),
}

/// What a measurement says of all figures of a data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdicts {
    /// Name of the sheet.
    pub datasheet: String,
    /// How far its figures can be trusted.
    pub note: Option<String>,
    /// By channel of the layout; none for channels without figures.
    pub channels: Vec<Vec<FigureVerdict>>,
}

/// Why the effect of the stream on a parameter is unknown; the first reason that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamUnknown {
    /// The averaging on board is not reported.
    Window,
    /// The sample rate is assumed.
    Rate,
    /// A line was removed, and some of the parameter with it.
    LineRemoved,
}

/// √(2 ln 2/π): the flat part of the Allan deviation of flicker noise with B = 1.
fn floor_of_flicker() -> f64 {
    (2.0 * LN_2 / PI).sqrt()
}

impl Datasheet {
    /// What the assessment of a snapshot says of every figure.
    ///
    /// White noise is compared with the figure times what averaging and decimation on board make of
    /// it. Where these are not known, or the sample rate is assumed, nothing passes and nothing
    /// fails: a window longer than the interval makes white noise read low, and bias instability
    /// high. Nor do the others where a line was removed. Nothing is compared where the sensor was
    /// moved.
    #[must_use]
    pub fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Verdicts {
        let of_channel = |channel: &ChannelAssessment| {
            let Some(noise) = channel.noise.as_ref().filter(|_| assessment.motion.is_none()) else { return Vec::new() };
            let (window, of_white) = self.window(noise.sensor, channel.onboard, snapshot);
            let of_others = of_white.or(snapshot.detrended.then_some(StreamUnknown::LineRemoved));
            let white = StreamFactor {
                factor: window.white_factor(),
                uncertainty: Onboard::uncertainty_of(window),
                is_known: of_white.is_none(),
            };
            // only white noise folds
            let others = StreamFactor { is_known: of_others.is_none(), ..StreamFactor::ONE };
            let figures = self.figures.iter().filter(|figure| figure.sensor == noise.sensor);
            figures
                .filter_map(|figure| {
                    let (stream, unknown) =
                        if figure.term == Term::White { (white, of_white) } else { (others, of_others) };
                    figure.judge(noise, stream, unknown)
                })
                .collect()
        };
        let channels = assessment.channels.iter().map(of_channel).collect();
        Verdicts { datasheet: self.name.clone(), note: self.note.clone(), channels }
    }

    /// Each parameter in SI units (magnetic field in gauss), with B as the model has it, by the
    /// lower end of what is typical, or by the limit where nothing is.
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

    /// And why that is not known.
    fn window(
        &self,
        sensor: Sensor,
        onboard: Option<Onboard>,
        snapshot: &Snapshot,
    ) -> (BoxcarWindow, Option<StreamUnknown>) {
        let stated = self.onboard.filter(|_| sensor != Sensor::Magnetometer);
        let (window, is_known) = match (onboard, stated) {
            (Some(onboard), _) => (onboard.window, onboard.window_known),
            (None, Some(stated)) => {
                let decimation = stated.refresh_hz / snapshot.timing.rate_hz;
                let window = BoxcarWindow { length: stated.window, decimation };
                // the fit allows for shared refreshes only where the sensor itself reported them
                (window, !window.overlaps())
            }
            (None, None) => (BoxcarWindow { length: 1, decimation: 1.0 }, false),
        };
        let rate_assumed = snapshot.timing.rate_from == RateFrom::Assumed;
        let unknown = (!is_known).then_some(StreamUnknown::Window).or(rate_assumed.then_some(StreamUnknown::Rate));
        (window, unknown)
    }
}

impl DatasheetFigure {
    /// The parameter of the model that reads as printed, by the lower end of what is typical.
    fn parameter(&self) -> f64 {
        let (Claim::Limit(printed) | Claim::Typical { from: printed, .. }) = self.claim;
        if self.is_curve_minimum() { printed / floor_of_flicker() } else { printed }
    }

    fn is_curve_minimum(&self) -> bool {
        self.is_minimum && self.term == Term::BiasInstability
    }

    fn judge(
        &self,
        noise: &ChannelNoise,
        stream: StreamFactor,
        unknown: Option<StreamUnknown>,
    ) -> Option<FigureVerdict> {
        let measured = if self.is_curve_minimum() {
            let [white, walk] = [Term::White, Term::RateRandomWalk].map(|term| noise.parameter(term));
            curve_minimum(&white?, &noise.parameter(self.term)?, &walk?)
        } else {
            noise.parameter(self.term)?
        };
        Some(FigureVerdict {
            verdict: self.claim.judge(&measured, &stream),
            expected: self.claim.expected(&stream),
            figure: self.clone(),
            measured,
            stream,
            unknown,
        })
    }
}

/// Why not all verdicts on `figure` are a pass, by channel. One of `verdicts` belongs to each
/// channel of the layout. Where the sheet has a limit, what is typical decides nothing. `None` is a
/// channel without a figure, or one that is not there.
#[must_use]
pub fn not_passed<'a>(
    figure: &NoiseFigure,
    snapshot: &Snapshot,
    verdicts: &'a [Vec<FigureVerdict>],
) -> Vec<(String, Option<&'a FigureVerdict>)> {
    let concerned: Vec<_> =
        snapshot.layout_channels().iter().zip(verdicts).filter(|(channel, _)| figure.concerns(channel)).collect();
    if concerned.is_empty() {
        return vec![(figure.to_string(), None)];
    }
    let mut reasons = Vec::new();
    for (channel, verdicts) in concerned {
        let of_term = || verdicts.iter().filter(|verdict| verdict.figure.term == figure.term);
        let is_limit = |verdict: &&FigureVerdict| matches!(verdict.figure.claim, Claim::Limit(_));
        let has_limit = of_term().any(|verdict| is_limit(&verdict));
        if of_term().next().is_none() {
            reasons.push((channel.name.to_string(), None));
        }
        let deciding = of_term().filter(|verdict| !has_limit || is_limit(verdict));
        let worse = deciding.filter(|verdict| verdict.verdict != Verdict::Pass);
        reasons.extend(worse.map(|verdict| (channel.name.to_string(), Some(verdict))));
    }
    reasons
}

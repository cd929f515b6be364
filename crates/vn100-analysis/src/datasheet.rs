//! Data sheets, and verdicts of an assessment against one.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

use imu_noise::{BoxcarWindow, Claim, Parameter, Sensor, Sides, StreamFactor, Term, Verdict};

use crate::{
    assessment::{Assessment, ChannelAssessment, ChannelNoise, Onboard},
    detrend::Detrend,
    noise_figure::NoiseFigure,
    snapshot::{RateFrom, Snapshot},
};

/// The noise of a sensor as its maker specifies it.
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
    /// Typical figures pass and fail, too.
    pub typical_is_limit: bool,
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
    /// What is claimed, in SI units; of a density, two-sided.
    pub claim: Claim,
    /// The density may be one-sided as well: the claim is √2 smaller then.
    pub is_of_unknown_sides: bool,
    /// The minimum of the Allan deviation, what most sheets call bias instability:
    /// [`curve_minimum`](imu_noise::curve_minimum).
    pub is_minimum: bool,
    /// The figure as printed, such as `typical 0.0035 deg/s/sqrt(Hz)`.
    pub printed: String,
    /// Where it was found.
    pub source: Option<String>,
}

/// The verdict of a measurement on one figure.
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
    /// Whether the averaging on board is known, which is no matter to other noise than white.
    pub window_known: bool,
    /// Lower and upper value expected in this stream of a sensor at the figure, in SI units; a
    /// density of unknown sides taken as two-sided.
    pub expected: (f64, f64),
    /// The verdict for each convention where it is not known whether a density is one-sided; else
    /// empty.
    pub readings: Vec<Reading>,
}

/// One reading of a figure whose convention is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// As which density.
    pub sides: Sides,
    /// The verdict if that was meant.
    pub verdict: Verdict,
    /// Lower and upper value then expected in this stream, in SI units.
    pub expected: (f64, f64),
}

/// The verdicts of a measurement on all figures of a data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdicts {
    /// Name of the sheet.
    pub datasheet: String,
    /// How far its figures can be trusted.
    pub note: Option<String>,
    /// By channel of the layout; none for channels without figures.
    pub channels: Vec<Vec<FigureVerdict>>,
    /// Typical figures pass and fail, too.
    pub typical_is_limit: bool,
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
    /// The verdict of an assessment on every figure.
    ///
    /// White noise is compared with the figure times what averaging and decimation on board make of
    /// it; where these are unknown it neither passes nor fails. Neither of them changes B. All but
    /// B and the minimum of the curve, which do not depend on the time scale, need a rate that is
    /// not assumed; all but white noise a record from which no line was removed. Nothing is
    /// compared where the sensor was moved.
    #[must_use]
    pub fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Verdicts {
        let of_channel = |channel: &ChannelAssessment| {
            let Some(noise) = channel.noise.as_ref().filter(|_| assessment.motion.is_none()) else { return Vec::new() };
            let figures = self.figures.iter().filter(|figure| figure.sensor == noise.sensor);
            let judged = |figure: &DatasheetFigure| {
                let (window, window_known) = self.window(noise.sensor, channel.onboard, snapshot);
                let unknown = unknown(figure.term, window_known, snapshot);
                let stream = StreamFactor { is_known: unknown.is_none(), ..StreamFactor::ONE };
                // only white noise folds
                let stream = match figure.term {
                    Term::White => {
                        let (factor, uncertainty) = (window.white_factor(), Onboard::uncertainty_of(window));
                        StreamFactor { factor, uncertainty, ..stream }
                    }
                    _ => stream,
                };
                let judged = figure.judge(noise, stream, self.typical_is_limit)?;
                Some(FigureVerdict { unknown, window_known, ..judged })
            };
            figures.filter_map(judged).collect()
        };
        Verdicts {
            datasheet: self.name.clone(),
            note: self.note.clone(),
            channels: assessment.channels.iter().map(of_channel).collect(),
            typical_is_limit: self.typical_is_limit,
        }
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

    /// The averaging on board, and whether it is known.
    fn window(&self, sensor: Sensor, onboard: Option<Onboard>, snapshot: &Snapshot) -> (BoxcarWindow, bool) {
        let stated = self.onboard.filter(|_| sensor != Sensor::Magnetometer);
        match (onboard, stated) {
            (Some(onboard), _) => (onboard.window, onboard.window_known()),
            (None, Some(stated)) => {
                let decimation = stated.refresh_hz / snapshot.timing.rate_hz;
                let window = BoxcarWindow { length: stated.window, decimation };
                // the fit allows for shared refreshes only where the sensor itself reported them
                (window, !window.overlaps())
            }
            (None, None) => (BoxcarWindow { length: 1, decimation: 1.0 }, false),
        }
    }
}

/// Why the effect of the stream on that parameter is unknown; `None` where it is known.
fn unknown(term: Term, window_known: bool, snapshot: &Snapshot) -> Option<StreamUnknown> {
    let window = (!window_known).then_some(StreamUnknown::Window);
    let rate = (snapshot.timing.rate_from == RateFrom::Assumed).then_some(StreamUnknown::Rate);
    let line = (snapshot.detrended == Some(Detrend::Line)).then_some(StreamUnknown::LineRemoved);
    match term {
        Term::White => window.or(rate),
        Term::BiasInstability => line,
        Term::Quantization | Term::RateRandomWalk | Term::RateRamp => rate.or(line),
    }
}

impl DatasheetFigure {
    /// The parameter of the model that reads as printed, by the lower end of what is typical.
    fn parameter(&self) -> f64 {
        let (Claim::Limit(printed) | Claim::Typical { from: printed, .. }) = self.claim;
        if self.is_curve_minimum() { printed / floor_of_flicker() } else { printed }
    }

    /// Whether it is the minimum of the deviation, rather than a parameter of the model.
    #[must_use]
    pub fn is_curve_minimum(&self) -> bool {
        self.is_minimum && self.term == Term::BiasInstability
    }

    fn judge(&self, noise: &ChannelNoise, stream: StreamFactor, typical_is_limit: bool) -> Option<FigureVerdict> {
        let measured = if self.is_curve_minimum() { noise.curve_minimum()? } else { noise.parameter(self.term)? };
        let read = |sides| {
            let claim = match sides {
                Sides::Two => self.claim,
                Sides::One => self.claim.scaled(FRAC_1_SQRT_2),
            };
            let verdict = claim.judge(&measured, &stream);
            let verdict = if typical_is_limit { verdict.with_typical_as_limit() } else { verdict };
            Reading { sides, verdict, expected: claim.expected(&stream) }
        };
        let (as_two_sided, as_one_sided) = (read(Sides::Two), read(Sides::One));
        let (verdict, readings) = match self.is_of_unknown_sides {
            true => (as_two_sided.verdict.of_either_reading(as_one_sided.verdict), vec![as_two_sided, as_one_sided]),
            false => (as_two_sided.verdict, Vec::new()),
        };
        Some(FigureVerdict {
            verdict,
            expected: as_two_sided.expected,
            figure: self.clone(),
            measured,
            stream,
            unknown: None,
            window_known: true,
            readings,
        })
    }
}

/// Why not all verdicts that decide on `figure` are a pass, by channel; none without a data sheet.
/// Limits decide, and typical figures where they are taken for limits. `None` is a channel without
/// a figure, or one that is not there.
#[must_use]
pub fn not_passed<'a>(
    figure: &NoiseFigure,
    snapshot: &Snapshot,
    verdicts: Option<&'a Verdicts>,
) -> Vec<(String, Option<&'a FigureVerdict>)> {
    let judged = verdicts.map_or(&[][..], |verdicts| &verdicts.channels);
    let typical_decides = verdicts.is_some_and(|verdicts| verdicts.typical_is_limit);
    let concerned: Vec<_> =
        snapshot.layout_channels().iter().zip(judged).filter(|(channel, _)| figure.concerns(channel)).collect();
    if concerned.is_empty() {
        return vec![(figure.to_string(), None)];
    }
    let mut reasons = Vec::new();
    for (channel, verdicts) in concerned {
        let of_term = || verdicts.iter().filter(|verdict| verdict.figure.term == figure.term);
        if of_term().next().is_none() {
            reasons.push((channel.name.to_string(), None));
        }
        let deciding = of_term().filter(|verdict| typical_decides || matches!(verdict.figure.claim, Claim::Limit(_)));
        let worse = deciding.filter(|verdict| verdict.verdict != Verdict::Pass);
        reasons.extend(worse.map(|verdict| (channel.name.to_string(), Some(verdict))));
    }
    reasons
}

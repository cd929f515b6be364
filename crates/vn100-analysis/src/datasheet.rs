//! Data sheets, and verdicts of an assessment against one.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

use imu_noise::{BoxcarWindow, Claim, Parameter, Sensor, Sides, StreamFactor, Term, Verdict};

use crate::{
    assessment::{Assessment, ChannelAssessment, ChannelNoise, Onboard},
    noise_figure::NoiseFigure,
    snapshot::{RateFrom, Snapshot},
};

/// The noise of a sensor as its maker specifies it.
#[derive(Debug, Clone, PartialEq)]
pub struct Datasheet {
    /// Name of the sensor.
    pub name: String,
    /// How far the figures can be trusted; `None` where the sheet says nothing about that.
    pub note: Option<String>,
    /// What the sensor does on board before it sends a sample; `None` for a sensor that this
    /// program knows.
    pub onboard: Option<SheetOnboard>,
    /// The figures of the sheet.
    pub figures: Vec<DatasheetFigure>,
    /// Whether typical figures pass and fail, as limits do.
    pub typical_is_limit: bool,
}

/// What a sensor does to gyroscope and accelerometer before it sends a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetOnboard {
    /// Refreshes per second, above 0.
    pub refresh_hz: f64,
    /// Refreshes averaged for one sample; 1 averages nothing.
    pub window: u32,
}

/// One figure of a data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasheetFigure {
    /// The kind of sensor.
    pub sensor: Sensor,
    /// The parameter.
    pub term: Term,
    /// The claim in SI units (magnetic field in gauss); a density as two-sided.
    pub claim: Claim,
    /// Whether it is unknown if the density is two-sided or one-sided; as one-sided, the claim is
    /// √2 smaller.
    pub is_of_unknown_sides: bool,
    /// Whether the figure is the minimum of the Allan deviation, which most sheets call bias
    /// instability: [`curve_minimum`](imu_noise::curve_minimum).
    pub is_minimum: bool,
    /// The figure as printed, such as `typical 0.0035 deg/s/sqrt(Hz)`.
    pub printed: String,
    /// Where the figure was found.
    pub source: Option<String>,
}

/// The verdict of a measurement on one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureVerdict {
    /// The figure.
    pub figure: DatasheetFigure,
    /// The verdict.
    pub verdict: Verdict,
    /// The measured parameter in the convention of the figure, in SI units (magnetic field in
    /// gauss).
    pub measured: Parameter,
    /// The effect of averaging and decimation on the parameter in this stream.
    pub stream: StreamFactor,
    /// Why that effect is not known; `None` where it is known.
    pub unknown: Option<StreamUnknown>,
    /// Whether the averaging on board is known; it has no effect on other terms than white noise.
    pub window_known: bool,
    /// Lower and upper value that a sensor at the figure is expected to show in this stream, in SI
    /// units; a density of unknown convention is taken as two-sided.
    pub expected: (f64, f64),
    /// The verdict under each convention, where it is not known whether a density is one-sided;
    /// else empty.
    pub readings: Vec<Reading>,
}

/// One reading of a figure whose convention is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The convention: two-sided or one-sided.
    pub sides: Sides,
    /// The verdict under this convention.
    pub verdict: Verdict,
    /// Lower and upper value expected in this stream under this convention, in SI units.
    pub expected: (f64, f64),
}

/// The verdicts of a measurement on all figures of a data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdicts {
    /// Name of the data sheet.
    pub datasheet: String,
    /// How far the figures of the sheet can be trusted.
    pub note: Option<String>,
    /// By channel of the layout, the verdicts on its figures; empty for channels without figures.
    pub channels: Vec<Vec<FigureVerdict>>,
    /// Whether typical figures pass and fail, as limits do.
    pub typical_is_limit: bool,
}

/// Why the effect of the stream on a parameter is not known; the first reason that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamUnknown {
    /// The averaging on board is not reported by the sensor.
    Window,
    /// The sample rate is assumed.
    Rate,
}

/// √(2 ln 2/π): the flat part of the Allan deviation of flicker noise with B = 1 (IEEE 952).
pub(crate) fn floor_of_flicker() -> f64 {
    (2.0 * LN_2 / PI).sqrt()
}

impl Datasheet {
    /// Judges an assessment by every figure of the sheet.
    ///
    /// White noise is compared with the figure multiplied by the effect of averaging and decimation
    /// on board; where that effect is not known, it neither passes nor fails. B does not depend on
    /// it. All figures but B and the minimum of the curve, which do not depend on the time scale,
    /// need a sample rate that is not assumed. Where the sensor was moved, no channel has verdicts.
    #[must_use]
    pub fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Verdicts {
        let of_channel = |channel: &ChannelAssessment| {
            let Some(noise) = channel.noise.as_ref().filter(|_| assessment.motion.is_none()) else { return Vec::new() };
            let figures = self.figures.iter().filter(|figure| figure.sensor == noise.sensor);
            let judged = |figure: &DatasheetFigure| {
                let (window, window_known) = self.window(noise.sensor, channel.onboard, snapshot);
                // at the rate of the sensor no window aliases
                let is_settled = window_known || channel.onboard.is_some_and(|onboard| !onboard.aliases());
                let unknown = unknown(figure.term, is_settled, snapshot);
                let stream = StreamFactor { is_known: unknown.is_none(), ..StreamFactor::ONE };
                // only white noise aliases
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

    /// The terms that the sheet gives for a sensor, in SI units (magnetic field in gauss), with B
    /// as the noise model defines it: the lower end of a typical range, or the limit where the
    /// sheet gives no typical value.
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

    /// Whether a limit on this parameter is one on the minimum of the deviation, as the sheet's
    /// figure is, or as that of most sheets where this one has none.
    pub(crate) fn is_of_minimum(&self, sensor: Sensor, term: Term) -> bool {
        let quoted = self.typical_figures(sensor).find(|figure| figure.term == term);
        quoted.map_or(term == Term::BiasInstability, DatasheetFigure::is_curve_minimum)
    }

    /// The averaging on board, and whether it is known.
    fn window(&self, sensor: Sensor, onboard: Option<Onboard>, snapshot: &Snapshot) -> (BoxcarWindow, bool) {
        let stated = self.onboard.filter(|_| sensor != Sensor::Magnetometer);
        match (onboard, stated) {
            (Some(onboard), _) => (onboard.window, onboard.window_known()),
            (None, Some(stated)) => {
                let decimation = stated.refresh_hz / snapshot.timing.rate_hz;
                let window = BoxcarWindow { length: stated.window, decimation };
                // the fit allows for refreshes that neighbouring windows share only where the
                // sensor itself reports the window
                (window, !window.overlaps())
            }
            (None, None) => (BoxcarWindow { length: 1, decimation: 1.0 }, false),
        }
    }
}

/// Why the effect of the stream on a parameter is not known; `None` where it is known.
fn unknown(term: Term, is_settled: bool, snapshot: &Snapshot) -> Option<StreamUnknown> {
    let window = (!is_settled).then_some(StreamUnknown::Window);
    let rate = (snapshot.timing.rate_from == RateFrom::Assumed).then_some(StreamUnknown::Rate);
    match term {
        Term::White => window.or(rate),
        Term::BiasInstability => None,
        Term::Quantization | Term::RateRandomWalk | Term::RateRamp => rate,
    }
}

impl DatasheetFigure {
    /// The parameter of the noise model that corresponds to the printed figure, by the lower end of
    /// a typical range.
    fn parameter(&self) -> f64 {
        let (Claim::Limit(printed) | Claim::Typical { from: printed, .. }) = self.claim;
        if self.is_curve_minimum() { printed / floor_of_flicker() } else { printed }
    }

    /// Whether the figure is the minimum of the deviation, rather than a parameter of the noise
    /// model.
    #[must_use]
    pub fn is_curve_minimum(&self) -> bool {
        self.is_minimum && self.term == Term::BiasInstability
    }

    fn judge(&self, noise: &ChannelNoise, stream: StreamFactor, typical_is_limit: bool) -> Option<FigureVerdict> {
        let measured = if self.is_curve_minimum() { noise.curve_minimum()? } else { noise.parameter(self.term)? };
        let read = |sides, parameter: &Parameter| {
            let claim = match sides {
                Sides::Two => self.claim,
                Sides::One => self.claim.scaled(FRAC_1_SQRT_2),
            };
            let verdict = claim.judge(parameter, &stream);
            let verdict = if typical_is_limit { verdict.with_typical_as_limit() } else { verdict };
            Reading { sides, verdict, expected: claim.expected(&stream) }
        };
        let both = |parameter: &Parameter| [Sides::Two, Sides::One].map(|sides| read(sides, parameter));
        let of = |[as_two_sided, as_one_sided]: &[Reading; 2]| match self.is_of_unknown_sides {
            true => as_two_sided.verdict.of_either_reading(as_one_sided.verdict),
            false => as_two_sided.verdict,
        };
        let readings = both(&measured);
        let mut verdict = of(&readings);
        if verdict == Verdict::Inconclusive {
            // what no record decides, however long, is not left to a longer one
            let known = measured.value.map(|value| of(&both(&Parameter::estimated(value, value, value))));
            verdict = known.filter(|known| *known == Verdict::Consistent).unwrap_or(verdict);
        }
        let expected = readings[0].expected;
        let readings = if self.is_of_unknown_sides { readings.to_vec() } else { Vec::new() };
        Some(FigureVerdict {
            verdict,
            expected,
            figure: self.clone(),
            measured,
            stream,
            unknown: None,
            window_known: true,
            readings,
        })
    }
}

/// The channels of `figure` whose deciding verdicts are not all a pass, each with such a verdict;
/// empty where all pass. Limits decide, and typical figures where these are taken as limits. `None`
/// stands for a channel without a figure, and, under the name of the figure, for a record without
/// such a channel or for no data sheet.
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

//! Data sheets, and verdicts of an assessment against one.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

use imu_noise::{BoxcarWindow, Claim, Parameter, Sensor, Term, Verdict, si_unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use crate::{
    assessment::{Assessment, ChannelAssessment, ChannelNoise, Onboard, WindowFrom},
    snapshot::{RateFrom, Snapshot},
};

/// The noise of a sensor as its maker specifies it.
#[derive(Debug, Clone, PartialEq)]
pub struct Datasheet {
    /// Name of the sensor.
    pub name: String,
    /// How far the figures can be trusted; `None` if the sheet says nothing about that.
    pub note: Option<String>,
    /// What the sensor does on board; `None` for a sensor that this program knows.
    pub onboard: Option<SheetOnboard>,
    /// The figures of the sheet.
    pub figures: Vec<DatasheetFigure>,
    /// Whether typical figures pass and fail, as limits do.
    pub typical_is_limit: bool,
}

/// What a sensor does to gyroscope and accelerometer before it sends a sample.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SheetOnboard {
    /// Refreshes per second, above 0.
    pub refresh_hz: f64,
    /// Refreshes averaged for one sample; 1 averages nothing, `None` if the user sets it.
    pub window: Option<u32>,
}

/// One figure of a data sheet.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct DatasheetFigure {
    /// The kind of sensor.
    #[serde(skip)]
    pub sensor: Sensor,
    /// Parameter.
    #[serde(rename = "parameter")]
    pub term: Term,
    /// The claim: limit or typical, in SI units (magnetic field in gauss); a density as two-sided.
    #[serde(serialize_with = "as_word")]
    #[schemars(with = "String")]
    pub claim: Claim,
    /// Whether it is unknown if the density is two-sided or one-sided; as one-sided, the claim is
    /// √2 smaller.
    #[serde(rename = "unknown_sides")]
    pub is_of_unknown_sides: bool,
    /// Whether the figure is the minimum of the Allan deviation, which most sheets call bias
    /// instability.
    pub is_minimum: bool,
    /// The figure as printed, such as typically 0.0035 deg/s/sqrt(Hz).
    #[serde(rename = "figure")]
    pub printed: String,
    /// Where the figure was found.
    pub source: Option<String>,
}

fn as_word<S: Serializer>(claim: &Claim, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(claim.name())
}

/// One figure of the data sheet and the verdict of the measurement, in SI units (magnetic field in
/// gauss).
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct FigureVerdict {
    /// The figure.
    #[serde(flatten)]
    pub figure: DatasheetFigure,
    /// Verdict; null for a typical figure that is not taken for a limit, unless the stream does not
    /// carry the parameter.
    pub verdict: Option<Verdict>,
    /// What would decide; null unless the verdict is undecided.
    pub decided_by: Option<DecidedBy>,
    /// Length in seconds of a record that would probably decide, if it has the noise that this one
    /// shows; null unless a longer record would decide, and if 100 days do not.
    pub deciding_record_s: Option<f64>,
    /// Below the first a parameter passes, above the second it fails.
    #[serde(skip)]
    pub(crate) range: (f64, f64),
    /// SI unit of measured and expected.
    pub unit: &'static str,
    /// The measured parameter in the convention of the figure.
    pub measured: Parameter,
    /// The measured parameter over the expected one.
    pub ratio: Ratio,
    /// The lowest and the highest factor by which averaging and decimation on board may raise the
    /// parameter in this stream.
    pub factor: (f64, f64),
    /// The lowest and the highest value that a sensor at the figure may show in this stream.
    pub expected: (f64, f64),
}

/// How many times as large as expected a parameter is, with its interval and all that is not known
/// of the figure.
#[derive(Debug, Clone, Copy, Default, PartialEq, JsonSchema, Serialize)]
pub struct Ratio {
    /// `None` unless the parameter is estimated, and the figure and the stream have one reading.
    pub value: Option<f64>,
    /// Lower end; `None` if the parameter is not known from below.
    pub lower: Option<f64>,
    /// Upper end; `None` if the parameter is not known from above.
    pub upper: Option<f64>,
}

/// What would decide a verdict that is open; the first that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DecidedBy {
    /// The sample rate is assumed.
    Rate,
    /// The stream does not contain how the sensor averages, and so how much aliases.
    Window,
    /// A one-sided density is √2 times the two-sided one, and the value lies between both readings.
    Convention,
    /// How much aliasing raises the value is known to 10 %, and the value lies within that of the
    /// limit.
    Unaliased,
    /// The interval spans the limit, or there is none; it narrows with the record.
    LongerRecord,
    /// The parameter is so near to the limit that 100 days of the noise in this record do not
    /// decide.
    Nothing,
}

/// √(2 ln 2/π): the flat part of the Allan deviation of flicker noise with B = 1 (IEEE 952).
pub(crate) fn floor_of_flicker() -> f64 {
    (2.0 * LN_2 / PI).sqrt()
}

/// What averaging and decimation on board do to white noise.
#[derive(Debug, Clone, Copy)]
struct Stream {
    /// The lowest and the highest factor.
    factor: (f64, f64),
    /// How far either may be off, relative.
    uncertainty: f64,
    /// Whether the sensor reports its averaging, or averages nothing.
    is_known: bool,
}

impl Stream {
    const UNCHANGED: Self = Self { factor: (1.0, 1.0), uncertainty: 0.0, is_known: true };

    fn of(window: BoxcarWindow) -> Self {
        let factor = window.white_factor();
        Self { factor: (factor, factor), uncertainty: Onboard::uncertainty_of(window), is_known: true }
    }

    /// Of any averaging window; none aliases at the rate of the sensor.
    fn of_unknown_window(onboard: Onboard) -> Self {
        if !onboard.aliases() {
            return Self::UNCHANGED;
        }
        let most = BoxcarWindow { length: 1, ..onboard.window }.white_factor();
        Self { factor: (1.0, most), uncertainty: Onboard::UNCERTAINTY, is_known: false }
    }
}

impl Datasheet {
    /// Compares an assessment with every figure of the sheet.
    ///
    /// White noise is compared with the figure times the effect of averaging and decimation on board, or
    /// with all that it may be. All figures but B and the minimum of the curve need a sample rate that is
    /// not assumed. By channel of the layout; empty for channels without figures, and for all of a sensor
    /// that was moved.
    pub fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Vec<Vec<FigureVerdict>> {
        let is_rate_assumed = snapshot.timing.rate_from == RateFrom::Assumed;
        let of_channel = |channel: &ChannelAssessment| {
            let Some(noise) = channel.noise.as_ref().filter(|_| assessment.motion.is_none()) else { return Vec::new() };
            let figures = self.figures.iter().filter(|figure| figure.sensor == noise.sensor);
            let white = self.stream(noise.sensor, channel.onboard, snapshot);
            let judged = |figure: &DatasheetFigure| {
                // only white noise aliases
                let stream = if figure.term == Term::White { white } else { Stream::UNCHANGED };
                let needs_rate = is_rate_assumed && figure.term != Term::BiasInstability;
                figure.judge(noise, stream, needs_rate, self.typical_is_limit)
            };
            figures.filter_map(judged).collect()
        };
        assessment.channels.iter().map(of_channel).collect()
    }

    /// The terms that the sheet gives for a sensor, in SI units, with B as the noise model defines it: the
    /// lower end of a typical range, or else the limit.
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

    /// Whether a limit on this parameter is one on the minimum, as the figures of most sheets are.
    pub(crate) fn is_of_minimum(&self, sensor: Sensor, term: Term) -> bool {
        let quoted = self.typical_figures(sensor).find(|figure| figure.term == term);
        quoted.map_or(term == Term::BiasInstability, DatasheetFigure::is_curve_minimum)
    }

    /// What is done on board: by a VN-100, or as the sheet says of its own sensor. A sheet that says
    /// nothing is that of a sensor whose stream is compared as it is.
    fn stream(&self, sensor: Sensor, onboard: Option<Onboard>, snapshot: &Snapshot) -> Stream {
        let stated = self.onboard.filter(|_| sensor != Sensor::Magnetometer);
        match (onboard, stated) {
            (Some(onboard), _) if onboard.window_known() => Stream::of(onboard.window),
            (Some(onboard), _) => Stream::of_unknown_window(onboard),
            (None, Some(SheetOnboard { refresh_hz, window })) => {
                let rate_hz = snapshot.timing.rate_hz;
                let of = |length| BoxcarWindow { length, decimation: refresh_hz / rate_hz };
                let Some(window) = window.map(of) else {
                    let window_from = WindowFrom::Default;
                    return Stream::of_unknown_window(Onboard { refresh_hz, rate_hz, window: of(1), window_from });
                };
                // the fit allows for refreshes that neighbouring windows share only if the sensor
                // itself reports the window
                Stream { is_known: !window.overlaps(), ..Stream::of(window) }
            }
            (None, None) => Stream::UNCHANGED,
        }
    }
}

impl DatasheetFigure {
    /// The parameter of the noise model for the printed figure, the lower end of a range.
    fn parameter(&self) -> f64 {
        let (Claim::Limit(printed) | Claim::Typical { from: printed, .. }) = self.claim;
        if self.is_curve_minimum() { printed / floor_of_flicker() } else { printed }
    }

    /// Whether the figure is the minimum of the deviation, and no parameter.
    pub fn is_curve_minimum(&self) -> bool {
        self.is_minimum && self.term == Term::BiasInstability
    }

    fn judge(
        &self,
        noise: &ChannelNoise,
        stream: Stream,
        needs_rate: bool,
        typical_is_limit: bool,
    ) -> Option<FigureVerdict> {
        let measured = if self.is_curve_minimum() { noise.curve_minimum()? } else { noise.parameter(self.term)? };
        let Stream { factor: (least, most), uncertainty, is_known } = stream;
        // of two readings the one-sided density is the smaller
        let smaller = if self.is_of_unknown_sides { FRAC_1_SQRT_2 } else { 1.0 };
        let (from, to) = self.claim.ends();
        let expected = (from * smaller * least * (1.0 - uncertainty), to * most * (1.0 + uncertainty));
        let is_limit = matches!(self.claim, Claim::Limit(_));
        let limit = self.claim.as_limit();
        // a typical sensor is to pass, although its stream is known less well
        let guard = if is_limit { 1.0 - uncertainty } else { 1.0 + uncertainty };
        let range = (limit * smaller * least * guard, limit * most * (1.0 + uncertainty));
        let is_open = needs_rate || !is_known && least == most;
        let verdict = match Verdict::of(&measured, range) {
            Verdict::Pass | Verdict::Fail if is_open => Verdict::Undecided,
            verdict => verdict,
        };
        let verdict =
            Some(verdict).filter(|verdict| is_limit || typical_is_limit || *verdict == Verdict::NotComparable);
        let is_between = measured.value.is_some_and(|value| range.0 < value && value <= range.1);
        let open = [
            (needs_rate, DecidedBy::Rate),
            (!is_known && (is_between || is_open), DecidedBy::Window),
            (self.is_of_unknown_sides && is_between, DecidedBy::Convention),
            (is_between, DecidedBy::Unaliased),
            (true, DecidedBy::LongerRecord),
        ];
        let decided_by = open.into_iter().filter(|_| verdict == Some(Verdict::Undecided)).find(|(applies, _)| *applies);
        let is_of_one_reading = smaller == 1.0 && least == most && !needs_rate;
        let middle = f64::midpoint(from, to) * least;
        let ratio = Ratio {
            value: measured.value.filter(|_| is_of_one_reading).map(|value| value / middle),
            lower: measured.lower.filter(|_| !needs_rate).map(|lower| lower / expected.1),
            upper: measured.upper.filter(|_| !needs_rate).map(|upper| upper / expected.0),
        };
        Some(FigureVerdict {
            figure: self.clone(),
            verdict,
            decided_by: decided_by.map(|(_, by)| by),
            deciding_record_s: None,
            range,
            unit: si_unit(self.sensor, self.term),
            measured,
            ratio,
            factor: stream.factor,
            expected,
        })
    }
}

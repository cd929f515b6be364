//! Warnings as data: the kind, the severity, the channels, what was found, and what can be done. The
//! words for them are those of the faces.

pub(crate) mod checks;
mod finding;

pub use finding::{Doubt, Doubtful, Event, Finding, Happening, Peak, Rejected};

use schemars::JsonSchema;

use crate::remedy::Remedy;

/// The kinds of warning, whose names are a contract with scripts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, JsonSchema)]
#[schemars(rename_all = "kebab-case")]
pub enum WarningKind {
    /// The record, or the recording that was made of it, is not whole.
    Incomplete,
    /// Bytes arrived, but no sample of a message that is measured.
    NoValidLines,
    /// Sentences or packets of a message other than the measured one were excluded.
    OtherMessages,
    /// Another program has the port of the sensor open, or the sensor reported errors that answer
    /// no command.
    LinkErrors,
    /// The sensor, its output rate or its printed resolution changed within the record.
    StreamChanged,
    /// Samples, or values of single channels, are missing; each gap keeps its place on the time
    /// axis.
    Gaps,
    /// Sentences, packets or rows were rejected, or carry no checksum.
    #[schemars(rename = "bad-lines")]
    RejectedLines,
    /// Samples repeat earlier ones exactly, which a live sensor does not do.
    RepeatedLines,
    /// There are too few samples for a deviation, or for more than a rough one.
    TooShort,
    /// The capture does not contain the sample rate; the factory default of 40 Hz is assumed.
    RateAssumed,
    /// The measured rate is none of the sensor's, not the nominal one, or unsure because many
    /// samples are missing.
    RateOffNominal,
    /// Time stamps step backwards, are uneven or cannot be those of a sensor, or the sensor
    /// restarted.
    StampsDoubtful,
    /// The spectrum has significant peaks: vibration, or an alternating magnetic field.
    VibrationLine,
    /// The sensor was moved, or mean or noise changed during the record.
    NotStationary,
    /// The level settled at the beginning of the record, as when a sensor warms up.
    WarmUp,
    /// The bias follows the temperature of the sensor significantly.
    FollowsTemperature,
    /// The magnitude of the mean acceleration or magnetic field is not that of the Earth.
    MagnitudeOff,
    /// An attitude filter has removed its estimate of the bias from the rates.
    CompensatedStream,
    /// The capture does not contain whether a filter has removed the bias of the gyroscope.
    CompensationUnknown,
    /// A low-pass filter slower than the output removes the high frequencies.
    LowPass,
    /// The sensor turns its axes (register 26), or averages otherwise than was given (register 85).
    SensorSettings,
    /// From sample to sample the noise is less than half a step of the values.
    QuantisationFloor,
    /// Besides white noise there is noise correlated over seconds.
    CorrelatedNoise,
    /// A channel reaches the end of its range, or the count of its turns began anew.
    FullRange,
    /// A column holds magnitudes that its unit makes impossible.
    UnitDoubtful,
}

/// The kinds in their order, each with its code, what it concerns, and what most of its findings mean
/// for the result.
const KINDS: [(WarningKind, &str, Aspect, Severity); 25] = [
    (WarningKind::Incomplete, "incomplete", Aspect::Data, Severity::Problem),
    (WarningKind::NoValidLines, "no-valid-lines", Aspect::Data, Severity::Problem),
    (WarningKind::OtherMessages, "other-messages", Aspect::Data, Severity::Caution),
    (WarningKind::LinkErrors, "link-errors", Aspect::Data, Severity::Problem),
    (WarningKind::StreamChanged, "stream-changed", Aspect::Data, Severity::Problem),
    (WarningKind::Gaps, "gaps", Aspect::Data, Severity::Caution),
    (WarningKind::RejectedLines, "bad-lines", Aspect::Data, Severity::Caution),
    (WarningKind::RepeatedLines, "repeated-lines", Aspect::Data, Severity::Problem),
    (WarningKind::TooShort, "too-short", Aspect::Data, Severity::Caution),
    (WarningKind::RateAssumed, "rate-assumed", Aspect::Time, Severity::Caution),
    (WarningKind::RateOffNominal, "rate-off-nominal", Aspect::Time, Severity::Caution),
    (WarningKind::StampsDoubtful, "stamps-doubtful", Aspect::Time, Severity::Caution),
    (WarningKind::VibrationLine, "vibration-line", Aspect::AtRest, Severity::Caution),
    (WarningKind::NotStationary, "not-stationary", Aspect::AtRest, Severity::Caution),
    (WarningKind::WarmUp, "warm-up", Aspect::AtRest, Severity::Caution),
    (WarningKind::FollowsTemperature, "follows-temperature", Aspect::AtRest, Severity::Caution),
    (WarningKind::MagnitudeOff, "magnitude-off", Aspect::AtRest, Severity::Caution),
    (WarningKind::CompensatedStream, "compensated-stream", Aspect::Message, Severity::Note),
    (WarningKind::CompensationUnknown, "compensation-unknown", Aspect::Message, Severity::Caution),
    (WarningKind::LowPass, "low-pass", Aspect::Message, Severity::Caution),
    (WarningKind::SensorSettings, "sensor-settings", Aspect::Message, Severity::Note),
    (WarningKind::QuantisationFloor, "quantisation-floor", Aspect::Values, Severity::Caution),
    (WarningKind::CorrelatedNoise, "correlated-noise", Aspect::Values, Severity::Caution),
    (WarningKind::FullRange, "full-range", Aspect::Values, Severity::Problem),
    (WarningKind::UnitDoubtful, "unit-doubtful", Aspect::Values, Severity::Problem),
];

impl WarningKind {
    /// All kinds.
    pub const ALL: [Self; KINDS.len()] = {
        let mut all = [Self::Incomplete; KINDS.len()];
        let mut place = 0;
        while place < all.len() {
            all[place] = KINDS[place].0;
            place += 1;
        }
        all
    };

    /// The code of the kind: lower case, words joined by hyphens.
    pub const fn name(self) -> &'static str {
        KINDS[self as usize].1
    }

    /// What warnings of this kind concern.
    pub const fn aspect(self) -> Aspect {
        KINDS[self as usize].2
    }

    /// What most findings of this kind mean for the result.
    pub const fn severity(self) -> Severity {
        KINDS[self as usize].3
    }
}

/// What a warning concerns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aspect {
    /// Whether all samples arrived, and intact.
    Data,
    /// Rate and time stamps.
    Time,
    /// Whether the sensor lay still.
    AtRest,
    /// What the stream carries of the sensor's own noise.
    Message,
    /// What the numbers can resolve.
    Values,
}

impl Aspect {
    /// All aspects.
    pub const ALL: [Self; 5] = [Self::Data, Self::Time, Self::AtRest, Self::Message, Self::Values];

    /// The name of the aspect.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Data => "data",
            Self::Time => "time",
            Self::AtRest => "at rest",
            Self::Message => "message",
            Self::Values => "values",
        }
    }
}

/// What a warning means for the result, the gravest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Numbers of the result are wrong, or not those of the sensor, or the record is not complete.
    Problem,
    /// Numbers of the result are less certain, or mean less.
    Caution,
    /// A property of the stream that its user should know; healthy sensors have it as well.
    Note,
}

impl Severity {
    /// The code of the severity.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Problem => "problem",
            Self::Caution => "caution",
            Self::Note => "note",
        }
    }
}

/// One warning.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// The kind of the warning.
    pub kind: WarningKind,
    /// What the warning means for the result.
    pub severity: Severity,
    /// Names of the channels concerned; empty if all are.
    pub channels: Vec<String>,
    /// What was found.
    pub finding: Finding,
    /// What can be done about it in this case; empty if nothing but the general advice helps.
    pub remedies: Vec<Remedy>,
}

impl Warning {
    /// A warning that concerns all channels, with the severity of most findings of its kind and
    /// without a remedy of its own.
    pub fn new(kind: WarningKind, finding: Finding) -> Self {
        Self { kind, severity: kind.severity(), channels: Vec::new(), finding, remedies: Vec::new() }
    }

    /// A warning of these channels; `None` if there are none.
    pub(crate) fn of_any(kind: WarningKind, finding: Finding, channels: Vec<String>) -> Option<Self> {
        (!channels.is_empty()).then(|| Self::new(kind, finding).of(channels))
    }

    /// The same, of these channels.
    pub fn of(self, channels: impl IntoIterator<Item = String>) -> Self {
        Self { channels: channels.into_iter().collect(), ..self }
    }

    /// The same, with another severity.
    pub fn as_severe_as(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }

    /// The same, with one more remedy.
    pub fn cured_by(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }
}

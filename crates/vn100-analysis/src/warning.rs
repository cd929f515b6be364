//! Warnings as data: the kind, the severity, the channels, what was found, and what can be done. The
//! words for them are those of the faces.

pub(crate) mod checks;
mod finding;

pub use finding::{Doubt, Doubtful, Event, Finding, Happening, Peak, Rejected};

use crate::remedy::Remedy;

/// The kinds of warning, whose names are a contract with scripts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WarningKind {
    /// The record, or the recording that was made of it, is not whole.
    Incomplete,
    /// Bytes arrive, but no sample of a message that is measured.
    NoValidLines,
    /// Valid frames of a message other than the measured one are excluded.
    OtherMessages,
    /// Another program uses the link, or the sensor reports errors that answer no command.
    LinkErrors,
    /// The sensor, its rate or its printed resolution changed within the record.
    StreamChanged,
    /// Samples, or values of single channels, are missing.
    Gaps,
    /// Sentences, packets or rows were rejected, or carry no checksum.
    RejectedLines,
    /// Sentences, packets or rows repeat earlier ones.
    RepeatedLines,
    /// There are too few samples for a deviation, or for more than a rough one.
    TooShort,
    /// The sample rate is unknown.
    RateAssumed,
    /// The measured rate is none of the sensor's, or not the nominal one.
    RateOffNominal,
    /// The time stamps step backwards, are uneven, or cannot be those of a sensor.
    StampsDoubtful,
    /// A spectrum has peaks: vibration, or an alternating magnetic field.
    VibrationLine,
    /// The sensor was moved, or mean or noise changed during the record.
    NotStationary,
    /// The level settled at the beginning of the record, as when a sensor warms up.
    WarmUp,
    /// The bias follows the temperature of the sensor significantly.
    FollowsTemperature,
    /// The magnitude of the mean acceleration or magnetic field is not that of the Earth.
    MagnitudeOff,
    /// A filter of the sensor has removed the bias from the rates.
    CompensatedStream,
    /// Whether a filter has removed the bias from the rates is not known.
    CompensationUnknown,
    /// A low-pass filter slower than the output removes the high frequencies, or may do so.
    LowPass,
    /// Settings of the sensor turn its axes, or differ from what was given.
    SensorSettings,
    /// The resolution of the values hides the noise.
    QuantisationFloor,
    /// Besides white noise there is noise correlated over seconds.
    CorrelatedNoise,
    /// A channel reaches the end of its range.
    FullRange,
    /// Columns of a file hold magnitudes that their unit makes impossible.
    UnitDoubtful,
}

/// The kinds in their order, each with its code and what most of its findings mean for the result.
const KINDS: [(WarningKind, &str, Severity); 25] = [
    (WarningKind::Incomplete, "incomplete", Severity::Problem),
    (WarningKind::NoValidLines, "no-valid-lines", Severity::Problem),
    (WarningKind::OtherMessages, "other-messages", Severity::Caution),
    (WarningKind::LinkErrors, "link-errors", Severity::Problem),
    (WarningKind::StreamChanged, "stream-changed", Severity::Problem),
    (WarningKind::Gaps, "gaps", Severity::Caution),
    (WarningKind::RejectedLines, "bad-lines", Severity::Caution),
    (WarningKind::RepeatedLines, "repeated-lines", Severity::Problem),
    (WarningKind::TooShort, "too-short", Severity::Caution),
    (WarningKind::RateAssumed, "rate-assumed", Severity::Caution),
    (WarningKind::RateOffNominal, "rate-off-nominal", Severity::Caution),
    (WarningKind::StampsDoubtful, "stamps-doubtful", Severity::Caution),
    (WarningKind::VibrationLine, "vibration-line", Severity::Caution),
    (WarningKind::NotStationary, "not-stationary", Severity::Caution),
    (WarningKind::WarmUp, "warm-up", Severity::Caution),
    (WarningKind::FollowsTemperature, "follows-temperature", Severity::Caution),
    (WarningKind::MagnitudeOff, "magnitude-off", Severity::Caution),
    (WarningKind::CompensatedStream, "compensated-stream", Severity::Note),
    (WarningKind::CompensationUnknown, "compensation-unknown", Severity::Caution),
    (WarningKind::LowPass, "low-pass", Severity::Caution),
    (WarningKind::SensorSettings, "sensor-settings", Severity::Note),
    (WarningKind::QuantisationFloor, "quantisation-floor", Severity::Caution),
    (WarningKind::CorrelatedNoise, "correlated-noise", Severity::Caution),
    (WarningKind::FullRange, "full-range", Severity::Problem),
    (WarningKind::UnitDoubtful, "unit-doubtful", Severity::Problem),
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
    #[must_use]
    pub const fn name(self) -> &'static str {
        KINDS[self as usize].1
    }

    /// What most findings of this kind mean for the result.
    #[must_use]
    pub const fn severity(self) -> Severity {
        KINDS[self as usize].2
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
    /// All severities, the gravest first.
    pub const ALL: [Self; 3] = [Self::Problem, Self::Caution, Self::Note];

    /// The code of the severity.
    #[must_use]
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
    #[must_use]
    pub fn new(kind: WarningKind, finding: Finding) -> Self {
        Self { kind, severity: kind.severity(), channels: Vec::new(), finding, remedies: Vec::new() }
    }

    /// The same, of these channels.
    #[must_use]
    pub fn of(self, channels: impl IntoIterator<Item = String>) -> Self {
        Self { channels: channels.into_iter().collect(), ..self }
    }

    /// The same, with another severity.
    #[must_use]
    pub fn as_severe_as(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }

    /// The same, with one more remedy.
    #[must_use]
    pub fn cured_by(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }
}

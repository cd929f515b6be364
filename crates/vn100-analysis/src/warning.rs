//! Warnings: kinds, channels and texts.

pub(crate) mod advice;

use std::fmt;

use crate::remedy::{RemedyWords, Text};

/// The kinds of warning, by the names scripts may rely on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum WarningKind {
    /// The recording that was made meanwhile is not whole.
    RecordingFailed,
    /// Bytes arrive, and no sample is among them.
    NoValidLines,
    /// Valid sentences of another message are excluded.
    OtherMessages,
    /// The sensor has more to send than its line carries.
    LinkBudget,
    /// The sensor reported unsolicited errors.
    DeviceErrors,
    /// The message carries values corrected by the sensor's own filter.
    CompensatedStream,
    /// Whether the values are corrected by a filter is not known.
    CompensationUnknown,
    /// The sensor averages and decimates: its white noise reads higher, or at short tau lower.
    DecimatedStream,
    /// Another sensor answered in mid-stream.
    AnotherSensor,
    /// The sample rate is unknown.
    RateAssumed,
    /// The sensor's rate changed in mid-stream.
    RateChanged,
    /// The measured rate is none the sensor has, or not the one taken.
    RateOffNominal,
    /// Some arrival stamps lie before earlier ones.
    StampsBackwards,
    /// The arrival stamps cannot be a sensor's.
    StampsRefused,
    /// Lines arrive several at a time.
    BunchedArrival,
    /// Samples are missing.
    Gaps,
    /// Lines were damaged.
    RejectedLines,
    /// Rows lack values of some channels.
    AbsentValues,
    /// Lines carry no checksum.
    UncheckedLines,
    /// Lines repeat earlier ones.
    RepeatedLines,
    /// The sensor's printed resolution changed in mid-stream.
    PrintFormat,
    /// A channel repeats very few values.
    StuckDigits,
    /// A spectrum has peaks: something shakes the sensor, or an alternating field is near.
    VibrationLine,
    /// Besides white noise there is noise correlated over seconds.
    CorrelatedNoise,
    /// A filter slower than the output takes the high frequencies.
    LowPass,
    /// Lines leave less than half of the frequencies to the noise.
    LineFreeBand,
    /// Something happened in the middle of the record.
    NotStationary,
    /// The level settled from the beginning on, as of a sensor that warms up.
    WarmUp,
    /// The bias follows the temperature of the sensor.
    FollowsTemperature,
    /// A channel's noise is less than its last printed digit.
    QuantisationFloor,
    /// A channel reaches the end of its sensor's range.
    FullRange,
    /// An angle turned so far that its count had to start anew.
    AngleRestarted,
    /// Columns of a file hold magnitudes that their unit makes impossible.
    UnitDoubtful,
    /// The mean acceleration is not as long as gravity.
    GravityMagnitude,
    /// The mean magnetic field is not as long as the Earth's.
    FieldMagnitude,
    /// Yaw is worse than pitch and roll.
    YawFromMagnetometer,
    /// Too few samples for any deviation, or for more than a rough one.
    TooShort,
}

impl WarningKind {
    /// The kind's name in results: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RecordingFailed => "recording-failed",
            Self::NoValidLines => "no-valid-lines",
            Self::OtherMessages => "other-messages",
            Self::LinkBudget => "link-budget",
            Self::DeviceErrors => "device-errors",
            Self::CompensatedStream => "compensated-stream",
            Self::CompensationUnknown => "compensation-unknown",
            Self::DecimatedStream => "decimated-stream",
            Self::AnotherSensor => "another-sensor",
            Self::RateAssumed => "rate-assumed",
            Self::RateChanged => "rate-changed",
            Self::RateOffNominal => "rate-off-nominal",
            Self::StampsBackwards => "stamps-backwards",
            Self::StampsRefused => "stamps-refused",
            Self::BunchedArrival => "bunched-arrival",
            Self::Gaps => "gaps",
            Self::RejectedLines => "bad-lines",
            Self::AbsentValues => "absent-values",
            Self::UncheckedLines => "unchecked-lines",
            Self::RepeatedLines => "repeated-lines",
            Self::PrintFormat => "print-format",
            Self::StuckDigits => "stuck-digits",
            Self::VibrationLine => "vibration-line",
            Self::CorrelatedNoise => "correlated-noise",
            Self::LowPass => "low-pass",
            Self::LineFreeBand => "line-free-band",
            Self::NotStationary => "not-stationary",
            Self::WarmUp => "warm-up",
            Self::FollowsTemperature => "follows-temperature",
            Self::QuantisationFloor => "quantisation-floor",
            Self::FullRange => "full-range",
            Self::AngleRestarted => "angle-restarted",
            Self::UnitDoubtful => "unit-doubtful",
            Self::GravityMagnitude => "gravity-magnitude",
            Self::FieldMagnitude => "field-magnitude",
            Self::YawFromMagnetometer => "yaw-from-magnetometer",
            Self::TooShort => "too-short",
        }
    }
}

/// One warning.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// What kind it is.
    pub kind: WarningKind,
    /// The channels it concerns, by name; empty when it concerns all.
    pub channels: Vec<String>,
    /// What was seen, why it matters, what to try.
    pub text: Text,
}

impl Warning {
    pub(crate) fn new(kind: WarningKind, channels: Vec<String>, text: impl Into<Text>) -> Self {
        Self { kind, channels, text: text.into() }
    }

    /// Kind and text, with what the user can do by the names of a face.
    #[must_use]
    pub fn in_words(&self, words: RemedyWords) -> String {
        format!("{}: {}", self.kind.name(), self.text.in_words(words))
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.name(), self.text)
    }
}

//! Warnings: kinds, channels and texts.

pub(crate) mod advice;

use std::fmt;

use crate::remedy::{RemedyWords, Text};

/// The kinds of warning, by the names scripts may rely on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WarningKind {
    /// The recording that was made meanwhile is not whole.
    RecordingFailed,
    /// The measurement ended before what was asked for was measured.
    EndedEarly,
    /// Bytes arrive, and no sample is among them.
    NoValidLines,
    /// Valid sentences of another message are excluded.
    OtherMessages,
    /// The sensor has more to send than its line carries.
    LinkBudget,
    /// The sensor reported unsolicited errors.
    DeviceErrors,
    /// Another program has the port open too.
    PortShared,
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
    /// Numbers of a bag were taken for absent, and are not.
    UnreadValues,
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
    /// The sensor turns its measurements into the axes of a vehicle.
    RotatedAxes,
    /// Yaw is worse than pitch and roll.
    YawFromMagnetometer,
    /// Too few samples for any deviation, or for more than a rough one.
    TooShort,
}

impl WarningKind {
    /// All of them.
    pub const ALL: [Self; 41] = [
        Self::RecordingFailed,
        Self::EndedEarly,
        Self::NoValidLines,
        Self::OtherMessages,
        Self::LinkBudget,
        Self::DeviceErrors,
        Self::PortShared,
        Self::CompensatedStream,
        Self::CompensationUnknown,
        Self::DecimatedStream,
        Self::AnotherSensor,
        Self::RateAssumed,
        Self::RateChanged,
        Self::RateOffNominal,
        Self::StampsBackwards,
        Self::StampsRefused,
        Self::BunchedArrival,
        Self::Gaps,
        Self::RejectedLines,
        Self::AbsentValues,
        Self::UnreadValues,
        Self::UncheckedLines,
        Self::RepeatedLines,
        Self::PrintFormat,
        Self::StuckDigits,
        Self::VibrationLine,
        Self::CorrelatedNoise,
        Self::LowPass,
        Self::LineFreeBand,
        Self::NotStationary,
        Self::WarmUp,
        Self::FollowsTemperature,
        Self::QuantisationFloor,
        Self::FullRange,
        Self::AngleRestarted,
        Self::UnitDoubtful,
        Self::GravityMagnitude,
        Self::FieldMagnitude,
        Self::RotatedAxes,
        Self::YawFromMagnetometer,
        Self::TooShort,
    ];

    /// The kind's name in results: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RecordingFailed => "recording-failed",
            Self::EndedEarly => "ended-early",
            Self::NoValidLines => "no-valid-lines",
            Self::OtherMessages => "other-messages",
            Self::LinkBudget => "link-budget",
            Self::DeviceErrors => "device-errors",
            Self::PortShared => "port-shared",
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
            Self::UnreadValues => "unread-values",
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
            Self::RotatedAxes => "rotated-axes",
            Self::YawFromMagnetometer => "yaw-from-magnetometer",
            Self::TooShort => "too-short",
        }
    }

    /// What it means for the result; where the sensor was moved, [`WarningKind::NotStationary`] is
    /// a problem, and of a capture [`WarningKind::EndedEarly`] a note.
    #[must_use]
    pub const fn severity(self) -> Severity {
        match self {
            Self::RecordingFailed
            | Self::EndedEarly
            | Self::NoValidLines
            | Self::LinkBudget
            | Self::PortShared
            | Self::AnotherSensor
            | Self::RateChanged
            | Self::RepeatedLines
            | Self::StuckDigits
            | Self::FullRange
            | Self::UnreadValues
            | Self::UnitDoubtful => Severity::Problem,
            Self::OtherMessages
            | Self::DeviceErrors
            | Self::CompensationUnknown
            | Self::RateAssumed
            | Self::RateOffNominal
            | Self::StampsBackwards
            | Self::StampsRefused
            | Self::Gaps
            | Self::RejectedLines
            | Self::AbsentValues
            | Self::UncheckedLines
            | Self::PrintFormat
            | Self::VibrationLine
            | Self::CorrelatedNoise
            | Self::LowPass
            | Self::LineFreeBand
            | Self::NotStationary
            | Self::WarmUp
            | Self::FollowsTemperature
            | Self::QuantisationFloor
            | Self::GravityMagnitude
            | Self::FieldMagnitude
            | Self::TooShort => Severity::Caution,
            Self::CompensatedStream
            | Self::DecimatedStream
            | Self::BunchedArrival
            | Self::AngleRestarted
            | Self::RotatedAxes
            | Self::YawFromMagnetometer => Severity::Note,
        }
    }
}

/// What a warning means for the result, the gravest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Numbers of the result are wrong, or not those of the sensor, or the record is not whole.
    Problem,
    /// Numbers of the result are less certain, or mean less.
    Caution,
    /// A property of the stream that its reader should know; healthy sensors have it, too.
    Note,
}

impl Severity {
    /// All of them, the gravest first.
    pub const ALL: [Self; 3] = [Self::Problem, Self::Caution, Self::Note];

    /// Its name in results.
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
    /// What kind it is.
    pub kind: WarningKind,
    /// What it means for the result.
    pub severity: Severity,
    /// The channels it concerns, by name; empty when it concerns all.
    pub channels: Vec<String>,
    /// What was found, in some words without a full stop.
    pub headline: String,
    /// Why it matters and what to do, in sentences; empty where the headline says it all.
    pub details: Text,
}

impl Warning {
    /// With the severity of its kind.
    #[must_use]
    pub fn new(
        kind: WarningKind,
        channels: Vec<String>,
        headline: impl Into<String>,
        details: impl Into<Text>,
    ) -> Self {
        Self { kind, severity: kind.severity(), channels, headline: headline.into(), details: details.into() }
    }

    /// Kind and headline: one line.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}: {}", self.kind.name(), self.headline)
    }

    /// Headline and details, with what the user can do by the names of a face.
    #[must_use]
    pub fn in_words(&self, words: RemedyWords) -> String {
        self.with_details(&self.details.in_words(words))
    }

    fn with_details(&self, details: &str) -> String {
        match details {
            "" => self.headline.clone(),
            _ if self.headline.ends_with('?') => format!("{} {details}", self.headline),
            _ => format!("{}. {details}", self.headline),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.name(), self.with_details(&self.details.to_string()))
    }
}

//! Warnings: kinds, severities, channels and texts.

pub(crate) mod advice;

use std::fmt;

use crate::remedy::{RemedyWords, Text};

/// The kinds of warning, whose names are a contract with scripts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WarningKind {
    /// The recording made during the measurement is not complete.
    RecordingFailed,
    /// The recording that was replayed was cut: its file has no end.
    RecordingCut,
    /// The measurement ended before all that was asked for was measured.
    EndedEarly,
    /// Bytes arrive, but no sample of a message that is measured.
    NoValidLines,
    /// Valid frames of a message other than the measured one are excluded.
    OtherMessages,
    /// The sensor has more to send than its baud rate has room for.
    LinkBudget,
    /// The sensor reported unsolicited errors.
    DeviceErrors,
    /// Another program has the port open as well.
    PortShared,
    /// The message carries values that the attitude filter of the sensor has corrected.
    CompensatedStream,
    /// Whether the values are corrected by a filter is not known.
    CompensationUnknown,
    /// The sensor averages and decimates: aliasing raises its white noise, or averaging lowers it
    /// at short averaging times.
    DecimatedStream,
    /// Another sensor answered within the record.
    AnotherSensor,
    /// The sample rate is unknown.
    RateAssumed,
    /// The rate of the sensor changed within the record.
    RateChanged,
    /// The measured rate is none of the sensor's, or not the nominal one.
    RateOffNominal,
    /// Some arrival stamps lie before earlier ones.
    StampsBackwards,
    /// The arrival stamps cannot be those of a sensor.
    StampsRefused,
    /// Sentences arrive several at a time.
    BunchedArrival,
    /// Samples were dropped.
    Gaps,
    /// Sentences or rows were rejected.
    RejectedLines,
    /// Rows lack values of some channels.
    AbsentValues,
    /// Numbers of a bag were treated as absent, although they are not.
    UnreadValues,
    /// Sentences carry no checksum.
    UncheckedLines,
    /// Sentences or rows repeat earlier ones.
    RepeatedLines,
    /// The resolution of the printed values changed within the record.
    PrintFormat,
    /// A channel takes no more than two values.
    StuckDigits,
    /// A spectrum has peaks: vibration, or an alternating magnetic field.
    VibrationLine,
    /// Besides white noise there is noise correlated over seconds.
    CorrelatedNoise,
    /// A low-pass filter slower than the output removes the high frequencies.
    LowPass,
    /// The spectrum may be that of a filter slower than the output.
    PossibleFilter,
    /// Spectral peaks leave less than half of the band to the noise.
    LineFreeBand,
    /// The sensor was moved, or mean or noise changed during the record.
    NotStationary,
    /// The level settled at the beginning of the record, as when a sensor warms up.
    WarmUp,
    /// The bias follows the temperature of the sensor significantly.
    FollowsTemperature,
    /// The noise of a channel from sample to sample is less than half a step of its values.
    QuantisationFloor,
    /// A channel reaches the end of the range of its sensor.
    FullRange,
    /// An angle turned so far that its count of turns started anew.
    AngleRestarted,
    /// Columns of a file hold magnitudes that their unit makes impossible.
    UnitDoubtful,
    /// The magnitude of the mean acceleration is not that of gravity.
    GravityMagnitude,
    /// The magnitude of the mean magnetic field is not that of the Earth.
    FieldMagnitude,
    /// The sensor turns its measurements into the axes of a vehicle.
    RotatedAxes,
    /// Yaw varies much more than pitch and roll.
    YawFromMagnetometer,
    /// There are too few samples for a deviation, or for more than a rough one.
    TooShort,
}

impl WarningKind {
    /// All kinds.
    pub const ALL: [Self; 43] = [
        Self::RecordingFailed,
        Self::RecordingCut,
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
        Self::PossibleFilter,
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

    /// The code of the kind: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RecordingFailed => "recording-failed",
            Self::RecordingCut => "recording-cut",
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
            Self::PossibleFilter => "possible-filter",
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

    /// What a warning of this kind means for the result. A single warning may differ: where the
    /// sensor was moved [`WarningKind::NotStationary`] is a problem, and for a capture
    /// [`WarningKind::EndedEarly`] is a note.
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
            Self::RecordingCut
            | Self::OtherMessages
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
            | Self::PossibleFilter
            | Self::AngleRestarted
            | Self::RotatedAxes
            | Self::YawFromMagnetometer => Severity::Note,
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
    /// Names of the channels concerned; empty where all are.
    pub channels: Vec<String>,
    /// What was found, in a few words without a full stop.
    pub headline: String,
    /// Why it matters and what to do, in sentences; empty where the headline is enough.
    pub details: Text,
}

impl Warning {
    /// A warning with the severity of its kind.
    #[must_use]
    pub fn new(
        kind: WarningKind,
        channels: Vec<String>,
        headline: impl Into<String>,
        details: impl Into<Text>,
    ) -> Self {
        Self { kind, severity: kind.severity(), channels, headline: headline.into(), details: details.into() }
    }

    /// Kind and headline, in one line.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}: {}", self.kind.name(), self.headline)
    }

    /// Headline and details, with the remedies in the words of a face.
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

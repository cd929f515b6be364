//! What a warning found, in numbers and names, and of which kind that is.

use imu_noise::timebase::{Refusal, Unevenness};
use schemars::JsonSchema;
use vn100_protocol::stream::{MessageName, RejectedRowCounts};
use vn100_protocol::{DeviceError, PacketHeader, Quantity};

use super::{Aspect, Severity};
use crate::{motion::Motion, rate_change::RateChange};

/// Meaning, code, aspect and usual severity of each kind.
macro_rules! kinds {
    ($($(#[$meaning:meta])* $kind:ident = $code:literal, $aspect:ident, $severity:ident;)*) => {
        /// The kinds of warning, whose names are a contract with scripts.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, JsonSchema)]
        pub enum WarningKind {
            $($(#[$meaning])* #[schemars(rename = $code)] $kind,)*
        }

        impl WarningKind {
            /// All kinds.
            pub const ALL: [Self; [$($code),*].len()] = [$(Self::$kind),*];

            /// The code of the kind: lower case, words joined by hyphens.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $code,)*
                }
            }

            /// What warnings of this kind concern.
            pub const fn aspect(self) -> Aspect {
                match self {
                    $(Self::$kind => Aspect::$aspect,)*
                }
            }

            /// What most findings of this kind mean for the result.
            pub const fn severity(self) -> Severity {
                match self {
                    $(Self::$kind => Severity::$severity,)*
                }
            }
        }
    };
}

kinds! {
    /// The record, or the recording that was made of it, is not whole.
    Incomplete = "incomplete", Data, Problem;
    /// Bytes arrived, but no sample of a message that is measured.
    NoValidLines = "no-valid-lines", Data, Problem;
    /// Sentences or packets of a message other than the measured one were excluded.
    OtherMessages = "other-messages", Data, Caution;
    /// Another program has the port of the sensor open, or the sensor reported errors that answer
    /// no command.
    LinkErrors = "link-errors", Data, Problem;
    /// The sensor, its output rate or its printed resolution changed within the record.
    StreamChanged = "stream-changed", Data, Problem;
    /// Samples, or values of single channels, are missing; each gap keeps its place on the time
    /// axis.
    Gaps = "gaps", Data, Caution;
    /// Sentences, packets or rows were rejected, or carry no checksum.
    RejectedLines = "bad-lines", Data, Caution;
    /// Samples repeat earlier ones exactly, which a live sensor does not do.
    RepeatedLines = "repeated-lines", Data, Problem;
    /// There are too few samples for a deviation, or for more than a rough one.
    TooShort = "too-short", Data, Caution;
    /// The capture does not contain the sample rate; the factory default of 40 Hz is assumed.
    RateAssumed = "rate-assumed", Time, Caution;
    /// The measured rate is none of the sensor's, not the nominal one, or unsure because many
    /// samples are missing.
    RateOffNominal = "rate-off-nominal", Time, Caution;
    /// Time stamps step backwards, are uneven or cannot be those of a sensor, or the sensor
    /// restarted.
    StampsDoubtful = "stamps-doubtful", Time, Caution;
    /// The spectrum has significant peaks: vibration, or an alternating magnetic field.
    VibrationLine = "vibration-line", AtRest, Caution;
    /// The sensor was moved, or mean or noise changed during the record.
    NotStationary = "not-stationary", AtRest, Caution;
    /// The level settled at the beginning of the record, as when a sensor warms up.
    WarmUp = "warm-up", AtRest, Caution;
    /// The bias follows the temperature of the sensor significantly.
    FollowsTemperature = "follows-temperature", AtRest, Caution;
    /// The magnitude of the mean acceleration or magnetic field is not that of the Earth.
    MagnitudeOff = "magnitude-off", AtRest, Caution;
    /// An attitude filter has removed its estimate of the bias from the rates.
    CompensatedStream = "compensated-stream", Message, Note;
    /// The capture does not contain whether a filter has removed the bias of the gyroscope.
    CompensationUnknown = "compensation-unknown", Message, Caution;
    /// A low-pass filter slower than the output removes the high frequencies.
    LowPass = "low-pass", Message, Caution;
    /// The sensor turns its axes (register 26), or averages otherwise than was given (register 85).
    SensorSettings = "sensor-settings", Message, Note;
    /// From sample to sample the noise is less than half a step of the values.
    QuantisationFloor = "quantisation-floor", Values, Caution;
    /// Besides white noise there is noise correlated over seconds.
    CorrelatedNoise = "correlated-noise", Values, Caution;
    /// A channel reaches the end of its range, or the count of its turns began anew.
    FullRange = "full-range", Values, Problem;
    /// A column holds magnitudes that its unit makes impossible.
    UnitDoubtful = "unit-doubtful", Values, Problem;
}

/// What was found. Counts are of the whole record; times are in seconds of data, with what was
/// skipped at the beginning.
#[derive(Debug, Clone, PartialEq)]
pub enum Finding {
    /// A fault of a recording or of an end, in the words of the face that knows it.
    Said(String),
    /// The file of a recording has no end, or a part before it is missing.
    RecordingCut,
    /// A link carries this many replies and no measurement, though register 6 may hold an output.
    OnlyReplies(u64, Option<String>),
    /// Binary packets and valid sentences, the first of them of this name; none is measured.
    NothingMeasured(u64, u64, Option<MessageName>),
    /// This many bytes hold no valid sentence.
    NoSentence(u64),
    /// No sample is measured, and sentences, packets or rows were rejected, of this many.
    AllRejected(Rejected, u64, u64),
    /// Sentences beside the measured message, the first of them of this name.
    OtherSentences(u64, MessageName, String),
    /// Packets beside the measured message, the first of them with this header.
    OtherPackets(u64, Option<PacketHeader>, String),
    /// Parts of packets that the sensor split.
    SplitPackets(u64),
    /// An error of the sensor that answers no command, and how often it came.
    DeviceError(DeviceError, u64),
    /// The program that has the port open too.
    PortShared(String),
    /// The output rate changed, and this many samples at another rate are excluded.
    RateChanged(RateChange, u64),
    /// Samples placed by a false rate are excluded.
    FalseRate {
        /// How many.
        samples: u64,
        /// The rate by arrival times, which the sensor contradicted, in hertz.
        arrival_hz: f64,
        /// The sensor's rate, in hertz.
        device_hz: f64,
    },
    /// Samples that came in a burst at another rate are excluded.
    BurstExcluded(u64),
    /// Serial numbers of two sensors, and whether the samples of the second are excluded.
    TwoSensors([String; 2], bool),
    /// How often the number of printed decimals changed.
    DecimalsChanged(u64),
    /// Samples that were dropped, the gaps they make, and the samples that are there.
    Dropped {
        /// Dropped samples.
        missing: u64,
        /// Runs of dropped samples.
        gaps: u64,
        /// Samples that arrived.
        samples: u64,
    },
    /// How often the sensor's own time stepped ahead.
    TimeSteps(u64),
    /// Of this many rows, those that lack the value of a channel.
    Absent(u64, Vec<(String, u64)>),
    /// Values beyond those of the first rows, of this many rows.
    OutOfRange(u64, u64),
    /// Sentences, packets or rows that were not read as they stand, of this many.
    Rejected(Rejected, u64, u64),
    /// Samples that repeat an earlier one, of this many.
    Repeated(u64, u64),
    /// So few samples.
    TooShort(u64),
    /// The rate that is assumed, in hertz.
    RateAssumed(f64),
    /// By the rate in hertz this share of the samples is missing.
    RateUnsure(f64, f64),
    /// Samples arrive at a rate, in hertz, that is none of the sensor's.
    RateNotListed(f64),
    /// The measured and the nominal rate, in hertz.
    RateOff(f64, f64),
    /// The rate, in hertz, by the times in the packets; a VN-100 sends at 800 Hz over a whole number.
    PacketRate(f64),
    /// A register sets one rate for packets, in hertz, and their own times show another.
    RegisterRate(u8, f64, f64),
    /// The sensor reports a rate that its samples do not have.
    FalseReport {
        /// The rate that the sensor reports in register 7, in hertz.
        reported_hz: f64,
        /// The rate by arrival times, that of the record, in hertz.
        arrival_hz: f64,
    },
    /// How often time stamps step backwards.
    Backwards(u64),
    /// Rows out of order or with a false time, which were put in order.
    Reordered(u64),
    /// How often the sensor restarted, and its own time with it.
    Restarts(u64),
    /// The stamps are not used; whether the link disconnected after that.
    StampsRefused(Refusal, bool),
    /// The share of the samples that arrive with the one before, and their number in one read.
    Together(f64, f64),
    /// Rows at the beginning that had waited.
    Flushed(u64),
    /// The stamps are uneven, and the rate is that of all rows.
    Uneven(Unevenness),
    /// Peaks of the spectrum, the strongest first.
    Peaks(Vec<Peak>),
    /// Peaks cover more than half of the band.
    NoFreeBand,
    /// The sensor was moved.
    Moved(Motion),
    /// What happened, in the order of its time.
    Events(Vec<Happening>),
    /// Channels that start off their level: amplitude and unit, the time constant in seconds, and
    /// whether the level settles within the record.
    WarmUp(Vec<(String, f64, String, f64, bool)>),
    /// The channel that follows the temperature most, and the largest share of its variance, 0 to 1.
    Temperature(String, f64),
    /// The magnitude of the mean acceleration, in m/s².
    Gravity(f64),
    /// The magnitude of the mean magnetic field, in gauss.
    Field(f64),
    /// A message that holds compensated values.
    Compensated(String),
    /// The deviation falls below the white noise, as if a filter removed the bias.
    BiasTracked,
    /// Nothing says whether the values are compensated.
    MaybeCompensated,
    /// White noise is correlated over so many samples.
    LowPass(f64),
    /// Register 26 holds a rotation.
    Rotated,
    /// The averaging window that was given, and those of accelerometer and gyroscope in register 85;
    /// `None` if no channel has such a window.
    WindowIgnored(u32, Option<[u32; 2]>),
    /// No more than two values.
    TwoValues,
    /// The noise is less than half a step of the values.
    RoundedAway,
    /// Processes beside white noise: channel, standard deviation and unit, correlation time in
    /// seconds, and the density of the random walk that longer times show.
    Correlated(Vec<(String, f64, String, f64, f64)>),
    /// Samples that the sensor reports at the end of a range, by axis, from and to these seconds.
    Saturated(u64, Vec<(String, u64)>, [f64; 2]),
    /// Values at the end of the range.
    RangeReached,
    /// Angles turned so far that their count of turns began anew.
    TurnsRestarted,
    /// Magnitudes that the unit makes impossible.
    UnitDoubtful(Vec<Doubtful>),
}

impl Finding {
    /// The kind of a warning of this.
    pub const fn kind(&self) -> WarningKind {
        match self {
            Self::Said(_) | Self::RecordingCut => WarningKind::Incomplete,
            Self::OnlyReplies(..) | Self::NothingMeasured(..) | Self::NoSentence(_) | Self::AllRejected(..) => {
                WarningKind::NoValidLines
            }
            Self::OtherSentences(..) | Self::OtherPackets(..) | Self::SplitPackets(_) => WarningKind::OtherMessages,
            Self::DeviceError(..) | Self::PortShared(_) => WarningKind::LinkErrors,
            Self::RateChanged(..) | Self::FalseRate { .. } | Self::BurstExcluded(_) => WarningKind::StreamChanged,
            Self::TwoSensors(..) | Self::DecimalsChanged(_) => WarningKind::StreamChanged,
            Self::Dropped { .. } | Self::TimeSteps(_) | Self::Absent(..) | Self::OutOfRange(..) => WarningKind::Gaps,
            Self::Rejected(..) => WarningKind::RejectedLines,
            Self::Repeated(..) => WarningKind::RepeatedLines,
            Self::TooShort(_) => WarningKind::TooShort,
            Self::RateAssumed(_) => WarningKind::RateAssumed,
            Self::RateUnsure(..) | Self::RateNotListed(_) | Self::RateOff(..) => WarningKind::RateOffNominal,
            Self::PacketRate(_) | Self::RegisterRate(..) | Self::FalseReport { .. } => WarningKind::RateOffNominal,
            Self::Backwards(_) | Self::Reordered(_) | Self::Restarts(_) => WarningKind::StampsDoubtful,
            Self::StampsRefused(..) | Self::Together(..) => WarningKind::StampsDoubtful,
            Self::Flushed(_) | Self::Uneven(_) => WarningKind::StampsDoubtful,
            Self::Peaks(_) | Self::NoFreeBand => WarningKind::VibrationLine,
            Self::Moved(_) | Self::Events(_) => WarningKind::NotStationary,
            Self::WarmUp(_) => WarningKind::WarmUp,
            Self::Temperature(..) => WarningKind::FollowsTemperature,
            Self::Gravity(_) | Self::Field(_) => WarningKind::MagnitudeOff,
            Self::Compensated(_) | Self::BiasTracked => WarningKind::CompensatedStream,
            Self::MaybeCompensated => WarningKind::CompensationUnknown,
            Self::LowPass(_) => WarningKind::LowPass,
            Self::Rotated | Self::WindowIgnored(..) => WarningKind::SensorSettings,
            Self::TwoValues | Self::RoundedAway => WarningKind::QuantisationFloor,
            Self::Correlated(_) => WarningKind::CorrelatedNoise,
            Self::Saturated(..) | Self::RangeReached | Self::TurnsRestarted => WarningKind::FullRange,
            Self::UnitDoubtful(_) => WarningKind::UnitDoubtful,
        }
    }
}

/// Why frames or rows were not read, or were read with a doubt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rejected {
    /// Rows of a table, by reason.
    Rows(RejectedRowCounts),
    /// Sentences with a checksum mismatch, or malformed.
    Sentences,
    /// Sentences that are malformed, all of them.
    Malformed,
    /// Packets with a checksum mismatch.
    Packets,
    /// Packets with numbers that no sensor measures.
    PacketNumbers,
    /// Packets with a time that fits neither neighbour.
    PacketTimes,
    /// Sentences without a checksum.
    NoChecksum,
    /// Sentences without a checksum, which were accepted.
    AcceptedUnchecked,
}

/// A peak of the spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Peak {
    /// Frequency in hertz.
    pub frequency_hz: f64,
    /// Channels, and the share of the peak in the variance of each, 0 to 1; the largest first.
    pub axes: Vec<(String, f64)>,
    /// Frequencies in hertz that alias to this one.
    pub aliases_hz: Vec<f64>,
    /// The harmonic of the mains, in hertz, that an alternating field at this frequency may be.
    pub mains_hz: Option<f64>,
}

/// What happened on one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Happening {
    /// The channel.
    pub channel: String,
    /// From and to these seconds; `None` if it has no place.
    pub span_s: Option<(f64, f64)>,
    /// What it was.
    pub what: Event,
}

/// A disturbance of a record at rest.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// So many standard deviations off.
    Sigmas(f64),
    /// A step of the level, with its unit.
    Step(f64, String),
    /// A cycle of the level: period in seconds, amplitude and unit.
    Cycle(f64, f64, String),
    /// The noise is this many times as large.
    NoiseFactor(f64),
    /// The level of the noise varies this many times as much as that of even noise.
    Bursts(f64),
    /// The value stayed the same for these seconds.
    Frozen(f64),
    /// Outliers, and the standard deviations of the largest.
    Outliers(u64, f64),
}

/// A quantity whose unit is doubtful.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubtful {
    /// The quantity.
    pub quantity: Quantity,
    /// What is impossible about the value.
    pub by: Doubt,
    /// The value, in the unit of the channel.
    pub value: f64,
    /// The unit it is read in.
    pub read: String,
    /// The unit that fits.
    pub likely: &'static str,
}

/// What is impossible about a magnitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doubt {
    /// The mean.
    Mean,
    /// The largest value.
    Largest,
    /// The noise from sample to sample.
    Noise,
}

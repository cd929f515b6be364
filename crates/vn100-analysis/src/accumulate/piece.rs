//! Pieces of a record that are analysed separately and appended.
//!
//! What a snapshot says of the samples of the whole record is the same, bit by bit, in any order in
//! which neighbours are appended: sums, spectra, blocks, disturbances, fingerprint, magnitudes, a
//! temperature that the stream carries, the counts of the link. Angles are brought to the branch of
//! the piece before. Not covered:
//!
//! - Rows with arrival times: the detector of dropped samples weighs each by all before it. The
//!   clock of the sensor, outages and changes of rate belong to them.
//! - A temperature that was asked for between the rows, and a quaternion that changes its sign from
//!   piece to piece. These three are errors.
//! - Whether later pieces repeat the first one as a loop does: its rows are not kept.
//! - The last minutes for a screen, which are those of the last piece.

use thiserror::Error;

/// What of a record precedes a piece of it. All fields are 0 for the record itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PieceStart {
    /// Data time before the first row of the piece, in samples: those that count, those excluded
    /// and those missing, including the rejected rows directly before the piece.
    pub index: u64,
    /// The samples that count before the piece, and those missing since the first of them.
    pub places: u64,
    /// The samples that count before the piece.
    pub samples: u64,
}

/// Why a piece of a record cannot be appended to another. Nothing was appended.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NotAppended {
    /// The samples are of different messages, or their counts have different scales.
    #[error("the pieces hold different messages or channels: append pieces of one stream")]
    OtherMessage,
    /// The pieces were analysed with different settings.
    #[error("the pieces were analysed with different settings: analyse both with the same")]
    OtherSettings,
    /// The pieces have different rates.
    #[error("the pieces have the rates {hz} Hz and {next_hz} Hz: give the rate of the record for both")]
    OtherRate {
        /// The rate of the piece before.
        hz: f64,
        /// The rate of the piece to be appended.
        next_hz: f64,
    },
    /// The rate changed within a piece, and samples are excluded because of the change.
    #[error("the rate changes within a piece: what is excluded then depends on all that came before")]
    RateChanged,
    /// Rows of a piece were placed by their arrival times, or the link was lost: which samples are
    /// missing then depends on all earlier arrival times.
    #[error("rows of a piece have arrival times, by which samples are placed with all those before: analyse it whole")]
    ByArrival,
    /// The row counters of the piece do not continue those of the piece before.
    #[error(transparent)]
    OtherCounter(#[from] imu_timebase::OtherCounter),
    /// Only one of the two has row counters, so that it is not known what is missing in the other.
    #[error("one of the pieces has counters, the other has none: append pieces of one stream")]
    CounterInOne,
    /// The temperature was polled between the rows: its sums begin with the first reading.
    #[error("a piece relates its axes to a temperature that was asked for from time to time: analyse it whole")]
    PolledTemperature,
    /// The piece does not begin where the piece before ends, or after that.
    #[error(
        "the piece starts after {} samples in {} places, the one before ends after {} in {}: append neighbours \
         in order of time, each started with what precedes it",
        next.samples, next.places, end.samples, end.places
    )]
    OtherPlace {
        /// The end of the piece before.
        end: PieceStart,
        /// The start of the piece to be appended.
        next: PieceStart,
    },
    /// The quaternion of the sensor changed its sign before the piece began.
    #[error("the quaternion continues with the other sign: analyse the record whole")]
    OtherSign,
    /// An angle turns so far that its counts leave their range, or that a turn is no multiple of
    /// the width of its histogram bins.
    #[error("channel {channel} turns too far: analyse the record whole")]
    Turned {
        /// Place of the angle in the message, from 0.
        channel: usize,
    },
    /// The sums of a channel cannot be appended.
    #[error(transparent)]
    Sums(#[from] imu_noise::PieceNotAppended),
}

state_bytes::encoded!(PieceStart { index, places, samples });

//! Pieces of a record that are analysed by themselves, and appended.
//!
//! What a snapshot says of the samples of the whole is the same, bit by bit, in any order of
//! appending neighbours: sums, spectra, blocks, disturbances, fingerprint, magnitudes, the
//! temperature that the stream has, what the link carried. Angles are brought to the branch of the
//! piece before. Not part of it:
//!
//! - Rows with arrival times: the detector of dropped samples weighs each by all before it. The
//!   clock of the sensor, outages and changes of rate belong to them.
//! - A temperature that was asked for between the rows, and a quaternion that changes its sign from
//!   piece to piece. These three are errors.
//! - Whether later pieces repeat the first one as a loop does: its rows are not kept.
//! - The last minutes for a screen, which are those of the last piece.

use thiserror::Error;

/// What of a record lies before a piece of it. All 0 for the record itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PieceStart {
    /// Data time before the first row of the piece, in samples: those that count, those excluded
    /// and those missing, rejected rows right before it too.
    pub index: u64,
    /// The samples that count, and those missing since the first of them.
    pub places: u64,
    /// The samples that count.
    pub samples: u64,
}

/// Why a piece of a record cannot be appended to another. Nothing was appended.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NotAppended {
    /// The samples are of different messages, or their counts of different size.
    #[error("the pieces hold different messages or channels: append pieces of one stream")]
    OtherMessage,
    /// They were analysed with different settings.
    #[error("the pieces were analysed with different settings: analyse both with the same")]
    OtherSettings,
    /// Their rates differ.
    #[error("the pieces have the rates {hz} Hz and {next_hz} Hz: give the rate of the record for both")]
    OtherRate {
        /// Of the piece before.
        hz: f64,
        /// Of the piece to be appended.
        next_hz: f64,
    },
    /// The rate changed within a piece, and samples are excluded for that.
    #[error("the rate changes within a piece: what is excluded then depends on all that came before")]
    RateChanged,
    /// Rows of a piece were placed by their arrival times, or the link was lost: which samples are
    /// missing then depends on all times before.
    #[error("rows of a piece have arrival times, by which samples are placed with all those before: analyse it whole")]
    ByArrival,
    /// The counters of the rows do not continue those of the piece before.
    #[error(transparent)]
    OtherCounter(#[from] imu_noise::OtherCounter),
    /// Only the rows of one have counters, so that it is not known what is missing in the other.
    #[error("one of the pieces has counters, the other has none: append pieces of one stream")]
    CounterInOne,
    /// The temperature was asked for between the rows: its sums begin with the first answer.
    #[error("a piece relates its axes to a temperature that was asked for from time to time: analyse it whole")]
    PolledTemperature,
    /// One does not begin where the other ends, or behind it.
    #[error(
        "the piece starts after {} samples in {} places, the one before ends after {} in {}: append neighbours \
         in order of time, each started with what precedes it",
        next.samples, next.places, end.samples, end.places
    )]
    OtherPlace {
        /// Where the piece before ends.
        end: PieceStart,
        /// Where the other was begun.
        next: PieceStart,
    },
    /// The quaternion of the sensor changed its sign before the piece began.
    #[error("the quaternion continues with the other sign: analyse the record whole")]
    OtherSign,
    /// An angle turns so far that its counts leave their range, or that the bins of its histogram
    /// have another width than a turn is a multiple of.
    #[error("channel {channel} turns too far: analyse the record whole")]
    Turned {
        /// Its place in the message, from 0.
        channel: usize,
    },
    /// The sums of a channel do not belong together.
    #[error(transparent)]
    Sums(#[from] imu_noise::PieceNotAppended),
}

imu_noise::encoded!(PieceStart { index, places, samples });

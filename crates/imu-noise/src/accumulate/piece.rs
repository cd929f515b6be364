//! Where a piece of a record lies on the grid of absolute indices.

use std::fmt;

/// No gap reaches beyond, whatever it claims: two million years at 800 Hz, with room behind for all
/// samples there will ever be.
const FARTHEST: u64 = 1 << 56;

/// The places of a piece, present or missing. A break parts it into runs; the first and the last
/// one may continue in the pieces before and behind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Absolute index of the first place.
    pub(crate) start: u64,
    /// Absolute index behind the last place.
    pub(crate) end: u64,
    /// Where the first run ended, if it has.
    first_break: Option<u64>,
}

impl Piece {
    pub(crate) const fn starting_at(index: u64) -> Self {
        Self { start: index, end: index, first_break: None }
    }

    /// Of so many missing samples, those that have a place.
    pub(crate) fn room_for(&self, missing: u64) -> u64 {
        missing.min(FARTHEST.saturating_sub(self.end))
    }

    /// Ends the run.
    pub(crate) fn part(&mut self) {
        self.first_break.get_or_insert(self.end);
    }

    pub(crate) const fn is_parted(&self) -> bool {
        self.first_break.is_some()
    }

    pub(crate) fn first_run_end(&self) -> u64 {
        self.first_break.unwrap_or(self.end)
    }

    pub(crate) const fn check_follows(&self, next: &Self) -> Result<(), PieceNotAppended> {
        if next.start < self.end {
            return Err(PieceNotAppended::Overlap { end: self.end, first_sample: next.start });
        }
        Ok(())
    }

    pub(crate) fn append(&mut self, next: &Self) {
        self.first_break = self.first_break.or(next.first_break);
        self.end = next.end;
    }
}

/// Why a piece of a record cannot be appended to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceNotAppended {
    /// The piece begins before the other ends.
    Overlap {
        /// Absolute index after the last sample of the piece before.
        end: u64,
        /// Absolute index of the first sample of the piece to be appended.
        first_sample: u64,
    },
    /// The piece was begun after another number of samples.
    OtherSamples {
        /// Number of samples up to the end of the piece before.
        samples: u64,
        /// Number of samples after which the piece to be appended was begun.
        samples_before: u64,
    },
    /// The piece was accumulated with another estimator, deviation, or choice of kept sums.
    OtherKind,
}

impl fmt::Display for PieceNotAppended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap { end, first_sample } => write!(
                f,
                "the piece begins at sample {first_sample}, the one before ends at sample {end}: append pieces in \
                 order of time, each once"
            ),
            Self::OtherSamples { samples, samples_before } => write!(
                f,
                "the piece starts after {samples_before} samples, but {samples} precede it: start it after those"
            ),
            Self::OtherKind => write!(
                f,
                "the pieces were accumulated with different estimators or deviations: accumulate both with the same"
            ),
        }
    }
}

impl std::error::Error for PieceNotAppended {}

state_bytes::encoded!(Piece { start, end, first_break } if |piece| {
    piece.start <= piece.end && piece.first_break.is_none_or(|place| (piece.start..=piece.end).contains(&place))
});

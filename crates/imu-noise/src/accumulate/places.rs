//! How far the absolute indices of a record reach.

/// No gap reaches beyond, whatever it claims: two million years at 800 Hz, with room after it for
/// all samples there will ever be.
const FARTHEST: u64 = 1 << 56;

/// Of so many missing samples after the index `end`, those that have a place.
pub(crate) fn room_for(end: u64, missing: u64) -> u64 {
    missing.min(FARTHEST.saturating_sub(end))
}

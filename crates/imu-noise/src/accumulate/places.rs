//! The range of the absolute indices of a record.

/// No gap reaches beyond this index, for any claimed length: two million years at 800 Hz, with room
/// after it for all further samples.
const FARTHEST: u64 = 1 << 56;

/// The number of these missing samples after the index `end` that have a place.
pub(crate) fn room_for(end: u64, missing: u64) -> u64 {
    missing.min(FARTHEST.saturating_sub(end))
}

//! The last values of a level, before the next ones.

use crate::accumulate::stretch::Stretch;

/// The most windows per averaging time: neighbouring clusters are this many values apart at most.
pub(super) const MAX_LAG: usize = 16;

/// The most values that a level remembers: those of two clusters, for third differences.
pub(super) const MEMORY: usize = 2 * MAX_LAG;

/// Room for the values that a level remembers, followed by the new ones from [`MEMORY`] on.
pub(super) type Scratch<T> = [T; MEMORY + Stretch::MOST];

/// The last `len` values in `memory`, followed by the `new` values in `scratch`, of which the last are remembered.
#[inline(always)]
pub(super) fn continued<'a, T: Copy>(
    memory: &mut [T; MEMORY],
    len: usize,
    scratch: &'a mut Scratch<T>,
    new: usize,
) -> &'a [T] {
    // always all places, because a copy of constant length is a few moves
    scratch[..MEMORY].copy_from_slice(memory);
    memory.copy_from_slice(&scratch[new..new + MEMORY]);
    &scratch[MEMORY - len..MEMORY + new]
}

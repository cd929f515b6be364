//! The last values of a level, and the pairs that they make with the next ones.

use crate::accumulate::stretch::Stretch;

/// The most windows per averaging time, and the most values that a level remembers.
pub(super) const MAX_LAG: usize = 16;

/// Room for the values that a level remembers, followed by the new ones from [`MAX_LAG`] on.
pub(super) type Scratch<T> = [T; MAX_LAG + Stretch::MOST];

/// Pairs of values `lag` places apart among the remembered values in `memory` and the `new` values in
/// `scratch`: the older and the newer ones, as slices of equal length. The last values are remembered.
#[inline(always)]
pub(super) fn pairs<'a, T: Copy>(
    memory: &mut [T; MAX_LAG],
    remembered: usize,
    scratch: &'a mut Scratch<T>,
    new: usize,
    lag: usize,
) -> (&'a [T], &'a [T]) {
    // always all places, because a copy of constant length is a few moves
    scratch[..MAX_LAG].copy_from_slice(memory);
    memory.copy_from_slice(&scratch[new..new + MAX_LAG]);
    let values = &scratch[MAX_LAG - remembered..MAX_LAG + new];
    let kept = values.len().min(lag);
    let pairs = values.len() - kept;
    (&values[..pairs], &values[kept..])
}

pub(super) fn from_end<T>(values: &[T], len: usize) -> &[T] {
    &values[values.len() - len..]
}

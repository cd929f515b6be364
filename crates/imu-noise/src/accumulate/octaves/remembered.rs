//! The last values of a level, and the pairs that they make with the next ones.

use crate::accumulate::stretch::Stretch;

/// Most windows per averaging time, and most values that a level remembers.
pub(super) const MAX_LAG: usize = 16;

/// Room for the values that a level remembers, followed from [`MAX_LAG`] on by the new ones.
pub(super) type Scratch<T> = [T; MAX_LAG + Stretch::MOST];

/// Values `lag` places apart among the last ones of `memory`, which are remembered, and the `new`
/// ones of `scratch`: older and newer, as slices of equal length. The last values are remembered.
#[inline(always)]
pub(super) fn pairs<'a, T: Copy>(
    memory: &mut [T; MAX_LAG],
    remembered: usize,
    scratch: &'a mut Scratch<T>,
    new: usize,
    lag: usize,
) -> (&'a [T], &'a [T]) {
    // always all places: a copy of constant length is a few moves
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

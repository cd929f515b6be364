//! The places of a record from the first open segment on.

use std::ops::Range;

/// The values at successive indices, some of them missing.
#[derive(Clone, Debug, Default)]
pub(super) struct Places<T> {
    pub(super) first: u64,
    pub(super) values: Vec<T>,
    missing: Vec<Range<u64>>,
}

impl<T: Copy + Default> Places<T> {
    fn end(&self) -> u64 {
        self.first + self.values.len() as u64
    }

    /// The `N` places from `start` on, if they are kept and none is missing.
    pub(super) fn whole<const N: usize>(&self, start: u64) -> Option<&[T; N]> {
        let values = self.values.get(start.checked_sub(self.first)? as usize..)?.first_chunk()?;
        let has_missing = |missing: &Range<u64>| missing.start < start + N as u64 && start < missing.end;
        (!self.missing.iter().any(has_missing)).then_some(values)
    }

    pub(super) fn miss(&mut self, places: u64) {
        if places > 0 {
            self.missing.push(self.end()..self.end() + places);
            self.values.resize(self.values.len() + places as usize, T::default());
        }
    }

    pub(super) fn drop_before(&mut self, first: u64) {
        let before = usize::try_from(first.saturating_sub(self.first)).unwrap_or(usize::MAX);
        self.values.drain(..before.min(self.values.len()));
        self.missing.retain(|missing| missing.end > first);
        self.first = first;
    }

    pub(super) fn clear(&mut self) {
        self.values.clear();
        self.missing.clear();
    }
}

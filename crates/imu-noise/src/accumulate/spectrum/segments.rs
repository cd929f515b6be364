//! The places of a record that belong to a segment.

use std::{mem, ops::Range};

use super::LONG;

use crate::accumulate::places::room_for;

/// Segments begin at multiples of half their length.
const STEP: u64 = LONG as u64 / 2;

/// Up to this many samples every segment is taken.
const DENSE_SAMPLES: u64 = 32_768;

/// With this many complete long segments, the short ones are not used.
pub(super) const MIN_LONG_SEGMENTS: u64 = 8;

/// Finds the segments of a record, which begin at multiples of half their length of the absolute index.
#[derive(Clone, Debug)]
pub(super) struct Segments<T> {
    /// Absolute index of the next place.
    end: u64,
    /// Samples of the record so far: they determine the spacing of segments.
    samples: u64,
    counts_missing: bool,
    /// The places from the first open segment on.
    recent: Places<T>,
    open: Vec<Segment>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) start: u64,
    /// The number of segments that it represents.
    pub(super) stands_for: u64,
    /// Whether short segments are taken from it as well, although none of its samples is missing.
    pub(super) is_early: bool,
}

/// The values at successive indices, some of them missing.
#[derive(Clone, Debug)]
pub(super) struct Places<T> {
    first: u64,
    values: Vec<T>,
    missing: Vec<Range<u64>>,
}

impl<T: Copy + Default> Segments<T> {
    pub(super) fn new(counts_missing: bool) -> Self {
        Self { end: 0, samples: 0, counts_missing, recent: Places::new(), open: Vec::new() }
    }

    pub(super) const fn count_missing(&mut self) {
        self.counts_missing = true;
    }

    /// The index after the last place.
    pub(super) const fn end(&self) -> u64 {
        self.end
    }

    /// Adds values; `ended` receives each segment that ends, with its places.
    pub(super) fn push(&mut self, mut counts: &[T], mut ended: impl FnMut(&Places<T>, &Segment)) {
        while !counts.is_empty() {
            self.begin_segment();
            let (now, later) = counts.split_at(self.room(counts.len() as u64));
            if !self.open.is_empty() {
                self.recent.values.extend_from_slice(now);
            }
            self.samples += now.len() as u64;
            self.continue_by(now.len() as u64, &mut ended);
            counts = later;
        }
    }

    /// Samples are missing here.
    pub(super) fn gap(&mut self, missing: u64, mut ended: impl FnMut(&Places<T>, &Segment)) {
        let end = self.end + room_for(self.end, missing);
        // segments that begin and end in the gap have no sample
        let ended_before = self.end + LONG as u64;
        let resumed = end.saturating_sub(LONG as u64) / STEP * STEP;
        while self.end < end {
            if (ended_before..resumed).contains(&self.end) {
                self.open.clear();
                self.recent.clear();
                self.miss(resumed - self.end, &mut ended);
            }
            self.begin_segment();
            let places = self.room(end - self.end) as u64;
            if !self.open.is_empty() {
                self.recent.miss(places);
            }
            self.miss(places, &mut ended);
        }
    }

    /// No segment reaches across this place.
    pub(super) fn part(&mut self, mut ended: impl FnMut(&Places<T>, &Segment)) {
        self.end_all(&mut ended);
    }

    /// The incomplete segments, and their places.
    pub(super) fn open(&self) -> (&[Segment], &Places<T>) {
        (&self.open, &self.recent)
    }

    /// The number of these places up to the next start of a segment.
    fn room(&self, places: u64) -> usize {
        (STEP - self.end % STEP).min(places) as usize
    }

    fn begin_segment(&mut self) {
        let start = self.end;
        if !start.is_multiple_of(STEP) {
            return;
        }
        let stands_for = stands_for(self.samples);
        if start.is_multiple_of(STEP * stands_for) {
            if self.open.is_empty() {
                self.recent.first = start;
            }
            let is_early = self.samples < MIN_LONG_SEGMENTS * STEP;
            self.open.push(Segment { start, stands_for, is_early });
        }
    }

    fn miss(&mut self, places: u64, ended: &mut impl FnMut(&Places<T>, &Segment)) {
        self.samples += if self.counts_missing { places } else { 0 };
        self.continue_by(places, ended);
    }

    fn continue_by(&mut self, places: u64, ended: &mut impl FnMut(&Places<T>, &Segment)) {
        self.end += places;
        if self.end.is_multiple_of(STEP) {
            self.end_full(self.end, ended);
        }
    }

    fn end_full(&mut self, end: u64, ended: &mut impl FnMut(&Places<T>, &Segment)) {
        let is_full = |segment: &Segment| segment.start + LONG as u64 <= end;
        let full = self.open.iter().take_while(|segment| is_full(segment)).count();
        self.open.drain(..full).for_each(|segment| ended(&self.recent, &segment));
        match self.open.first() {
            Some(first) => self.recent.drop_before(first.start),
            None => self.recent.clear(),
        }
    }

    fn end_all(&mut self, ended: &mut impl FnMut(&Places<T>, &Segment)) {
        mem::take(&mut self.open).iter().for_each(|segment| ended(&self.recent, segment));
        self.recent.clear();
    }
}

impl<T: Copy + Default> Places<T> {
    const fn new() -> Self {
        Self { first: 0, values: Vec::new(), missing: Vec::new() }
    }

    fn end(&self) -> u64 {
        self.first + self.values.len() as u64
    }

    /// The `N` places from `start` on, if they are kept and none is missing.
    pub(super) fn whole<const N: usize>(&self, start: u64) -> Option<&[T; N]> {
        let values = self.values.get(start.checked_sub(self.first)? as usize..)?.first_chunk()?;
        let has_missing = |missing: &Range<u64>| missing.start < start + N as u64 && start < missing.end;
        (!self.missing.iter().any(has_missing)).then_some(values)
    }

    fn miss(&mut self, places: u64) {
        if places > 0 {
            self.missing.push(self.end()..self.end() + places);
            self.values.resize(self.values.len() + places as usize, T::default());
        }
    }

    fn drop_before(&mut self, first: u64) {
        let before = usize::try_from(first.saturating_sub(self.first)).unwrap_or(usize::MAX);
        self.values.drain(..before.min(self.values.len()));
        self.missing.retain(|missing| missing.end > first);
        self.first = first;
    }

    fn clear(&mut self) {
        self.values.clear();
        self.missing.clear();
    }
}

/// The number of segments that one represents at this number of samples: 1, 2, 4, ...
fn stands_for(samples: u64) -> u64 {
    match (samples / DENSE_SAMPLES).checked_ilog2() {
        None => 1,
        Some(octave) => 2 << octave,
    }
}

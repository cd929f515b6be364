//! Which places of a record belong to one segment, however the record comes in pieces.

use std::{mem, ops::Range};

use super::LONG;
use state_bytes::Encoded;

use crate::accumulate::piece::Piece;

/// Segments begin at multiples of half their length.
const STEP: u64 = LONG as u64 / 2;

/// Samples within which every segment is taken.
const DENSE_SAMPLES: u64 = 32_768;

/// So many long segments without a gap are enough not to read the short ones.
pub(super) const MIN_LONG_SEGMENTS: u64 = 8;

/// Finds the segments of a record, at multiples of half their length of the absolute index.
///
/// A piece keeps the places that segments which begin in the piece before reach, and those of the
/// segments that it does not fill.
#[derive(Clone, Debug)]
pub(super) struct Segments<T> {
    piece: Piece,
    /// Samples of the record so far: they say how far apart segments are taken.
    samples: u64,
    counts_missing: bool,
    head: Places<T>,
    /// From the first open segment on.
    recent: Places<T>,
    open: Vec<Segment>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) start: u64,
    /// Segments of which it is one.
    pub(super) stands_for: u64,
    /// Short segments are taken from it too, though no sample of it is missing.
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
        Self {
            piece: Piece::starting_at(0),
            samples: 0,
            counts_missing,
            head: Places::from(0),
            recent: Places::from(0),
            open: Vec::new(),
        }
    }

    pub(super) const fn count_missing(&mut self) {
        self.counts_missing = true;
    }

    /// A piece that begins at this index, with so many samples of the record before it.
    pub(super) fn start_at(&mut self, index: u64, samples: u64) {
        (self.piece, self.samples, self.head) = (Piece::starting_at(index), samples, Places::from(index));
    }

    /// Behind the last place.
    pub(super) const fn end(&self) -> u64 {
        self.piece.end
    }

    /// `ended` gets each segment that ends, with its places.
    pub(super) fn push(&mut self, mut counts: &[T], mut ended: impl FnMut(&Places<T>, &Segment)) {
        while !counts.is_empty() {
            self.begin_segment();
            let (now, later) = counts.split_at(self.room(counts.len() as u64));
            if !self.open.is_empty() {
                self.recent.values.extend_from_slice(now);
            }
            self.head.values.extend_from_slice(&now[..now.len().min(self.room_of_head())]);
            self.samples += now.len() as u64;
            self.continue_by(now.len() as u64, &mut ended);
            counts = later;
        }
    }

    /// Samples are missing here.
    pub(super) fn gap(&mut self, missing: u64, mut ended: impl FnMut(&Places<T>, &Segment)) {
        let end = self.piece.end + self.piece.room_for(missing);
        let head = (end - self.piece.end).min(self.room_of_head() as u64);
        self.head.miss(head);
        // segments that begin and end in the gap have no sample
        let ended_before = self.piece.end + LONG as u64;
        let resumed = end.saturating_sub(LONG as u64) / STEP * STEP;
        while self.piece.end < end {
            if (ended_before..resumed).contains(&self.piece.end) {
                self.open.clear();
                self.recent.clear();
                self.miss(resumed - self.piece.end, &mut ended);
            }
            self.begin_segment();
            let places = self.room(end - self.piece.end) as u64;
            if !self.open.is_empty() {
                self.recent.miss(places);
            }
            self.miss(places, &mut ended);
        }
    }

    /// No segment reaches across this place.
    pub(super) fn part(&mut self, mut ended: impl FnMut(&Places<T>, &Segment)) {
        self.end_all(&mut ended);
        self.piece.part();
    }

    /// Continues with a piece that begins at the end of this one, or behind it.
    pub(super) fn append(&mut self, next: &Self, mut ended: impl FnMut(&Places<T>, &Segment)) {
        match next.piece.start.saturating_sub(self.piece.end) {
            0 => {}
            between => self.gap(between, &mut ended),
        }
        self.head.append(&next.head, self.room_of_head());
        if !self.open.is_empty() {
            self.recent.append(&next.head, LONG);
            self.end_full(next.head.end(), &mut ended);
        }
        if next.piece.is_parted() {
            self.end_all(&mut ended);
        }
        if self.open.is_empty() {
            self.recent.clone_from(&next.recent);
        }
        // else all of the next piece is among the recent places already
        self.open.extend(&next.open);
        self.samples = next.samples;
        self.piece.append(&next.piece);
    }

    pub(super) fn shift(&mut self, shifted: impl Fn(T) -> T) {
        self.head.values.iter_mut().chain(&mut self.recent.values).for_each(|value| *value = shifted(*value));
    }

    /// The segments that have begun, and their places.
    pub(super) fn open(&self) -> (&[Segment], &Places<T>) {
        (&self.open, &self.recent)
    }

    /// Of so many places, those up to the next one at which a segment may begin.
    fn room(&self, places: u64) -> usize {
        (STEP - self.piece.end % STEP).min(places) as usize
    }

    /// As far as a segment reaches that begins before the piece: none does before index 0.
    fn room_of_head(&self) -> usize {
        let has_room = self.piece.start > 0 && !self.piece.is_parted();
        if has_room { (LONG - 1).saturating_sub(self.head.values.len()) } else { 0 }
    }

    fn begin_segment(&mut self) {
        let start = self.piece.end;
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
        self.piece.end += places;
        if self.piece.end.is_multiple_of(STEP) {
            self.end_full(self.piece.end, ended);
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
    const fn from(first: u64) -> Self {
        Self { first, values: Vec::new(), missing: Vec::new() }
    }

    fn end(&self) -> u64 {
        self.first + self.values.len() as u64
    }

    /// The `N` places from `start` on, if they are here and none is missing.
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

    /// The places of `next` that follow the last one here, so many at most.
    fn append(&mut self, next: &Self, most: usize) {
        let more = next.values.len().min(most);
        self.values.extend_from_slice(&next.values[..more]);
        let within = next.missing.iter().map(|missing| missing.start..missing.end.min(next.first + more as u64));
        self.missing.extend(within.filter(|missing| !missing.is_empty()));
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

/// Segments in place of which one at this number of samples is taken: 1, 2, 4, ...
fn stands_for(samples: u64) -> u64 {
    match (samples / DENSE_SAMPLES).checked_ilog2() {
        None => 1,
        Some(octave) => 2 << octave,
    }
}

state_bytes::encoded!(Segment { start, stands_for, is_early } if |segment| segment.stands_for.is_power_of_two());
state_bytes::encoded!(@[T: Encoded] Places<T> { first, values, missing } if |places| {
    places.values.len() <= 2 * LONG && places.missing.iter().all(|missing| missing.start <= missing.end)
});
state_bytes::encoded!(@[T: Encoded] Segments<T> { piece, samples, counts_missing, head, recent, open } if |segments| {
    // none begins in another step than one of the last two
    segments.open.len() <= 2 && segments.head.values.len() < LONG
});

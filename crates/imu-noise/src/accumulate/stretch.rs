//! A short part of a record: the places with and without a sample.

const WORD: usize = u64::BITS as usize;

/// Successive places of a record, at most [`MOST`](Self::MOST), each with a sample or without one.
/// All channels of a stream can share it.
///
/// ```
/// use imu_noise::Stretch;
///
/// let mut stretch = Stretch::EMPTY;
/// stretch.push(3, true);
/// stretch.push(2, false);
/// assert_eq!((stretch.places(), stretch.samples()), (5, 3));
/// assert_eq!(stretch.runs_of(&[7, 8, 9]).collect::<Vec<_>>(), [(0, &[7, 8, 9][..]), (2, &[])]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stretch {
    places: usize,
    /// One bit for each place, the first in the lowest bit; those after the last place are 0.
    present: [u64; Self::MOST / WORD],
}

impl Stretch {
    /// The most places of a stretch.
    pub const MOST: usize = 256;

    /// A stretch without places.
    pub const EMPTY: Self = Self { places: 0, present: [0; Self::MOST / WORD] };

    /// This many places with a sample; at most [`MOST`](Self::MOST).
    pub fn full(samples: usize) -> Self {
        let mut stretch = Self::EMPTY;
        stretch.push(samples, true);
        stretch
    }

    /// Adds places, with or without samples. Returns the number for which there was room.
    pub fn push(&mut self, places: usize, with_samples: bool) -> usize {
        let end = self.places + places.min(Self::MOST - self.places);
        let added = end - self.places;
        while with_samples && self.places < end {
            let (word, bit) = (self.places / WORD, self.places % WORD);
            let here = (WORD - bit).min(end - self.places);
            self.present[word] |= u64::MAX >> (WORD - here) << bit;
            self.places += here;
        }
        self.places = end;
        added
    }

    /// The number of places.
    pub const fn places(&self) -> usize {
        self.places
    }

    /// The number of places with a sample.
    pub fn samples(&self) -> usize {
        self.present.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The samples of the stretch in runs without a gap, each with the number of places without a sample
    /// before it. The last run is empty if the stretch ends without a sample, and cut short with `samples`.
    pub fn runs_of<'a, T>(&self, mut samples: &'a [T]) -> impl Iterator<Item = (usize, &'a [T])> + use<'a, T> {
        let stretch = *self;
        let mut place = 0;
        std::iter::from_fn(move || {
            let begin = stretch.end_of_alike(place, false);
            let end = stretch.end_of_alike(begin, true);
            let (run, later) = samples.split_at((end - begin).min(samples.len()));
            let missing = begin - place;
            let has_ended = place == stretch.places;
            (place, samples) = (end, later);
            (!has_ended).then_some((missing, run))
        })
    }

    /// The runs of [`runs_of`](Self::runs_of) that have samples, each with the absolute index of its
    /// first sample, for a stretch that begins at `first_index`.
    pub fn indexed_runs<'a, T>(&self, first_index: u64, samples: &'a [T]) -> impl Iterator<Item = (u64, &'a [T])> {
        let mut index = first_index;
        let runs = self.runs_of(samples).map(move |(missing, run)| {
            let first = index + missing as u64;
            index = first + run.len() as u64;
            (first, run)
        });
        runs.filter(|(_, run)| !run.is_empty())
    }

    /// The stretch without these samples, numbered from 0.
    pub fn without(&self, samples: &[usize]) -> Self {
        let mut left = *self;
        for place in samples.iter().filter_map(|sample| self.place_of(*sample)) {
            left.present[place / WORD] &= !(1 << (place % WORD));
        }
        left
    }

    /// The places before this sample, numbered from 0, and those from it on.
    pub fn split_before_sample(&self, sample: usize) -> [Self; 2] {
        let (mut before, mut after) = (Self::EMPTY, Self::EMPTY);
        let split = self.place_of(sample).unwrap_or(self.places);
        for (place, has_sample) in self.has_sample().enumerate() {
            let part = if place < split { &mut before } else { &mut after };
            part.push(1, has_sample);
        }
        [before, after]
    }

    /// The places with a sample, beginning with the first of the stretch.
    pub(crate) fn has_sample(&self) -> impl Iterator<Item = bool> {
        (0..self.places).map(|place| self.present[place / WORD] >> (place % WORD) & 1 == 1)
    }

    /// The place of a sample, both numbered from 0; `None` if there is no such sample.
    pub fn place_of(&self, sample: usize) -> Option<usize> {
        let mut before = 0;
        for (place, word) in (0..).step_by(WORD).zip(self.present) {
            let samples = word.count_ones() as usize;
            if sample < before + samples {
                // without the lowest ones
                let rest = (before..sample).fold(word, |word, _| word & (word - 1));
                return Some(place + rest.trailing_zeros() as usize);
            }
            before += samples;
        }
        None
    }

    /// The first place from this one on whose presence of a sample differs from `have_samples`; the
    /// end of the stretch if there is none.
    fn end_of_alike(&self, from: usize, have_samples: bool) -> usize {
        let mut place = from;
        while place < self.places {
            let word = self.present[place / WORD];
            let others = (if have_samples { !word } else { word }) >> (place % WORD);
            if others != 0 {
                return (place + others.trailing_zeros() as usize).min(self.places);
            }
            place = (place / WORD + 1) * WORD;
        }
        self.places
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    proptest! {
        #[test]
        fn places_are_those_pushed(
            parts in vec((0_usize..90, any::<bool>()), 0..12),
            lacking in vec(any::<bool>(), 256),
            split in 0_usize..260,
        ) {
            let (mut stretch, mut expected) = (Stretch::EMPTY, Vec::new());
            for (places, with_samples) in parts {
                let room = Stretch::MOST - expected.len();
                prop_assert_eq!(stretch.push(places, with_samples), places.min(room));
                expected.extend(vec![with_samples; places.min(room)]);
            }
            prop_assert_eq!(stretch.has_sample().collect::<Vec<_>>(), expected.clone());
            prop_assert_eq!(stretch.samples(), expected.iter().filter(|present| **present).count());
            let numbers: Vec<_> = (0..stretch.samples()).collect();
            let runs: Vec<_> = stretch.runs_of(&numbers).collect();
            let of_runs = runs.iter().flat_map(|(missing, run)| [vec![false; *missing], vec![true; run.len()]].concat());
            prop_assert_eq!(of_runs.collect::<Vec<_>>(), expected.clone());
            prop_assert_eq!(runs.iter().flat_map(|(_, run)| run.to_vec()).collect::<Vec<_>>(), numbers.clone());
            let [before, after] = stretch.split_before_sample(split);
            let of_parts: Vec<_> = before.has_sample().chain(after.has_sample()).collect();
            prop_assert_eq!(of_parts, expected.clone());
            prop_assert!(before.samples() == split.min(numbers.len()) && after.has_sample().next() != Some(false));
            let lacks: Vec<usize> = (0..256).filter(|sample| lacking[*sample]).collect();
            let left = stretch.without(&lacks);
            let samples = expected.iter_mut().filter(|present| **present);
            samples.zip(&lacking).for_each(|(present, lacks)| *present = !lacks);
            prop_assert_eq!(left.has_sample().collect::<Vec<_>>(), expected);
            let mut indices = stretch.indexed_runs(7, &numbers).flat_map(|(first, run)| (first..).zip(run));
            prop_assert!(indices.all(|(index, number)| stretch.place_of(*number) == Some(index as usize - 7)));
        }
    }
}

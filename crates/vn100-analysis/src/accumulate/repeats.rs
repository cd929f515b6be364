//! Repeated rows: a recording played in a loop, or rows stored twice. A live sensor has none.

use std::{
    collections::HashSet,
    hash::{BuildHasherDefault, Hasher},
};

/// How many rows are remembered: the first ones, because a loop returns to its beginning.
const REMEMBERED: usize = 1024;

/// Counts the rows that equal one of the first 1024 in every channel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Repeats {
    first: HashSet<Box<[i32]>, BuildHasherDefault<RowHasher>>,
    pub(super) repeated: u64,
}

impl Repeats {
    pub(crate) fn push(&mut self, counts: &[i32]) {
        if self.first.contains(counts) {
            self.repeated += 1;
        } else if self.first.len() < REMEMBERED {
            self.first.insert(counts.into());
        }
    }
}

/// The standard hasher, which resists chosen keys, would take longer than the sums of a row.
#[derive(Debug, Clone, Copy, Default)]
struct RowHasher(u64);

impl Hasher for RowHasher {
    fn write(&mut self, bytes: &[u8]) {
        /// The fractional part of the golden ratio, as an odd number.
        const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;
        let (words, _) = bytes.as_chunks::<8>();
        for word in words {
            self.0 = (self.0.rotate_left(29) ^ u64::from_le_bytes(*word)).wrapping_mul(MULTIPLIER);
        }
    }

    fn finish(&self) -> u64 {
        // the low bits of a product are its weakest, and choose the bucket
        self.0 ^ self.0 >> 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeated(rows: impl IntoIterator<Item = [i32; 12]>) -> u64 {
        let mut repeats = Repeats::default();
        rows.into_iter().for_each(|row| repeats.push(&row));
        repeats.repeated
    }

    fn row(i: i32) -> [i32; 12] {
        std::array::from_fn(|channel| (i.wrapping_mul(7919) ^ channel as i32).wrapping_mul(31) % 997)
    }

    #[test]
    fn a_loop_is_counted_from_its_second_pass_on() {
        assert_eq!(repeated((0..449).map(|i| row(i % 163))), 449 - 163);
    }

    #[test]
    fn a_long_loop_shows_by_its_first_lines() {
        assert_eq!(repeated((0..6000).map(|i| [i % 3000; 12])), 1024);
    }

    #[test]
    fn one_differing_channel_is_another_line() {
        for channel in 0..12 {
            let mut other = row(5);
            other[channel] += 1;
            assert_eq!(repeated([row(5), other]), 0, "channel {channel}");
        }
    }

    #[test]
    fn a_line_stored_twice_is_counted_once() {
        assert_eq!(repeated([row(1), row(1), row(2)]), 1);
    }
}

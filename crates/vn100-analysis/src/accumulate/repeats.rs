//! Repeated rows: a recording played in a loop, or rows stored twice.

/// The number of values by which the beginning of the record is recognised, in at least sixteen rows.
const BEGINNING_VALUES: usize = 144;
const BEGINNING_ROWS: usize = 16;

/// Rows of fewer channels equal the row before by chance, and if the signal is slow.
const MIN_CHANNELS_STORED_TWICE: usize = 9;

/// The most rows that are kept of the first pass.
const MOST_KEPT: usize = 1024;

/// Counts repeated rows by their hashes, in bounded memory.
///
/// The record repeats itself if its first rows, sixteen or more of few channels, occur again in order;
/// the rows after them count until one differs from its place in the first pass, of which up to 1024
/// are kept. A row that equals the one before was stored twice, unless that happens by chance: by how
/// often a row equals the second one before. A live sensor repeats neither.
#[derive(Debug, Clone, Default)]
pub(crate) struct Repeats {
    channels: usize,
    beginning: Vec<u64>,
    /// The rows of the first pass whose places are multiples of 2^`every_log2`.
    first_pass: Vec<u64>,
    every_log2: u32,
    /// Rows of the first pass so far.
    rows: u64,
    /// Length of the first pass, once it has ended.
    period: Option<u64>,
    /// How many rows of the beginning the latest rows equal, while the beginning is searched.
    found: usize,
    /// The place of the next row in a pass that has been equal to the first pass so far.
    place: Option<u64>,
    in_passes: u64,
    /// The hashes of the last two rows, the last row first.
    last: [Option<u64>; 2],
    like_last: u64,
    like_one_before: u64,
}

impl Repeats {
    /// For rows of at least one channel.
    pub(crate) fn new(channels: usize) -> Self {
        Self { channels, ..Self::default() }
    }

    /// Rows that repeat earlier ones.
    pub(crate) fn repeated(&self) -> u64 {
        if self.channels < MIN_CHANNELS_STORED_TWICE {
            return self.in_passes;
        }
        let twice = self.like_last.saturating_sub(self.like_one_before);
        let by_chance = 5.0 * ((self.like_last + self.like_one_before) as f64).sqrt();
        let is_chance = self.like_one_before > 0 && (twice as f64) < by_chance;
        self.in_passes.max(if is_chance { 0 } else { twice })
    }

    /// Adds a row by its [`hash`].
    pub(crate) fn push(&mut self, row: u64) {
        let is_like_last = self.last[0] == Some(row);
        self.like_last += u64::from(is_like_last);
        self.like_one_before += u64::from(self.last[1] == Some(row));
        self.last = [Some(row), self.last[0]];
        if self.beginning.len() < self.beginning_rows() {
            // constant rows mark no place
            if is_like_last {
                self.beginning.clear();
                self.first_pass.clear();
                self.rows = 0;
            }
            self.beginning.push(row);
            return self.learn(row);
        }
        match (self.period, self.place) {
            (Some(period), Some(place)) => {
                let kept = self.first_pass[(place >> self.every_log2) as usize];
                let is_kept = place.trailing_zeros() >= self.every_log2;
                self.place = (!is_kept || kept == row).then_some((place + 1) % period);
                self.in_passes += u64::from(self.place.is_some());
            }
            _ => self.search(row),
        }
    }

    fn learn(&mut self, row: u64) {
        if self.first_pass.len() == MOST_KEPT {
            self.first_pass = self.first_pass.iter().copied().step_by(2).collect();
            self.every_log2 += 1;
        }
        if self.rows.trailing_zeros() >= self.every_log2 {
            self.first_pass.push(row);
        }
        self.rows += 1;
    }

    fn search(&mut self, row: u64) {
        if self.period.is_none() {
            self.learn(row);
        }
        let is_next = row == self.beginning[self.found];
        self.found = if is_next { self.found + 1 } else { usize::from(row == self.beginning[0]) };
        if self.found == self.beginning.len() {
            let found = std::mem::take(&mut self.found) as u64;
            let period = *self.period.get_or_insert(self.rows - found);
            self.place = Some(found % period);
            self.in_passes += found;
        }
    }

    fn beginning_rows(&self) -> usize {
        (BEGINNING_VALUES / self.channels.max(1)).max(BEGINNING_ROWS)
    }
}

/// The hash of a row, much faster than by the standard hasher.
pub(crate) fn hash(counts: &[i32]) -> u64 {
    // no product depends on another one
    let weighted = |sum: u64, counts: &[i32]| {
        let products =
            counts.iter().zip(WEIGHTS).map(|(count, weight)| u64::from(count.cast_unsigned()).wrapping_mul(weight));
        products.fold(sum.rotate_left(29), u64::wrapping_add)
    };
    scattered(counts.chunks(WEIGHTS.len()).fold(0, weighted))
}

/// Numbers that are no multiples of two, without a simple relation between them, one for each
/// channel of a message.
const WEIGHTS: [u64; 16] = {
    let (mut weights, mut place) = ([0; 16], 0);
    while place < weights.len() {
        weights[place] = scattered(scattered(place as u64 + 1)) | 1;
        place += 1;
    }
    weights
};

/// A number all bits of which depend on all bits of this one; different numbers give different ones.
const fn scattered(number: u64) -> u64 {
    /// The fractional part of the golden ratio, as an odd number.
    const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;
    // the low bits of a product depend on the fewest bits
    let product = (number ^ number >> 32).wrapping_mul(MULTIPLIER);
    product ^ product >> 32
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn repeated<const CHANNELS: usize>(rows: impl IntoIterator<Item = [i32; CHANNELS]>) -> u64 {
        let mut repeats = Repeats::new(CHANNELS);
        rows.into_iter().for_each(|row| repeats.push(hash(&row)));
        repeats.repeated()
    }

    fn row(i: i32) -> [i32; 12] {
        std::array::from_fn(|channel| (i.wrapping_mul(7919) ^ channel as i32).wrapping_mul(31) % 997)
    }

    proptest! {
        #[test]
        fn a_loop_is_counted_from_its_second_pass_on(period in 16_i32..5000, passes in 1.0..4.0_f64) {
            let rows = (f64::from(period) * passes) as i32;
            let counted = repeated((0..rows).map(|i| [i % period; 12]));
            let truth = if rows - period < BEGINNING_ROWS as i32 { 0 } else { (rows - period) as u64 };
            prop_assert_eq!(counted, truth);
        }
    }

    #[test]
    fn a_loop_that_is_left_is_no_longer_counted() {
        let back = (0..500).chain(0..100).chain(1000..1400);
        assert_eq!(repeated(back.map(row)), 100);
        let again = (0..500).chain(0..100).chain(1000..1400).chain(0..500);
        assert_eq!(repeated(again.map(row)), 600, "only the rows of the first pass are known");
    }

    #[test]
    fn coarse_noise_repeats_rows_by_chance() {
        // one count of noise in each of nine channels: rows that are alike, but no order of them
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 60 == 0) as i32
        };
        let rows: Vec<[i32; 12]> = (0..50_000).map(|_| std::array::from_fn(|_| noise())).collect();
        assert_eq!(repeated(rows), 0);
    }

    #[test]
    fn a_table_of_few_channels_that_was_written_twice_is_counted() {
        let noise = |place: i32| (scattered(place as u64 % 3000) >> 56) as i32;
        assert_eq!(repeated((0..6000).map(|place| [noise(place)])), 3000);
        assert_eq!(repeated((0..6000).map(|place| [noise(place), noise(place + 7), noise(place + 90)])), 3000);
        assert_eq!(repeated((0..6000).map(|place| [place / 2])), 0, "a slow signal");
    }

    #[test]
    fn one_differing_channel_is_another_row() {
        for channel in 0..12 {
            let mut other = row(5);
            other[channel] += 1;
            assert_eq!(repeated([row(5), other]), 0, "channel {channel}");
        }
    }

    #[test]
    fn rows_stored_twice_are_counted_once() {
        assert_eq!(repeated([row(1), row(1), row(2)]), 1);
        assert_eq!(repeated((0..1000).map(|i| row(i / 2))), 500);
        assert_eq!(repeated([row(1); 1000]), 0, "a sensor that stands still");
    }
}

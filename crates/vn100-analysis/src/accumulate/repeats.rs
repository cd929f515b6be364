//! Repeated rows: a recording played in a loop, or rows stored twice.

/// The number of rows by which the beginning of the record is recognised.
const BEGINNING: usize = 16;

/// The most sums that are kept of the first pass.
const MOST_SUMS: usize = 1024;

/// Counts repeated rows, in bounded memory, by sums of their hashes.
///
/// The record repeats itself where its first sixteen rows occur again in order; the rows after them
/// are compared with those of the first pass, in up to 1024 groups of 1, 2, 4, ... rows. A row that
/// equals the row before it was stored twice, unless that happens by chance, which is estimated by
/// how often a row equals the second row before it. A live sensor repeats neither.
#[derive(Debug, Clone)]
pub(crate) struct Repeats {
    beginning: Vec<u64>,
    /// Sums of the first pass, by group.
    sums: Vec<u64>,
    rows_per_sum: u64,
    /// Rows of the first pass since the beginning.
    rows: u64,
    /// Length of the first pass, once it has ended.
    period: Option<u64>,
    /// How many rows of the beginning the latest rows equal, while the beginning is searched.
    found: usize,
    pass: Option<Pass>,
    in_passes: u64,
    /// The hashes of the last two rows, the last row first.
    last: [Option<u64>; 2],
    like_last: u64,
    like_one_before: u64,
}

/// A pass that has been equal to the first pass so far.
#[derive(Debug, Clone, Copy)]
struct Pass {
    rows: u64,
    counted: u64,
    /// Sum over the rows of the present group.
    sum: u64,
}

impl Default for Repeats {
    fn default() -> Self {
        Self {
            beginning: Vec::new(),
            sums: Vec::new(),
            rows_per_sum: 1,
            rows: 0,
            period: None,
            found: 0,
            pass: None,
            in_passes: 0,
            last: [None; 2],
            like_last: 0,
            like_one_before: 0,
        }
    }
}

impl Repeats {
    /// Rows that repeat earlier ones, without those of a group that has not ended.
    pub(crate) fn repeated(&self) -> u64 {
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
        if self.beginning.len() < BEGINNING {
            // constant rows mark no place
            if is_like_last {
                self.beginning.clear();
                self.sums.clear();
                self.rows = 0;
            }
            self.beginning.push(row);
            self.learn(row);
            return;
        }
        if self.period.is_none() {
            self.learn(row);
        }
        match self.pass {
            Some(pass) => self.compare(pass, row),
            None => self.search(row),
        }
    }

    fn learn(&mut self, row: u64) {
        let place = (self.rows / self.rows_per_sum) as usize;
        if place == MOST_SUMS {
            self.sums = self.sums.chunks(2).map(|pair| pair.iter().copied().fold(0, u64::wrapping_add)).collect();
            self.rows_per_sum *= 2;
        }
        self.add(self.rows, row);
        self.rows += 1;
    }

    fn add(&mut self, at: u64, row: u64) {
        let place = (at / self.rows_per_sum) as usize;
        if place == self.sums.len() {
            self.sums.push(0);
        }
        self.sums[place] = self.sums[place].wrapping_add(row);
    }

    fn search(&mut self, row: u64) {
        self.found =
            if row == self.beginning[self.found] { self.found + 1 } else { usize::from(row == self.beginning[0]) };
        if self.found < BEGINNING {
            return;
        }
        self.found = 0;
        if self.period.is_none() {
            // the first rows of the second pass were added to the first pass
            let period = self.rows - BEGINNING as u64;
            for (at, row) in (period..).zip(self.beginning.clone()) {
                self.add(at, row.wrapping_neg());
            }
            self.period = Some(period);
        }
        let beginning = BEGINNING as u64;
        self.in_passes += beginning;
        let grouped = BEGINNING - BEGINNING % self.rows_per_sum as usize;
        let sum = self.beginning[grouped..].iter().copied().fold(0, u64::wrapping_add);
        let rows = if self.period == Some(beginning) { 0 } else { beginning };
        self.pass = Some(Pass { rows, counted: rows, sum });
    }

    fn compare(&mut self, mut pass: Pass, row: u64) {
        let place = (pass.rows / self.rows_per_sum) as usize;
        pass.sum = pass.sum.wrapping_add(row);
        pass.rows += 1;
        let has_ended = self.period == Some(pass.rows);
        if has_ended || pass.rows.is_multiple_of(self.rows_per_sum) {
            if pass.sum != self.sums[place] {
                self.pass = None;
                return;
            }
            self.in_passes += pass.rows - pass.counted;
            (pass.counted, pass.sum) = (pass.rows, 0);
        }
        if has_ended {
            (pass.rows, pass.counted) = (0, 0);
        }
        self.pass = Some(pass);
    }
}

/// The hash of a row. The standard hasher, which resists chosen keys, would take longer than all
/// sums of the row.
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

/// A number all bits of which depend on all bits of this one; different numbers give different
/// ones.
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

    fn repeated(rows: impl IntoIterator<Item = [i32; 12]>) -> u64 {
        let mut repeats = Repeats::default();
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
            let truth = (rows - period) as u64;
            // the rows of a group are counted together, those of the beginning too
            let group = (f64::from(period) / MOST_SUMS as f64).log2().ceil().max(0.0).exp2() as u64;
            prop_assert!(counted <= truth && truth < counted + group.max(BEGINNING as u64), "{} of {}", counted, truth);
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

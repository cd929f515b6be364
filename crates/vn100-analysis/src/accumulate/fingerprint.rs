//! Which rows a record holds, by a sample of their hashes. By this two records of the same samples
//! are distinguished from two records of the same sensor.

/// The most hashes that are kept.
const MOST: usize = 4096;

/// The least number of common hashes: fewer may be equal by chance.
const LEAST_SHARED: usize = 8;

/// The rows whose hashes begin with a number of zeros, chosen so that at most 4096 are kept: of any
/// two records the same rows are kept, whatever surrounds them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Fingerprint {
    zeros: u32,
    /// In the order of the rows.
    hashes: Vec<u64>,
}

impl Fingerprint {
    /// Adds a row by its hash, all 64 bits of which depend on the whole row.
    pub(crate) fn push(&mut self, hash: u64) {
        if hash.leading_zeros() < self.zeros {
            return;
        }
        self.hashes.push(hash);
        while self.hashes.len() > MOST {
            self.zeros += 1;
            self.hashes.retain(|hash| hash.leading_zeros() >= self.zeros);
        }
    }

    /// The shares of the rows of either record that the other holds, in the same order; `None` where
    /// these are no more than by chance. Rows that occur more than once, as of a sensor that hangs, do not count. Common
    /// stretches are detected that are longer than a five hundredth of the longer record.
    pub(crate) fn shared_with(&self, other: &Self) -> Option<[f64; 2]> {
        let zeros = self.zeros.max(other.zeros);
        let [first, second] = [self, other].map(|one| one.places(zeros));
        // places in the second record, in the order of the first
        let mut shared: Vec<(usize, usize)> =
            first.iter().filter_map(|(hash, place)| Some((*place, find(&second, *hash)?))).collect();
        shared.sort_unstable();
        let in_order = shared.windows(2).filter(|pair| pair[0].1 < pair[1].1).count();
        // of rows that are equal by chance half of the neighbours are in order
        let is_same = shared.len() >= LEAST_SHARED && 10 * in_order >= 9 * (shared.len() - 1);
        let part = |of: usize| shared.len() as f64 / of as f64;
        is_same.then(|| [first.len(), second.len()].map(part))
    }

    /// The hashes that occur once, in rising order, with their places.
    fn places(&self, zeros: u32) -> Vec<(u64, usize)> {
        let kept = self.hashes.iter().filter(|hash| hash.leading_zeros() >= zeros);
        let mut places: Vec<(u64, usize)> = kept.enumerate().map(|(place, hash)| (*hash, place)).collect();
        places.sort_unstable();
        let is_single = |group: &&[(u64, usize)]| group.len() == 1;
        places.chunk_by(|a, b| a.0 == b.0).filter(is_single).flatten().copied().collect()
    }
}

fn find(places: &[(u64, usize)], hash: u64) -> Option<usize> {
    let found = places.binary_search_by_key(&hash, |(hash, _)| *hash).ok()?;
    Some(places[found].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SplitMix64, as hashes of rows.
    fn hash(row: u64) -> u64 {
        let mut mixed = row.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    fn of(rows: impl IntoIterator<Item = u64>) -> Fingerprint {
        let mut fingerprint = Fingerprint::default();
        rows.into_iter().for_each(|row| fingerprint.push(hash(row)));
        fingerprint
    }

    #[test]
    fn the_same_rows_are_recognised_and_others_are_not() {
        let whole = of(0..100_000);
        assert!(whole.hashes.len() <= MOST && whole.hashes.len() > MOST / 3);
        assert_eq!(whole.shared_with(&of(0..100_000)), Some([1.0, 1.0]));
        assert_eq!(whole.shared_with(&of(100_000..200_000)), None);
        assert_eq!(whole.shared_with(&of(0..0)), None);
        assert_eq!(of(0..7).shared_with(&of(0..7)), None, "too few to compare");
        assert!(of(0..9).shared_with(&of(0..9)).is_some());
    }

    #[test]
    fn a_part_and_an_overlap_are_known_by_their_share() {
        let whole = of(0..720_000);
        let part = whole.shared_with(&of(300_000..324_000)).unwrap();
        assert!((part[0] / (24.0 / 720.0) - 1.0).abs() < 0.3 && part[1] == 1.0, "{part:?}");
        let overlap = of(0..40_000).shared_with(&of(30_000..60_000)).unwrap();
        assert!((overlap[0] - 0.25).abs() < 0.05 && (overlap[1] - 1.0 / 3.0).abs() < 0.05, "{overlap:?}");
    }

    #[test]
    fn rows_that_come_by_chance_or_again_and_again_do_not_count() {
        // each of few coarse rows many times, in another order
        let coarse = |seed: u64| of((0..50_000).map(move |i| hash(i + seed) % 20_000));
        assert_eq!(coarse(0).shared_with(&coarse(1 << 40)), None);
        let frozen = |from: u64| of((0..3000).map(|_| 5).chain(from..from + 3000));
        assert_eq!(frozen(10_000).shared_with(&frozen(20_000)), None);
    }
}

//! Sums of the axes of a sensor and of its temperature, block by block.

/// The most blocks of a record; when they are full, half as many of twice the length replace them.
pub(crate) const MOST_BLOCKS: u64 = 1024;

/// Binary logarithm of the samples of the shortest block.
const SHORTEST_LOG2: u32 = 5;

/// Sums of the axes of a sensor and of its temperature: exact sums over at most 1024 blocks on the
/// grid of absolute indices, of the smallest power of two of at least 32 samples for which the record
/// fits. At most 113 KiB for six axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TemperatureBlocks {
    length_log2: u32,
    /// For each axis, and last for the temperature, the blocks from absolute index 0 on.
    columns: Vec<Vec<Sums>>,
    /// For each block whether an unknown number of samples is missing in it or after it.
    is_broken: Vec<bool>,
    /// Absolute index of the last sample.
    last: Option<u64>,
}

/// The sum of the values in a block, in counts: exact for up to 2^32 values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sums {
    values: u64,
    sum: i64,
}

impl TemperatureBlocks {
    /// Blocks without samples, for this number of axes.
    pub fn new(axes: usize) -> Self {
        Self { length_log2: SHORTEST_LOG2, columns: vec![Vec::new(); axes + 1], is_broken: Vec::new(), last: None }
    }

    /// Adds samples of one axis, numbered from 0, the first with this absolute index.
    pub fn push_axis(&mut self, axis: usize, first: u64, counts: &[i32]) {
        if axis < self.axes() {
            self.push(axis, first, counts);
            self.last = self.last.max((first + counts.len() as u64).checked_sub(1));
        }
    }

    /// Adds readings of the temperature at successive samples from this index on.
    pub fn push_temperature(&mut self, first: u64, counts: &[i32]) {
        self.push(self.axes(), first, counts);
    }

    /// Marks that an unknown number of samples is missing here: no difference spans this place.
    pub fn part(&mut self) {
        if let Some(last) = self.last {
            self.is_broken[(last >> self.length_log2) as usize] = true;
        }
    }

    /// Number of samples that this axis lacks of those of the axes, and number of all of these.
    pub fn lacks(&self, axis: usize) -> (u64, u64) {
        let samples = (0..self.blocks()).map(|block| self.samples(block)).sum::<u64>();
        (samples - self.columns[axis].iter().map(|sums| sums.values).sum::<u64>(), samples)
    }

    /// Number of axes.
    pub fn axes(&self) -> usize {
        self.columns.len() - 1
    }

    /// The number of places of a block.
    pub(crate) const fn length(&self) -> u64 {
        1 << self.length_log2
    }

    /// The number of blocks, from absolute index 0 on.
    pub(crate) const fn blocks(&self) -> usize {
        self.is_broken.len()
    }

    /// The samples in a block of the axis that has the most.
    pub(crate) fn samples(&self, block: usize) -> u64 {
        self.columns[..self.axes()].iter().map(|sums| sums[block].values).max().unwrap_or(0)
    }

    /// Whether an unknown number of samples is missing in a block or after it.
    pub(crate) fn is_broken(&self, block: usize) -> bool {
        self.is_broken[block]
    }

    /// The mean of an axis in a block, in counts; `None` if more than a quarter is missing.
    pub(crate) fn mean_counts(&self, block: usize, axis: usize) -> Option<f64> {
        let lacks = self.samples(block) - self.columns[axis][block].values;
        self.columns[axis][block].mean().filter(|_| 4 * lacks <= self.samples(block))
    }

    /// The mean of the readings of the temperature in a block, in counts; `None` without one.
    pub(crate) fn mean_temperature_counts(&self, block: usize) -> Option<f64> {
        self.columns[self.axes()][block].mean()
    }

    /// Halves the number of blocks.
    pub(crate) fn merge_pairs(&mut self) {
        for column in &mut self.columns {
            let merged = |pair: &[Sums]| Sums {
                values: pair.iter().map(|sums| sums.values).sum(),
                sum: pair.iter().map(|sums| sums.sum).sum(),
            };
            *column = column.chunks(2).map(merged).collect();
        }
        self.is_broken = self.is_broken.chunks(2).map(|pair| pair.contains(&true)).collect();
        self.length_log2 += 1;
    }

    fn push(&mut self, column: usize, first: u64, mut counts: &[i32]) {
        let Some(last) = (first + counts.len() as u64).checked_sub(1).filter(|_| !counts.is_empty()) else { return };
        while last >> self.length_log2 >= MOST_BLOCKS {
            self.merge_pairs();
        }
        let blocks = (last >> self.length_log2) as usize + 1;
        if self.blocks() < blocks {
            self.is_broken.resize(blocks, false);
            self.columns.iter_mut().for_each(|column| column.resize(blocks, Sums::default()));
        }
        let mut at = first;
        while !counts.is_empty() {
            let block = at >> self.length_log2;
            let room = usize::try_from(((block + 1) << self.length_log2) - at).unwrap_or(usize::MAX);
            let (here, later) = counts.split_at(room.min(counts.len()));
            let sums = &mut self.columns[column][block as usize];
            sums.values += here.len() as u64;
            sums.sum += here.iter().map(|&count| i64::from(count)).sum::<i64>();
            at += here.len() as u64;
            counts = later;
        }
    }
}

impl Sums {
    fn mean(&self) -> Option<f64> {
        (self.values > 0).then(|| self.sum as f64 / self.values as f64)
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    /// One step of a record: samples of two axes and the temperature, one reading, a gap, a break.
    #[derive(Clone, Debug)]
    enum Step {
        Samples(usize),
        Reading,
        Missing(u64),
        Break,
    }

    fn steps() -> impl Strategy<Value = Vec<Step>> {
        let step = prop_oneof![
            4 => (0_usize..3000).prop_map(Step::Samples),
            1 => Just(Step::Reading),
            1 => (0_u64..40_000).prop_map(Step::Missing),
            1 => Just(Step::Break),
        ];
        vec(step, 0..6)
    }

    fn value(axis: usize, index: u64) -> i32 {
        (index as i32).wrapping_mul(26_544_357).wrapping_add(axis as i32 * 977)
    }

    /// The sums of these steps in calls of at most `cut` samples; also returns the end.
    fn of(start: u64, steps: &[Step], cut: usize) -> (TemperatureBlocks, u64) {
        let mut blocks = TemperatureBlocks::new(2);
        let mut at = start;
        for step in steps {
            match step {
                Step::Samples(samples) => {
                    let indices: Vec<u64> = (at..at + *samples as u64).collect();
                    for part in indices.chunks(cut.max(1)) {
                        for axis in 0..3 {
                            let counts: Vec<i32> = part.iter().map(|index| value(axis, *index)).collect();
                            match axis {
                                2 => blocks.push_temperature(part[0], &counts),
                                _ => blocks.push_axis(axis, part[0], &counts),
                            }
                        }
                    }
                    at += *samples as u64;
                }
                Step::Reading => blocks.push_temperature(at, &[215]),
                Step::Missing(missing) => at += missing,
                Step::Break => blocks.part(),
            }
        }
        (blocks, at)
    }

    proptest! {
        #[test]
        fn sums_are_the_same_however_the_samples_are_cut(
            start in 0_u64..100,
            steps in vec(steps(), 1..6),
            cut in 1_usize..400,
        ) {
            let (whole, _) = of(start, &steps.concat(), 10_000);
            prop_assert!(whole.blocks() as u64 <= MOST_BLOCKS);
            prop_assert_eq!(of(start, &steps.concat(), cut).0, whole);
        }
    }

    #[test]
    fn sums_are_those_of_the_samples() {
        let (blocks, _) = of(40, &[Step::Samples(100), Step::Missing(4), Step::Break, Step::Samples(40)], 7);
        let samples: Vec<u64> = (0..blocks.blocks()).map(|block| blocks.samples(block)).collect();
        assert_eq!(samples, [0, 24, 32, 32, 28, 24]);
        let sum = (64..96).map(|index| i64::from(value(1, index))).sum::<i64>();
        assert_eq!(blocks.mean_counts(2, 1), Some(sum as f64 / 32.0));
        assert_eq!((blocks.mean_counts(0, 1), blocks.mean_temperature_counts(0)), (None, None));
        assert_eq!(blocks.is_broken, [false, false, false, false, true, false]);
    }

    #[test]
    fn an_axis_may_lack_samples_of_the_others() {
        let mut blocks = TemperatureBlocks::new(2);
        blocks.push_axis(0, 0, &[6; 64]);
        blocks.push_axis(1, 0, &[9; 24]);
        blocks.push_axis(1, 32, &[9; 23]);
        blocks.push_axis(2, 0, &[1]);
        assert_eq!([blocks.lacks(0), blocks.lacks(1)], [(0, 64), (17, 64)]);
        assert_eq!([0, 1].map(|block| blocks.mean_counts(block, 1)), [Some(9.0), None]);
    }
}

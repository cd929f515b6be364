//! Sums of the axes of a sensor and of its temperature, block by block.

/// The most blocks of a record; when they are full, half as many of twice the length replace them.
pub(crate) const MOST_BLOCKS: u64 = 1024;

/// Binary logarithm of the samples of the shortest block.
const SHORTEST_LOG2: u32 = 5;

/// Sums of the axes of a sensor and of its temperature: exact sums over at most 1024 blocks of
/// equal length, the smallest power of two of at least 32 samples for which the record fits. The
/// blocks lie on the grid of absolute indices. The result is the same, bit by bit, for any division
/// of the samples over calls. At most 64 KiB for six axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TemperatureBlocks {
    axes: usize,
    length_log2: u32,
    /// The blocks from absolute index 0 on.
    blocks: Vec<Presence>,
    /// The sums of all axes for each block, in counts: exact for up to 2^32 samples in a block.
    sums: Vec<i64>,
    /// Like `sums`: the number of announced samples that each axis lacks. Empty while no axis lacks any.
    absent: Vec<u64>,
    /// Absolute index of the last sample.
    last: Option<u64>,
}

/// The samples and readings present in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Presence {
    pub(crate) samples: u64,
    /// Readings of the temperature, and their sum.
    pub(crate) readings: u64,
    pub(crate) temperature_counts: i64,
    /// Whether an unknown number of samples is missing in the block or after it.
    pub(crate) is_broken: bool,
}

impl TemperatureBlocks {
    /// Blocks without samples, for this number of axes.
    #[must_use]
    pub const fn new(axes: usize) -> Self {
        Self { axes, length_log2: SHORTEST_LOG2, blocks: Vec::new(), sums: Vec::new(), absent: Vec::new(), last: None }
    }

    /// Announces the next samples, the first with this absolute index; the samples of each axis are
    /// added by [`push_axis`](Self::push_axis).
    pub fn push_samples(&mut self, first: u64, samples: usize) {
        let Some(last) = (first + samples as u64).checked_sub(1).filter(|_| samples > 0) else { return };
        self.reach(last);
        self.last = Some(last);
        let mut at = first;
        while at <= last {
            let block = at >> self.length_log2;
            let end = ((block + 1) << self.length_log2).min(last + 1);
            self.blocks[block as usize].samples += end - at;
            at = end;
        }
    }

    /// Adds samples of one axis, numbered from 0, that [`push_samples`](Self::push_samples) has
    /// announced.
    pub fn push_axis(&mut self, axis: usize, first: u64, counts: &[i32]) {
        let (log2, axes) = (self.length_log2, self.axes);
        in_blocks(log2, first, counts, |block, sum, _| {
            if let Some(total) = self.sums.get_mut(block * axes + axis).filter(|_| axis < axes) {
                *total += sum;
            }
        });
    }

    /// Notes that an axis lacks the sample with this index, which
    /// [`push_samples`](Self::push_samples) has announced.
    pub fn push_absent(&mut self, axis: usize, index: u64) {
        self.absent.resize(self.sums.len(), 0);
        let block = (index >> self.length_log2) as usize;
        if let Some(absent) = self.absent.get_mut(block * self.axes + axis).filter(|_| axis < self.axes) {
            *absent += 1;
        }
    }

    /// Number of announced samples that this axis lacks, and number of all announced samples.
    #[must_use]
    pub fn lacks(&self, axis: usize) -> (u64, u64) {
        let absent = self.absent.iter().skip(axis).step_by(self.axes.max(1)).sum();
        (absent, self.blocks.iter().map(|block| block.samples).sum())
    }

    /// Adds readings of the temperature at successive samples from this index on, or a single
    /// reading.
    pub fn push_temperature(&mut self, first: u64, counts: &[i32]) {
        let Some(last) = (first + counts.len() as u64).checked_sub(1).filter(|_| !counts.is_empty()) else { return };
        self.reach(last);
        let log2 = self.length_log2;
        in_blocks(log2, first, counts, |block, sum, readings| {
            let presence = &mut self.blocks[block];
            presence.readings += readings;
            presence.temperature_counts += sum;
        });
    }

    /// Marks that an unknown number of samples is missing here: no difference spans this place.
    pub fn part(&mut self) {
        if let Some(last) = self.last {
            self.blocks[(last >> self.length_log2) as usize].is_broken = true;
        }
    }

    /// Number of axes.
    #[must_use]
    pub const fn axes(&self) -> usize {
        self.axes
    }

    /// The number of places of a block.
    pub(crate) const fn length(&self) -> u64 {
        1 << self.length_log2
    }

    /// The blocks from absolute index 0 on.
    pub(crate) fn blocks(&self) -> &[Presence] {
        &self.blocks
    }

    /// The mean of an axis in a block, in counts; `None` if the axis lacks more than a quarter of
    /// the samples.
    pub(crate) fn mean_counts(&self, block: usize, axis: usize) -> Option<f64> {
        let (place, samples) = (block * self.axes + axis, self.blocks[block].samples);
        let absent = self.absent.get(place).copied().unwrap_or(0);
        (4 * absent <= samples).then(|| self.sums[place] as f64 / (samples - absent) as f64)
    }

    /// Halves the number of blocks.
    pub(crate) fn merge_pairs(&mut self) {
        let axes = self.axes;
        for block in 0..self.blocks.len() {
            let merged = block / 2;
            let presence = self.blocks[block];
            if block % 2 == 0 {
                self.blocks[merged] = presence;
                self.sums.copy_within(block * axes..(block + 1) * axes, merged * axes);
                if !self.absent.is_empty() {
                    self.absent.copy_within(block * axes..(block + 1) * axes, merged * axes);
                }
            } else {
                self.blocks[merged].add(&presence);
                for axis in 0..axes {
                    self.sums[merged * axes + axis] += self.sums[block * axes + axis];
                    if !self.absent.is_empty() {
                        self.absent[merged * axes + axis] += self.absent[block * axes + axis];
                    }
                }
            }
        }
        let merged = self.blocks.len().div_ceil(2);
        self.blocks.truncate(merged);
        self.sums.truncate(merged * axes);
        self.absent.truncate(merged * axes);
        self.length_log2 += 1;
    }

    fn reach(&mut self, sample: u64) {
        while sample >> self.length_log2 >= MOST_BLOCKS {
            self.merge_pairs();
        }
        let blocks = (sample >> self.length_log2) as usize + 1;
        if self.blocks.len() < blocks {
            self.resize(blocks);
        }
    }

    fn resize(&mut self, blocks: usize) {
        self.blocks.resize(blocks, Presence::default());
        self.sums.resize(blocks * self.axes, 0);
        if !self.absent.is_empty() {
            self.absent.resize(self.sums.len(), 0);
        }
    }
}

impl Presence {
    const fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.readings += other.readings;
        self.temperature_counts += other.temperature_counts;
        self.is_broken |= other.is_broken;
    }
}

/// The sum of the counts in each block, and their number.
fn in_blocks(log2: u32, first: u64, mut counts: &[i32], mut add: impl FnMut(usize, i64, u64)) {
    let mut at = first;
    while !counts.is_empty() {
        let block = at >> log2;
        let room = usize::try_from(((block + 1) << log2) - at).unwrap_or(usize::MAX);
        let (head, tail) = counts.split_at(room.min(counts.len()));
        add(block as usize, head.iter().map(|&count| i64::from(count)).sum(), head.len() as u64);
        at += head.len() as u64;
        counts = tail;
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
                        blocks.push_samples(part[0], part.len());
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
            prop_assert!(whole.blocks.len() as u64 <= MOST_BLOCKS);
            prop_assert_eq!(of(start, &steps.concat(), cut).0, whole);
        }
    }

    #[test]
    fn sums_are_those_of_the_samples() {
        let (blocks, _) = of(40, &[Step::Samples(100), Step::Missing(4), Step::Break, Step::Samples(40)], 7);
        let samples: Vec<u64> = blocks.blocks().iter().map(|block| block.samples).collect();
        assert_eq!(samples, [0, 24, 32, 32, 28, 24]);
        let sum = (64..96).map(|index| i64::from(value(1, index))).sum::<i64>();
        assert_eq!(blocks.mean_counts(2, 1), Some(sum as f64 / blocks.blocks()[2].samples as f64));
        let broken: Vec<bool> = blocks.blocks().iter().map(|block| block.is_broken).collect();
        assert_eq!(broken, [false, false, false, false, true, false]);
    }
}

//! Sums over blocks of samples on a grid of absolute indices.

use super::places::room_for;

/// Samples per block. Shorter blocks would cost more than the octaves.
pub(crate) const BLOCK: u64 = 64;

/// Cuts a channel into blocks of `block` samples that start at multiples of `block`.
#[derive(Clone, Debug)]
pub(crate) struct AlignedSums {
    block: u64,
    /// Absolute index of the next place.
    end: u64,
    /// The incomplete block.
    current: AlignedBlock,
    /// Whether its first sample is of this run.
    begun: bool,
}

/// A block, complete or not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlignedBlock {
    /// Absolute index of its first sample, divided by its length.
    pub(crate) number: u64,
    pub(crate) sum: i64,
    pub(crate) present: u64,
    /// The sum of twice their distances from the middle of the block.
    pub(crate) distances: i64,
}

impl AlignedBlock {
    const fn empty(number: u64) -> Self {
        Self { number, sum: 0, present: 0, distances: 0 }
    }

    fn add(&mut self, other: &Self) {
        self.sum += other.sum;
        self.present += other.present;
        self.distances += other.distances;
    }
}

impl AlignedSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, end: 0, current: AlignedBlock::empty(0), begun: true }
    }

    /// Adds samples; `complete` receives each block that ends with them.
    #[inline]
    pub(crate) fn push<T: Copy + Into<i64>>(&mut self, mut counts: &[T], mut complete: impl FnMut(AlignedBlock)) {
        while !counts.is_empty() {
            let room = self.block - self.end % self.block;
            let (part, rest) = counts.split_at(counts.len().min(room as usize));
            counts = rest;
            let len = part.len() as u64;
            self.current.add(&AlignedBlock {
                number: self.current.number,
                sum: part.iter().map(|&count| count.into()).sum::<i64>(),
                present: len,
                // the middle of the part minus that of the block
                distances: len as i64 * (self.block as i64 - 2 * room as i64 + len as i64),
            });
            self.end += len;
            if len == room {
                complete_with(self.end_block(), &mut complete);
            }
        }
    }

    /// Adds a gap; `None` for an unknown number of missing samples, which takes no place. A divided
    /// block is dropped.
    pub(crate) fn gap(&mut self, missing: Option<u64>, mut complete: impl FnMut(AlignedBlock)) {
        match missing.map(|missing| room_for(self.end, missing)) {
            Some(missing) if missing > 0 => {
                let ends_block = self.end % self.block + missing >= self.block;
                self.end += missing;
                if ends_block {
                    complete_with(self.end_block(), &mut complete);
                }
            }
            _ => {
                self.begin_block();
                self.begun = self.end.is_multiple_of(self.block);
            }
        }
    }

    /// The block that ends, if this run contains its beginning.
    fn end_block(&mut self) -> Option<AlignedBlock> {
        let whole = self.begun.then_some(self.current);
        self.begin_block();
        self.begun = true;
        whole
    }

    fn begin_block(&mut self) {
        self.current = AlignedBlock::empty(self.end / self.block);
    }
}

#[inline]
fn complete_with(block: Option<AlignedBlock>, complete: &mut impl FnMut(AlignedBlock)) {
    if let Some(block) = block.filter(|block| block.present > 0) {
        complete(block);
    }
}

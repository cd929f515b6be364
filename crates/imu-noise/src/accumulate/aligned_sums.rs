//! Sums over blocks of samples on a grid of absolute indices.

use super::piece::Piece;

/// Samples per block. Shorter blocks would cost more than the octaves do.
pub(crate) const BLOCK: u64 = 64;

/// Cuts a channel into blocks of `block` samples that start at multiples of `block`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct AlignedSums {
    block: u64,
    piece: Piece,
    /// What a piece that begins within a block holds of it.
    head: Option<AlignedBlock>,
    /// The block that is being filled.
    current: AlignedBlock,
    /// Its first sample is of this run.
    begun: bool,
}

/// A block, or what a piece holds of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AlignedBlock {
    /// Absolute index of its first sample over its length.
    pub(crate) number: u64,
    pub(crate) sum: i64,
    /// Samples that are present.
    pub(crate) present: u64,
    /// Twice their distances from the middle of the block, summed.
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
    pub(crate) const fn new(block: u64, first_sample: u64) -> Self {
        let current = AlignedBlock::empty(first_sample / block);
        let begun = first_sample.is_multiple_of(block);
        Self { block, piece: Piece::starting_at(first_sample), head: None, current, begun }
    }

    /// `complete` gets each block that ends with these samples.
    #[inline]
    pub(crate) fn push<T: Copy + Into<i64>>(&mut self, mut counts: &[T], mut complete: impl FnMut(AlignedBlock)) {
        while !counts.is_empty() {
            let room = self.block - self.piece.end % self.block;
            let (part, rest) = counts.split_at(counts.len().min(room as usize));
            counts = rest;
            let len = part.len() as u64;
            self.current.add(&AlignedBlock {
                number: self.current.number,
                sum: part.iter().map(|&count| count.into()).sum::<i64>(),
                present: len,
                // the middle of the part less that of the block
                distances: len as i64 * (self.block as i64 - 2 * room as i64 + len as i64),
            });
            self.piece.end += len;
            if len == room {
                complete_with(self.end_block(), &mut complete);
            }
        }
    }

    /// `None` for an unknown number of missing samples, which takes no place; a block that is
    /// parted is none.
    pub(crate) fn gap(&mut self, missing: Option<u64>, mut complete: impl FnMut(AlignedBlock)) {
        match missing.map(|missing| self.piece.room_for(missing)) {
            Some(missing) if missing > 0 => {
                let ends_block = self.piece.end % self.block + missing >= self.block;
                self.piece.end += missing;
                if ends_block {
                    complete_with(self.end_block(), &mut complete);
                }
            }
            _ => {
                self.piece.part();
                self.begin_block();
                self.begun = self.piece.end.is_multiple_of(self.block);
            }
        }
    }

    /// Continues with a piece that begins at the end of this one, or behind it. `complete` gets the
    /// blocks that end between the two, and the one that they share, where its end is in the other.
    pub(crate) fn append(&mut self, next: &Self, mut complete: impl FnMut(AlignedBlock)) {
        match next.piece.start.saturating_sub(self.piece.end) {
            0 => {}
            between => self.gap(Some(between), &mut complete),
        }
        let is_shared = !self.piece.end.is_multiple_of(self.block);
        let rest = next.head.or((is_shared && !next.piece.is_parted()).then_some(next.current));
        if let Some(rest) = rest.filter(|_| is_shared) {
            self.current.add(&rest);
        }
        if next.head.is_some() {
            complete_with(self.end_block(), &mut complete);
        }
        if next.head.is_some() || !is_shared || next.piece.is_parted() {
            (self.current, self.begun) = (next.current, next.begun);
        }
        self.piece.append(&next.piece);
    }

    /// Of a piece that ends in the block that it begins in: no block begins in it.
    pub(crate) const fn is_within_block(&self) -> bool {
        self.piece.end < self.piece.start.next_multiple_of(self.block)
    }

    /// As if each sample were so many counts larger.
    pub(crate) fn shift(&mut self, by: i64) {
        for block in self.head.iter_mut().chain([&mut self.current]) {
            block.sum += by * block.present as i64;
        }
    }

    /// The block that ends, if this piece holds its beginning.
    fn end_block(&mut self) -> Option<AlignedBlock> {
        let ended = self.current;
        let whole = self.begun.then_some(ended);
        if whole.is_none() && self.head.is_none() && !self.piece.is_parted() {
            self.head = Some(ended);
        }
        self.begin_block();
        self.begun = true;
        whole
    }

    fn begin_block(&mut self) {
        self.current = AlignedBlock::empty(self.piece.end / self.block);
    }
}

#[inline]
fn complete_with(block: Option<AlignedBlock>, complete: &mut impl FnMut(AlignedBlock)) {
    if let Some(block) = block.filter(|block| block.present > 0) {
        complete(block);
    }
}

state_bytes::encoded!(AlignedBlock { number, sum, present, distances } if |block| {
    // more than a block has in any record, and little enough to be squared
    block.present <= BLOCK && block.distances.unsigned_abs() <= BLOCK * BLOCK && block.sum.unsigned_abs() <= 1 << 41
});
state_bytes::encoded!(AlignedSums { block, piece, head, current, begun } if |sums| {
    sums.block.is_power_of_two() && sums.block <= BLOCK
});

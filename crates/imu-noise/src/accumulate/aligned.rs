//! Sums over blocks of samples that lie on a fixed grid of absolute indices.

/// Samples per block. Shorter blocks would cost more than the octaves do.
pub(crate) const BLOCK: u64 = 64;

/// Cuts a channel into blocks of `block` samples that start at multiples of `block`.
#[derive(Clone, Debug)]
pub(crate) struct AlignedSums {
    block: u64,
    /// Absolute index of the next sample.
    next: u64,
    /// Sum of the present block so far.
    sum: i64,
    /// Whether the present block has all its samples so far.
    whole: bool,
}

impl AlignedSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, next: 0, sum: 0, whole: true }
    }

    /// Adds the next samples; `complete` gets the number and the sum of each block that is complete
    /// with them.
    #[inline]
    pub(crate) fn push(&mut self, mut counts: &[i32], mut complete: impl FnMut(u64, i64)) {
        while !counts.is_empty() {
            let missing = self.block - self.next % self.block;
            let (part, rest) = counts.split_at(counts.len().min(missing as usize));
            counts = rest;
            self.sum += part.iter().map(|&count| i64::from(count)).sum::<i64>();
            self.next += part.len() as u64;
            if part.len() as u64 == missing {
                if self.whole {
                    complete(self.next / self.block - 1, self.sum);
                }
                self.sum = 0;
                self.whole = true;
            }
        }
    }

    /// So many samples are missing; `None` for an unknown number, which starts a new grid.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        self.next = missing.map_or(0, |missing| self.next.wrapping_add(missing));
        self.sum = 0;
        self.whole = self.next.is_multiple_of(self.block);
    }
}

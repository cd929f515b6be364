//! Sums over blocks of samples on a grid of absolute indices, and what is accumulated of them: the
//! lag-1 autocorrelation at each block length, and the slope of the record.

use ethnum::I256;

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
    distances: i64,
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
    pub(crate) fn push(&mut self, mut counts: &[i32], mut complete: impl FnMut(AlignedBlock)) {
        while !counts.is_empty() {
            let room = self.block - self.piece.end % self.block;
            let (part, rest) = counts.split_at(counts.len().min(room as usize));
            counts = rest;
            let len = part.len() as u64;
            self.current.add(&AlignedBlock {
                number: self.current.number,
                sum: part.iter().map(|&count| i64::from(count)).sum(),
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

    /// `None` for an unknown number of missing samples, which takes no place; a block that is parted
    /// is none.
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

/// Times that block sums are differenced at most, as suits the Allan deviation.
pub(crate) const MAX_DIFFERENCES: usize = 2;

/// Longest blocks, 2^26 samples: then sums cannot overflow in years of full-scale data.
const LONGEST: u64 = 1 << 26;

/// Streaming lag-1 autocorrelation of adjacent block sums, at block lengths of 64, 128, ... samples
/// (Riley and Greenhall, 2004). Shorter blocks would cost as much as all the octaves; there the
/// slope shows the noise type. Blocks that miss samples have no part in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LagOneSums {
    pub(crate) block: u64,
    levels: Vec<Level>,
    parted: bool,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Level {
    /// By number of differences taken.
    series: [LagOneSeries; MAX_DIFFERENCES + 1],
    /// Numbers of the first block of the piece, unless a break came before, and of the last one of
    /// the present run.
    first: Option<u64>,
    last: Option<u64>,
    /// All blocks so far are neighbours of each other.
    in_first_row: bool,
}

impl LagOneSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, levels: Vec::new(), parted: false }
    }

    #[inline]
    pub(crate) fn push(&mut self, mut number: u64, mut sum: i64) {
        for k in 0.. {
            let Some(level) = self.level(k) else { return };
            let before = level.push(number, sum);
            let Some(first_half) = before.filter(|_| number & 1 == 1) else { return };
            sum += first_half;
            number /= 2;
        }
    }

    /// Neighbours across a break are no neighbours.
    pub(crate) fn part(&mut self) {
        self.parted = true;
        self.levels.iter_mut().for_each(Level::part);
    }

    /// Continues with the next piece; the block that the two share, if they do, is the last one
    /// here.
    pub(crate) fn append(&mut self, next: &Self) {
        let mut shared = None;
        for k in 0..=(LONGEST / self.block).ilog2() as usize {
            if shared.is_none() && k >= self.levels.len().max(next.levels.len()) {
                break;
            }
            let none = Level::new(true);
            let theirs = next.levels.get(k).unwrap_or(&none);
            let Some(level) = self.level(k) else { break };
            let mut joined = None;
            if let Some((number, sum)) = shared {
                let first_half = level.push(number, sum).filter(|_| number & 1 == 1);
                joined = first_half.map(|half| (number / 2, half + sum));
            }
            if let Some(last) = level.last.filter(|last| last & 1 == 0 && theirs.first == Some(last + 1)) {
                let halves = level.series[0].last.zip(theirs.series[0].first);
                joined = halves.map(|(first, second)| (last / 2, first + second));
            }
            level.append(theirs, next.parted);
            shared = joined;
        }
        self.parted |= next.parted;
    }

    /// As if each sample were so many counts larger: differences of blocks stay as they are.
    pub(crate) fn shift(&mut self, by: i64) {
        for (k, level) in self.levels.iter_mut().enumerate() {
            level.series[0].shift(by * (self.block << k) as i64);
        }
    }

    /// `None` for blocks longer than the longest.
    fn level(&mut self, k: usize) -> Option<&mut Level> {
        if k >= self.levels.len() {
            if self.block << k > LONGEST {
                return None;
            }
            self.levels.push(Level::new(!self.parted));
        }
        self.levels.get_mut(k)
    }

    /// By the number of differences taken; `None` for lengths that are not kept.
    pub(crate) fn series(&self, m: u64) -> Option<&[LagOneSeries; MAX_DIFFERENCES + 1]> {
        let level = self.levels.get((m / self.block).checked_ilog2()? as usize).filter(|_| m.is_power_of_two())?;
        Some(&level.series)
    }
}

impl Level {
    fn new(in_first_row: bool) -> Self {
        Self { series: Default::default(), first: None, last: None, in_first_row }
    }

    /// Returns the sum of the block before, if it is a neighbour.
    #[inline]
    fn push(&mut self, number: u64, sum: i64) -> Option<i64> {
        if self.last.is_some_and(|last| last + 1 != number) {
            self.part();
        }
        if self.in_first_row && self.first.is_none() {
            self.first = Some(number);
        }
        self.last = Some(number);
        let before = self.series[0].last;
        let mut value = Some(sum);
        for series in &mut self.series {
            value = value.and_then(|value| series.push(value, self.in_first_row));
        }
        before
    }

    fn part(&mut self) {
        self.series.iter_mut().for_each(LagOneSeries::end_run);
        (self.last, self.in_first_row) = (None, false);
    }

    fn append(&mut self, next: &Self, next_is_parted: bool) {
        if next.series[0].count == 0 {
            if next_is_parted {
                self.part();
            }
            return;
        }
        let meets = self.last.is_some_and(|last| next.first == Some(last + 1));
        let (is_empty, in_first_row) = (self.series[0].count == 0, self.in_first_row);
        if !meets {
            self.part();
        }
        self.in_first_row = in_first_row && (meets || is_empty) && next.in_first_row;
        if in_first_row && is_empty {
            self.first = next.first;
        }
        self.last = next.last;
        // the differences between the two sides, of which the next series are made
        let mut over_seam = Vec::new();
        for (ours, theirs) in self.series.iter_mut().zip(&next.series) {
            let mut differences: Vec<i64> =
                over_seam.into_iter().filter_map(|value| ours.push(value, in_first_row)).collect();
            if meets {
                differences.extend(ours.last.zip(theirs.first).map(|(last, first)| first - last));
            }
            ours.append(theirs, meets, next.in_first_row);
            if in_first_row && (meets || is_empty) {
                ours.first = ours.first.or(theirs.first);
            }
            over_seam = differences;
        }
    }
}

/// Sums over the values of a series; products join neighbours within runs without gap.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct LagOneSeries {
    pub(crate) count: u64,
    pairs: u64,
    sum: i128,
    squares: i128,
    products: i128,
    /// Sum of the first value of every run and of the last one of every run that has ended.
    ends: i128,
    /// In the first row of blocks.
    first: Option<i64>,
    last: Option<i64>,
}

impl LagOneSeries {
    /// The difference to the value before.
    #[inline]
    fn push(&mut self, value: i64, in_first_row: bool) -> Option<i64> {
        let wide = i128::from(value);
        self.count += 1;
        self.sum += wide;
        self.squares += wide * wide;
        if in_first_row && self.first.is_none() {
            self.first = Some(value);
        }
        let Some(last) = self.last.replace(value) else {
            self.ends += wide;
            return None;
        };
        self.pairs += 1;
        self.products += i128::from(last) * wide;
        Some(value - last)
    }

    /// As if each value were so much larger.
    fn shift(&mut self, by: i64) {
        let (wide, count, pairs) = (i128::from(by), i128::from(self.count), i128::from(self.pairs));
        let inner = 2 * self.sum - self.ends - self.last.map_or(0, i128::from);
        self.products += wide * (inner + pairs * wide);
        self.squares += wide * (2 * self.sum + count * wide);
        // each run has a value more than pairs, and two ends but for the present one
        self.ends += wide * (2 * (count - pairs) - i128::from(self.last.is_some()));
        self.sum += wide * count;
        (self.first, self.last) = (self.first.map(|first| first + by), self.last.map(|last| last + by));
    }

    fn end_run(&mut self) {
        self.ends += self.last.take().map_or(0, i128::from);
    }

    /// `meets`: its first value, if it has one, follows the last one here; `in_first_row`: so does
    /// all of it.
    fn append(&mut self, next: &Self, meets: bool, in_first_row: bool) {
        match (self.last.filter(|_| meets), next.first) {
            (Some(last), Some(first)) => {
                self.pairs += 1;
                self.products += i128::from(last) * i128::from(first);
                self.ends -= i128::from(first);
                self.last = None;
            }
            _ if in_first_row => {}
            _ => self.end_run(),
        }
        self.count += next.count;
        self.pairs += next.pairs;
        self.sum += next.sum;
        self.squares += next.squares;
        self.products += next.products;
        self.ends += next.ends;
        self.last = next.last.or(self.last);
    }

    /// Σ (z_i - z̄)(z_(i+1) - z̄) / Σ (z_i - z̄)²; `None` without values that differ.
    pub(crate) fn lag_one_autocorrelation(&self) -> Option<f64> {
        let n = self.count as f64;
        // About the integer nearest the mean: what remains is small enough for floats.
        let centre = if self.count == 0 { return None } else { self.sum.div_euclid(i128::from(self.count)) };
        let count = i128::from(self.count);
        let sum = (self.sum - count * centre) as f64;
        let squares = (self.squares - centre * (2 * self.sum - count * centre)) as f64;
        let inner = 2 * self.sum - self.ends - self.last.map_or(0, i128::from);
        let pairs = i128::from(self.pairs);
        let products = (self.products - centre * (inner - pairs * centre)) as f64;
        let inner = (inner - 2 * pairs * centre) as f64;
        let mean = sum / n;
        let denominator = squares - sum * mean;
        let numerator = products - mean * inner + self.pairs as f64 * mean * mean;
        (denominator > 0.0).then(|| numerator / denominator)
    }
}

/// Least-squares line through the means of blocks, each at the mean place of its samples and with
/// their number as its weight: as blocks are short against the record, the regression over the
/// samples within its noise. Of a block that misses samples, each sum is rounded once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Trend {
    /// Samples present, and sums over them of the place of their block, in half samples, and of its
    /// square.
    samples: i128,
    places: i128,
    squares: I256,
    /// Sums of the sums, and of these times the places of their blocks.
    sums: i128,
    products: i128,
    blocks: u64,
    grids: Grids,
}

/// Whether the places of the blocks are those of the samples, but for a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grids {
    One,
    /// A gap of unknown length stands before the first block.
    LastOf,
    /// Such gaps stand between blocks.
    Several,
}

impl Trend {
    pub(crate) const fn new() -> Self {
        Self { samples: 0, places: 0, squares: I256::ZERO, sums: 0, products: 0, blocks: 0, grids: Grids::One }
    }

    /// One block of [`BLOCK`] samples, one of them present at least.
    #[inline]
    pub(crate) fn push(&mut self, block: AlignedBlock) {
        let middle = i128::from(2 * BLOCK * block.number);
        let [sum, present, distances] = [block.sum, block.present as i64, block.distances].map(i128::from);
        self.blocks += 1;
        self.samples += present;
        self.sums += sum;
        self.places += present * middle + distances;
        let (mut square, mut product) = ((present * middle + 2 * distances) * middle, sum * middle);
        if distances != 0 {
            square += rounded_quotient(distances * distances, present);
            product += rounded_quotient(sum * distances, present);
        }
        self.squares += I256::from(square);
        self.products += product;
    }

    /// As if each sample were so many counts larger.
    pub(crate) fn shift(&mut self, by: i64) {
        self.sums += i128::from(by) * self.samples;
        self.products += i128::from(by) * self.places;
    }

    pub(crate) fn restart(&mut self) {
        let has_blocks = self.blocks > 0;
        self.grids = if has_blocks { Grids::Several } else { Grids::LastOf };
    }

    pub(crate) fn append(&mut self, next: &Self) {
        if next.grids != Grids::One {
            self.restart();
        }
        if next.grids == Grids::Several {
            self.grids = Grids::Several;
        }
        self.samples += next.samples;
        self.places += next.places;
        self.squares += next.squares;
        self.sums += next.sums;
        self.products += next.products;
        self.blocks += next.blocks;
    }

    /// Change per sample, in counts; `None` below three blocks and across a gap of unknown length.
    pub(crate) fn slope_counts(&self) -> Option<f64> {
        if self.blocks < 3 || self.grids == Grids::Several {
            return None;
        }
        let [n, x, y] = [self.samples, self.places, self.sums].map(I256::from);
        let numerator = n * I256::from(self.products) - x * y;
        let denominator = n * self.squares - x * x;
        (denominator > I256::ZERO).then(|| 2.0 * numerator.as_f64() / denominator.as_f64())
    }
}

/// Half up, for a divisor above 0: a whole number more is that number more of the result.
fn rounded_quotient(value: i128, divisor: i128) -> i128 {
    (2 * value + divisor).div_euclid(2 * divisor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(block: AlignedBlock, trend: &mut Trend) {
        if 2 * block.present >= BLOCK {
            trend.push(block);
        }
    }

    fn slope(runs: &[(Option<u64>, Vec<i32>)]) -> Option<f64> {
        let mut aligned = AlignedSums::new(BLOCK, 0);
        let mut trend = Trend::new();
        for (missing, counts) in runs {
            aligned.gap(*missing, |block| push(block, &mut trend));
            if missing.is_none() {
                trend.restart();
            }
            aligned.push(counts, |block| push(block, &mut trend));
        }
        trend.slope_counts()
    }

    #[test]
    fn a_line_has_its_slope_with_and_without_gaps() {
        let line = |range: std::ops::Range<i32>| range.map(|i| 3 * i - 70_000).collect::<Vec<_>>();
        assert_eq!(slope(&[(Some(0), line(0..1000))]), Some(3.0));
        for runs in [
            [(Some(0), line(0..1000)), (Some(500), line(1500..1830))],
            [(Some(100), line(100..1000)), (Some(1), line(1001..5000))],
        ] {
            assert!(slope(&runs).is_some_and(|slope| (slope - 3.0).abs() < 1e-6), "{:?}", slope(&runs));
        }
        assert_eq!(slope(&[(None, line(0..1000)), (None, line(0..1000))]), None);
        assert_eq!(slope(&[(Some(0), line(0..191))]), None);
        assert_eq!(slope(&[(Some(0), vec![5; 1000])]), Some(0.0));
    }
}

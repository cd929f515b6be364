//! Every overlapping window: 8 bytes per sample of the longest gap-free run and of the first, or of
//! all runs.

use std::mem;

use multiversion::multiversion;

use super::{cascade::MAX_LEVEL, squares::SquareSum};
use crate::accumulate::{piece::Piece, record::Deviation};
use state_bytes::{BadEncoding, ByteReader, Encoded, check};

/// Every octave visits the block at two more places of the record: long enough for the memory to
/// stream.
pub(super) const BLOCK: usize = 1024;

#[derive(Clone, Debug)]
pub(super) struct Overlapping {
    pub(super) deviation: Deviation,
    /// Prefix sums of the present run, from 0 on. They may wrap: their differences do not.
    pub(super) prefix: Vec<i64>,
    /// Those of the runs before it: of the first one of the piece, or of all where they are kept.
    pub(super) earlier: Vec<Vec<i64>>,
    pub(super) keeps_runs: bool,
    piece: Piece,
    squares: Vec<SquareSum>,
}

impl Overlapping {
    pub(super) fn new(deviation: Deviation) -> Self {
        let (prefix, earlier) = (Vec::new(), Vec::new());
        let piece = Piece::starting_at(0);
        Self { deviation, prefix, earlier, keeps_runs: false, piece, squares: Vec::new() }
    }

    pub(super) fn start_at(&mut self, index: u64) {
        self.piece = Piece::starting_at(index);
    }

    pub(super) fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.push_block(block);
        }
    }

    pub(super) fn gap(&mut self, missing: Option<u64>) {
        let run = mem::take(&mut self.prefix);
        self.keep_run(run);
        self.piece.part();
        self.piece.end += missing.map_or(0, |missing| self.piece.room_for(missing));
    }

    /// The first one is kept even without a sample: the piece begins with it.
    fn keep_run(&mut self, run: Vec<i64>) {
        if self.earlier.is_empty() || self.keeps_runs && run.len() > self.deviation.order() {
            self.earlier.push(run);
        }
    }

    pub(super) const fn piece(&self) -> &Piece {
        &self.piece
    }

    pub(super) fn is_kind_of(&self, other: &Self) -> bool {
        let kind = |all: &Self| (all.deviation, all.keeps_runs);
        kind(self) == kind(other)
    }

    /// Continues with a piece of the same kind that begins at the end of this one, or behind it.
    pub(super) fn append(&mut self, next: &Self) {
        match next.piece.start.saturating_sub(self.piece.end) {
            0 => {}
            between => self.gap(Some(between)),
        }
        let run = next.earlier.first().unwrap_or(&next.prefix);
        let seam = self.prefix.len().saturating_sub(1);
        let before = self.prefix.last().copied().unwrap_or(0);
        let joined = if self.prefix.is_empty() { run } else { run.get(1..).unwrap_or_default() };
        self.prefix.extend(joined.iter().map(|sum| before.wrapping_add(*sum)));
        for k in 0..=MAX_LEVEL {
            let span = self.deviation.order() << k;
            let (first_end, end) = (span.max(seam + 1), self.prefix.len().min(seam + span));
            self.add_windows(k as usize, first_end, end);
        }
        let octaves = self.squares.len().max(next.squares.len());
        self.squares.resize(octaves, SquareSum::EMPTY);
        self.squares.iter_mut().zip(&next.squares).for_each(|(squares, more)| squares.append(more));
        if let Some((_, others)) = next.earlier.split_first() {
            let run = mem::replace(&mut self.prefix, next.prefix.clone());
            self.keep_run(run);
            self.earlier.extend(others.iter().filter(|_| self.keeps_runs).cloned());
        }
        self.piece.append(&next.piece);
    }

    /// As if each sample were so many counts larger.
    pub(super) fn shift(&mut self, by: i64) {
        for run in self.earlier.iter_mut().chain([&mut self.prefix]) {
            (0..).zip(run).for_each(|(samples, sum)| *sum = sum.wrapping_add(by.wrapping_mul(samples)));
        }
    }

    /// As [`Cascade::octave`](super::cascade::Cascade::octave); no window reaches across a gap.
    pub(super) fn octave(&self, k: usize) -> Option<SquareSum> {
        self.squares.get(k).copied()
    }

    fn push_block(&mut self, block: &[i32]) {
        self.piece.end += block.len() as u64;
        if self.prefix.is_empty() {
            self.prefix.push(0);
        }
        let known = self.prefix.len();
        let mut sum = self.prefix[known - 1];
        self.prefix.extend(block.iter().map(|&count| {
            sum = sum.wrapping_add(count.into());
            sum
        }));
        let order = self.deviation.order();
        for k in 0..=MAX_LEVEL {
            let first_end = known.max(order << k);
            if first_end >= self.prefix.len() {
                break;
            }
            self.add_windows(k as usize, first_end, self.prefix.len());
        }
    }

    /// The windows that end at these prefix sums, up to `end`.
    fn add_windows(&mut self, k: usize, first_end: usize, end: usize) {
        if first_end >= end {
            return;
        }
        if self.squares.len() <= k {
            self.squares.resize(k + 1, SquareSum::EMPTY);
        }
        add_windows(self.deviation, &self.prefix[..end], first_end, 1 << k, &mut self.squares[k]);
    }
}

/// Adds the windows at averaging factor `m` that end at `first_end` or later in a run of `prefix`
/// sums.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn add_windows(deviation: Deviation, prefix: &[i64], first_end: usize, m: usize, squares: &mut SquareSum) {
    let len = prefix.len() - first_end;
    let points = |lag: usize| &prefix[first_end - lag * m..][..len];
    match deviation {
        Deviation::Allan => {
            squares.add([points(0), points(1), points(2)], |[p0, p1, p2]| second_difference(p0, p1, p2));
        }
        Deviation::Hadamard => {
            squares.add([points(0), points(1), points(2), points(3)], |[p0, p1, p2, p3]| {
                second_difference(p0, p1, p2).wrapping_sub(second_difference(p1, p2, p3))
            });
        }
    }
}

#[inline]
fn second_difference(p0: i64, p1: i64, p2: i64) -> i64 {
    p0.wrapping_sub(p1).wrapping_sub(p1.wrapping_sub(p2))
}

/// The counts of a run, and not their sums: these are four times as long.
struct Run(Vec<i64>);

impl Encoded for Run {
    fn encode(&self, out: &mut Vec<u8>) {
        self.0.len().encode(out);
        self.0.windows(2).for_each(|sums| sums[1].wrapping_sub(sums[0]).encode(out));
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let sums = usize::decode(input)?;
        check(sums <= input.left() + 1)?;
        let mut run: Vec<i64> = (0..sums.min(1)).map(|_| 0).collect();
        for _ in 1..sums {
            let before = run.last().copied().unwrap_or(0);
            run.push(before.wrapping_add(i64::decode(input)?));
        }
        Ok(Self(run))
    }
}

impl Encoded for Overlapping {
    fn encode(&self, out: &mut Vec<u8>) {
        let Self { deviation, prefix, earlier, keeps_runs, piece, squares } = self;
        deviation.encode(out);
        Run(prefix.clone()).encode(out);
        earlier.iter().map(|run| Run(run.clone())).collect::<Vec<_>>().encode(out);
        keeps_runs.encode(out);
        piece.encode(out);
        squares.encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let decoded = Self {
            deviation: Encoded::decode(input)?,
            prefix: Run::decode(input)?.0,
            earlier: Vec::<Run>::decode(input)?.into_iter().map(|run| run.0).collect(),
            keeps_runs: Encoded::decode(input)?,
            piece: Encoded::decode(input)?,
            squares: Encoded::decode(input)?,
        };
        let octaves = decoded.squares.len();
        check(octaves <= MAX_LEVEL as usize + 1)?;
        Ok(decoded)
    }
}

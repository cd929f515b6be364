//! Every overlapping window: 8 bytes per sample of the longest gap-free run.

use super::{cascade::MAX_LEVEL, squares::SquareSum};
use crate::accumulate::record::Deviation;

/// Every octave visits the block at two more places of the record: long enough for the memory to
/// stream.
const BLOCK: usize = 1024;

#[derive(Clone, Debug)]
pub(super) struct Overlapping {
    deviation: Deviation,
    /// Prefix sums of the present run, from 0 on. They may wrap: their differences do not.
    prefix: Vec<i64>,
    squares: Vec<SquareSum>,
    /// Sums of the Allan terms themselves, where they are kept: a slope shows in them.
    terms: Option<Vec<i128>>,
}

impl Overlapping {
    pub(super) fn new(deviation: Deviation) -> Self {
        Self { deviation, prefix: Vec::new(), squares: Vec::new(), terms: None }
    }

    pub(super) fn keep_terms(&mut self) {
        self.terms = Some(Vec::new());
    }

    pub(super) fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.push_block(block);
        }
    }

    pub(super) fn gap(&mut self) {
        self.prefix.clear();
    }

    /// As [`Cascade::octave`](super::cascade::Cascade::octave).
    pub(super) fn octave(&self, k: usize) -> Option<(SquareSum, Option<i128>)> {
        let terms = self.terms.as_ref().and_then(|terms| terms.get(k).copied());
        self.squares.get(k).map(|squares| (*squares, terms))
    }

    fn push_block(&mut self, block: &[i32]) {
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
            let m = 1_usize << k;
            let first_end = known.max(order * m);
            if first_end >= self.prefix.len() {
                break;
            }
            if k as usize == self.squares.len() {
                self.squares.push(SquareSum::EMPTY);
            }
            let len = self.prefix.len() - first_end;
            let points = |lag: usize| &self.prefix[first_end - lag * m..][..len];
            let squares = &mut self.squares[k as usize];
            match self.deviation {
                Deviation::Allan => {
                    squares.add([points(0), points(1), points(2)], |[p0, p1, p2]| second_difference(p0, p1, p2));
                    if let Some(terms) = &mut self.terms {
                        if k as usize == terms.len() {
                            terms.push(0);
                        }
                        let points = points(0).iter().zip(points(1)).zip(points(2));
                        let sum = points.map(|((p0, p1), p2)| i128::from(second_difference(*p0, *p1, *p2)));
                        terms[k as usize] += sum.sum::<i128>();
                    }
                }
                Deviation::Hadamard => {
                    squares.add([points(0), points(1), points(2), points(3)], |[p0, p1, p2, p3]| {
                        second_difference(p0, p1, p2).wrapping_sub(second_difference(p1, p2, p3))
                    });
                }
            }
        }
    }
}

#[inline]
fn second_difference(p0: i64, p1: i64, p2: i64) -> i64 {
    p0.wrapping_sub(p1).wrapping_sub(p1.wrapping_sub(p2))
}

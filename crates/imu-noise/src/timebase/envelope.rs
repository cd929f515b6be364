//! Fitted rate: a line under the arrivals, robust against bunching, stalls and steps.

use super::stretches::STRETCH_TOLERANCE;

/// Points kept at most; a fit looks at every pair.
const MAX_POINTS: usize = 64;

/// Lines in the first blocks. Blocks double as the record grows.
const FIRST_BLOCK_LINES: u64 = 32;

/// Fewest points a fit is made of.
const MIN_POINTS: usize = 4;

/// A line's place and its arrival.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    index: u64,
    at_s: f64,
    /// Behind the nominal rate; only differences matter.
    lag_s: f64,
}

/// Above every line.
const NO_ARRIVAL: Arrival = Arrival { index: 0, at_s: 0.0, lag_s: f64::INFINITY };

/// The earliest arrival, against the nominal rate, of each of at most 64 equally long blocks of the
/// record.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    nominal_period_s: f64,
    block_lines: u64,
    /// First line behind the present block.
    block_end: u64,
    lowest: Arrival,
    points: Vec<Arrival>,
    fitted_period_s: Option<f64>,
}

impl Envelope {
    pub(super) fn new(nominal_period_s: f64) -> Self {
        Self {
            nominal_period_s,
            block_lines: FIRST_BLOCK_LINES,
            block_end: FIRST_BLOCK_LINES,
            lowest: NO_ARRIVAL,
            points: Vec::new(),
            fitted_period_s: None,
        }
    }

    /// Forgets the lines so far: they turned out late.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.nominal_period_s);
    }

    /// Adds a line; true when that closed a block, so that the fit is new.
    pub(super) fn push(&mut self, index: u64, at_s: f64) -> bool {
        let closed = index >= self.block_end;
        if closed {
            self.close(index);
        }
        let lag_s = at_s - index as f64 * self.nominal_period_s;
        if lag_s < self.lowest.lag_s {
            self.lowest = Arrival { index, at_s, lag_s };
        }
        closed
    }

    /// Period of the line under the arrivals: median slope over all pairs of points (Theil 1950,
    /// Sen 1968).
    pub(super) const fn fitted_period_s(&self) -> Option<f64> {
        self.fitted_period_s
    }

    /// The fitted period, or the nominal one while there is no fit within the tolerance of a
    /// measured rate.
    pub(super) fn credible_period_s(&self) -> f64 {
        let credible = |fitted_s: &f64| (fitted_s / self.nominal_period_s - 1.0).abs() < STRETCH_TOLERANCE;
        let fitted_s = self.fitted_period_s.filter(credible);
        fitted_s.unwrap_or(self.nominal_period_s)
    }

    /// Ends the block; the next one holds the line at `index`.
    fn close(&mut self, index: u64) {
        if self.lowest.lag_s < f64::INFINITY {
            self.points.push(self.lowest);
        }
        self.lowest = NO_ARRIVAL;
        if self.points.len() == MAX_POINTS {
            self.double_blocks();
        }
        self.block_end = (index / self.block_lines + 1) * self.block_lines;
        if self.points.len() >= MIN_POINTS {
            self.fitted_period_s = Some(self.median_slope_s());
        }
    }

    fn double_blocks(&mut self) {
        self.block_lines *= 2;
        let lines = self.block_lines;
        self.points.dedup_by(|later, earlier| {
            let same_block = later.index / lines == earlier.index / lines;
            if same_block && later.lag_s < earlier.lag_s {
                *earlier = *later;
            }
            same_block
        });
    }

    fn median_slope_s(&self) -> f64 {
        let mut slopes = Vec::with_capacity(self.points.len() * (self.points.len() - 1) / 2);
        for (place, a) in self.points.iter().enumerate() {
            for b in &self.points[place + 1..] {
                slopes.push((b.at_s - a.at_s) / (b.index - a.index) as f64);
            }
        }
        let middle = slopes.len() / 2;
        *slopes.select_nth_unstable_by(middle, f64::total_cmp).1
    }
}

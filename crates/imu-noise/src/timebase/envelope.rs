//! Fitted rate: the median slope of the lower envelope of the arrivals.

use super::sensor_rates::RUN;

/// The largest relative difference of a credible fit from the nominal rate.
const CREDIBLE: f64 = 0.05;

/// The most points that are kept: each fit takes the slopes of all pairs. Chosen.
const MAX_POINTS: usize = 64;

/// The fewest points of a fit. Chosen.
const MIN_POINTS: usize = 4;

/// An arrival; the index is that in the stream, including dropped samples.
#[derive(Clone, Copy, Debug)]
struct LaggedArrival {
    index: u64,
    at_s: f64,
    /// The lag after the nominal rate; only differences of lags matter.
    lag_s: f64,
}

/// The earliest arrival, relative to the nominal rate, of each of at most 64 blocks of equal
/// length: [`RUN`] samples at first, doubled as the record grows.
#[derive(Clone, Debug, Default)]
pub(super) struct Envelope {
    nominal_period_s: f64,
    block_len: u64,
    /// One for each block; the last block is not complete.
    points: Vec<LaggedArrival>,
    /// Median slope over all pairs of points of complete blocks (Theil 1950, Sen 1968).
    pub(super) fitted_period_s: Option<f64>,
}

impl Envelope {
    pub(super) const fn new(nominal_period_s: f64) -> Self {
        Self { nominal_period_s, block_len: RUN as u64, points: Vec::new(), fitted_period_s: None }
    }

    /// Forgets all points, because their arrivals were late.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.nominal_period_s);
    }

    /// Adds an arrival. Returns whether it began a block and renewed the fit.
    pub(super) fn push(&mut self, index: u64, at_s: f64) -> bool {
        let arrival = LaggedArrival { index, at_s, lag_s: at_s - index as f64 * self.nominal_period_s };
        let block_len = self.block_len;
        if let Some(lowest) = self.points.last_mut().filter(|last| last.index / block_len == index / block_len) {
            if arrival.lag_s < lowest.lag_s {
                *lowest = arrival;
            }
            return false;
        }
        if self.points.len() == MAX_POINTS {
            self.double_blocks();
        }
        if self.points.len() >= MIN_POINTS {
            self.fitted_period_s = Some(self.median_slope_s());
        }
        self.points.push(arrival);
        true
    }

    /// The fitted period if it is close to the nominal one, else the nominal one.
    pub(super) fn credible_period_s(&self) -> f64 {
        let is_credible = |fitted_s: &f64| (fitted_s / self.nominal_period_s - 1.0).abs() < CREDIBLE;
        self.fitted_period_s.filter(is_credible).unwrap_or(self.nominal_period_s)
    }

    fn double_blocks(&mut self) {
        self.block_len *= 2;
        let block_len = self.block_len;
        self.points.dedup_by(|later, earlier| {
            let same_block = later.index / block_len == earlier.index / block_len;
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

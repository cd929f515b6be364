//! The contribution of the temperature to the deviations, the level and the slope of an axis.

use crate::accumulate::blocks::Block;
use crate::accumulate::record::Deviation;

use super::series::{BlockSeries, less_mean};

/// Least share of the blocks of the record that the stretch of the fit must have.
const LEAST_OF_RECORD: f64 = 0.9;

/// A part of the level that follows the temperature, to be removed from what is known of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureRemoval {
    length: u64,
    first_block: u64,
    /// By block, in counts.
    axis: Vec<f64>,
    made: Vec<f64>,
}

impl TemperatureRemoval {
    /// `None` where a gap leaves less than nine tenths of the record in one stretch.
    pub(super) fn new(series: &BlockSeries, axis: usize, counts_per_degree: f64, lag_s: f64) -> Option<Self> {
        let axis = series.axes.get(axis)?.clone();
        let of_record = (series.record.end - series.record.start) as f64;
        let made = series.lagged_c(lag_s).iter().map(|degrees| degrees * counts_per_degree).collect();
        (axis.len() as f64 >= LEAST_OF_RECORD * of_record).then_some(Self {
            length: series.length,
            first_block: series.first_block,
            axis,
            made,
        })
    }

    /// Samples of a block.
    #[must_use]
    pub const fn block_length(&self) -> u64 {
        self.length
    }

    /// The `variance` at averaging factor `m`, less the contribution of the temperature, by the
    /// windows of the block means; `of_block` is the variance at
    /// [`block_length`](Self::block_length). Within a block the temperature is taken to change
    /// steadily; where two windows are longer than the stretch, it has the share that it has in the
    /// longest ones.
    #[must_use]
    pub fn variance_without(&self, deviation: Deviation, m: u64, variance: f64, of_block: f64) -> f64 {
        if m < self.length {
            let within = (m as f64 / self.length as f64).powi(2 * (deviation.order() as i32 - 1));
            return (variance - of_block * (1.0 - self.ratio(deviation, 1)) * within).max(0.0);
        }
        let longest = (self.axis.len() / deviation.order()).max(1);
        let blocks = ((m as f64 / self.length as f64).round() as usize).clamp(1, longest);
        variance * self.ratio(deviation, blocks)
    }

    /// Of the variances of means over so many blocks.
    fn ratio(&self, deviation: Deviation, blocks: usize) -> f64 {
        let rest: Vec<f64> = self.axis.iter().zip(&self.made).map(|(axis, made)| axis - made).collect();
        let (with, without) = (variance(deviation, &self.axis, blocks), variance(deviation, &rest, blocks));
        if with > 0.0 { without / with } else { 1.0 }
    }

    /// Slope of what the temperature made, in counts per sample.
    #[must_use]
    pub fn slope_counts(&self) -> f64 {
        let times: Vec<f64> = (0..self.made.len()).map(|i| i as f64 * self.length as f64).collect();
        let times = less_mean(&times);
        let product: f64 = times.iter().zip(&self.made).map(|(time, made)| time * made).sum();
        product / times.iter().map(|time| time * time).sum::<f64>()
    }

    /// The same blocks, of this axis, without what the temperature made: of their means, as of what
    /// the first sample had.
    #[must_use]
    pub fn without(&self, blocks: &[Block]) -> Vec<Block> {
        let last = self.made.len().saturating_sub(1);
        let place = |sample: u64| ((sample / self.length).saturating_sub(self.first_block) as usize).min(last);
        let without = |block: &Block| {
            let (from, to) = (place(block.first_sample), place(block.first_sample + block.length - 1));
            let made = &self.made[from..=to];
            let mean = made.iter().sum::<f64>() / made.len() as f64;
            Block { mean_counts: block.mean_counts - mean, ..*block }
        };
        blocks.iter().map(without).collect()
    }
}

/// Mean square of the differences of means of so many blocks, at all places.
fn variance(deviation: Deviation, values: &[f64], blocks: usize) -> f64 {
    let mut sum = 0.0;
    let sums: Vec<f64> = core::iter::once(0.0)
        .chain(values.iter().map(|value| {
            sum += value;
            sum
        }))
        .collect();
    let order = deviation.order();
    let windows = (values.len() + 1).saturating_sub(order * blocks);
    let mean = |start: usize| sums[start + blocks] - sums[start];
    let squares = (0..windows).map(|start| {
        let difference = match deviation {
            Deviation::Allan => mean(start + blocks) - mean(start),
            Deviation::Hadamard => mean(start + 2 * blocks) - 2.0 * mean(start + blocks) + mean(start),
        };
        difference * difference
    });
    squares.sum::<f64>() / windows.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What changes steadily has a deviation that grows with the averaging time, and what bends one
    /// that grows with its square.
    #[test]
    fn within_a_block_the_temperature_is_taken_to_change_steadily() {
        let of = |made: fn(f64) -> f64| {
            let made: Vec<f64> = (0..64).map(|block| made(f64::from(block))).collect();
            TemperatureRemoval { length: 40, first_block: 0, axis: made.clone(), made }
        };
        let (steady, bent) = (of(|block| 3.0 * block), of(|block| block * block));
        let without = |removal: &TemperatureRemoval, deviation, m| removal.variance_without(deviation, m, 7.0, 16.0);
        assert_eq!([10, 20].map(|m| without(&steady, Deviation::Allan, m)), [7.0 - 1.0, 7.0 - 4.0]);
        assert_eq!([10, 20].map(|m| without(&bent, Deviation::Hadamard, m)), [7.0 - 0.0625, 7.0 - 1.0]);
        // all of a block is the temperature's, and no more than there is
        assert_eq!([39, 40].map(|m| without(&steady, Deviation::Allan, m)), [0.0; 2]);
    }
}

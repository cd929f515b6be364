//! The contribution of the temperature to the deviations of an axis.

use crate::accumulate::record::Deviation;

use super::series::BlockSeries;

/// Least share of the blocks of the record that the stretch of the fit must have.
const LEAST_OF_RECORD: f64 = 0.9;

/// A part of the level of an axis that follows the temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureContribution {
    length: u64,
    /// By block, in counts.
    axis: Vec<f64>,
    made: Vec<f64>,
}

impl TemperatureContribution {
    /// `None` if a gap leaves less than nine tenths of the record in one stretch.
    pub(super) fn new(series: &BlockSeries, axis: usize, counts_per_degree: f64, lag_s: f64) -> Option<Self> {
        let axis = series.axes.get(axis)?.clone();
        let of_record = (series.record.end - series.record.start) as f64;
        let made = series.lagged_c(lag_s).iter().map(|degrees| degrees * counts_per_degree).collect();
        (axis.len() as f64 >= LEAST_OF_RECORD * of_record).then_some(Self { length: series.length, axis, made })
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
            TemperatureContribution { length: 40, axis: made.clone(), made }
        };
        let (steady, bent) = (of(|block| 3.0 * block), of(|block| block * block));
        let without = |contribution: &TemperatureContribution, deviation, m| {
            contribution.variance_without(deviation, m, 7.0, 16.0)
        };
        assert_eq!([10, 20].map(|m| without(&steady, Deviation::Allan, m)), [7.0 - 1.0, 7.0 - 4.0]);
        assert_eq!([10, 20].map(|m| without(&bent, Deviation::Hadamard, m)), [7.0 - 0.0625, 7.0 - 1.0]);
        // all of a block is the temperature's, and no more than there is
        assert_eq!([39, 40].map(|m| without(&steady, Deviation::Allan, m)), [0.0; 2]);
    }
}

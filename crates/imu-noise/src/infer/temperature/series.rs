//! The block means of the axes and of the temperature in the longest stretch without a gap.

use core::ops::Range;

use crate::accumulate::temperature_blocks::TemperatureBlocks;

/// Least share of its samples in a block that has a part.
const LEAST_PRESENT: f64 = 0.75;

/// Least share of blocks with a reading of the temperature; between them it is interpolated.
const LEAST_READ: f64 = 0.9;

#[derive(Clone, Debug)]
pub(super) struct BlockSeries {
    pub(super) block_s: f64,
    /// Of each axis the block means less the first one, in counts.
    pub(super) axes: Vec<Vec<f64>>,
    /// Less the first one.
    pub(super) temperatures_c: Vec<f64>,
}

impl BlockSeries {
    /// With blocks so long that the temperature was read in nearly each of them.
    pub(super) fn longest(blocks: &TemperatureBlocks, interval_s: f64, degrees_per_count: f64) -> Self {
        let mut blocks = blocks.clone();
        let mut run = longest_run(&blocks);
        let is_read = |blocks: &TemperatureBlocks, run: &Range<usize>| {
            let read = run.clone().filter(|block| blocks.mean_temperature_counts(*block).is_some()).count();
            read as f64 >= LEAST_READ * run.len() as f64
        };
        while run.len() > 1 && !is_read(&blocks, &run) {
            blocks.merge_pairs();
            run = longest_run(&blocks);
        }
        let series =
            |mean: &dyn Fn(usize) -> Option<f64>| less_first(interpolated(&run.clone().map(mean).collect::<Vec<_>>()));
        let read_c = |block: usize| Some(degrees_per_count * blocks.mean_temperature_counts(block)?);
        Self {
            block_s: blocks.length() as f64 * interval_s,
            axes: (0..blocks.axes()).map(|axis| series(&|block| blocks.mean_counts(block, axis))).collect(),
            temperatures_c: series(&read_c),
        }
    }

    pub(super) fn duration_s(&self) -> f64 {
        self.block_s * self.temperatures_c.len() as f64
    }

    pub(super) fn excursion_c(&self) -> f64 {
        let ends = |(low, high): (f64, f64), value: &f64| (low.min(*value), high.max(*value));
        let (low, high) = self.temperatures_c.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        (high - low).max(0.0)
    }

    pub(super) fn correlation_with_time(&self) -> f64 {
        let times: Vec<f64> = (0..self.temperatures_c.len()).map(|i| i as f64).collect();
        let (times, temperatures) = (less_mean(&times), less_mean(&self.temperatures_c));
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let squares = product(&times, &times) * product(&temperatures, &temperatures);
        product(&times, &temperatures) / squares.sqrt()
    }

    /// The block means of the temperature behind a first-order lag, which it is taken not to have changed
    /// before: exact for a temperature that is constant within each block.
    pub(super) fn lagged_c(&self, lag_s: f64) -> Vec<f64> {
        let blocks = self.block_s / lag_s;
        let (left, mean_left) =
            if blocks.is_finite() { ((-blocks).exp(), -(-blocks).exp_m1() / blocks) } else { (0.0, 0.0) };
        let mut behind = 0.0;
        let lagged = self.temperatures_c.iter().map(|value| {
            let off = behind - value;
            behind = value + off * left;
            value + off * mean_left
        });
        lagged.collect()
    }
}

/// Blocks behind one another that are as good as full, none of them with a break.
fn longest_run(blocks: &TemperatureBlocks) -> Range<usize> {
    let least = LEAST_PRESENT * blocks.length() as f64;
    let mut longest = 0..0;
    let mut start = 0;
    for place in 0..blocks.blocks() {
        if (blocks.samples(place) as f64) < least || blocks.is_broken(place) {
            start = place + 1;
        } else if place + 1 - start > longest.len() {
            longest = start..place + 1;
        }
    }
    longest
}

/// What is missing lies on the line between its neighbours, at the ends it is the next value.
fn interpolated(values: &[Option<f64>]) -> Vec<f64> {
    let known: Vec<(usize, f64)> = values.iter().enumerate().filter_map(|(i, value)| Some((i, (*value)?))).collect();
    let at = |i: usize| {
        let behind = known.partition_point(|(place, _)| *place < i);
        match (behind.checked_sub(1).and_then(|before| known.get(before)), known.get(behind)) {
            (_, Some((place, value))) if *place == i => *value,
            (Some((a, before)), Some((b, after))) => before + (after - before) * (i - a) as f64 / (b - a) as f64,
            (Some((_, value)), None) | (None, Some((_, value))) => *value,
            (None, None) => f64::NAN,
        }
    };
    (0..values.len()).map(at).collect()
}

/// No digits are lost on a large offset.
fn less_first(mut values: Vec<f64>) -> Vec<f64> {
    let first = values.first().copied().unwrap_or(0.0);
    values.iter_mut().for_each(|value| *value -= first);
    values
}

pub(super) fn less_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| value - mean).collect()
}

//! The level of a channel over its record, by cosine coefficients.

use core::{f64::consts::PI, fmt};
use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use crate::accumulate::blocks::Block;
use crate::accumulate::signal::ChannelSignal;

/// Below, a few coefficients decide, and flicker noise looks like a walk too often.
pub(super) const MIN_BLOCKS: usize = 24;

/// Least share of samples in a block: its mean has more white noise without them.
const LEAST_PRESENT: f64 = 0.5;

/// Least share of the record in the series.
const LEAST_SHARE: f64 = 15.0 / 16.0;

/// Cosine coefficients of the means of the blocks of a channel (DCT-II, orthonormal), in its unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LevelSeries {
    /// Length of a block in samples.
    pub(super) block_samples: u64,
    /// From that of half a cycle per series on, in rising frequency: one less than blocks.
    pub(super) coefficients: Vec<f64>,
    /// White noise of the means over that of blocks without a missing sample, in variance.
    pub(super) white_factor: f64,
}

impl LevelSeries {
    /// The level of `signal` in its longest series of blocks that have half of their samples at least,
    /// where one count is `unit_per_count`. `None` for fewer than 24 blocks, for less than 15/16 of the
    /// record, and with a gap of unknown length.
    pub(super) fn of(signal: &ChannelSignal, unit_per_count: f64) -> Option<Self> {
        if signal.is_parted {
            return None;
        }
        Self::of_blocks(&signal.blocks(), unit_per_count)
    }

    fn of_blocks(blocks: &[Block], unit_per_count: f64) -> Option<Self> {
        let series = longest_series(blocks, |block| block.count as f64 >= LEAST_PRESENT * block.length as f64);
        if series.len() < MIN_BLOCKS {
            return None;
        }
        let (first, start, end) = (series.first()?, blocks.first()?, blocks.last()?);
        let places = end.first_sample + end.count - start.first_sample;
        if ((series.len() as u64 * first.length) as f64) < LEAST_SHARE * places as f64 {
            return None;
        }
        // from the first, so that no digits are lost on a large offset
        let level = |block: &Block| (block.mean_counts - first.mean_counts) * unit_per_count;
        let levels: Vec<f64> = series.iter().map(level).collect();
        let missing = series.iter().map(|block| block.length as f64 / block.count as f64);
        let white_factor = missing.sum::<f64>() / series.len() as f64;
        Some(Self {
            block_samples: first.length,
            coefficients: CosineTransform::new(levels.len()).of(&levels),
            white_factor,
        })
    }
}

/// The longest of the series of consecutive blocks that are as good as full, the first of several.
pub(super) fn longest_series(blocks: &[Block], is_full: impl Fn(&Block) -> bool) -> &[Block] {
    let follows = |a: &Block, b: &Block| a.first_sample + a.length == b.first_sample && is_full(a) == is_full(b);
    let series = blocks.chunk_by(follows).filter(|series| is_full(&series[0]));
    series.rev().max_by_key(|series| series.len()).unwrap_or_default()
}

/// The cosine transform of series of one length.
#[derive(Clone)]
pub(super) struct CosineTransform {
    transform: Arc<dyn RealToComplex<f64>>,
    /// By coefficient, from the first on without that of the mean.
    turns: Arc<[Complex<f64>]>,
}

impl CosineTransform {
    pub(super) fn new(blocks: usize) -> Self {
        let transform = RealFftPlanner::new().plan_fft_forward(2 * blocks);
        let scale = (0.5 / blocks as f64).sqrt();
        let turn = |k: usize| Complex::from_polar(scale, -PI * k as f64 / (2 * blocks) as f64);
        Self { transform, turns: (1..blocks).map(turn).collect() }
    }

    /// Zeros for a series of another length.
    pub(super) fn of(&self, levels: &[f64]) -> Vec<f64> {
        let mut mirrored: Vec<f64> = levels.iter().chain(levels.iter().rev()).copied().collect();
        let mut spectrum = self.transform.make_output_vec();
        let has_failed = self.transform.process(&mut mirrored, &mut spectrum).is_err();
        let coefficient = |(turn, value): (&Complex<f64>, &Complex<f64>)| (turn * value).re;
        let coefficients = self.turns.iter().zip(&spectrum[1..]).map(coefficient);
        if has_failed { vec![0.0; self.turns.len()] } else { coefficients.collect() }
    }
}

impl fmt::Debug for CosineTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CosineTransform").field("blocks", &(self.turns.len() + 1)).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::spectrum::SpectrumPlan;

    fn blocks(levels: &[f64], length: u64) -> Vec<Block> {
        let block = |(i, level): (usize, &f64)| Block {
            first_sample: length * i as u64,
            length,
            count: length,
            mean_counts: 1e6 + level,
            std_counts: None,
            min_counts: 0,
            max_counts: 0,
        };
        levels.iter().enumerate().map(block).collect()
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9 * (1.0 + b.abs())
    }

    #[test]
    fn coefficients_hold_the_whole_variance_in_the_unit() {
        let levels: Vec<f64> = (0..37).map(|i| f64::from(i * i % 7)).collect();
        let series = LevelSeries::of_blocks(&blocks(&levels, 8), 0.5).unwrap();
        let mean = levels.iter().sum::<f64>() / 37.0;
        let squares: f64 = levels.iter().map(|level| (level - mean).powi(2)).sum();
        assert_eq!((series.block_samples, series.coefficients.len()), (8, 36));
        assert!(near(series.coefficients.iter().map(|x| x * x).sum(), 0.25 * squares));
        // half a cycle per series is the first of them
        let cosine: Vec<f64> = (0..50).map(|i| (PI * (f64::from(i) + 0.5) / 50.0).cos()).collect();
        let series = LevelSeries::of_blocks(&blocks(&cosine, 8), 1.0).unwrap();
        assert!(near(series.coefficients[0], 5.0) && series.coefficients[1..].iter().all(|x| near(*x, 0.0)));
    }

    #[test]
    fn a_series_of_half_full_blocks_over_nearly_the_whole_record_counts() {
        let levels: Vec<f64> = (0..80).map(|i| f64::from(i % 5)).collect();
        let blocks = |count: usize| blocks(&levels[..count], 32);
        let found = |blocks: &[Block]| LevelSeries::of_blocks(blocks, 1.0).map(|series| series.coefficients.len());
        assert_eq!(found(&blocks(80)), Some(79));
        // losses, and a last block that is not full yet
        let mut lossy = blocks(80);
        lossy[40].count = 16;
        lossy[79].count = 3;
        assert_eq!(found(&lossy), Some(78));
        lossy[40].count = 15;
        assert_eq!(found(&lossy), None);
        lossy[40].count = 32;
        lossy[3].count = 15;
        assert_eq!(found(&lossy), Some(74));
        lossy[4].count = 15;
        assert_eq!(found(&lossy), None);
        let mut broken = blocks(80);
        broken.drain(2..4);
        assert_eq!(found(&broken), Some(75));
        assert_eq!((found(&blocks(23)), found(&blocks(24)), found(&[])), (None, Some(23), None));
    }

    #[test]
    fn a_gap_of_unknown_length_leaves_no_series() {
        let mut signal = ChannelSignal::new(&SpectrumPlan::new());
        let counts: Vec<i32> = (0..40_000).map(|i| i * i % 17).collect();
        signal.push(&counts);
        assert!(LevelSeries::of(&signal, 1.0).is_some());
        let mut parted = signal.clone();
        parted.gap(None);
        parted.push(&counts);
        assert!(LevelSeries::of(&parted, 1.0).is_none());
        signal.gap(Some(3));
        signal.push(&counts);
        assert!(LevelSeries::of(&signal, 1.0).is_some());
    }
}

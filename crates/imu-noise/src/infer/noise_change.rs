//! Noise that is not the same throughout a record: louder or quieter for a while, in bursts, frozen.
//!
//! By the logarithms of the spreads within windows of 32 samples, whose means over blocks are nearly
//! normal whatever the tails. How much they vary is taken from the differences of neighbouring
//! blocks, so that neither tails nor correlated noise pass for a change.

use super::chi_squared::{self, CHANNELS};
use super::spikes::{FALSE_ALARM, Spikes};
use crate::accumulate::blocks::{Spreads, WINDOW};
use crate::accumulate::histogram::Histogram;
use crate::accumulate::signal::ChannelSignal;
use schemars::JsonSchema;
use serde::Serialize;

const MIN_BLOCKS: usize = 16;

/// Fewest windows in a stretch, and outside it: the logarithms of fewer are far from normal.
const MIN_WINDOWS: f64 = 8.0;

/// Smallest change of the binary logarithm of the variance, 2 % of the deviation: a smaller one
/// makes no result wrong, and any sensor changes as much with time.
const LEAST_CHANGE: f64 = 0.06;

/// Fewest windows of one value in neighbouring blocks that are a frozen channel.
const FROZEN_WINDOWS: u64 = 3;

/// Smallest standard deviation within a window over the step of the channel: a coarser channel has
/// windows of one value, and its noise depends on where in a step the level lies.
const LEAST_STEPS: f64 = 0.5;

/// What is not the same throughout in the noise of a channel.
#[derive(Clone, Debug, Default, PartialEq, JsonSchema, Serialize)]
pub struct NoiseChanges {
    /// Stretch with another noise than the rest; null if none was found.
    #[serde(rename = "noise_change")]
    pub change: Option<NoiseChange>,
    /// Variance of the noise from block to block over that of even noise; null if it is even.
    pub bursts: Option<f64>,
    /// Stretch of one value; null if none was found.
    pub frozen: Option<Frozen>,
    /// Single samples far out; null if none was found.
    pub spikes: Option<Spikes>,
}

/// A stretch with more or less noise than the rest of the record.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct NoiseChange {
    /// Start in seconds of data from the first sample, to a block.
    pub start_s: f64,
    /// End, likewise.
    pub end_s: f64,
    /// Standard deviation of the samples within, over that of the rest.
    pub factor: f64,
    /// How many standard errors the logarithm of that is.
    pub sigmas: f64,
}

/// A stretch with windows of one value.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Frozen {
    /// Start in seconds of data of the block in which it begins.
    pub start_s: f64,
    /// End of the block in which it ends.
    pub end_s: f64,
    /// Length of its windows of one value in seconds.
    pub duration_s: f64,
}

impl ChannelSignal {
    /// Changes of the noise of the record, by the `histogram` of the same samples; nothing below 16
    /// blocks of 32 samples, and only spikes where the noise is less than half a step of the channel.
    pub fn noise_changes(&self, histogram: &Histogram, interval_s: f64) -> NoiseChanges {
        let blocks = self.spreads();
        let Some(std_counts) = self.std_within_windows(&blocks) else { return NoiseChanges::default() };
        if blocks.len() < MIN_BLOCKS {
            return NoiseChanges::default();
        }
        let is_exact = histogram.bin_width_counts() == 1;
        let least = if is_exact { LEAST_STEPS * histogram.spacing_counts() } else { 0.0 };
        let spikes = Spikes::find(&self.extremes(), std_counts.max(least));
        if std_counts < least {
            return NoiseChanges { spikes, ..NoiseChanges::default() };
        }
        let noise = BlockNoise::new(&blocks);
        let change = noise.as_ref().and_then(BlockNoise::change);
        let bursts = noise.as_ref().and_then(|noise| noise.bursts(change.as_ref()));
        let disturbed = change.is_some() || bursts.is_some();
        let span = |first: usize, behind: usize| {
            let (start, length) = (blocks[first].0, blocks[first].1);
            (start as f64 * interval_s, (blocks[behind - 1].0 + length) as f64 * interval_s)
        };
        NoiseChanges {
            change: change.map(|ChangedBlocks { first, behind, change, sigmas }| {
                let (start_s, end_s) = span(first, behind);
                NoiseChange { start_s, end_s, factor: (change / 2.0).exp2(), sigmas }
            }),
            bursts,
            frozen: frozen(&blocks).map(|(first, behind, windows)| {
                let (start_s, end_s) = span(first, behind);
                Frozen { start_s, end_s, duration_s: windows as f64 * WINDOW as f64 * interval_s }
            }),
            spikes: spikes.filter(|_| !disturbed),
        }
    }

    /// Of the median window among those whose samples differ.
    fn std_within_windows(&self, blocks: &[BlockSpreads]) -> Option<f64> {
        let sum = |of: fn(&Spreads) -> u64| blocks.iter().map(|(.., spreads)| of(spreads)).sum::<u64>() as f64;
        let (windows, constant) = (sum(|spreads| spreads.windows), sum(|spreads| spreads.constant));
        let median = self.windows.spreads.quantile((constant + windows / 2.0) / (windows + constant))?;
        Some((median / (WINDOW * (WINDOW - 1)) as f64).sqrt())
    }
}

/// First sample, length in samples, spreads.
type BlockSpreads = (u64, u64, Spreads);

/// The longest series of neighbouring blocks with windows of one value: its first block, the one
/// behind it, and the windows.
fn frozen(blocks: &[BlockSpreads]) -> Option<(usize, usize, u64)> {
    let mut longest: Option<(usize, usize, u64)> = None;
    let mut first = 0;
    for series in blocks.chunk_by(|a, b| (a.2.constant > 0) == (b.2.constant > 0)) {
        let windows: u64 = series.iter().map(|(.., spreads)| spreads.constant).sum();
        if windows >= FROZEN_WINDOWS && longest.is_none_or(|(.., most)| windows > most) {
            longest = Some((first, first + series.len(), windows));
        }
        first += series.len();
    }
    longest
}

/// Mean logarithms of the spreads of the blocks.
struct BlockNoise {
    /// Windows of each block, and their mean binary logarithm from that of the record.
    means: Vec<(f64, f64)>,
    /// Places of these among the blocks.
    places: Vec<usize>,
    windows: f64,
    /// Of one window, from windows in the same block; 0 where blocks have too few.
    variance_within: f64,
    /// Of one window, from each pair of neighbouring blocks.
    pairs: Vec<f64>,
}

/// Blocks that differ from the rest.
#[derive(Clone, Copy)]
struct ChangedBlocks {
    first: usize,
    behind: usize,
    /// Of the binary logarithm of the variance.
    change: f64,
    sigmas: f64,
}

impl BlockNoise {
    /// `None` for too few blocks with windows.
    fn new(blocks: &[BlockSpreads]) -> Option<Self> {
        let (places, mut means): (Vec<usize>, Vec<(f64, f64)>) = (blocks.iter().enumerate())
            .filter_map(|(place, (.., spreads))| Some((place, (spreads.windows as f64, spreads.mean_log2()?))))
            .unzip();
        if means.len() < MIN_BLOCKS {
            return None;
        }
        let windows: f64 = means.iter().map(|(windows, _)| windows).sum();
        let mean = means.iter().map(|(windows, log)| windows * log).sum::<f64>() / windows;
        means.iter_mut().for_each(|(_, log)| *log -= mean);
        let squares: f64 = blocks.iter().map(|(.., spreads)| spreads.log2_squares()).sum();
        let free = windows - means.len() as f64;
        let pair = |pair: &[(f64, f64)]| (pair[0].1 - pair[1].1).powi(2) / (1.0 / pair[0].0 + 1.0 / pair[1].0);
        Some(Self {
            pairs: means.windows(2).map(pair).collect(),
            variance_within: if free > windows / 2.0 { squares / free } else { 0.0 },
            means,
            places,
            windows,
        })
    }

    /// Standard errors that no stretch of a clean record reaches, by Student's distribution.
    fn threshold(&self) -> Option<f64> {
        let blocks = self.means.len() as f64;
        let stretches = blocks * (blocks - 1.0) / 2.0;
        // Differences of neighbours share a block.
        let freedom = self.pairs.len() as f64 * 2.0 / 3.0;
        chi_squared::student_two_sided(1.0 - FALSE_ALARM / CHANNELS / stretches, freedom)
    }

    /// Of the `pairs` whose values are together this, all of them but `without`.
    fn variance(&self, without: usize, sum: f64) -> f64 {
        (sum.max(0.0) / (self.pairs.len() - without) as f64).max(self.variance_within)
    }

    /// The stretch that differs most.
    fn change(&self) -> Option<ChangedBlocks> {
        let threshold = self.threshold()?;
        let blocks = self.means.len();
        let mut sums = vec![(0.0, 0.0)];
        for (windows, log) in &self.means {
            let (all, sum) = sums[sums.len() - 1];
            sums.push((all + windows, sum + windows * log));
        }
        let total = sums[blocks].1;
        let all_pairs: f64 = self.pairs.iter().sum();
        // The square of the standard errors of a stretch as numerator and denominator: quotients and
        // roots of all stretches would take longer than everything else.
        let mut most: Option<(usize, usize, f64, f64)> = None;
        // One from the start on is that of the rest behind it.
        for first in 1..blocks {
            let (windows_before, sum_before) = sums[first];
            for (behind, (windows, sum)) in sums.iter().enumerate().skip(first + 1) {
                let (windows, sum) = (windows - windows_before, sum - sum_before);
                let rest = self.windows - windows;
                if windows.min(rest) < MIN_WINDOWS {
                    continue;
                }
                let edges = [Some(first - 1), (behind < blocks).then_some(behind - 1)].into_iter().flatten();
                let (without, sum_of_pairs) =
                    edges.fold((0, all_pairs), |(count, sum), edge| (count + 1, sum - self.pairs[edge]));
                // change = sum/windows - (total - sum)/rest, and its variance 1/windows + 1/rest
                let change = sum * self.windows - total * windows;
                let variance = self.variance(without, sum_of_pairs) * windows * rest * self.windows;
                let square = change * change;
                if most.is_none_or(|(.., of, over)| square * over > of * variance) {
                    most = Some((first, behind, square, variance));
                }
            }
        }
        let most = most.map(|(first, behind, square, variance)| {
            let (windows, sum) = (sums[behind].0 - sums[first].0, sums[behind].1 - sums[first].1);
            let change = sum / windows - (total - sum) / (self.windows - windows);
            ChangedBlocks { first, behind, change, sigmas: (square / variance).sqrt() }
        });
        let found = most.filter(|found| found.sigmas > threshold && found.change.abs() >= LEAST_CHANGE)?;
        Some(ChangedBlocks { first: self.places[found.first], behind: self.places[found.behind - 1] + 1, ..found })
    }

    /// Beside the `change` that was found.
    fn bursts(&self, change: Option<&ChangedBlocks>) -> Option<f64> {
        /// For the tails of the logarithms.
        const MARGIN: f64 = 1.15;
        const LEAST: f64 = 1.5;
        if self.variance_within == 0.0 {
            return None;
        }
        let is_within = |place: usize| change.is_some_and(|change| (change.first..change.behind).contains(&place));
        let part = |within: bool| {
            let all = self.places.iter().zip(&self.means).filter(|(place, _)| is_within(**place) == within);
            let means: Vec<_> = all.map(|(_, mean)| *mean).collect();
            let windows: f64 = means.iter().map(|(windows, _)| windows).sum();
            let mean = means.iter().map(|(windows, log)| windows * log).sum::<f64>() / windows;
            let squares: f64 = means.iter().map(|(windows, log)| windows * (log - mean).powi(2)).sum();
            (squares, means.len().saturating_sub(1))
        };
        // without a change there is no part within
        let ((outside, free_outside), (within, free_within)) = (part(false), part(true));
        let (squares, free) = (outside + within, free_outside + free_within);
        let ratio = squares / free as f64 / self.variance_within;
        let p = chi_squared::probability_above(ratio / MARGIN * free as f64, free as f64)?;
        (p < FALSE_ALARM / CHANNELS && ratio > LEAST).then_some(ratio)
    }
}

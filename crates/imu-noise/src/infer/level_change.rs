//! Changes of the level of a channel: warm-up, steps, cycles.

use super::level_noise::{LevelFit, LevelNoise};
use super::level_shapes::{BlockShape, is_few};
use crate::accumulate::blocks::Block;
use crate::accumulate::counts::counts_to_unit;
use crate::accumulate::signal::ChannelSignal;
use schemars::JsonSchema;
use serde::Serialize;

const MIN_BLOCKS: usize = 16;

/// Thresholds of the evidence, by simulation of white, flicker and random-walk noise in many
/// proportions, 8000 series of 16, 24, 48 and 70 blocks each: fewer than 1 in 1000 exceed any.
const WARM_UP_EVIDENCE: f64 = 24.0;
const STEP_EVIDENCE: f64 = 24.0;
const CYCLE_EVIDENCE: f64 = 30.0;

/// Of one to three cycles, likewise, and of series of 94 blocks: fewer than 2 in 1000 exceed it,
/// walks most often.
const FEW_CYCLES_EVIDENCE: f64 = 25.0;

/// Evidence that a step of the expected size has of which nine in ten records show more than the
/// threshold, white noise, flicker noise and mixtures simulated; of pure random walks seven.
const EVIDENCE_OF_NINE_IN_TEN: f64 = 46.0;

/// A straight line with this much less evidence than the best shape is as good an explanation.
const AS_GOOD: f64 = 6.0;

/// Least share of the samples of the fullest block in a block that has a part.
const LEAST_PRESENT: f64 = 0.75;

/// A change of level that the noise of the record, with flicker and random walk, does not explain.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct LevelChange {
    /// Its shape.
    #[serde(flatten)]
    pub shape: LevelShape,
    /// Square root of twice the log-likelihood ratio: the sigmas of a known shape in known noise.
    pub sigmas: f64,
    /// A straight line explains the record as well: the ramp of a noise model is the change.
    pub is_ramp: bool,
}

/// The shape of a change of level.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case", tag = "shape")]
pub enum LevelShape {
    /// The level relaxes from the start of the record on.
    WarmUp {
        /// Level at the start minus the final level, in the unit of the channel.
        amplitude: f64,
        /// Time constant of the relaxation in seconds: the likeliest of the powers of two of block
        /// lengths that are within the record. A drift that does not settle within it shows the
        /// longest, and no skip.
        time_constant_s: f64,
        /// Seconds to exclude at the start, after which the rest is below half the noise of a block
        /// mean. `None` when that is more than half of the record.
        skip_s: Option<f64>,
    },
    /// The level is another from some time on.
    Step {
        /// When, in seconds of data from the first sample, to half a block.
        start_s: f64,
        /// New level minus old level, in the unit of the channel.
        amplitude: f64,
    },
    /// The level goes up and down evenly, once or more within the record.
    Cycle {
        /// In seconds.
        period_s: f64,
        /// Half of the way from the lowest to the highest level, in the unit of the channel.
        amplitude: f64,
    },
}

/// What the level of one channel shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelFindings {
    /// The change with the most evidence above its threshold.
    pub change: Option<LevelChange>,
    /// The step in the middle of the record, in the unit of the channel, that nine of ten such
    /// records would show; `None` if there is too little to judge.
    pub detectable_step: Option<f64>,
}

/// The search for changes of level in the channels of one record: holds what those with as many
/// blocks have in common.
#[derive(Clone, Debug)]
pub struct LevelSearch {
    noises: Vec<LevelNoise>,
}

impl LevelSearch {
    /// A search in these channels. Costs about a millisecond, whatever their number.
    #[must_use]
    pub fn of<'a>(signals: impl IntoIterator<Item = &'a ChannelSignal>) -> Self {
        let mut noises: Vec<LevelNoise> = Vec::new();
        for signal in signals {
            let blocks = longest_series(&signal.blocks()).len();
            if blocks >= MIN_BLOCKS && noises.iter().all(|noise| noise.blocks() != blocks) {
                noises.push(LevelNoise::new(blocks));
            }
        }
        Self { noises }
    }

    /// A warm-up, a step or a cycle of the level of `signal`, one of those the search was made for,
    /// in its longest series of blocks that no gap cuts; nothing below 16 of them.
    #[must_use]
    pub fn find(&self, signal: &ChannelSignal, interval_s: f64, decimals: u8) -> LevelFindings {
        self.find_in(&signal.blocks(), interval_s, decimals)
    }

    /// The same in the blocks of such a signal, of which something known may have been removed.
    #[must_use]
    pub fn find_in(&self, blocks: &[Block], interval_s: f64, decimals: u8) -> LevelFindings {
        let blocks = longest_series(blocks);
        let noise = self.noises.iter().find(|noise| noise.blocks() == blocks.len());
        let (Some(noise), Some(first)) = (noise, blocks.first()) else { return LevelFindings::default() };
        // From the first, so that no digits are lost on a large offset.
        let means: Vec<f64> = blocks.iter().map(|block| block.mean_counts - first.mean_counts).collect();
        let fits = noise.fits(&means);
        let span = Span {
            start_s: first.first_sample as f64 * interval_s,
            block_s: first.length as f64 * interval_s,
            blocks: blocks.len() as f64,
            decimals,
        };
        let change = change(&fits, &span);
        LevelFindings { change, detectable_step: detectable_step(noise, &fits, &span) }
    }
}

/// The blocks behind one another that are as good as full.
fn longest_series(blocks: &[Block]) -> &[Block] {
    let fullest = blocks.iter().map(|block| block.count).max().unwrap_or(0) as f64;
    let is_full = |block: &Block| block.count as f64 >= LEAST_PRESENT * fullest;
    let follows = |a: &Block, b: &Block| a.first_sample + a.length == b.first_sample && is_full(a) == is_full(b);
    let series = blocks.chunk_by(follows).filter(|series| is_full(&series[0]));
    // the first of the longest
    series.rev().max_by_key(|series| series.len()).unwrap_or_default()
}

struct Span {
    start_s: f64,
    block_s: f64,
    blocks: f64,
    decimals: u8,
}

fn change(fits: &[LevelFit], span: &Span) -> Option<LevelChange> {
    let beyond = |fit: &LevelFit| match fit.shape {
        BlockShape::Relaxation(_) => fit.evidence - WARM_UP_EVIDENCE,
        BlockShape::Step(_) => fit.evidence - STEP_EVIDENCE,
        BlockShape::Cycle(frequency) if is_few(frequency * span.blocks) => fit.evidence - FEW_CYCLES_EVIDENCE,
        BlockShape::Cycle(_) => fit.evidence - CYCLE_EVIDENCE,
        BlockShape::Ramp => f64::NEG_INFINITY,
    };
    let fit = fits.iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b))).filter(|fit| beyond(fit) > 0.0)?;
    let ramp = fits.iter().find(|fit| fit.shape == BlockShape::Ramp);
    let is_ramp = ramp.is_some_and(|ramp| ramp.evidence > fit.evidence - AS_GOOD);
    let amplitude = counts_to_unit(fit.amplitude, span.decimals);
    let shape = match fit.shape {
        BlockShape::Relaxation(time) => {
            let skip = time * (2.0 * fit.amplitude.abs() / fit.short_std).ln();
            let skip_s = (skip <= span.blocks / 2.0).then_some(span.start_s + skip.max(0.0) * span.block_s);
            LevelShape::WarmUp { amplitude, time_constant_s: time * span.block_s, skip_s }
        }
        BlockShape::Step(at) => LevelShape::Step { start_s: span.start_s + at * span.block_s, amplitude },
        BlockShape::Cycle(frequency) => {
            // the mean over a block is smaller
            let phase = core::f64::consts::PI * frequency;
            LevelShape::Cycle { period_s: span.block_s / frequency, amplitude: amplitude * phase / phase.sin() }
        }
        BlockShape::Ramp => return None,
    };
    Some(LevelChange { shape, sigmas: fit.evidence.sqrt(), is_ramp })
}

/// With the noise fitted together with a step in the middle.
fn detectable_step(noise: &LevelNoise, fits: &[LevelFit], span: &Span) -> Option<f64> {
    let middle = BlockShape::Step((span.blocks / 2.0).floor());
    let fit = fits.iter().find(|fit| fit.shape == middle)?;
    Some(counts_to_unit(noise.detectable(middle, fit, EVIDENCE_OF_NINE_IN_TEN)?, span.decimals))
}

//! Changes of the level of a channel: warm-up, steps, cycles.
//!
//! By the likelihood of the cosine coefficients of the block means, in white noise, flicker noise and
//! a random walk of any proportion: a change is a shape with which the likelihood, the noise fitted
//! with it, is that much larger.

use super::level_series::longest_series;
use super::noise_model::{MeanShape, MeanShapes, Rows, Scored, Structure};
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
const FEW_CYCLES: f64 = 3.0;

/// Most cycles per block.
const FASTEST_CYCLE: f64 = 0.4;

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
        /// The likeliest time constant of the relaxation in seconds, three times the record at most. A
        /// drift that does not settle within the record shows a long one, and no skip.
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
    /// The record is long enough to show one.
    pub is_searched: bool,
}

/// The search for changes of level: what channels with as many blocks have in common.
#[derive(Clone, Debug)]
pub struct LevelSearch {
    shapes: Vec<MeanShapes>,
}

impl LevelSearch {
    /// A search in these channels. Costs about two milliseconds, whatever their number.
    pub fn of<'a>(signals: impl IntoIterator<Item = &'a ChannelSignal>) -> Self {
        let mut shapes: Vec<MeanShapes> = Vec::new();
        for signal in signals {
            let blocks = longest_full(&signal.blocks()).len();
            if blocks >= MIN_BLOCKS && shapes.iter().all(|known| known.blocks != blocks) {
                shapes.push(MeanShapes::new(blocks, true));
            }
        }
        Self { shapes }
    }

    /// A warm-up, a step or a cycle of the level of `signal`, one of those the search was made for,
    /// in its longest series of blocks that no gap cuts; nothing below 16 of them.
    pub fn find(&self, signal: &ChannelSignal, interval_s: f64, decimals: u8) -> LevelFindings {
        let blocks = signal.blocks();
        let blocks = longest_full(&blocks);
        let shapes = self.shapes.iter().find(|shapes| shapes.blocks == blocks.len());
        let (Some(shapes), Some(first)) = (shapes, blocks.first()) else { return LevelFindings::default() };
        // From the first, so that no digits are lost on a large offset.
        let means: Vec<f64> = blocks.iter().map(|block| block.mean_counts - first.mean_counts).collect();
        let Some(level) = Level::new(shapes, &means) else { return LevelFindings::default() };
        let span = Span {
            start_s: first.first_sample as f64 * interval_s,
            block_s: first.length as f64 * interval_s,
            blocks: blocks.len() as f64,
            decimals,
        };
        LevelFindings { change: change(&level, &span), is_searched: true }
    }
}

/// The consecutive blocks that are as good as full.
fn longest_full(blocks: &[Block]) -> &[Block] {
    let fullest = blocks.iter().map(|block| block.count).max().unwrap_or(0) as f64;
    longest_series(blocks, |block| block.count as f64 >= LEAST_PRESENT * fullest)
}

/// The level of a channel, and its noise without any shape.
struct Level<'a> {
    shapes: &'a MeanShapes,
    rows: Rows,
    alone: Scored,
}

/// The likeliest shape of one kind, with the noise that suits it best.
struct LevelFit {
    shape: MeanShape,
    /// Of a cycle not negative.
    amplitude: f64,
    /// Twice the log-likelihood ratio with and without the shape.
    evidence: f64,
    /// Standard deviation of a block mean without the shape, by the noise at the highest frequency.
    short_std: f64,
}

impl<'a> Level<'a> {
    /// `None` for a level that does not vary.
    fn new(shapes: &'a MeanShapes, means: &[f64]) -> Option<Self> {
        let rows = Rows::of_level(shapes.transform.of(means));
        let alone = rows.fit(&Structure::of_level(&[]), None)?;
        Some(Self { shapes, rows, alone })
    }

    /// The likeliest shape of those that are meant, looked at more closely if it may reach `evidence`.
    fn likeliest(&self, evidence: f64, is_meant: impl Fn(MeanShape) -> bool) -> Option<LevelFit> {
        let find = |noise: &Scored, least_rise: f64| {
            let found = self.shapes.likeliest(&self.rows.level, &noise.expected, &[], &is_meant, least_rise)?;
            let shapes: Vec<&[f64]> = found.coefficients.iter().map(Vec::as_slice).collect();
            let with = self.rows.fit(&Structure::of_level(&shapes), Some(noise))?;
            Some((found.shape, with))
        };
        let (mut shape, mut with) = find(&self.alone, 0.0)?;
        if self.evidence(&with) > 0.5 * evidence
            && let Some((other, better)) = find(&with, 0.0)
            && better.log_likelihood > with.log_likelihood
        {
            (shape, with) = (other, better);
        }
        let amplitude = match with.multiples[..] {
            [one] => one,
            _ => with.multiples.iter().map(|multiple| multiple * multiple).sum::<f64>().sqrt(),
        };
        let short_std = with.expected.iter().copied().fold(f64::INFINITY, f64::min).sqrt();
        Some(LevelFit { shape, amplitude, evidence: self.evidence(&with), short_std })
    }

    fn evidence(&self, with: &Scored) -> f64 {
        2.0 * (with.log_likelihood - self.alone.log_likelihood)
    }

    fn ramp_evidence(&self) -> f64 {
        let structure = Structure::of_level(&[&self.shapes.ramp]);
        self.rows.fit(&structure, Some(&self.alone)).map_or(0.0, |with| self.evidence(&with))
    }
}

struct Span {
    start_s: f64,
    block_s: f64,
    blocks: f64,
    decimals: u8,
}

fn change(level: &Level<'_>, span: &Span) -> Option<LevelChange> {
    let few = FEW_CYCLES / span.blocks;
    let slowest = 1.0 / span.blocks;
    let kinds: [(f64, &dyn Fn(MeanShape) -> bool); 4] = [
        (WARM_UP_EVIDENCE, &|shape| matches!(shape, MeanShape::Relaxation(_))),
        (STEP_EVIDENCE, &|shape| matches!(shape, MeanShape::Step(_))),
        (FEW_CYCLES_EVIDENCE, &|shape| matches!(shape, MeanShape::Cycle(of) if of >= slowest && of < few)),
        (CYCLE_EVIDENCE, &|shape| matches!(shape, MeanShape::Cycle(of) if of >= few && of <= FASTEST_CYCLE)),
    ];
    let found = kinds.into_iter().filter_map(|(needed, is_meant)| {
        let fit = level.likeliest(needed, is_meant)?;
        (fit.evidence > needed).then_some((fit.evidence - needed, fit))
    });
    let (_, fit) = found.max_by(|(a, _), (b, _)| a.total_cmp(b))?;
    let is_ramp = level.ramp_evidence() > fit.evidence - AS_GOOD;
    let amplitude = counts_to_unit(fit.amplitude, span.decimals);
    let shape = match fit.shape {
        MeanShape::Relaxation(time) => {
            let skip = time * (2.0 * fit.amplitude.abs() / fit.short_std).ln();
            let skip_s = (skip <= span.blocks / 2.0).then_some(span.start_s + skip.max(0.0) * span.block_s);
            LevelShape::WarmUp { amplitude, time_constant_s: time * span.block_s, skip_s }
        }
        MeanShape::Step(at) => LevelShape::Step { start_s: span.start_s + at * span.block_s, amplitude },
        MeanShape::Cycle(frequency) => {
            // the mean over a block is smaller
            let phase = core::f64::consts::PI * frequency;
            LevelShape::Cycle { period_s: span.block_s / frequency, amplitude: amplitude * phase / phase.sin() }
        }
    };
    Some(LevelChange { shape, sigmas: fit.evidence.sqrt(), is_ramp })
}

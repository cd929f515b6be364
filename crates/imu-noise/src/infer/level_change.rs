//! A warm-up at the start of a record, or a step of its level.

use super::local_level::{Fit, Mean, Regressor, fits};
use crate::accumulate::blocks::Block;
use crate::accumulate::counts::counts_to_unit;
use crate::accumulate::signal::ChannelSignal;

/// Fewest blocks in which a change is distinguished from noise.
const MIN_BLOCKS: usize = 16;

/// Evidence for a warm-up, and for a step at any place. Of 40 000 simulated channels of white,
/// flicker and random-walk noise three at most exceed either in any proportion of the three, most
/// often none.
const WARM_UP_EVIDENCE: f64 = 24.0;
const STEP_EVIDENCE: f64 = 28.0;

/// Blocks at either end of the record in which a step is not sought: a few blocks do not make a
/// level.
const STEP_MARGIN: usize = 4;

/// A change of level that the noise of the record, with flicker and random walk, does not explain.
///
/// Of simulated warm-ups that move N, B or K out of its interval at most 9 records in 100 go unseen
/// in white noise or a random walk, but up to 25 in flicker noise: a slow settling there is
/// what flicker noise and a small walk look like together (the benchmark `warm_up`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelChange {
    /// Its shape.
    pub shape: LevelShape,
    /// Square root of twice the logarithm of the likelihood ratio: the sigmas of a known shape in
    /// known noise.
    pub sigmas: f64,
}

/// The shape of a change of level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelShape {
    /// The level relaxes from the start of the record on.
    WarmUp {
        /// Level at the start minus the final level, in the unit of the channel.
        amplitude: f64,
        /// Time constant of the relaxation in seconds: the likeliest of the powers of two of block
        /// lengths that are within the record. A drift that does not settle within it shows the
        /// longest, and no skip.
        time_constant_s: f64,
        /// Seconds to exclude at the start, after which the rest is below half the white noise of
        /// a block mean. `None` when that is more than half of the record.
        skip_s: Option<f64>,
    },
    /// The level is another from some time on.
    Step {
        /// Start of the first block with the new level, in seconds of data from the first sample.
        start_s: f64,
        /// New level minus old level, in the unit of the channel.
        amplitude: f64,
    },
}

impl ChannelSignal {
    /// A warm-up or a step of the level that the noise of the record, with flicker and random walk,
    /// does not explain. `None` below 16 blocks.
    #[must_use]
    pub fn level_change(&self, interval_s: f64, decimals: u8) -> Option<LevelChange> {
        change(&self.blocks(), interval_s, decimals)
    }
}

/// The change with the most evidence beyond what is required of it.
fn change(blocks: &[Block], interval_s: f64, decimals: u8) -> Option<LevelChange> {
    let (first, last) = (blocks.first()?, blocks.last()?);
    if blocks.len() < MIN_BLOCKS {
        return None;
    }
    let length = first.length;
    let means: Vec<_> = blocks.iter().map(|block| mean(block, first)).collect();
    let span = (last.first_sample - first.first_sample) / length + 1;
    let time_constants: Vec<_> = (0..).map(|k| f64::from(1 << k)).take_while(|&blocks| blocks <= span as f64).collect();
    let beyond = |fit: &Fit| match fit.shape {
        Regressor::Relaxation(_) => fit.evidence - WARM_UP_EVIDENCE,
        Regressor::Step(place) if (STEP_MARGIN..=means.len() - STEP_MARGIN).contains(&place) => {
            fit.evidence - STEP_EVIDENCE
        }
        Regressor::Step(_) => f64::NEG_INFINITY,
    };
    let fit = fits(&means, &time_constants).into_iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    if beyond(&fit) <= 0.0 {
        return None;
    }
    let amplitude = counts_to_unit(fit.amplitude, decimals);
    let shape = match fit.shape {
        Regressor::Relaxation(time_constant) => {
            let block_s = length as f64 * interval_s;
            let skip = time_constant * (2.0 * fit.amplitude.abs() / fit.white_std).ln();
            let skip_s = (skip <= span as f64 / 2.0).then_some(skip.max(0.0) * block_s);
            LevelShape::WarmUp { amplitude, time_constant_s: time_constant * block_s, skip_s }
        }
        Regressor::Step(place) => {
            LevelShape::Step { start_s: blocks[place].first_sample as f64 * interval_s, amplitude }
        }
    };
    Some(LevelChange { shape, sigmas: fit.evidence.sqrt() })
}

fn mean(block: &Block, first: &Block) -> Mean {
    Mean {
        block: (block.first_sample - first.first_sample) / block.length,
        // From the first, so that no digits are lost on a large offset.
        mean: block.mean_counts() - first.mean_counts(),
        relative_variance: block.length as f64 / block.count() as f64,
    }
}

//! Warm-up and steps of the level of a channel.

use crate::accumulate::blocks::Block;
use crate::accumulate::counts::counts_to_unit;
use crate::accumulate::signal::ChannelSignal;

const MIN_BLOCKS: usize = 16;

/// Of 40 000 simulated channels of white, flicker and random-walk noise three at most exceed either
/// in any proportion of the three, most often none.
const WARM_UP_EVIDENCE: f64 = 24.0;
const STEP_EVIDENCE: f64 = 28.0;

/// Blocks at either end in which a step is not sought: a few blocks do not make a level.
const STEP_MARGIN: usize = 4;

/// A change of level that the noise of the record, with flicker and random walk, does not explain.
/// Of simulated warm-ups that move N, B or K out of its interval at most 9 records in 100 go unseen
/// in white noise or a random walk, but up to 25 in flicker noise: a slow settling there is what
/// flicker noise and a small walk look like together (the benchmark `warm_up`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelChange {
    /// Its shape.
    pub shape: LevelShape,
    /// Square root of twice the log-likelihood ratio: the sigmas of a known shape in known noise.
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
    /// A warm-up or a step of the level; `None` below 16 blocks.
    #[must_use]
    pub fn level_change(&self, interval_s: f64, decimals: u8) -> Option<LevelChange> {
        let blocks = self.blocks();
        let (first, last) = (blocks.first()?, blocks.last()?);
        if blocks.len() < MIN_BLOCKS {
            return None;
        }
        let length = first.length;
        let means: Vec<_> = blocks.iter().map(|block| mean(block, first)).collect();
        let span = (last.first_sample - first.first_sample) / length + 1;
        let time_constants: Vec<_> =
            (0..).map(|k| f64::from(1 << k)).take_while(|&blocks| blocks <= span as f64).collect();
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
}

fn mean(block: &Block, first: &Block) -> Mean {
    Mean {
        block: (block.first_sample - first.first_sample) / block.length,
        // From the first, so that no digits are lost on a large offset.
        mean: block.mean_counts - first.mean_counts,
        relative_variance: block.length as f64 / block.count as f64,
    }
}

#[derive(Clone, Copy, Debug)]
struct Mean {
    block: u64,
    mean: f64,
    /// Of its white noise, over that of the mean of a full block.
    relative_variance: f64,
}

/// Variances of the random-walk step over that of the white noise of a block mean: from white noise
/// to a random walk; flicker is followed by those between.
const STEP_VARIANCES: [f64; 12] = [0.0, 1e-4, 4e-4, 1.6e-3, 6.4e-3, 0.026, 0.1, 0.4, 1.6, 6.4, 26.0, 400.0];

#[derive(Clone, Copy, Debug, PartialEq)]
struct Fit {
    shape: Regressor,
    /// Least-squares multiple, under the noise that makes the series likeliest.
    amplitude: f64,
    /// Twice the log-likelihood ratio with and without the shape, each with the noise that suits it
    /// best.
    evidence: f64,
    /// Of the white noise of the mean of a full block, the shape removed.
    white_std: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Regressor {
    /// exp(-t/time constant) from the first block on, in blocks.
    Relaxation(f64),
    /// 0 before the mean with this index, 1 from it on.
    Step(usize),
}

/// The evidence for a relaxation of each of the time constants, in blocks, and for a step at every
/// mean but the first. The noise is the local level model, white noise around a random walk, by its
/// prediction errors: Harvey (1989), 3.4 and 7.3. Empty for fewer than three means, or when nothing
/// but a shape is in the series.
fn fits(means: &[Mean], time_constants: &[f64]) -> Vec<Fit> {
    let relaxations = time_constants.iter().map(|&time_constant| {
        let values: Vec<_> = means.iter().map(|mean| (-(mean.block as f64) / time_constant).exp()).collect();
        (Regressor::Relaxation(time_constant), values)
    });
    let relaxations: Vec<_> = relaxations.collect();
    let mut without = f64::NEG_INFINITY;
    // For each shape the highest likelihood, and the fit that has it.
    let mut with: Vec<(f64, Fit)> = Vec::new();
    for step_variance in STEP_VARIANCES {
        let errors = PredictionErrors::new(means, step_variance);
        let series: Vec<_> = errors.of(means.iter().map(|mean| mean.mean)).collect();
        let squares: f64 = series.iter().map(|error| error * error).sum();
        let Some(likelihood) = errors.likelihood(squares) else { return Vec::new() };
        without = without.max(likelihood);
        let products = relaxations.iter().map(|(shape, values)| {
            let (cross, own) = (errors.of(values.iter().copied()).zip(&series))
                .fold((0.0, 0.0), |(cross, own), (x, y)| (cross + x * y, own + x * x));
            (*shape, cross, own)
        });
        for (place, (shape, cross, own)) in products.chain(errors.steps_on(&series)).enumerate() {
            let amplitude = if own > 0.0 { cross / own } else { 0.0 };
            let rest = squares - cross * amplitude;
            let Some(likelihood) = errors.likelihood(rest) else { return Vec::new() };
            let white_std = (rest / series.len() as f64).sqrt();
            let fit = (likelihood, Fit { shape, amplitude, evidence: 0.0, white_std });
            match with.get_mut(place) {
                Some(best) if best.0 >= likelihood => {}
                Some(best) => *best = fit,
                None => with.push(fit),
            }
        }
    }
    with.into_iter().map(|(likelihood, fit)| Fit { evidence: 2.0 * (likelihood - without), ..fit }).collect()
}

struct PredictionErrors {
    /// For each mean but the first: gain, and 1 over the standard deviation of its error.
    gains: Vec<(f64, f64)>,
    /// Sum of the logarithms of the variances of the errors.
    log_variances: f64,
}

impl PredictionErrors {
    fn new(means: &[Mean], step_variance: f64) -> Self {
        let mut log_variances = 0.0;
        let mut last: Option<Mean> = None;
        // Variance of the estimated level.
        let mut variance = 0.0;
        let gains = means.iter().filter_map(|mean| {
            let Some(before) = last.replace(*mean) else {
                variance = mean.relative_variance;
                return None;
            };
            variance += step_variance * (mean.block - before.block) as f64;
            let error_variance = variance + mean.relative_variance;
            let gain = variance / error_variance;
            variance *= mean.relative_variance / error_variance;
            log_variances += error_variance.ln();
            Some((gain, error_variance.sqrt().recip()))
        });
        Self { gains: gains.collect(), log_variances }
    }

    /// In standard deviations, for all values but the first.
    fn of(&self, mut values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        let mut level = values.next().unwrap_or(0.0);
        values.zip(&self.gains).map(move |(value, (gain, scale))| {
            let error = value - level;
            level += gain * error;
            error * scale
        })
    }

    /// For a step at each mean but the first, backward: the products of its errors with `series`
    /// and with themselves. The error shrinks by 1 - gain from mean to mean, so each sum follows
    /// from the next.
    fn steps_on(&self, series: &[f64]) -> impl Iterator<Item = (Regressor, f64, f64)> {
        let backward = self.gains.iter().zip(series).enumerate().rev();
        backward.scan((0.0, 0.0), |(cross, own), (before, ((gain, scale), error))| {
            let kept = 1.0 - gain;
            *cross = scale * error + kept * *cross;
            *own = scale * scale + kept * kept * *own;
            Some((Regressor::Step(before + 1), *cross, *own))
        })
    }

    /// Up to a constant, with the most likely scale. `None` for a sum of squares of zero.
    fn likelihood(&self, squares: f64) -> Option<f64> {
        let n = self.gains.len() as f64;
        (n >= 2.0 && squares > 0.0).then(|| -0.5 * (n * squares.ln() + self.log_variances))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Logarithm of the likelihood of the differences of the series, by their covariance matrix,
    /// with the best scale.
    fn dense(means: &[Mean], series: &[f64], step_variance: f64) -> f64 {
        let n = means.len() - 1;
        let covariance = |i: usize, j: usize| {
            let white = |k: usize| means[k].relative_variance;
            match i.abs_diff(j) {
                0 => white(i) + white(i + 1) + step_variance * (means[i + 1].block - means[i].block) as f64,
                1 => -white(i.max(j)),
                _ => 0.0,
            }
        };
        // Cholesky, and the errors by forward substitution.
        let mut root = vec![vec![0.0; n]; n];
        let (mut squares, mut log_determinant) = (0.0, 0.0);
        let mut errors = vec![0.0; n];
        for i in 0..n {
            for j in 0..=i {
                let rest = covariance(i, j) - (0..j).map(|k| root[i][k] * root[j][k]).sum::<f64>();
                root[i][j] = if i == j { rest.sqrt() } else { rest / root[j][j] };
            }
            let known: f64 = (0..i).map(|k| root[i][k] * errors[k]).sum();
            errors[i] = (series[i + 1] - series[i] - known) / root[i][i];
            squares += errors[i] * errors[i];
            log_determinant += 2.0 * root[i][i].ln();
        }
        -0.5 * (n as f64 * squares.ln() + log_determinant)
    }

    #[test]
    fn the_evidence_is_that_of_the_whole_covariance_matrix() {
        // Two blocks are missing and two are not full.
        let blocks = [0, 1, 2, 3, 6, 7, 8, 9, 10, 11, 12, 13];
        let noise = [0.3, -1.1, 0.8, 0.1, -0.4, 1.9, 0.2, -0.7, 0.5, -0.2, 1.0, -1.3];
        let means: Vec<_> = (0..12)
            .map(|i| Mean {
                block: blocks[i],
                mean: noise[i] + 6.0 * (-(blocks[i] as f64) / 4.0).exp() + if i < 7 { 0.0 } else { 2.0 },
                relative_variance: if i % 5 == 3 { 2.5 } else { 1.0 },
            })
            .collect();
        let series: Vec<_> = means.iter().map(|mean| mean.mean).collect();
        let likeliest = |series: &[f64]| {
            STEP_VARIANCES.iter().map(|&step| dense(&means, series, step)).fold(f64::NEG_INFINITY, f64::max)
        };
        let fits = fits(&means, &[4.0, 8.0]);
        assert_eq!(fits.len(), 2 + 11);
        for fit in fits {
            let shape = |i: usize| match fit.shape {
                Regressor::Relaxation(time_constant) => (-(blocks[i] as f64) / time_constant).exp(),
                Regressor::Step(place) => f64::from(u8::from(i >= place)),
            };
            let rest = |amplitude: f64| -> Vec<_> { (0..12).map(|i| series[i] - amplitude * shape(i)).collect() };
            let evidence = 2.0 * (likeliest(&rest(fit.amplitude)) - likeliest(&series));
            assert!((fit.evidence - evidence).abs() < 1e-9, "{fit:?}: {evidence}");
            // The amplitude is the best one.
            for other in [fit.amplitude - 0.01, fit.amplitude + 0.01] {
                assert!(likeliest(&rest(other)) < likeliest(&rest(fit.amplitude)), "{fit:?}");
            }
        }
    }

    #[test]
    fn without_noise_or_with_two_means_there_is_no_evidence() {
        let means = |values: &[f64]| -> Vec<_> {
            (0..).zip(values).map(|(block, &mean)| Mean { block, mean, relative_variance: 1.0 }).collect()
        };
        assert_eq!(fits(&means(&[5.0; 20]), &[4.0]), []);
        assert_eq!(fits(&means(&[1.0, 2.0]), &[4.0]), []);
        assert_eq!(fits(&[], &[4.0]), []);
    }
}

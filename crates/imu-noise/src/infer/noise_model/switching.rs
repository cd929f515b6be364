//! Noise that switches between two levels (popcorn noise).
//!
//! Its spectrum is that of a Gauss-Markov process; the values tell: by a hidden Markov model of two
//! levels (Baum and others, 1970), with white noise about each.

use core::f64::consts::TAU;

/// Most steps of the search for the likeliest levels, and the rise of the last one.
const STEPS: usize = 40;
const TOLERANCE: f64 = 1e-2;

/// Least variance about a level, of that of all blocks: two equal values are no level.
const LEAST_VARIANCE: f64 = 1e-4;

struct Switching {
    levels: [f64; 2],
    variance: f64,
    /// Probability that a block at either level is the last one there.
    leave: [f64; 2],
    /// Share of the blocks in which the level switches.
    between: f64,
    /// From the lowest to the highest block.
    range: f64,
}

/// The largest log-likelihood of the changes of a level by block, without the part -(n - 1)/2 ln 2π that
/// every model of n blocks has; `lacks_ramp`: of what a ramp leaves (restricted, as that of
/// [`Structure`](super::Structure)). No number for blocks that are all alike.
pub(super) fn log_likelihood(level: &[f64], lacks_ramp: bool) -> f64 {
    let n = level.len() as f64;
    let mean = level.iter().sum::<f64>() / n;
    let variance = level.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
    let ends = |(low, high): (f64, f64), value: &f64| (low.min(*value), high.max(*value));
    let (low, high) = level.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    let levels = [mean - variance.sqrt(), mean + variance.sqrt()];
    let mut model = Switching { levels, variance: 0.5 * variance, leave: [0.1; 2], between: 0.1, range: high - low };
    let mut found = f64::NEG_INFINITY;
    for _ in 0..STEPS {
        let before = found;
        found = model.improve(level);
        model.variance = model.variance.max(LEAST_VARIANCE * variance);
        if found - before < TOLERANCE {
            break;
        }
    }
    // over all means, each as likely as any other, and over all ramps
    let free = if lacks_ramp { 2.0 } else { 1.0 };
    found + 0.5 * (n * TAU.ln() + free * model.variance.ln())
}

impl Switching {
    /// By level the density of a value, and the share of the level itself in it.
    fn densities(&self, value: f64) -> [(f64, f64); 2] {
        let anywhere = self.between / self.range;
        self.levels.map(|level| {
            let normal = (-0.5 * (value - level).powi(2) / self.variance).exp() / (TAU * self.variance).sqrt();
            let own = (1.0 - self.between) * normal;
            (own + anywhere, own / (own + anywhere))
        })
    }

    /// One step of expectation and maximisation (Dempster, Laird and Rubin, 1977), after the recursions
    /// forwards and backwards of Rabiner (1989); gives the log-likelihood before it.
    fn improve(&mut self, series: &[f64]) -> f64 {
        let densities: Vec<[(f64, f64); 2]> = series.iter().map(|value| self.densities(*value)).collect();
        let [up, down] = self.leave;
        let mut next = [down / (up + down), up / (up + down)];
        let mut forward = Vec::with_capacity(series.len());
        for [low, high] in &densities {
            let joint = [next[0] * low.0, next[1] * high.0];
            let scale = joint[0] + joint[1];
            let now = joint.map(|joint| joint / scale);
            forward.push((now, scale));
            next = [now[0] * (1.0 - up) + now[1] * down, now[0] * up + now[1] * (1.0 - down)];
        }
        let mut backward = [1.0; 2];
        let (mut weights, mut sums, mut squares) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        let (mut stays, mut leaves) = ([0.0; 2], [0.0; 2]);
        for (place, value) in series.iter().enumerate().rev() {
            for state in 0..2 {
                let weight = forward[place].0[state] * backward[state] * densities[place][state].1;
                weights[state] += weight;
                sums[state] += weight * value;
                squares[state] += weight * value * value;
            }
            let Some(earlier) = place.checked_sub(1) else { break };
            let beyond = [0, 1].map(|state| densities[place][state].0 * backward[state] / forward[place].1);
            for (state, leave) in self.leave.into_iter().enumerate() {
                let (stay, change) = ((1.0 - leave) * beyond[state], leave * beyond[1 - state]);
                stays[state] += forward[earlier].0[state] * stay;
                leaves[state] += forward[earlier].0[state] * change;
                backward[state] = stay + change;
            }
        }
        let of_levels = weights[0] + weights[1];
        let about = |state: usize| squares[state] - sums[state] * sums[state] / weights[state];
        self.levels = [0, 1].map(|state| sums[state] / weights[state]);
        self.variance = (about(0) + about(1)) / of_levels;
        self.between = (1.0 - of_levels / series.len() as f64).clamp(1e-6, 0.5);
        self.leave = [0, 1].map(|state| (leaves[state] / (stays[state] + leaves[state])).clamp(1e-4, 0.5));
        forward.iter().map(|(_, scale)| scale.ln()).sum()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Sums of twelve uniform numbers of a congruence.
    fn noise(seed: u64, blocks: usize) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 2_f64.powi(53)
        };
        (0..blocks).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    fn of_white(level: &[f64]) -> f64 {
        let n = level.len() as f64;
        let mean = level.iter().sum::<f64>() / n;
        let square: f64 = level.iter().map(|value| (value - mean).powi(2)).sum();
        -0.5 * (n - 1.0) * ((square / (n - 1.0)).ln() + 1.0)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn two_levels_are_likelier_than_noise_in_any_unit(
            seed: u64,
            blocks in 40..128_usize,
            dwell in 5..12_usize,
            scale in -9.0..9.0,
        ) {
            let white = noise(seed, blocks);
            let switching: Vec<f64> =
                white.iter().enumerate().map(|(i, noise)| noise + (i / dwell % 2) as f64 * 6.0).collect();
            let found = log_likelihood(&switching, false);
            prop_assert!(found > of_white(&switching) + 15.0);
            // densities are those of another unit
            let scale = f64::exp(scale);
            let other: Vec<f64> = switching.iter().map(|value| 7.0 - scale * value).collect();
            prop_assert!((log_likelihood(&other, false) - (found - (blocks - 1) as f64 * scale.ln())).abs() < 1e-3);
        }
    }

    /// White noise is taken for two levels, at half the logarithm of the blocks for each of their four
    /// parameters, in few records: outliers may be a level of their own.
    #[test]
    fn noise_is_rarely_two_levels() {
        let rises = |seed: u64, blocks: usize| {
            let white = noise(seed, blocks);
            log_likelihood(&white, false) - of_white(&white) > 2.0 * (blocks as f64).ln()
        };
        let taken = [40, 64, 127].map(|blocks| (0..400).filter(|seed| rises(*seed * 7919, blocks)).count());
        assert!(taken.iter().all(|taken| *taken <= 10), "{taken:?} of 400");
    }

    #[test]
    fn blocks_that_are_alike_have_no_likelihood() {
        assert!(log_likelihood(&[3.0; 40], false).is_nan() && log_likelihood(&[], false).is_nan());
    }
}

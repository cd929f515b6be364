//! Whether the level of a record walks, by likelihood.
//!
//! Octaves of a third of the record and more have no part in the fit, and beside strong flicker
//! noise what the others show of a walk exceeds its probability. The cosine coefficients of the
//! means of blocks (DCT-II) hold all of it: of white noise and of a random walk they are
//! independent, of flicker noise nearly, but that the slowest are up to a quarter smaller than
//! here. So Whittle's likelihood (1953) is exact for white noise and a walk, and errs against walks
//! beside flicker noise.

use core::f64::consts::FRAC_1_SQRT_2;

use crate::infer::chi_squared;
use crate::infer::least_squares::{NonNegative, dot};
use crate::infer::level_noise::{flicker_variance, walk_variance};
use crate::infer::level_series::LevelSeries;

/// White noise, flicker noise, random walk.
const TERMS: usize = 3;

/// Places among them.
const FLICKER: usize = 1;
const WALK: usize = 2;

/// Most steps of the scoring, and most halvings of each.
const ROUNDS: usize = 60;
const HALVINGS: usize = 12;

/// Of twice the log-likelihood, which rises by less in the last step.
const TOLERANCE: f64 = 1e-4;

/// Places of coefficients from which other starts of the scoring come.
const STARTS: [usize; 3] = [0, 3, 15];

/// Most halvings or doublings until an end of an interval is bracketed, then bisections, to 0.14 %
/// of K².
const MOST_FACTORS: usize = 40;
const BISECTIONS: usize = 9;

/// Without a walk, the evidence exceeds z 0.2 to 0.43 times as often as a standard normal variable
/// does, as free flicker noise takes the place of a walk: simulated, 20 000 series of 48 to 93
/// blocks each, probabilities of 0.1 to 2.5 %.
const PART_OF_NORMAL: f64 = 0.5;

/// Squared amplitudes by term, in the unit of the channel and of one sample interval.
type Squares = [f64; TERMS];

/// Octaves shorter than a block in a fit: independent, with variance 1.
pub(super) struct ShortOctaves<'a> {
    pub(super) residuals: &'a [f64],
    /// By term: minus the derivative of each by its squared amplitude.
    pub(super) by_term: [&'a [f64]; TERMS],
    /// The squares of that fit.
    pub(super) at: Squares,
}

/// The likelihood of white noise, flicker noise and a random walk in one channel, beside a ramp.
pub(super) struct LevelLikelihood<'a> {
    coefficients: &'a [f64],
    octaves: ShortOctaves<'a>,
    ramp: Vec<f64>,
    /// By coefficient: what each term with parameter 1 adds to the variance.
    by_term: Vec<Squares>,
}

/// A random walk as the likelihood finds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    /// Standard deviations by which zero is excluded: the root of twice the log-likelihood ratio.
    pub(super) evidence: f64,
    pub(super) squares: Squares,
    /// Minus twice the log-likelihood.
    deviance: f64,
}

impl Walk {
    /// Probability that noise without a walk shows as much of one.
    pub(super) fn p(&self) -> f64 {
        PART_OF_NORMAL * chi_squared::normal_above(self.evidence)
    }
}

/// Memory to work in.
#[derive(Default)]
struct Space {
    columns: Vec<f64>,
    target: Vec<f64>,
    least_squares: NonNegative,
    /// Coefficients over their standard deviations, less the ramp, and the ramp.
    residuals: Vec<f64>,
    ramp: Vec<f64>,
}

impl<'a> LevelLikelihood<'a> {
    pub(super) fn new(level: &'a LevelSeries, octaves: ShortOctaves<'a>) -> Self {
        let blocks = level.coefficients.len() + 1;
        let length = level.block_samples as f64;
        let by_term = |k: usize| [1.0 / length, flicker_variance(k, blocks), length * walk_variance(k, blocks)];
        Self {
            coefficients: &level.coefficients,
            octaves,
            ramp: level.ramp(),
            by_term: (1..blocks).map(by_term).collect(),
        }
    }

    /// The likeliest walk; `None` if the octaves cannot be explained.
    pub(super) fn walk(&self) -> Option<Walk> {
        let space = &mut Space::default();
        let [white, flicker, _] = self.octaves.at;
        // a likelihood may have several maxima: a term as strong as the white noise at each of these
        let crossing = |place: &usize, term: usize| white * self.by_term[*place][0] / self.by_term[*place][term];
        let free = STARTS.iter().map(|place| [white, 0.0, crossing(place, WALK)]).chain([self.octaves.at]);
        let (squares, deviance) = self.likeliest_from(space, free, None)?;
        let held = STARTS.iter().map(|place| [white, crossing(place, FLICKER), 0.0]);
        let held = held.chain([[white, flicker, 0.0], [squares[0], squares[1], 0.0]]);
        let (_, without) = self.likeliest_from(space, held, Some(WALK))?;
        Some(Walk { evidence: (without - deviance).max(0.0).sqrt(), squares, deviance })
    }

    /// The best of what `likeliest` finds from each of these on.
    fn likeliest_from(
        &self,
        space: &mut Space,
        starts: impl Iterator<Item = Squares>,
        held: Option<usize>,
    ) -> Option<(Squares, f64)> {
        let found = starts.filter_map(|start| self.likeliest(space, start, held));
        found.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// The squared amplitude of `walk`, and the ends of those that the data do not exclude by more
    /// than `z` standard deviations.
    pub(super) fn interval(&self, walk: &Walk, z: f64) -> Option<(f64, f64, f64)> {
        let space = &mut Space::default();
        let [white, flicker, best] = walk.squares;
        let mut is_excluded = |square: f64| {
            let (_, deviance) = self.likeliest(space, [white, flicker, square], Some(WALK))?;
            Some(deviance - walk.deviance > z * z)
        };
        let mut end = |factor: f64| {
            let mut inside = best;
            for _ in 0..MOST_FACTORS {
                if is_excluded(inside * factor)? {
                    break;
                }
                inside *= factor;
            }
            let mut outside = inside * factor;
            for _ in 0..BISECTIONS {
                let middle = (inside * outside).sqrt();
                if is_excluded(middle)? { outside = middle } else { inside = middle }
            }
            Some(outside)
        };
        let lower = if walk.evidence > z { end(0.5)? } else { 0.0 };
        Some((lower, best, end(2.0)?))
    }

    /// The likeliest squares, the `held` one as it is in `near`, and minus twice their
    /// log-likelihood: Fisher's scoring, each step shortened until the likelihood rises.
    fn likeliest(&self, space: &mut Space, near: Squares, held: Option<usize>) -> Option<(Squares, f64)> {
        let mut squares = near;
        let mut deviance = Some(self.deviance(space, &squares)).filter(|deviance| deviance.is_finite())?;
        for _ in 0..ROUNDS {
            let aim = self.aim(space, &squares, held);
            let towards = |part: f64| -> Squares {
                core::array::from_fn(|term| squares[term] + part * (aim[term] - squares[term]))
            };
            let steps = (0..HALVINGS).map(|halvings| towards(0.5_f64.powi(halvings as i32)));
            let mut better = steps.map(|squares| (squares, self.deviance(space, &squares)));
            let Some((next, at_next)) = better.find(|(_, at_next)| *at_next < deviance) else { break };
            let fall = deviance - at_next;
            (squares, deviance) = (next, at_next);
            if fall < TOLERANCE {
                break;
            }
        }
        Some((squares, deviance))
    }

    /// The squares that explain powers and variances best, with the weights that `squares` give.
    fn aim(&self, space: &mut Space, squares: &Squares, held: Option<usize>) -> Squares {
        self.residuals(space, squares);
        let Space { columns, target, least_squares, residuals, .. } = space;
        let rows = self.coefficients.len() + self.octaves.residuals.len();
        columns.clear();
        columns.resize(TERMS * rows, 0.0);
        target.clear();
        for (row, (residual, by_term)) in residuals.iter().zip(&self.by_term).enumerate() {
            // the square of a normal variable has twice its squared variance
            target.push(residual * residual * FRAC_1_SQRT_2);
            let weight = FRAC_1_SQRT_2 / expected(by_term, squares);
            (0..TERMS).for_each(|term| columns[term * rows + row] = by_term[term] * weight);
        }
        target.extend_from_slice(self.octaves.residuals);
        for (term, by_term) in self.octaves.by_term.iter().enumerate() {
            let (_, column) = columns[term * rows..][..rows].split_at_mut(self.coefficients.len());
            column.copy_from_slice(by_term);
            let target = &mut target[self.coefficients.len()..];
            target.iter_mut().zip(*by_term).for_each(|(target, d)| *target += d * self.octaves.at[term]);
        }
        if let Some(held) = held {
            let column = &mut columns[held * rows..][..rows];
            target.iter_mut().zip(&*column).for_each(|(target, value)| *target -= value * squares[held]);
            column.fill(0.0);
        }
        let found = least_squares.solve(columns, target, squares);
        core::array::from_fn(|term| if Some(term) == held { squares[term] } else { found[term] })
    }

    /// Into `space`, the coefficients over their standard deviations, less the likeliest ramp.
    fn residuals(&self, space: &mut Space, squares: &Squares) {
        let Space { residuals, ramp, .. } = space;
        let inverse = || self.by_term.iter().map(|by_term| 1.0 / expected(by_term, squares).sqrt());
        let weighted = |values: &[f64], into: &mut Vec<f64>| {
            into.clear();
            into.extend(values.iter().zip(inverse()).map(|(value, inverse)| value * inverse));
        };
        weighted(self.coefficients, residuals);
        weighted(&self.ramp, ramp);
        let multiple = dot(residuals, ramp) / dot(ramp, ramp);
        residuals.iter_mut().zip(&*ramp).for_each(|(residual, ramp)| *residual -= multiple * ramp);
    }

    /// Minus twice the log-likelihood, the ramp at its likeliest; not finite where it cannot be.
    fn deviance(&self, space: &mut Space, squares: &Squares) -> f64 {
        self.residuals(space, squares);
        let variances = self.by_term.iter().map(|by_term| expected(by_term, squares).ln());
        let of_coefficients = space.residuals.iter().zip(variances).map(|(residual, ln)| residual * residual + ln);
        let of_octaves = self.octaves.residuals.iter().enumerate().map(|(i, residual)| {
            let by_term = self.octaves.by_term.iter().zip(squares).zip(&self.octaves.at);
            (residual - by_term.map(|((column, square), at)| column[i] * (square - at)).sum::<f64>()).powi(2)
        });
        of_coefficients.chain(of_octaves).sum()
    }
}

fn expected(by_term: &Squares, squares: &Squares) -> f64 {
    by_term.iter().zip(squares).map(|(value, square)| value * square).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::Deviation;
    use crate::infer::power_law::PowerLaw;

    const LENGTH: u64 = 256;
    const BLOCKS: usize = 90;

    /// N² known to a hundredth of this, and nothing of the others.
    const NEAR_WHITE: Squares = [1.0, 0.0, 0.0];
    const OF_WHITE: [f64; 1] = [100.0];
    const OF_NOTHING: [f64; 1] = [0.0];

    fn octaves(residuals: &[f64; 1]) -> ShortOctaves<'_> {
        ShortOctaves { residuals, by_term: [&OF_WHITE, &OF_NOTHING, &OF_NOTHING], at: NEAR_WHITE }
    }

    /// Every coefficient as large as `squares` make it on average, with alternating signs, times
    /// `factor(k)`.
    fn series(squares: Squares, factor: impl Fn(usize) -> f64) -> LevelSeries {
        let flat = LevelSeries { block_samples: LENGTH, coefficients: vec![0.0; BLOCKS - 1] };
        let by_term = LevelLikelihood::new(&flat, octaves(&[0.0])).by_term;
        let coefficient = |(k, by_term): (usize, &Squares)| {
            let sign = if k % 4 < 2 { 1.0 } else { -1.0 };
            sign * factor(k) * expected(by_term, &squares).sqrt()
        };
        LevelSeries { coefficients: by_term.iter().enumerate().map(coefficient).collect(), ..flat }
    }

    /// Of a walk that crosses the white noise at a third of the record.
    const WALK_SQUARE: f64 = 3.0 / (7_680.0 * 7_680.0);

    #[test]
    fn the_coefficients_have_the_variance_of_an_octave_of_one_block() {
        // differences of neighbours are the coefficients times 2 sin(πk/2n)
        let series = series([1.0, 0.0, 0.0], |_| 1.0);
        let by_term = LevelLikelihood::new(&series, octaves(&[0.0])).by_term;
        let laws = [PowerLaw::White, PowerLaw::Flicker, PowerLaw::RandomWalk];
        for (term, (law, tolerance)) in laws.into_iter().zip([1e-9, 0.01, 1e-4]).enumerate() {
            let sine = |k: usize| (core::f64::consts::PI * k as f64 / (2 * BLOCKS) as f64).sin();
            let of = |(i, by_term): (usize, &Squares)| 2.0 * sine(i + 1).powi(2) * by_term[term];
            let found = by_term.iter().enumerate().map(of).sum::<f64>() / (BLOCKS - 1) as f64;
            let expected = law.variance(Deviation::Allan, LENGTH);
            assert!((found / expected - 1.0).abs() < tolerance, "{law:?} {found} {expected}");
        }
    }

    #[test]
    fn a_level_as_expected_of_a_walk_gives_its_square_back() {
        let squares = [1.0, 0.0, 1000.0 * WALK_SQUARE];
        let series = series(squares, |_| 1.0);
        let likelihood = LevelLikelihood::new(&series, octaves(&[0.0]));
        let walk = likelihood.walk().unwrap();
        assert!(walk.evidence > 3.0 && walk.p() < 0.0007, "{walk:?}");
        let (lower, best, upper) = likelihood.interval(&walk, 1.96).unwrap();
        assert!((best / squares[WALK] - 1.0).abs() < 0.2, "{best}");
        // where the likelihood has fallen as far as it may
        for end in [lower, upper] {
            let (_, deviance) = likelihood.likeliest(&mut Space::default(), [1.0, 0.0, end], Some(WALK)).unwrap();
            assert!(((deviance - walk.deviance).sqrt() - 1.96).abs() < 0.02, "{end} {deviance} {walk:?}");
        }
        assert!(0.0 < lower && lower < best && best < upper, "{lower} {best} {upper}");
        // further out than zero is
        let (lower, ..) = likelihood.interval(&walk, walk.evidence + 0.1).unwrap();
        assert_eq!(lower, 0.0);
    }

    #[test]
    fn white_noise_flicker_noise_and_ramps_are_no_walk() {
        let flicker = 30.0 * WALK_SQUARE * 7_680.0;
        for squares in [[1.0, 0.0, 0.0], [1.0, flicker, 0.0]] {
            let mut series = series(squares, |_| 1.0);
            let walk = |series: &LevelSeries| LevelLikelihood::new(series, octaves(&[0.0])).walk().unwrap();
            let without = walk(&series);
            assert!(without.evidence < 0.5, "{squares:?} {without:?}");
            let ramp = series.ramp();
            series.coefficients.iter_mut().zip(ramp).for_each(|(value, ramp)| *value += 3.0 * ramp);
            let with_ramp = walk(&series);
            assert!((with_ramp.evidence - without.evidence).abs() < 0.05, "{squares:?} {with_ramp:?}");
        }
    }

    #[test]
    fn nothing_on_a_grid_is_likelier_than_the_likeliest() {
        for seed in 0..20_usize {
            // between a tenth and twice of what is expected
            let factor = |k: usize| 0.1 + 1.9 * ((k * 7919 + seed * 104_729) % 1000) as f64 / 1000.0;
            let series = series([1.0, 20.0 * WALK_SQUARE * 7_680.0, 10.0 * WALK_SQUARE], factor);
            let residuals = [0.3 * (seed as f64 - 10.0)];
            let likelihood = LevelLikelihood::new(&series, octaves(&residuals));
            let space = &mut Space::default();
            let (_, best) = likelihood.likeliest(space, NEAR_WHITE, None).unwrap();
            let held = |walk| likelihood.likeliest(&mut Space::default(), [1.0, 0.0, walk], Some(WALK)).unwrap();
            let grid = |i: usize| if i == 0 { 0.0 } else { 0.1 * 2_f64.powi(i as i32) };
            for (white, flicker, walk) in
                (0..9).flat_map(|w| (0..13).flat_map(move |f| (0..13).map(move |k| (w, f, k))))
            {
                let squares =
                    [0.96 + 0.01 * white as f64, grid(flicker) * WALK_SQUARE * 7_680.0, grid(walk) * WALK_SQUARE];
                let deviance = likelihood.deviance(space, &squares);
                assert!(deviance > best - 0.01, "{seed} {squares:?} {deviance} {best}");
                let (kept, best) = held(squares[WALK]);
                assert_eq!(kept[WALK], squares[WALK]);
                assert!(deviance > best - 0.01, "{seed} {squares:?} {deviance} {best}");
            }
        }
    }

    #[test]
    fn flicker_noise_explains_what_it_can_of_a_walk_held_at_zero() {
        let series = series([1.0, 0.0, 1000.0 * WALK_SQUARE], |_| 1.0);
        let likelihood = LevelLikelihood::new(&series, octaves(&[0.0]));
        let space = &mut Space::default();
        let (squares, best) = likelihood.likeliest(space, NEAR_WHITE, Some(WALK)).unwrap();
        assert!(squares[FLICKER] > 0.0 && squares[WALK] == 0.0, "{squares:?}");
        for power in -20..20 {
            let deviance = likelihood.deviance(space, &[1.0, WALK_SQUARE * 7_680.0 * 1.5_f64.powi(power), 0.0]);
            assert!(deviance > best - 0.01, "{power} {deviance} {best}");
        }
    }

    #[test]
    fn of_several_maxima_the_highest_counts() {
        let mut several = 0;
        for seed in 0..400_usize {
            // coefficients that no noise makes: a part of one of the deviance may be missed
            let uniform = |k: usize| ((k * k * 7919 + (k + 3) * seed * 104_729) % 1009) as f64 / 1009.0;
            let series = series([1.0, 0.0, 30.0 * WALK_SQUARE], |k| 4.0 * uniform(k).powi(4));
            let likelihood = LevelLikelihood::new(&series, octaves(&[0.0]));
            let space = &mut Space::default();
            let walk = likelihood.walk().unwrap();
            let starts = (-3..4).map(|power| [1.0, 0.0, WALK_SQUARE * 20_f64.powi(power)]);
            for start in starts.chain([[1.0, WALK_SQUARE * 7_680.0 * 100.0, 0.0], NEAR_WHITE]) {
                let (_, deviance) = likelihood.likeliest(space, start, None).unwrap();
                several += usize::from(deviance > walk.deviance + 1.0);
                assert!(deviance > walk.deviance - 1.0, "{seed} {start:?} {deviance} {walk:?}");
            }
        }
        assert!(several > 0);
    }

    #[test]
    fn what_cannot_be_explained_has_no_walk() {
        let series = series([0.0; TERMS], |_| 1.0);
        let silent = ShortOctaves { at: [0.0; TERMS], ..octaves(&[0.0]) };
        assert!(LevelLikelihood::new(&series, silent).walk().is_none());
    }
}

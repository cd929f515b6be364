//! One amplitude from several records of it, which differ by more than their own uncertainty.
//!
//! On the logarithmic scale record i reads y_i = μ + t_i + e_i, with t_i normal of variance τ²
//! between records and e_i normal of known variance v_i within. τ² is the restricted maximum
//! likelihood estimate (Harville, 1977); the interval of μ is that of Hartung and Knapp (2001, eq.
//! 4): Student's t with k - 1 degrees of freedom on q/Σw, with w_i = 1/(v_i + τ²) and
//! q = Σ w_i (y_i - μ)²/(k - 1). A record that only bounds the amplitude enters by its likelihood.

use imu_noise::chi_squared::{normal_quantile, normal_two_sided, student_two_sided, student_two_sided_above};
use imu_noise::{Parameter, Status};

/// Fewer estimates show no spread between records worth a number.
const LEAST_ESTIMATES: usize = 3;

/// An amplitude from several records of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomEffects {
    /// The median amplitude over all records that might be made.
    pub value: f64,
    /// Its interval.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Standard deviation of the logarithm between records, 0 where none shows: 0.05 is 5 %.
    pub spread: f64,
    /// Between these the value of one more record will lie, estimated as well as these.
    pub next_lower: f64,
    /// Upper end.
    pub next_upper: f64,
    /// Records with a value, at least three; the others gave a bound.
    pub estimates: usize,
    /// The record that differs most from the estimate of the others; `None` where they all agree to
    /// the last digit.
    pub farthest: Option<FarthestRecord>,
}

/// The record that differs most from the estimate of the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarthestRecord {
    /// Its number, from 0 in the order given.
    pub record: usize,
    /// Its value over what the others foretell.
    pub ratio: f64,
    /// Probability that the farthest of as many alike records lies as far: Bonferroni's, of
    /// Student's t with k - 2 degrees of freedom for each without itself.
    pub p: f64,
}

impl RandomEffects {
    /// Of one parameter in several records, each with its interval or bound at the level
    /// `confidence`, which is that of the result too. `None` below three estimates, outside 0 <
    /// `confidence` < 1, and for what is no positive amplitude.
    #[must_use]
    pub fn of(parameters: &[Parameter], confidence: f64) -> Option<Self> {
        let z = normal_two_sided(confidence)?;
        let records: Vec<(usize, RecordEvidence)> = (parameters.iter().enumerate())
            .filter_map(|(number, parameter)| Some((number, RecordEvidence::new(parameter, z)?)))
            .collect();
        let all: Vec<RecordEvidence> = records.iter().map(|(_, record)| *record).collect();
        if estimates(&all).count() < LEAST_ESTIMATES {
            return None;
        }
        let fit = MeanFit::of(&all)?;
        let t = student_two_sided(confidence, fit.dof)?;
        let (reach, next) = (t * fit.error2.sqrt(), t * fit.next2(typical(&all)).sqrt());
        Some(Self {
            value: fit.mean.exp(),
            lower: (fit.mean - reach).exp(),
            upper: (fit.mean + reach).exp(),
            spread: fit.between.sqrt(),
            next_lower: (fit.mean - next).exp(),
            next_upper: (fit.mean + next).exp(),
            estimates: estimates(&all).count(),
            farthest: farthest(&records),
        })
    }
}

/// The bound on an amplitude that three records or more bound and none estimates, if it is the same
/// in all of them: from the product of their likelihoods, in which the square of the amplitude is
/// normal. `None` otherwise.
#[must_use]
pub fn common_bound(parameters: &[Parameter], confidence: f64) -> Option<f64> {
    let z = normal_two_sided(confidence)?;
    let records: Vec<RecordEvidence> =
        parameters.iter().filter_map(|parameter| RecordEvidence::new(parameter, z)).collect();
    let (mut weights, mut weighted) = (0.0, 0.0);
    for record in &records {
        let RecordEvidence::Bound { log_upper, found, reach } = *record else { return None };
        let deviation = (2.0 * log_upper).exp() / reach;
        weights += deviation.powi(-2);
        weighted += found / deviation;
    }
    (records.len() >= LEAST_ESTIMATES).then(|| (weighted / weights + z / weights.sqrt()).sqrt())
}

/// The information of one record on the logarithm η of the amplitude.
#[derive(Clone, Copy, Debug)]
enum RecordEvidence {
    /// Normal around `log`.
    Estimate { log: f64, variance: f64 },
    /// The square of the amplitude is normal: `found` is how many of its standard deviations it
    /// lies above zero, `reach` how many the upper bound exp(`log_upper`) does.
    Bound { log_upper: f64, found: f64, reach: f64 },
}

impl RecordEvidence {
    fn new(parameter: &Parameter, z: f64) -> Option<Self> {
        let log = |value: Option<f64>| value.filter(|value| *value > 0.0 && value.is_finite()).map(f64::ln);
        match parameter.status {
            Status::Estimated => {
                let (value, upper) = (log(parameter.value)?, log(parameter.upper)?);
                let half_width = log(parameter.lower).map_or(upper - value, |lower| (upper - lower) / 2.0);
                let variance = (half_width / z).powi(2);
                (variance > 0.0).then_some(Self::Estimate { log: value, variance })
            }
            Status::Bounded => {
                let found = parameter.p.map_or(0.0, |p| -normal_quantile(p.clamp(1e-9, 0.5)));
                Some(Self::Bound { log_upper: log(parameter.upper)?, found, reach: found + z })
            }
            Status::NotObservable | Status::NotMeasurable | Status::Moved | Status::ModelRejected => None,
        }
    }

    /// The logarithm of the likelihood of the mean μ, with its first and second derivative, where
    /// records vary with the variance `between` around it.
    fn likelihood(&self, mean: f64, between: f64) -> [f64; 3] {
        /// Standard deviations, and steps to each, of the mean over the records that might be.
        const REACH: i32 = 6;
        const STEPS: i32 = 8;
        match *self {
            Self::Estimate { log, variance } => {
                let weight = 1.0 / (variance + between);
                let apart = log - mean;
                [(weight.ln() - weight * apart * apart) / 2.0, weight * apart, -weight]
            }
            Self::Bound { .. } => {
                let deviation = between.sqrt();
                let nodes: Vec<[f64; 3]> = (-REACH * STEPS..=REACH * STEPS)
                    .map(|step| {
                        let u = f64::from(step) / f64::from(STEPS);
                        let [log, first, second] = self.bound_at(mean + deviation * u);
                        [log - u * u / 2.0, first, second]
                    })
                    .collect();
                let most = nodes.iter().map(|node| node[0]).fold(f64::NEG_INFINITY, f64::max);
                let mut sums = [0.0; 3];
                for [log, first, second] in nodes {
                    let weight = (log - most).exp();
                    sums[0] += weight;
                    sums[1] += weight * first;
                    sums[2] += weight * (second + first * first);
                }
                let first = sums[1] / sums[0];
                [most + sums[0].ln(), first, sums[2] / sums[0] - first * first]
            }
        }
    }

    /// The same of a bound at one amplitude.
    fn bound_at(&self, log: f64) -> [f64; 3] {
        let Self::Bound { log_upper, found, reach } = *self else { return [0.0; 3] };
        // far beyond the bound the likelihood is zero, and its derivatives no numbers
        let square = (2.0 * (log - log_upper)).min(50.0).exp() * reach;
        let apart = square - found;
        [-apart * apart / 2.0, -2.0 * apart * square, -4.0 * square * (square + apart)]
    }
}

fn estimates(records: &[RecordEvidence]) -> impl Iterator<Item = (f64, f64)> {
    records.iter().filter_map(|record| match record {
        RecordEvidence::Estimate { log, variance } => Some((*log, *variance)),
        RecordEvidence::Bound { .. } => None,
    })
}

/// The variance within a record: the harmonic mean.
fn typical(records: &[RecordEvidence]) -> f64 {
    let (count, sum) = estimates(records).fold((0.0, 0.0), |(count, sum), (_, v)| (count + 1.0, sum + 1.0 / v));
    count / sum
}

/// The mean of all records and what is known of it.
#[derive(Clone, Copy, Debug)]
struct MeanFit {
    mean: f64,
    /// τ².
    between: f64,
    /// q.
    scale: f64,
    /// Squared standard error of the mean, scaled.
    error2: f64,
    dof: f64,
}

impl MeanFit {
    /// `None` below two estimates, and where bounds leave no maximum.
    fn of(records: &[RecordEvidence]) -> Option<Self> {
        let estimates: Vec<(f64, f64)> = estimates(records).collect();
        if estimates.len() < 2 {
            return None;
        }
        let restricted = |deviation: f64| {
            let (mean, information) = mode(records, &estimates, deviation * deviation)?;
            let log: f64 = records.iter().map(|record| record.likelihood(mean, deviation * deviation)[0]).sum();
            Some(log - information.ln() / 2.0)
        };
        let between = most_likely(&estimates, |deviation| restricted(deviation).unwrap_or(f64::NEG_INFINITY)).powi(2);
        let (mean, information) = mode(records, &estimates, between)?;
        let dof = estimates.len() as f64 - 1.0;
        // bounds carry no information on the spread: it is that of the estimates alone
        let scale = estimates.iter().map(|(log, v)| (log - mean).powi(2) / (v + between)).sum::<f64>() / dof;
        Some(Self { mean, between, scale, error2: scale / information, dof })
    }

    /// Squared standard error of the next record's value, whose own variance is `within`.
    fn next2(&self, within: f64) -> f64 {
        self.scale * (self.between + within) + self.error2
    }
}

/// The most likely mean, and minus the second derivative there.
fn mode(records: &[RecordEvidence], estimates: &[(f64, f64)], between: f64) -> Option<(f64, f64)> {
    let weights: f64 = estimates.iter().map(|(_, v)| 1.0 / (v + between)).sum();
    let mut mean = estimates.iter().map(|(log, v)| log / (v + between)).sum::<f64>() / weights;
    let derivatives = |mean: f64| {
        records.iter().fold([0.0; 2], |[first, second], record| {
            let [_, d1, d2] = record.likelihood(mean, between);
            [first + d1, second + d2]
        })
    };
    for _ in 0..100 {
        let [first, second] = derivatives(mean);
        let step = (first / (-second).max(weights)).clamp(-1.0, 1.0);
        mean += step;
        if step.abs() < 1e-13 {
            break;
        }
    }
    let information = -derivatives(mean)[1];
    (information > 0.0 && mean.is_finite()).then_some((mean, information))
}

/// The standard deviation between records with the largest restricted likelihood.
fn most_likely(estimates: &[(f64, f64)], restricted: impl Fn(f64) -> f64) -> f64 {
    const COARSE: usize = 64;
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let logs = || estimates.iter().map(|(log, _)| *log);
    let span = logs().fold(f64::NEG_INFINITY, f64::max) - logs().fold(f64::INFINITY, f64::min);
    let step = 2.0 * span / COARSE as f64;
    let place = (0..=COARSE).map(|i| (i, restricted(step * i as f64))).max_by(|a, b| a.1.total_cmp(&b.1));
    let place = place.map_or(0, |(i, _)| i) as f64;
    let (mut from, mut to) = (step * (place - 1.0).max(0.0), step * (place + 1.0));
    while to - from > 1e-9 * step {
        let (a, b) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
        if restricted(a) >= restricted(b) { to = b } else { from = a }
    }
    let inner = (from + to) / 2.0;
    if restricted(0.0) >= restricted(inner) { 0.0 } else { inner }
}

fn farthest(records: &[(usize, RecordEvidence)]) -> Option<FarthestRecord> {
    let count = records.iter().filter(|(_, record)| matches!(record, RecordEvidence::Estimate { .. })).count() as f64;
    let without = |place: usize| {
        let RecordEvidence::Estimate { log, variance } = records[place].1 else { return None };
        let others: Vec<RecordEvidence> =
            records.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, (_, record))| *record).collect();
        let fit = MeanFit::of(&others)?;
        let apart = log - fit.mean;
        let p = student_two_sided_above((apart / fit.next2(variance).sqrt()).abs(), fit.dof)?;
        Some(FarthestRecord { record: records[place].0, ratio: apart.exp(), p: (count * p).min(1.0) })
    };
    (0..records.len()).filter_map(without).min_by(|a, b| a.p.total_cmp(&b.p))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An estimate whose logarithm is normal with this variance.
    fn estimate(log: f64, variance: f64) -> Parameter {
        let reach = normal_two_sided(0.95).unwrap() * variance.sqrt();
        Parameter::estimated(log.exp(), (log - reach).exp(), (log + reach).exp())
    }

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() < tolerance, "{found}, not {expected}");
    }

    /// Thirteen trials of a vaccine (Colditz et al., 1994), log relative risks and their variances
    /// from the counts, which R's metafor has as `dat.bcg`.
    const TRIALS: [[f64; 4]; 13] = [
        [4.0, 119.0, 11.0, 128.0],
        [6.0, 300.0, 29.0, 274.0],
        [3.0, 228.0, 11.0, 209.0],
        [62.0, 13_536.0, 248.0, 12_619.0],
        [33.0, 5_036.0, 47.0, 5_761.0],
        [180.0, 1_361.0, 372.0, 1_079.0],
        [8.0, 2_537.0, 10.0, 619.0],
        [505.0, 87_886.0, 499.0, 87_892.0],
        [29.0, 7_470.0, 45.0, 7_232.0],
        [17.0, 1_699.0, 65.0, 1_600.0],
        [186.0, 50_448.0, 141.0, 27_197.0],
        [5.0, 2_493.0, 3.0, 2_338.0],
        [27.0, 16_886.0, 29.0, 17_825.0],
    ];

    #[test]
    fn hartung_and_knapp_are_those_of_metafor() {
        let trials = TRIALS.map(|[a, b, c, d]| {
            let log = (a / (a + b) / (c / (c + d))).ln();
            estimate(log, 1.0 / a - 1.0 / (a + b) + 1.0 / c - 1.0 / (c + d))
        });
        let found = RandomEffects::of(&trials, 0.95).unwrap();
        // Viechtbauer (2010): rma(yi, vi, test = "knha"), four decimals
        assert_near(found.value.ln(), -0.7145, 5e-5);
        assert_near(found.lower.ln(), -1.1084, 5e-5);
        assert_near(found.upper.ln(), -0.3206, 5e-5);
        assert_near(found.spread.powi(2), 0.3132, 5e-5);
        // and the farthest, by a script of the same formulas in NumPy and SciPy
        assert_near(found.next_lower.ln(), -2.041_680_470_2, 1e-6);
        assert_near(found.next_upper.ln(), 0.612_615_784_2, 1e-6);
        assert_eq!(found.farthest.map(|farthest| farthest.p), Some(1.0));
    }

    #[test]
    fn few_records_are_those_of_the_formulas_elsewhere() {
        // by the same script: logs, variances; mean, its ends, spread, ends of the next, farthest, p
        type Row = (&'static [f64], &'static [f64], [f64; 6], usize, f64);
        let rows: [Row; 3] = [
            (
                &[0.0, 0.12, -0.05],
                &[0.0004, 0.0009, 0.0004],
                [
                    0.021_190_405_67,
                    -0.193_726_100_5,
                    0.236_106_911_8,
                    0.082_370_733_68,
                    -0.407_139_465_9,
                    0.449_520_277_2,
                ],
                1,
                0.619_243_639_283,
            ),
            (
                &[-0.01, 0.004, 0.002, 0.006],
                &[0.0004, 0.0009, 0.0001, 0.0004],
                [0.000_896_551_724_1, -0.008_083_333_99, 0.009_876_437_438, 0.0, -0.019_183_083_16, 0.020_976_186_61],
                0,
                0.177_900_939_804,
            ),
            (
                &[0.3, 0.31, 0.29, 0.32, 1.1],
                &[0.0025, 0.0016, 0.0025, 0.0036, 0.0025],
                [0.464_027_571_2, 0.022_294_176_87, 0.905_760_965_5, 0.352_227_043_1, -0.617_427_411_5, 1.545_482_554],
                4,
                5.418_708_589e-5,
            ),
        ];
        for (logs, variances, expected, record, p) in rows {
            let records: Vec<Parameter> = logs.iter().zip(variances).map(|(log, v)| estimate(*log, *v)).collect();
            let found = RandomEffects::of(&records, 0.95).unwrap();
            let RandomEffects { value, lower, upper, spread, next_lower, next_upper, .. } = found;
            let found_logs = [value.ln(), lower.ln(), upper.ln(), spread, next_lower.ln(), next_upper.ln()];
            found_logs.into_iter().zip(expected).for_each(|(found, expected)| assert_near(found, expected, 1e-6));
            let farthest = found.farthest.unwrap();
            assert_eq!((farthest.record, found.estimates), (record, logs.len()));
            assert!((farthest.p / p - 1.0).abs() < 1e-4, "{farthest:?}, not {p}");
        }
    }

    #[test]
    fn a_bound_draws_the_mean_as_far_as_it_excludes_it() {
        let three = [estimate(0.0, 0.01), estimate(0.1, 0.01), estimate(-0.05, 0.01)];
        let with = |bound: f64| {
            let all: Vec<Parameter> = three.into_iter().chain([Parameter::bounded(bound)]).collect();
            RandomEffects::of(&all, 0.95).unwrap()
        };
        let without = RandomEffects::of(&three, 0.95).unwrap();
        assert_near(with(1e3).value, without.value, 1e-4);
        let (near, low) = (with(1.3), with(0.8));
        assert!(low.value < near.value && near.value < without.value, "{low:?} {near:?}");
        assert!(low.spread > without.spread, "{low:?}");
        assert!(low.lower < low.value && low.value < low.upper && low.next_lower < low.lower);
    }

    #[test]
    fn fewer_than_three_estimates_are_not_pooled() {
        let two = [estimate(0.0, 0.01), Parameter::bounded(2.0), estimate(0.1, 0.01)];
        assert_eq!(RandomEffects::of(&two, 0.95), None);
        assert_eq!(RandomEffects::of(&[], 0.95), None);
        let three = [estimate(0.0, 0.01), estimate(0.1, 0.01), estimate(0.2, 0.01)];
        for confidence in [0.0, 1.0, f64::NAN] {
            assert_eq!(RandomEffects::of(&three, confidence), None, "{confidence}");
        }
        let same = RandomEffects::of(&[estimate(0.5, 0.01); 4], 0.95).unwrap();
        assert_near(same.value.ln(), 0.5, 1e-12);
        assert_eq!((same.spread, same.farthest.map(|farthest| farthest.record)), (0.0, None));
    }

    /// A linear congruential generator (Knuth, The Art of Computer Programming 2, 3.3.4, table 1)
    /// and the polar method: no code of the emulated sensor.
    struct NormalNoise(u64);

    impl NormalNoise {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn normal(&mut self) -> f64 {
            loop {
                let (a, b) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
                let square: f64 = a * a + b * b;
                if square > 0.0 && square < 1.0 {
                    return a * (-2.0 * square.ln() / square).sqrt();
                }
            }
        }
    }

    #[test]
    fn a_common_bound_is_tighter_than_each_and_seldom_too_tight() {
        const TRIALS: usize = 4000;
        let z = normal_two_sided(0.95).unwrap();
        let bounded = |square: f64| {
            // as a fit with squares not below zero bounds it
            let upper = if square > 0.0 { square + z } else { square + (square * square + z * z).sqrt() };
            let p = imu_noise::chi_squared::normal_above(square.max(0.0));
            Parameter { p: Some(p), ..Parameter::bounded(upper.sqrt()) }
        };
        let equal = common_bound(&[bounded(0.0); 4], 0.95).unwrap();
        assert_near(equal / z.sqrt(), 0.5_f64.sqrt(), 1e-9);
        assert_eq!(common_bound(&[bounded(0.0); 2], 0.95), None);
        assert_eq!(common_bound(&[bounded(0.0), bounded(0.0), bounded(0.0), estimate(0.0, 0.01)], 0.95), None);
        let mut noise = NormalNoise(7);
        for truth in [0.0, 0.25, 0.5, 1.0, 2.0] {
            let mut too_tight = 0;
            for _ in 0..TRIALS {
                let squares: Vec<f64> = (0..4).map(|_| truth + noise.normal()).collect();
                // others are estimated, and pooled
                if squares.iter().all(|square| *square < 1.96) {
                    let records: Vec<Parameter> = squares.iter().map(|square| bounded(*square)).collect();
                    too_tight += usize::from(common_bound(&records, 0.95).unwrap().powi(2) < truth);
                }
            }
            let percent = 100.0 * too_tight as f64 / TRIALS as f64;
            println!("square of the truth {truth}: {percent} % too tight");
            assert!(percent < 5.0, "{truth}: {percent} %");
        }
    }

    /// White noise of as many degrees of freedom, as its record shows it.
    fn measured(truth: f64, dof: usize, noise: &mut NormalNoise) -> Parameter {
        let mean_square = (0..dof).map(|_| noise.normal().powi(2)).sum::<f64>() / dof as f64;
        let interval = imu_noise::Interval::new(mean_square, dof as f64, 0.95).unwrap();
        Parameter::estimated(truth * mean_square.sqrt(), truth * interval.lower, truth * interval.upper)
    }

    #[test]
    fn mean_and_next_record_hold_as_often_as_they_say() {
        const TRIALS: usize = 2000;
        for (k, spread) in [(3, 0.0), (3, 0.05), (5, 0.0), (5, 0.05)] {
            let mut noise = NormalNoise(20_261_122 + k as u64);
            let (mut mean_holds, mut next_holds, mut farthest) = (0, 0, 0);
            for _ in 0..TRIALS {
                let mut record = || {
                    let truth = 2e-4 * (spread * noise.normal()).exp();
                    measured(truth, 300, &mut noise)
                };
                let records: Vec<Parameter> = (0..k).map(|_| record()).collect();
                let next = record().value.unwrap();
                let found = RandomEffects::of(&records, 0.95).unwrap();
                mean_holds += usize::from((found.lower..found.upper).contains(&2e-4));
                next_holds += usize::from((found.next_lower..found.next_upper).contains(&next));
                farthest += usize::from(found.farthest.is_some_and(|farthest| farthest.p < 0.05));
            }
            let percent = |count: usize| 100.0 * count as f64 / TRIALS as f64;
            let (mean, next, farthest) = (percent(mean_holds), percent(next_holds), percent(farthest));
            println!("k = {k}, spread {spread}: mean {mean} %, next {next} %, farthest {farthest} %");
            // three standard errors of 2000 trials, and 1 % for what the logarithm leaves
            assert!((93.0..97.5).contains(&mean), "k = {k}, spread {spread}: mean {mean} %");
            assert!((93.0..97.5).contains(&next), "k = {k}, spread {spread}: next {next} %");
            assert!(farthest < 6.5, "k = {k}, spread {spread}: farthest {farthest} %");
        }
    }
}

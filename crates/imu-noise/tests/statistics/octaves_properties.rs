//! Octave sums against their definition, with any division, any gaps and any counts.

use imu_noise::{Deviation, Estimator, Octaves};
use proptest::{collection::vec, prelude::*};

#[derive(Clone, Debug)]
enum Step {
    Push(Vec<i32>),
    Gap(Option<u64>),
}

/// Windows of the definition, over the places of each run, present or not.
struct Definition {
    /// Index of the first place of each run, and its places.
    runs: Vec<(usize, Vec<Option<i32>>)>,
}

/// An octave: whole windows and their squares, all windows, their present share and variance.
#[derive(Debug)]
struct Row {
    m: u64,
    whole: (u64, u128),
    terms: u64,
    share_present: f64,
    variance: f64,
}

impl Definition {
    fn of(steps: &[Step], gaps_part: bool) -> Self {
        let mut runs = vec![(0, Vec::new())];
        for step in steps {
            let (start, run) = runs.last_mut().unwrap();
            let end = *start + run.len();
            match step {
                Step::Push(counts) => run.extend(counts.iter().copied().map(Some)),
                Step::Gap(Some(missing)) if *missing == 0 || gaps_part => runs.push((end + *missing as usize, vec![])),
                Step::Gap(Some(missing)) => run.resize(run.len() + *missing as usize, None),
                Step::Gap(None) => runs.push((end, Vec::new())),
            }
        }
        Self { runs }
    }

    fn rows(&self, estimator: Estimator, deviation: Deviation) -> Vec<Row> {
        let stride = |m: usize| match estimator {
            Estimator::Strided => (m / 16).max(1),
            Estimator::Plain => m,
            Estimator::Full => 1,
        };
        (0..12).filter_map(|k| self.row(1 << k, stride(1 << k), deviation)).collect()
    }

    /// The row at any averaging factor.
    fn row(&self, m: usize, stride: usize, deviation: Deviation) -> Option<Row> {
        let weights: &[f64] = match deviation {
            Deviation::Allan => &[-1.0, 1.0],
            Deviation::Hadamard => &[1.0, -2.0, 1.0],
        };
        let all: f64 = weights.iter().map(|weight| weight * weight).sum();
        let (mut whole, mut terms, mut shares, mut squares) = ((0, 0_u128), 0, 0.0, 0.0);
        for (start, run) in &self.runs {
            let first = start.next_multiple_of(stride) - start;
            for place in (first..run.len()).step_by(stride) {
                let Some(window) = run.get(place..place + weights.len() * m) else { break };
                let present = |cluster: &[Option<i32>]| cluster.iter().flatten().map(|c| i64::from(*c)).collect();
                let clusters: Vec<Vec<i64>> = window.chunks(m).map(present).collect();
                if clusters.iter().any(|cluster| 2 * cluster.len() < m) {
                    continue;
                }
                let sum = |cluster: &Vec<i64>| cluster.iter().map(|c| i128::from(*c)).sum::<i128>();
                terms += 1;
                if clusters.iter().all(|cluster| cluster.len() == m) {
                    let z: i128 = clusters.iter().zip(weights).map(|(c, w)| *w as i128 * sum(c)).sum();
                    whole = (whole.0 + 1, whole.1 + (z * z) as u128);
                    shares += 1.0;
                    squares += (z as f64).powi(2);
                    continue;
                }
                // about the first sample, because means of large counts cancel
                let origin = clusters[0][0];
                let mean = |cluster: &Vec<i64>| {
                    cluster.iter().map(|c| (c - origin) as f64).sum::<f64>() / cluster.len() as f64
                };
                let d: f64 = clusters.iter().zip(weights).map(|(c, w)| w * mean(c)).sum();
                let noise: f64 = clusters.iter().zip(weights).map(|(c, w)| w * w / c.len() as f64).sum();
                let share = all / m as f64 / noise;
                shares += share;
                squares += share * (m as f64 * d).powi(2);
            }
        }
        let n = terms as f64;
        let variance = squares / (all * (m * m) as f64 * n);
        (terms > 0).then_some(Row { m: m as u64, whole, terms, share_present: shares / n, variance })
    }
}

fn run(mut octaves: Octaves, steps: &[Step]) -> Octaves {
    for step in steps {
        match step {
            Step::Push(counts) => octaves.push(counts),
            Step::Gap(missing) => octaves.gap(*missing),
        }
    }
    octaves
}

fn octaves(estimator: Estimator, deviation: Deviation, steps: &[Step]) -> Octaves {
    run(Octaves::new(estimator, deviation), steps)
}

/// Counts of one record: quiet, lively, or up to the limits of `i32`.
fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        6 => vec(any::<i32>(), 0..400).prop_map(Step::Push),
        1 => any::<i32>().prop_map(|count| Step::Push(vec![count])),
        2 => (0_u64..40).prop_map(|missing| Step::Gap(Some(missing))),
        1 => Just(Step::Gap(Some(0))),
        1 => Just(Step::Gap(None)),
    ];
    (prop_oneof![Just(24_u32), Just(8), Just(0)], vec(step, 0..10)).prop_map(|(shift, mut steps)| {
        for step in &mut steps {
            if let Step::Push(counts) = step {
                counts.iter_mut().for_each(|count| *count >>= shift);
            }
        }
        steps
    })
}

fn estimators() -> impl Strategy<Value = (Estimator, Deviation)> {
    let estimators = prop_oneof![Just(Estimator::Strided), Just(Estimator::Plain), Just(Estimator::Full)];
    (estimators, prop_oneof![Just(Deviation::Allan), Just(Deviation::Hadamard)])
}

proptest! {
    #[test]
    fn sums_follow_the_definition((estimator, deviation) in estimators(), steps in steps()) {
        let expected = Definition::of(&steps, estimator == Estimator::Full).rows(estimator, deviation);
        let found: Vec<_> = octaves(estimator, deviation, &steps).sums().collect();
        let windows: Vec<_> = found.iter().map(|sum| (sum.m, sum.terms)).collect();
        prop_assert_eq!(windows, expected.iter().map(|row| (row.m, row.terms)).collect::<Vec<_>>());
        for (found, expected) in found.iter().zip(&expected) {
            prop_assert_eq!(found.sum_squares, Some(expected.whole.1));
            prop_assert!((found.octave().share_present - expected.share_present).abs() < 1e-9, "{:?}", expected);
            // each window is rounded to 2^-16 counts²
            let rounding = 1e-5 / (found.m * found.m) as f64;
            let error = (found.variance_counts2().unwrap() - expected.variance).abs();
            prop_assert!(error <= 1e-9 * expected.variance + rounding, "{:?}: {:?}", expected, found);
        }
    }

    #[test]
    fn a_long_gap_equals_as_many_single_ones(
        (estimator, deviation) in estimators(),
        parts in vec((vec(-4000..4000, 0..200), 1_u64..3000), 1..5),
    ) {
        prop_assume!(estimator != Estimator::Full);
        let (mut at_once, mut one_by_one) = (vec![], vec![]);
        for (counts, missing) in parts {
            at_once.extend([Step::Push(counts.clone()), Step::Gap(Some(missing))]);
            one_by_one.push(Step::Push(counts));
            one_by_one.extend((0..missing).map(|_| Step::Gap(Some(1))));
        }
        let [at_once, one_by_one] = [at_once, one_by_one].map(|steps| octaves(estimator, deviation, &steps));
        prop_assert_eq!(at_once.sums().collect::<Vec<_>>(), one_by_one.sums().collect::<Vec<_>>());
    }

    #[test]
    fn any_factor_follows_the_definition((_, deviation) in estimators(), steps in steps(), m in 1_usize..400) {
        let mut kept = Octaves::new(Estimator::Full, deviation);
        for step in &steps {
            match step {
                Step::Push(counts) => kept.push(counts),
                Step::Gap(missing) => kept.gap(*missing),
            }
        }
        let found = kept.sum_at(m as u64).map(|sum| (sum.m, sum.terms, sum.sum_squares.unwrap()));
        let expected = Definition::of(&steps, true).row(m, 1, deviation);
        prop_assert_eq!(found, expected.map(|row| (row.m, row.terms, row.whole.1)));
        prop_assert_eq!(kept.sums().map(|sum| Some(sum) == kept.sum_at(sum.m)).min(), kept.sums().next().map(|_| true));
        prop_assert!(kept.sum_at(0).is_none() && kept.sum_at(u64::MAX).is_none());
    }
}

//! Octave sums against their definition, for any division, any gaps and any counts.

use imu_noise::{Deviation, Estimator, Octaves};
use proptest::{collection::vec, prelude::*};

#[derive(Clone, Debug)]
enum Step {
    Push(Vec<i32>),
    Gap(Option<u64>),
}

/// Windows of the definition, over samples at their absolute indices. An unknown gap begins another
/// record.
#[derive(Default)]
struct Definition {
    records: Vec<Vec<Option<i32>>>,
}

impl Definition {
    fn of(steps: &[Step]) -> Self {
        let mut records = vec![Vec::new()];
        for step in steps {
            let record = records.last_mut().unwrap();
            match step {
                Step::Push(counts) => record.extend(counts.iter().copied().map(Some)),
                Step::Gap(Some(0)) => {
                    // A break without loss: shown to the definition by a stretch without samples that is a multiple of every stride.
                    let next = record.len();
                    record.resize(next + STRIDES, None);
                }
                Step::Gap(Some(missing)) => record.resize(record.len() + *missing as usize, None),
                Step::Gap(None) => records.push(Vec::new()),
            }
        }
        Self { records }
    }

    /// (m, windows, sum of squares) of every octave that has a window.
    fn sums(&self, estimator: Estimator, deviation: Deviation) -> Vec<(u64, u64, u128)> {
        let stride = |m: usize| match estimator {
            Estimator::Strided => (m / 16).max(1),
            Estimator::Plain => m,
            Estimator::Full => 1,
        };
        (0..12).filter_map(|k| self.sum(1 << k, stride(1 << k), deviation)).collect()
    }

    /// At any averaging factor.
    fn sum(&self, m: usize, stride: usize, deviation: Deviation) -> Option<(u64, u64, u128)> {
        let weights: &[i128] = match deviation {
            Deviation::Allan => &[-1, 1],
            Deviation::Hadamard => &[1, -2, 1],
        };
        let (mut terms, mut sum) = (0, 0);
        for record in &self.records {
            for start in (0..record.len()).step_by(stride) {
                let Some(window) = record.get(start..start + weights.len() * m) else { break };
                if let Some(counts) = window.iter().copied().collect::<Option<Vec<_>>>() {
                    let blocks = counts.chunks(m).zip(weights);
                    let z: i128 =
                        blocks.map(|(block, weight)| weight * block.iter().map(|&c| i128::from(c)).sum::<i128>()).sum();
                    terms += 1;
                    sum += (z * z) as u128;
                }
            }
        }
        (terms > 0).then_some((m as u64, terms, sum))
    }
}

/// A multiple of every stride that these records reach.
const STRIDES: usize = 2048;

fn octaves(estimator: Estimator, deviation: Deviation, steps: &[Step]) -> Octaves {
    let mut octaves = Octaves::new(estimator, deviation);
    for step in steps {
        match step {
            Step::Push(counts) => octaves.push(counts),
            Step::Gap(missing) => octaves.gap(*missing),
        }
    }
    octaves
}

fn sums(octaves: &Octaves) -> Vec<(u64, u64, u128)> {
    octaves.sums().map(|sum| (sum.m, sum.terms, sum.sum_squares.unwrap())).collect()
}

fn full(counts: &[i32]) -> Vec<(u64, u64, u128)> {
    sums(&octaves(Estimator::Full, Deviation::Allan, &[Step::Push(counts.to_vec())]))
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
        let expected = Definition::of(&steps).sums(estimator, deviation);
        prop_assert_eq!(sums(&octaves(estimator, deviation, &steps)), expected);
    }

    #[test]
    fn any_factor_follows_the_definition((_, deviation) in estimators(), steps in steps(), m in 1_usize..400) {
        let mut kept = Octaves::new(Estimator::Full, deviation).keeping_runs();
        for step in &steps {
            match step {
                Step::Push(counts) => kept.push(counts),
                Step::Gap(missing) => kept.gap(*missing),
            }
        }
        let found = |m| kept.sum_at(m).map(|sum| (sum.m, sum.terms, sum.sum_squares.unwrap()));
        prop_assert_eq!(found(m as u64), Definition::of(&steps).sum(m, 1, deviation));
        prop_assert_eq!(kept.sums().map(|sum| Some(sum) == kept.sum_at(sum.m)).min(), kept.sums().next().map(|_| true));
        prop_assert!(kept.sum_at(0).is_none() && kept.sum_at(u64::MAX).is_none());
    }

    #[test]
    fn any_division_gives_the_same(
        (estimator, deviation) in estimators(),
        parts in vec(vec(-4000..4000, 0..700), 0..8),
    ) {
        let divided: Vec<_> = parts.iter().cloned().map(Step::Push).collect();
        let whole = [Step::Push(parts.concat())];
        prop_assert_eq!(
            sums(&octaves(estimator, deviation, &divided)),
            sums(&octaves(estimator, deviation, &whole))
        );
    }

    #[test]
    fn strided_is_full_up_to_m_16(counts in vec(any::<i16>().prop_map(i32::from), 0..1000)) {
        let strided = sums(&octaves(Estimator::Strided, Deviation::Allan, &[Step::Push(counts.clone())]));
        for (strided, full) in strided.iter().zip(full(&counts)).take(5) {
            prop_assert_eq!(*strided, full);
        }
    }

    #[test]
    fn offset_scale_and_direction_of_time_do_what_they_must(
        counts in vec(-9000..9000, 0..1000),
        offset in -1_000_000..1_000_000,
        factor in 1_i32..1000,
    ) {
        let expected = full(&counts);
        let shifted: Vec<_> = counts.iter().map(|count| count + offset).collect();
        prop_assert_eq!(full(&shifted), expected.clone());
        let reversed: Vec<_> = counts.iter().rev().copied().collect();
        prop_assert_eq!(full(&reversed), expected.clone());
        let scaled: Vec<_> = counts.iter().map(|count| count * factor).collect();
        let squared_factor = u128::from(factor.unsigned_abs().pow(2));
        let expected: Vec<_> = expected.into_iter().map(|(m, terms, sum)| (m, terms, sum * squared_factor)).collect();
        prop_assert_eq!(full(&scaled), expected);
    }
}

//! A line taken out of the sums is a line taken out of the samples.

use imu_noise::{Deviation, Estimator, OctaveSum, Octaves};
use proptest::{collection::vec, prelude::*};

/// Sums of runs of counts with so many samples missing before each, `slope` counts per sample
/// added.
fn sums(estimator: Estimator, deviation: Deviation, runs: &[(u64, Vec<i32>)], slope: i32) -> Vec<OctaveSum> {
    let mut octaves = Octaves::new(estimator, deviation).keeping_slope();
    let mut place = 0;
    for (missing, counts) in runs {
        octaves.gap(Some(*missing));
        place += *missing as i32;
        for (index, chunk) in counts.chunks(300).enumerate() {
            let first = place + 300 * index as i32;
            let sloped: Vec<i32> = chunk.iter().zip(first..).map(|(count, place)| count + slope * place).collect();
            octaves.push(&sloped);
        }
        place += counts.len() as i32;
    }
    octaves.sums().collect()
}

proptest! {
    #[test]
    fn what_is_left_is_the_record_without_it(
        estimator in prop_oneof![Just(Estimator::Strided), Just(Estimator::Plain), Just(Estimator::Full)],
        deviation in prop_oneof![Just(Deviation::Allan), Just(Deviation::Hadamard)],
        runs in vec((0_u64..40, vec(-1000_i32..1000, 1..700)), 1..4),
        slope in -50_i32..50,
    ) {
        let level = sums(estimator, deviation, &runs, 0);
        let sloped = sums(estimator, deviation, &runs, slope);
        prop_assert_eq!(level.len(), sloped.len());
        for (level, sloped) in level.iter().zip(sloped) {
            let left = sloped.without_slope(slope.into());
            prop_assert_eq!((left.m, left.terms), (level.m, level.terms));
            let (left, level) = (left.sum_squares.unwrap_or(0) as f64, level.sum_squares.unwrap_or(0) as f64);
            let rounding = 1e-12 * sloped.sum_squares.unwrap_or(0) as f64;
            prop_assert!((left - level).abs() <= 1.0 + rounding, "{} of {:?}, not {}", left, sloped, level);
        }
    }
}

#[test]
fn sums_that_were_not_kept_leave_the_octave_unknown() {
    let mut octaves = Octaves::new(Estimator::Strided, Deviation::Allan);
    octaves.push(&[1, 2, 4]);
    assert!(octaves.sums().all(|sum| sum.without_slope(1.0).variance_counts2().is_none()));
    assert!(octaves.sums().all(|sum| sum.variance_counts2().is_some()));
}

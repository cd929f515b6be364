//! Histograms against their definition, for any order and division.

use std::collections::BTreeMap;

use imu_noise::{Histogram, MAX_BINS};
use proptest::{collection::vec, prelude::*};

/// Bin width, then lowest count and frequency of every bin, from the definition.
fn definition(counts: &[i32]) -> (u64, Vec<(i64, u64)>) {
    let bins = |width: i64| {
        let mut bins = BTreeMap::new();
        for &count in counts {
            *bins.entry(i64::from(count).div_euclid(width)).or_insert(0) += 1;
        }
        bins
    };
    let fits = |bins: &BTreeMap<i64, u64>| match (bins.first_key_value(), bins.last_key_value()) {
        (Some((first, _)), Some((last, _))) => last - first < MAX_BINS as i64,
        _ => true,
    };
    let width = (0..33).map(|k| 1 << k).find(|&width| fits(&bins(width))).unwrap();
    (width as u64, bins(width).into_iter().map(|(bin, frequency)| (bin * width, frequency)).collect())
}

fn read_out(histogram: &Histogram) -> (u64, Vec<(i64, u64)>) {
    (histogram.bin_width_counts(), histogram.bins().collect())
}

fn histogram(counts: &[i32]) -> Histogram {
    let mut histogram = Histogram::new();
    histogram.push(counts);
    histogram
}

#[test]
fn bins_widen_when_the_span_needs_it() {
    let last = MAX_BINS as i32 - 1;
    assert_eq!(histogram(&[0, last]).bin_width_counts(), 1);
    assert_eq!(read_out(&histogram(&[0, last + 1])), (2, vec![(0, 1), (i64::from(last) + 1, 1)]));
    // -1 and 0 never share a bin, so the span -1 ... last needs one more bin.
    assert_eq!(histogram(&[-1, last]).bin_width_counts(), 2);
    assert_eq!(
        read_out(&histogram(&[i32::MIN, i32::MAX])),
        (1 << 18, vec![(-(1 << 31), 1), ((1 << 31) - (1 << 18), 1)])
    );
}

proptest! {
    #[test]
    fn any_order_and_division_follow_the_definition(
        shift in 0_u32..32,
        parts in vec(vec(any::<i32>(), 0..200), 0..5),
    ) {
        let parts: Vec<Vec<_>> = parts.into_iter().map(|part| part.iter().map(|count| count >> shift).collect()).collect();
        let counts = parts.concat();
        let mut divided = Histogram::new();
        parts.iter().for_each(|part| divided.push(part));
        prop_assert_eq!(read_out(&divided), definition(&counts));
        prop_assert_eq!(divided.total(), counts.len() as u64);
        let mut sorted = counts.clone();
        sorted.sort_unstable();
        prop_assert_eq!(&histogram(&sorted), &divided);
        sorted.reverse();
        prop_assert_eq!(&histogram(&sorted), &divided);
    }
}

proptest! {
    #[test]
    fn bars_contain_every_sample_at_its_place(
        counts in vec(prop_oneof![-50_i32..50, -5000_i32..5000, any::<i32>()], 1..200),
        most in 2_usize..70,
    ) {
        let mut histogram = Histogram::new();
        histogram.push(&counts);
        let bars = histogram.bars(most).unwrap();
        prop_assert!(bars.counts.len() <= most);
        prop_assert_eq!(bars.counts.iter().sum::<u64>(), counts.len() as u64);
        prop_assert!(bars.counts.first() > Some(&0) && bars.counts.last() > Some(&0));
        let span = i64::from(*counts.iter().max().unwrap()) - i64::from(*counts.iter().min().unwrap()) + 1;
        let width = bars.width;
        prop_assert!(width == 1.0 || width * (most as f64 - 1.0) < 2.0 * span as f64 + 2.0 * width);
        if histogram.bin_width_counts() == 1 {
            for (bar, frequency) in bars.counts.iter().enumerate() {
                let lower = bars.first + bar as f64 * width;
                let inside = |count: &&i32| (lower..lower + width).contains(&f64::from(**count));
                prop_assert_eq!(counts.iter().filter(inside).count() as u64, *frequency);
            }
        }
    }
}

/// Triangular over `reach` values on either side, `step` counts apart before they are rounded.
fn stepping(step: f64, reach: i32, times: i32) -> Histogram {
    let value = |number: i32| (f64::from(number) * step).round() as i32;
    let of = |number: i32| std::iter::repeat_n(value(number), ((reach + 1 - number.abs()) * times) as usize);
    histogram(&(-reach..=reach).flat_map(of).collect::<Vec<_>>())
}

#[test]
fn the_step_of_frequent_values_is_found() {
    // the last two in bins of several counts
    for step in [2.0, 2.5, 9.765_625, 152.0, 1000.3, 61_035.156] {
        let found = stepping(step, 20, 10).step_counts().unwrap();
        assert!((found / step - 1.0).abs() < 0.03, "{found}, not {step}");
    }
    assert_eq!(stepping(9.8, 20, 1).step_counts().map(f64::round), Some(10.0));
    assert_eq!(stepping(9.8, 3, 1).step_counts(), None, "too few of each");
    assert_eq!(stepping(9.8, 1, 10).step_counts().map(f64::round), Some(10.0));
    assert_eq!(stepping(1.0, 20, 10).step_counts(), None, "the printed digit");
    let with_holes = [0, 1, 2, 3, 5, 6, 7, 8, 9, 11, 12].repeat(100);
    assert_eq!(histogram(&with_holes).step_counts(), None, "a value that is missing now and then is no step");
    // from a magnetometer with rotated axes: three counts around each step of ten
    let scattered: Vec<i32> = (-6..=6).flat_map(|number| [-1, 0, 0, 1].map(|off| 10 * number + off)).collect();
    let found = histogram(&scattered.repeat(50)).step_counts().unwrap();
    assert!((found - 10.0).abs() < 0.01, "{found}");
    assert_eq!(histogram(&[0, 7].repeat(100)).step_counts(), Some(7.0), "of two values their distance");
    assert_eq!(histogram(&[0, 7, 9].repeat(100)).step_counts(), None, "uneven");
    let rare = [[5].repeat(1000), vec![66, 66, 127]].concat();
    assert_eq!(histogram(&rare).step_counts(), Some(61.0), "beside one value");
    assert_eq!(histogram(&[5].repeat(1000)).step_counts(), None, "one value");
    let levels = [0, 1, 2, 1000, 1001, 1002].repeat(100);
    assert_eq!(histogram(&levels).step_counts(), None, "noise at two levels");
    let wide = [0, 1, MAX_BINS as i32].repeat(100);
    assert_eq!(histogram(&wide).step_counts(), Some(f64::from(wide[2])), "of two bins their distance");
    assert_eq!(histogram(&[]).step_counts(), None);
}

proptest! {
    /// Of fine values, whose step is a count, some are frequent by chance.
    #[test]
    fn values_that_are_frequent_by_chance_show_no_step(seed: u64, spread in 20_i32..4000, samples in 100_usize..20_000) {
        let mut state = seed;
        let mut below = |most: i32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as i32 % most
        };
        let counts: Vec<i32> = (0..samples).map(|_| below(spread) + below(spread)).collect();
        prop_assert_eq!(histogram(&counts).step_counts(), None);
    }
}

#[test]
fn bars_have_equal_numbers_of_steps() {
    let bars = stepping(9.765_625, 20, 10).bars(64).unwrap();
    let triangle: Vec<u64> = (-20_i64..=20).map(|number| 10 * (21 - number.unsigned_abs())).collect();
    assert_eq!(bars.counts, triangle);
    assert!((bars.width - 9.765_625).abs() < 0.05 && (bars.first + 20.5 * 9.765_625).abs() < 1.5, "{bars:?}");
    let joined = stepping(9.765_625, 20, 10).bars(21).unwrap();
    assert_eq!(joined.counts.iter().sum::<u64>(), triangle.iter().sum::<u64>());
    assert!((joined.width / bars.width - 2.0).abs() < 1e-12, "{joined:?}");
}

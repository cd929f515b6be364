//! Power sums and moments against exact tables, and for any division.

use ethnum::I256;
use proptest::{collection::vec, prelude::*};
use serde_json::Value;

use super::{Moments, PowerSums, in_integers, in_lanes};
use crate::oracle;

fn moments(counts: &[i32]) -> Moments {
    let mut moments = Moments::new();
    moments.push(counts);
    moments
}

fn assert_sums(moments: &Moments, expected: &Value, names: [&str; 4]) {
    let [first, second, third, fourth] = names.map(|name| expected[name].as_str().unwrap().parse::<I256>().unwrap());
    let count = expected["n"].as_u64().unwrap();
    let sums = PowerSums { count, first: first.as_i128(), second: second.as_i128(), third, fourth };
    assert_eq!(moments.sums, sums);
}

fn number(value: &Value) -> Option<f64> {
    value.as_str().map(|text| text.parse().unwrap())
}

fn assert_close(name: &str, found: Option<f64>, expected: &Value, scale: f64) {
    let (Some(found), Some(expected)) = (found, number(expected)) else {
        assert_eq!(found, number(expected), "{name}");
        return;
    };
    let found = found * scale;
    assert!((found / expected - 1.0).abs() <= 1e-12, "{name}: {found}, not {expected}");
}

fn check(file: &str, counts: &[i32], scale: f64) {
    let expected = oracle::json(file);
    let all = moments(counts);
    assert_sums(&all, &expected, ["sum_counts", "sum_sq_counts", "sum_cube_counts", "sum_4th_counts"]);
    let extremes = (all.min_counts(), all.max_counts());
    let integer = |name: &str| i32::try_from(expected[name].as_i64().unwrap()).ok();
    assert_eq!(extremes, (integer("min_count"), integer("max_count")));
    assert_close("mean", all.mean_counts(), &expected["mean"], scale);
    assert_close("variance", all.variance_counts2(), &expected["var_sample"], scale * scale);
    assert_close("std", all.std_counts(), &expected["std_sample"], scale);
    assert_close("excess kurtosis", all.excess_kurtosis(), &expected["excess_kurtosis_g2"], 1.0);
    let skewness_error = all.skewness().unwrap() - number(&expected["skewness_g1"]).unwrap();
    assert!(skewness_error.abs() <= 1e-12, "skewness off by {skewness_error}");

    for prefix in expected["prefix"].as_array().into_iter().flatten() {
        let n = usize::try_from(prefix["n"].as_u64().unwrap()).unwrap();
        let found = moments(&counts[..n]);
        assert_close("mean", found.mean_counts(), &prefix["mean"], scale);
        assert_close("variance", found.variance_counts2(), &prefix["var_sample"], scale * scale);
        assert_close("min", found.min_counts().map(f64::from), &prefix["min"], scale);
        assert_close("max", found.max_counts().map(f64::from), &prefix["max"], scale);
    }
}

#[test]
fn nist1000_moments() {
    check("nist1000_moments.json", &oracle::nist1000(), 1.0 / 2_147_483_647.0);
}

#[test]
fn imu_moments() {
    for (name, scale) in
        [("imu_a_acc_white", 1e-3), ("imu_b_gyro_white_flicker_rrw", 1e-6), ("imu_c_mag_white_flicker_ramp", 1e-4)]
    {
        check(&format!("{name}_moments.json"), &oracle::series(&format!("{name}.txt")), scale);
    }
}

#[test]
fn too_few_samples_have_no_moments() {
    let none = moments(&[]);
    assert_eq!((none.count(), none.min_counts(), none.max_counts(), none.mean_counts()), (0, None, None, None));
    let one = moments(&[-7]);
    assert_eq!(
        (one.count(), one.min_counts(), one.max_counts(), one.mean_counts()),
        (1, Some(-7), Some(-7), Some(-7.0))
    );
    for few in [none, one] {
        assert_eq!((few.variance_counts2(), few.std_counts()), (None, None));
        assert_eq!((few.skewness(), few.excess_kurtosis()), (None, None));
    }
}

#[test]
fn a_constant_has_no_spread_and_no_shape() {
    for constant in [i32::MIN, -9813, 0, 1, i32::MAX] {
        let moments = moments(&[constant; 1000]);
        assert_eq!(moments.mean_counts(), Some(constant.into()));
        assert_eq!(moments.std_counts(), Some(0.0));
        assert_eq!((moments.skewness(), moments.excess_kurtosis()), (None, None));
    }
}

/// Two equally frequent values one count apart, on a huge offset: variance 1/4, no skewness,
/// kurtosis 1.
#[test]
fn a_huge_offset_loses_no_digit() {
    let counts: Vec<_> = (0..100_000).map(|i| i32::MAX - i % 2).collect();
    let moments = moments(&counts);
    assert_eq!(moments.mean_counts(), Some(f64::from(i32::MAX) - 0.5));
    assert_eq!(moments.variance_counts2(), Some(25_000.0 / 99_999.0));
    assert_eq!((moments.skewness(), moments.excess_kurtosis()), (Some(0.0), Some(-2.0)));
}

fn definition(counts: &[i32]) -> PowerSums {
    let sum = |power: u32| counts.iter().map(|&count| I256::from(count).pow(power)).sum::<I256>();
    let count = counts.len() as u64;
    PowerSums { count, first: sum(1).as_i128(), second: sum(2).as_i128(), third: sum(3), fourth: sum(4) }
}

proptest! {
    #[test]
    fn floats_and_integers_agree_with_the_definition(
        pivot in any::<i32>(),
        bits in 0_u32..32,
        noise in vec(any::<i32>(), 1..=256),
    ) {
        let block: Vec<_> = noise.iter().map(|noise| pivot.saturating_add(noise >> (31 - bits))).collect();
        prop_assert_eq!(in_integers(&block), definition(&block));
        if let Some(sums) = in_lanes(&block) {
            prop_assert_eq!(sums, definition(&block));
        } else {
            prop_assert!(bits > 20, "{} bits are few enough for floats", bits);
        }
    }

    #[test]
    fn sums_about_any_centre_are_those_of_shifted_counts(
        counts in vec(-1_000_000_i32..1_000_000, 0..50),
        centre in -1_000_000_i32..1_000_000,
    ) {
        let shifted: Vec<_> = counts.iter().map(|count| count - centre).collect();
        prop_assert_eq!(definition(&counts).about(centre.into()), definition(&shifted));
    }

    #[test]
    fn any_division_gives_the_same(parts in vec(vec(any::<i32>(), 0..300), 0..6)) {
        let mut divided = Moments::new();
        for part in &parts {
            divided.push(part);
        }
        prop_assert_eq!(divided, moments(&parts.concat()));
    }
}

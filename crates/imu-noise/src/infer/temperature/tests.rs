//! The temperature coefficient beside noise of known kinds, and what keeps it from being shown.

use std::f64::consts::TAU;

use super::*;

const INTERVAL_S: f64 = 0.025;

/// Counts of an axis that are a hundredth of a unit; the temperature is in tenths of a degree.
struct SyntheticRecord {
    blocks: TemperatureBlocks,
    axis: Vec<i32>,
}

/// White noise of 1 a sample, uniform, by a generator of congruences.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12_f64.sqrt()
    }
}

impl SyntheticRecord {
    /// An axis that follows `temperature_c` (of seconds) by `coefficient`, behind a lag.
    fn new(seconds: usize, temperature_c: impl Fn(f64) -> f64, coefficient: f64, lag_s: f64, seed: u64) -> Self {
        let samples = seconds * 40;
        let mut noise = noise(seed);
        let gain = if lag_s > 0.0 { -(-INTERVAL_S / lag_s).exp_m1() } else { 1.0 };
        let mut lagged_c = temperature_c(0.0);
        let (mut axis, mut temperature) = (Vec::new(), Vec::new());
        for index in 0..samples {
            let now_c = temperature_c(index as f64 * INTERVAL_S);
            lagged_c += gain * (now_c - lagged_c);
            axis.push((100.0 * (coefficient * lagged_c + noise())).round() as i32);
            temperature.push((10.0 * now_c + 0.5 * noise()).round() as i32);
        }
        let mut blocks = TemperatureBlocks::new(1);
        blocks.push_axis(0, 0, &axis);
        blocks.push_temperature(0, &temperature);
        Self { blocks, axis }
    }

    fn search(&self) -> Result<TemperatureSearch, NoCoefficient> {
        TemperatureSearch::new(&self.blocks, INTERVAL_S, 0.1)
    }

    fn coefficient(&self) -> TemperatureCoefficient {
        self.search().unwrap().coefficient(0, 0.01, 0.95).unwrap()
    }
}

fn cycle(time_s: f64) -> f64 {
    25.0 + 2.0 * (TAU * time_s / 400.0).sin()
}

#[test]
fn a_coefficient_is_found_with_its_lag() {
    for lag_s in [0.0, 20.0, 60.0] {
        let mut held = 0;
        for seed in 1..=8 {
            let found = SyntheticRecord::new(1800, cycle, 0.2, lag_s, seed).coefficient();
            assert!((found.value - 0.2).abs() < 0.05 && found.p < 1e-6, "{found:?}");
            held += usize::from(found.lower < 0.2 && 0.2 < found.upper);
            let (shortest, longest) = found.lag_range_s;
            assert!(shortest <= lag_s && lag_s <= longest && longest - shortest < 60.0, "{found:?}");
            assert!(!found.is_lag_open, "{found:?}");
        }
        assert!(held >= 7, "{held} of 8 behind {lag_s} s");
    }
}

#[test]
fn an_axis_that_does_not_follow_has_an_interval_about_zero() {
    let found: Vec<_> = (1..=20).map(|seed| SyntheticRecord::new(900, cycle, 0.0, 0.0, seed).coefficient()).collect();
    assert!(found.iter().filter(|found| found.lower < 0.0 && 0.0 < found.upper).count() >= 18);
    assert!(found.iter().filter(|found| found.p < 0.05).count() <= 3);
    assert!(found.iter().filter(|found| found.is_lag_open).count() >= 15, "nothing shows the lag");
}

#[test]
fn white_noise_alone_has_the_error_of_least_squares() {
    let record = SyntheticRecord::new(1800, cycle, 0.2, 0.0, 3);
    let (search, found) = (record.search().unwrap(), record.coefficient());
    let (x, y) = (series::less_mean(&search.series.temperatures_c), series::less_mean(&search.series.axes[0]));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let slope = product(&x, &y) / product(&x, &x);
    let rest = product(&y, &y) - slope * product(&x, &y);
    let dof = (x.len() - 2) as f64;
    let quantile = chi_squared::student_two_sided(0.95, dof).unwrap();
    let half_width = 0.01 * quantile * (rest / dof / product(&x, &x)).sqrt();
    // flicker noise, a walk and a lag may be there too
    assert!((found.value - 0.01 * slope).abs() < 0.3 * half_width, "{found:?}, not {slope}");
    let found_width = (found.upper - found.lower) / (2.0 * half_width);
    assert!((0.9..1.6).contains(&found_width), "{found:?}, not {half_width}");
}

#[test]
fn a_record_that_cannot_show_one_says_why() {
    let why = |seconds, temperature_c: fn(f64) -> f64| {
        SyntheticRecord::new(seconds, temperature_c, 0.2, 0.0, 1).search().err()
    };
    assert!(matches!(why(20, cycle), Some(NoCoefficient::TooShort { blocks: 25 })), "{:?}", why(20, cycle));
    let little = |time_s: f64| 25.0 + 0.2 * (cycle(time_s) - 25.0) / 2.0;
    let Some(NoCoefficient::Excursion { excursion_c }) = why(900, little) else { panic!() };
    assert!((excursion_c - 0.4).abs() < 0.1, "{excursion_c}");
    let Some(NoCoefficient::OneDirection { correlation }) = why(900, |time_s| 25.0 - time_s / 100.0) else { panic!() };
    assert!(correlation < -0.99, "{correlation}");
    let text = [
        NoCoefficient::TooShort { blocks: 25 },
        NoCoefficient::Excursion { excursion_c: 0.4 },
        NoCoefficient::OneDirection { correlation: 0.97 },
    ]
    .map(|why| why.to_string());
    assert!(text[0].starts_with("25 consecutive blocks") && text[0].ends_with("32 needed"));
    assert_eq!(text[1], "the temperature changed by 0.4 °C, 1 °C needed");
    assert_eq!(text[2], "the temperature only rose (correlation with time +0.97), both directions are needed");
    assert!(TemperatureSearch::new(&TemperatureBlocks::new(1), INTERVAL_S, 0.1).is_err());
}

#[test]
fn an_axis_that_does_not_vary_has_none() {
    let mut record = SyntheticRecord::new(900, cycle, 0.2, 0.0, 1);
    let mut constant = TemperatureBlocks::new(2);
    constant.push_axis(0, 0, &record.axis);
    constant.push_axis(1, 0, &vec![7; record.axis.len()]);
    for index in 0..record.axis.len() {
        constant.push_temperature(index as u64, &[(10.0 * cycle(index as f64 * INTERVAL_S)).round() as i32]);
    }
    record.blocks = constant;
    let search = record.search().unwrap();
    assert!(search.coefficient(0, 0.01, 0.95).is_some());
    assert!(search.coefficient(1, 0.01, 0.95).is_none() && search.coefficient(2, 0.01, 0.95).is_none());
}

#[test]
fn a_few_readings_are_enough_and_nothing_is_taken_across_a_break() {
    let all = SyntheticRecord::new(1800, cycle, 0.2, 0.0, 5);
    let mut polled = TemperatureBlocks::new(1);
    polled.push_axis(0, 0, &all.axis);
    for reading in 0..180_u64 {
        polled.push_temperature(400 * reading, &[(10.0 * cycle(reading as f64 * 10.0)).round() as i32]);
    }
    let search = TemperatureSearch::new(&polled, INTERVAL_S, 0.1).unwrap();
    let (few, many) = (search.coefficient(0, 0.01, 0.95).unwrap(), all.coefficient());
    assert!(few.lower < 0.2 && 0.2 < few.upper && (few.value / many.value - 1.0).abs() < 0.1, "{few:?} {many:?}");
    assert!(search.series.block_s >= 10.0, "blocks as long as readings are apart: {}", search.series.block_s);

    let mut broken = TemperatureBlocks::new(1);
    let half = 1200 * 40;
    broken.push_axis(0, 0, &all.axis[..half]);
    broken.part();
    broken.push_axis(0, half as u64, &all.axis[half..]);
    for index in 0..all.axis.len() {
        broken.push_temperature(index as u64, &[(10.0 * cycle(index as f64 * INTERVAL_S)).round() as i32]);
    }
    let search = TemperatureSearch::new(&broken, INTERVAL_S, 0.1).unwrap();
    let end_s = search.series.duration_s();
    assert!((1190.0..=1200.0).contains(&end_s), "{end_s} s");
}

#[test]
fn the_largest_share_is_that_of_the_octave_of_the_cycle() {
    // white noise of 1 spreads evenly over all cosines, and nine cycles lie among the 16th to the 31st
    let (seconds, amplitude_c, coefficient) = (3600, 2.0, 0.0075_f64);
    let made = (coefficient * amplitude_c).powi(2) / 2.0;
    let noise = 16.0 / (seconds * 40) as f64;
    let shares =
        (0..20).map(|seed| SyntheticRecord::new(seconds, cycle, coefficient, 0.0, seed).coefficient().largest_share);
    let mean = shares.sum::<f64>() / 20.0;
    assert!((mean - made / (made + noise)).abs() < 0.1, "{mean}");
}

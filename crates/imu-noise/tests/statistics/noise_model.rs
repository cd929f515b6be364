//! The fit for noise-free curves, and its results if data do not follow the model.

use std::f64::consts::TAU;

use imu_noise::{
    BoxcarWindow, ChannelCurve, ChannelSignal, Deviation, Estimator, Interval, NoiseFit, NoiseModel, Octave, Octaves,
    Parameter, RecordShape, SpectrumPlan, Status, Term, Withheld,
};

use crate::oracle;
use crate::synthetic::Synthesis;

const INTERVAL_S: f64 = 0.025;

fn shape(samples: u64) -> RecordShape {
    RecordShape { samples, interval_s: INTERVAL_S, estimator: Estimator::Strided, deviation: Deviation::Allan }
}

/// Fits values in units of 1e-4, with the results of their spectrum.
fn fit_record(values: &[f64], window: Option<BoxcarWindow>, is_quantized: bool) -> NoiseFit {
    let counts: Vec<i32> = values.iter().map(|value| (value * 1e4).round() as i32).collect();
    let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
    sums.push(&counts);
    let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
    let variances: Vec<_> = sums.sums().map(|sum| sum.variance_counts2().unwrap() * 1e-8).collect();
    let signal = signal(&counts);
    let bands = signal.narrow_bands(1e-4, INTERVAL_S);
    let curve = ChannelCurve { bands: &bands, signal: Some((&signal, 1e-4)), ..ChannelCurve::new(&variances, false) };
    NoiseModel::new(&octaves, &shape(values.len() as u64), window, is_quantized).fit(&curve, 0.95)
}

fn signal(counts: &[i32]) -> ChannelSignal {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    signal.push(counts);
    signal
}

fn near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found / expected - 1.0).abs() < tolerance
}

#[test]
fn curves_without_noise_return_their_parameters() {
    let text = oracle::text("fit_curves.csv");
    let mut sets = 0;
    for parameters in text.lines().filter_map(|line| line.strip_prefix("#   ")).filter(|line| line.starts_with('{')) {
        let parameters: serde_json::Value = serde_json::from_str(parameters).unwrap();
        let number = |name: &str| parameters[name].as_str().unwrap().parse::<f64>().unwrap();
        // The ramp of one set needs the slope of the record, which is not in the curve.
        if number("R") != 0.0 {
            continue;
        }
        let rows: Vec<(u64, f64)> = oracle::table("fit_curves.csv")
            .iter()
            .filter(|row| oracle::field(row, "set") == parameters["set"].as_str())
            .map(|row| {
                let field = |name| oracle::field(row, name).unwrap();
                (field("m").parse().unwrap(), field("avar_disc").parse().unwrap())
            })
            .collect();
        // With this many samples the estimates have no spread.
        let shape = RecordShape { interval_s: number("tau0"), ..shape(1 << 36) };
        let octaves: Vec<_> = rows.iter().map(|(m, _)| Octave::whole(*m, shape.windows(*m))).collect();
        let variances: Vec<_> = rows.iter().map(|(_, variance)| *variance).collect();
        let fit = NoiseModel::new(&octaves, &shape, None, true).fit(&ChannelCurve::new(&variances, false), 0.95);
        for (term, name) in
            [(Term::Quantization, "Q"), (Term::White, "N"), (Term::BiasInstability, "B"), (Term::RateRandomWalk, "K")]
        {
            let Parameter { status, value, upper, .. } = fit.parameter(term).unwrap();
            let expected = number(name);
            if expected == 0.0 {
                assert_eq!(status, Status::Bounded, "{parameters} {name} {value:?}");
                assert!(upper.unwrap() < 0.02 * number("N"), "{parameters} {name} {upper:?}");
            } else {
                assert!(near(value.unwrap(), expected, 1e-3), "{parameters} {name}: {value:?}");
            }
        }
        sets += 1;
    }
    assert_eq!(sets, 3);
}

/// White noise with standard deviation 1 and a sine.
fn shaken(samples: usize, seed: u64, frequency_hz: f64, amplitude: f64) -> Vec<f64> {
    let (white, ..) = Synthesis::new(samples, seed).next_record();
    let sine = |i: usize| amplitude * (TAU * frequency_hz * INTERVAL_S * i as f64 + 1.0).sin();
    white.iter().enumerate().map(|(i, white)| white + sine(i)).collect()
}

#[test]
fn a_line_is_a_term_of_its_own_at_any_frequency() {
    // Slow ones, one at half the rate of the windows, fast ones, aliased ones.
    for (seed, frequency_hz) in [0.2, 0.53, 0.625, 3.1, 7.93, 18.4, 43.3].into_iter().enumerate() {
        let fit = fit_record(&shaken(24_000, seed as u64 + 20, frequency_hz, 1.0), None, false);
        let quality = fit.quality.unwrap();
        assert!(quality.p >= 0.01 && quality.tau_min_s == INTERVAL_S, "{frequency_hz} Hz: {quality:?}");
        let white = fit.parameter(Term::White).unwrap();
        // Three standard errors.
        assert!(near(white.value.unwrap(), INTERVAL_S.sqrt(), 0.016), "{frequency_hz} Hz: {white:?}");
        assert_eq!(fit.parameter(Term::BiasInstability).unwrap().status, Status::Bounded, "{frequency_hz} Hz");
        assert_eq!(fit.parameter(Term::RateRandomWalk).unwrap().status, Status::Bounded, "{frequency_hz} Hz");
    }
}

/// White noise on a level that changes between two values after random dwells of about a minute: neither
/// flicker noise nor a walk.
#[test]
fn noise_that_switches_between_two_levels_is_no_bias_instability() {
    let slow = [Term::BiasInstability, Term::RateRandomWalk];
    let mut told = 0;
    for seed in 40..50 {
        let (white, ..) = Synthesis::new(72_000, seed).next_record();
        let mut state = seed;
        let mut is_high = false;
        let switches = |white: &f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            is_high ^= state >> 32 < (1 << 32) / 2400;
            white + if is_high { 0.4 } else { 0.0 }
        };
        let fit = fit_record(&white.iter().map(switches).collect::<Vec<f64>>(), None, false);
        for term in slow {
            assert_eq!(fit.parameter(term).unwrap().status, Status::Bounded, "{seed} {term:?}");
        }
        told += usize::from(fit.rival(Term::BiasInstability) == Some(Withheld::MayBeSwitching));
    }
    assert!(told > 0, "B would be estimated in some if levels did not explain as much");
}

#[test]
fn a_band_has_the_power_of_its_line_and_is_found_once() {
    for frequency_hz in [0.2, 0.9, 7.93, 18.4] {
        let values = shaken(60_000, 31, frequency_hz, 0.5);
        let counts: Vec<i32> = values.iter().map(|value| (value * 1e4).round() as i32).collect();
        let bands = signal(&counts).narrow_bands(1e-4, INTERVAL_S);
        let [band] = &bands[..] else { panic!("{frequency_hz} Hz: {bands:?}") };
        assert!(near(band.frequency(), frequency_hz * INTERVAL_S, 0.01), "{frequency_hz} Hz: {band:?}");
        assert!(near(band.power, 0.125, 0.1), "{frequency_hz} Hz: {band:?}");
    }
}

#[test]
fn noise_without_lines_shows_none() {
    let mut synthesis = Synthesis::new(24_000, 41);
    let mut bands = 0;
    for _ in 0..10 {
        let (white, flicker, walk) = synthesis.next_record();
        for (flicker_b, step) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.01), (3.0, 0.0), (0.0, 3.0)] {
            let sum = |i: usize| white[i] + flicker_b * flicker[i] + step * walk[i];
            let counts: Vec<i32> = (0..white.len()).map(|i| (sum(i) * 1e3).round() as i32).collect();
            let signal = signal(&counts);
            let found = signal.narrow_bands(1e-3, INTERVAL_S);
            bands += found.len();
        }
    }
    // A hundred-thousandth of 50 records with 500 points each.
    assert!(bands <= 3, "{bands}");
}

/// A filter that changes a tenth of the variance, up or down, like that of a VN-100 at 200 Hz.
#[test]
fn a_weak_filter_of_unknown_transfer_leaves_n_right() {
    for (seed, before) in [(71, 0.1), (72, -0.05), (73, 0.05), (74, -0.08)] {
        let (white, ..) = Synthesis::new(24_000, seed).next_record();
        let values: Vec<f64> = white.windows(2).map(|pair| (pair[1] + before * pair[0]) / (1.0 + before)).collect();
        let fit = fit_record(&values, None, false);
        let white = fit.parameter(Term::White).unwrap();
        let truth = INTERVAL_S.sqrt();
        assert!(white.lower.unwrap() < truth && truth < white.upper.unwrap(), "{before}: {white:?}, not {truth}");
    }
}

#[test]
fn a_line_does_not_affect_the_filter() {
    let (white, ..) = Synthesis::new(24_000, 61).next_record();
    let filtered: Vec<f64> = white.windows(2).map(|pair| pair[0] + pair[1]).collect();
    let roll_off = |line: f64| {
        let sine = |i: usize| line * (TAU * 7.93 * INTERVAL_S * i as f64).sin();
        let values: Vec<f64> = filtered.iter().enumerate().map(|(i, value)| value + sine(i)).collect();
        fit_record(&values, None, false).correlation_samples.unwrap()
    };
    let alone = roll_off(0.0);
    // half of the variance
    let beside_line = roll_off(2.0);
    assert!(near(alone, 2.0, 0.1), "{alone}");
    assert!(near(beside_line, alone, 0.05), "{beside_line}, not {alone}");
}

#[test]
fn an_average_as_long_as_a_part_of_the_record_bounds_n_above_the_truth() {
    for (samples, average) in [(425, 21), (600, 30), (749, 10)] {
        for seed in 1..=8 {
            let (white, ..) = Synthesis::new(samples + average, seed).next_record();
            let values: Vec<f64> = white.windows(average).map(|all| all.iter().sum::<f64>() / average as f64).collect();
            let fit = fit_record(&values, None, false);
            let white = fit.parameter(Term::White).unwrap();
            let truth = INTERVAL_S.sqrt();
            assert!(white.upper.is_none_or(|upper| upper > truth), "{average} of {samples}, {seed}: {white:?}");
        }
    }
}

#[test]
fn correlated_noise_is_distinguished_from_white_noise() {
    // five samples, half a second and more
    for (seed, samples, time_s, sigma) in [
        (48, 19_113, 0.125, 0.34),
        (49, 19_113, 0.125, 0.34),
        (50, 19_113, 0.125, 0.34),
        (51, 24_000, 0.5, 0.5),
        (52, 24_000, 5.0, 0.5),
        (53, 24_000, 20.0, 0.5),
    ] {
        let mut synthesis = Synthesis::new(samples, seed);
        let (white, ..) = synthesis.next_record();
        let (driving, ..) = synthesis.next_record();
        let kept = (-INTERVAL_S / time_s).exp();
        let mut process = 0.0;
        let values: Vec<f64> = (white.iter().zip(&driving))
            .map(|(white, driving)| {
                process = kept * process + sigma * (1.0 - kept * kept).sqrt() * driving;
                white + process
            })
            .collect();
        let fit = fit_record(&values, None, false);
        let white = fit.parameter(Term::White).unwrap();
        assert!(near(white.value.unwrap(), INTERVAL_S.sqrt(), 0.02), "{time_s} s: {white:?}");
    }
}

#[test]
fn blue_noise_is_quantisation_of_the_angle_on_request() {
    let (white, ..) = Synthesis::new(20_000, 4).next_record();
    let values: Vec<f64> = white.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let fit = fit_record(&values, None, true);
    let quantization = fit.parameter(Term::Quantization).unwrap();
    assert!(near(quantization.value.unwrap(), INTERVAL_S, 0.05), "{quantization:?} {:?}", fit.quality);
    assert_eq!(fit.parameter(Term::White).unwrap().status, Status::Bounded);
}

#[test]
fn octaves_alone_leave_a_filter_possible() {
    let mut synthesis = Synthesis::new(20_000, 4);
    let (white, ..) = synthesis.next_record();
    let smoothed = white.windows(3).map(|three| (three.iter().sum::<f64>() / 3.0 * 1e4).round() as i32);
    let counts: Vec<i32> = smoothed.collect();
    let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
    sums.push(&counts);
    let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
    let variances: Vec<_> = sums.sums().map(|sum| sum.variance_counts2().unwrap() * 1e-8).collect();
    let model = NoiseModel::new(&octaves, &shape(counts.len() as u64), None, false);
    let white = model.fit(&ChannelCurve::new(&variances, false), 0.95).parameter(Term::White).unwrap();
    let (lower, upper) = (white.lower.unwrap_or(0.0) / INTERVAL_S.sqrt(), white.upper.unwrap() / INTERVAL_S.sqrt());
    assert!(lower < 1.0 && (1.0..1.3).contains(&upper), "{lower} to {upper} of N");
}

#[test]
fn too_few_and_constant_data_give_no_result() {
    for values in [vec![], vec![1.0], vec![1.0, 2.0], vec![1.0, 3.0, 2.0, 5.0], vec![1.0; 5000]] {
        let fit = fit_record(&values, None, false);
        assert_eq!(fit.quality, None, "{} samples", values.len());
        assert_eq!(fit.parameter(Term::White), Some(Parameter::without_value(Status::NotObservable)));
    }
}

#[test]
fn a_window_longer_than_the_interval_needs_its_own_basis() {
    // 20 of 800 a second averaged, every 4th average sent: neighbours share 16 of 20.
    let mut synthesis = Synthesis::new(400_000, 5);
    let (internal, ..) = synthesis.next_record();
    let values: Vec<f64> = internal.windows(20).step_by(4).map(|window| window.iter().sum::<f64>() / 20.0).collect();
    let fit = fit_record(&values, Some(BoxcarWindow { length: 20, decimation: 4.0 }), false);
    // Long averages of the outputs are those of the internal samples: N is 1 per √(internal sample).
    let expected = (INTERVAL_S / 4.0).sqrt();
    let white = fit.parameter(Term::White).unwrap();
    assert!(near(white.value.unwrap(), expected, 0.02), "{white:?}, not {expected}");
    assert_eq!(fit.parameter(Term::BiasInstability).unwrap().status, Status::Bounded);
    // Where the window is unknown the spectrum tells of it.
    let unknown = fit_record(&values, None, false);
    let white = unknown.parameter(Term::White).unwrap();
    assert!(white.lower.unwrap() < expected && expected < white.upper.unwrap(), "{white:?}, not {expected}");
    assert!(white.relative_half_width().unwrap() < 0.1, "{white:?}");
}

#[test]
fn intervals_widen_with_the_level() {
    let mut synthesis = Synthesis::new(24_000, 6);
    let (white, flicker, _) = synthesis.next_record();
    let values: Vec<_> = white.iter().zip(&flicker).map(|(white, flicker)| white + 0.1 * flicker).collect();
    let counts: Vec<i32> = values.iter().map(|value| (value * 1e4).round() as i32).collect();
    let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
    sums.push(&counts);
    let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
    let variances: Vec<_> = sums.sums().map(|sum| sum.variance_counts2().unwrap()).collect();
    let model = NoiseModel::new(&octaves, &shape(24_000), None, false);
    let mut width_before = 0.0;
    for confidence in [0.5, 0.6827, 0.95, 0.999] {
        let Parameter { value, lower, upper, .. } =
            model.fit(&ChannelCurve::new(&variances, false), confidence).parameter(Term::BiasInstability).unwrap();
        let (value, lower, upper) = (value.unwrap(), lower.unwrap(), upper.unwrap());
        assert!(lower <= value && value <= upper && upper - lower > width_before, "{lower} {value} {upper}");
        width_before = upper - lower;
    }
    for confidence in [0.0, 1.0, f64::NAN] {
        let parameter = model.fit(&ChannelCurve::new(&variances, false), confidence).parameter(Term::White).unwrap();
        assert_eq!(parameter.status, Status::NotObservable);
    }
}

#[test]
fn lost_samples_widen_the_intervals_as_they_must() {
    const RECORDS: usize = 30;
    const SAMPLES: usize = 24_000;
    let mut synthesis = Synthesis::new(SAMPLES, 9);
    let (mut white_held, mut octaves_held, mut octaves_all, mut rejected) = (0, 0, 0, 0);
    for _ in 0..RECORDS {
        let (white, ..) = synthesis.next_record();
        let counts: Vec<i32> = white.iter().map(|value| (value * 1e4).round() as i32).collect();
        let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
        // One in 601 lost: half of the windows of m = 128 remain.
        for run in counts.chunks(601) {
            sums.push(&run[..run.len() - 1]);
            sums.gap(Some(1));
        }
        let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
        let variances: Vec<_> = sums.sums().map(|sum| sum.variance_counts2().unwrap() * 1e-8).collect();
        let fit = NoiseModel::new(&octaves, &shape(SAMPLES as u64), None, false)
            .fit(&ChannelCurve::new(&variances, false), 0.95);
        rejected += usize::from(fit.quality.is_none());
        let white = fit.parameter(Term::White).unwrap();
        let truth = INTERVAL_S.sqrt();
        white_held += usize::from(white.lower.is_some_and(|lower| lower <= truth) && truth <= white.upper.unwrap());
        for (octave, variance) in octaves.iter().zip(&variances) {
            if let Some(edf) = fit.edf(octave.m).filter(|edf| *edf > 10.0) {
                let interval = Interval::new(*variance, edf, 0.95).unwrap();
                octaves_all += 1;
                octaves_held += usize::from((interval.lower..=interval.upper).contains(&(octave.m as f64).powf(-0.5)));
            }
        }
    }
    assert!(rejected <= 1, "{rejected}");
    assert!(white_held >= 25, "{white_held}");
    assert!((0.91..0.985).contains(&(octaves_held as f64 / f64::from(octaves_all))), "{octaves_held}/{octaves_all}");
}

#[test]
fn a_term_that_may_be_zero_is_no_estimate() {
    let mut estimated = 0;
    for seed in 1..=40 {
        // one second after a low pass, and short records
        let (white, ..) = Synthesis::new(1000, seed).next_record();
        let smoothed = |values: &[f64]| {
            let smooth = |last: &mut f64, value: &f64| {
                *last = 0.85 * *last + 0.15 * value;
                Some(*last)
            };
            values.iter().scan(0.0, smooth).collect::<Vec<f64>>()
        };
        let once = smoothed(&white);
        let twice = smoothed(&once);
        for values in [&once[200..], &twice[200..], &white[..40], &white[..200]] {
            let fit = fit_record(values, None, false);
            for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
                let parameter = fit.parameter(term).unwrap();
                if parameter.status == Status::Estimated {
                    estimated += 1;
                    let (value, lower) = (parameter.value.unwrap(), parameter.lower.unwrap());
                    assert!(lower > 0.01 * value, "seed {seed}, {term:?}: {lower} below {value}");
                }
            }
        }
    }
    assert!(estimated > 40, "{estimated}");
}

//! The spectrum compared with SciPy's, and the effect of gaps, length and late lines.

use std::f64::consts::TAU;

use imu_noise::{ChannelSignal, Sides, SpectralLine, SpectrumPlan};

use crate::oracle;

const INTERVAL_S: f64 = 0.025;

#[test]
fn densities_equal_those_of_scipy() {
    let rows = oracle::table("welch.csv");
    let field = |row: &[(String, String)], name| oracle::field(row, name).unwrap().to_string();
    for (series, decimals, samples, sides, segments) in [
        ("imu_a_acc_white", 3, 10_000, Sides::One, 38),
        ("imu_b_gyro_white_flicker_rrw", 6, 10_000, Sides::Two, 38),
        ("imu_c_mag_white_flicker_ramp", 4, 2000, Sides::One, 30),
    ] {
        let counts = oracle::series(&format!("{series}.txt"));
        let density = signal(&counts[..samples]).spectrum().density(sides, INTERVAL_S, decimals).unwrap();
        let expected: Vec<_> = rows.iter().filter(|row| field(row, "series") == series).collect();
        assert_eq!(density.points_unit2_hz.len(), expected.len(), "{series}");
        assert_eq!((density.segments, density.segment_samples), (segments, 2 * expected.len()), "{series}");
        for ((point, row), place) in density.points_unit2_hz.iter().zip(expected).zip(1..) {
            let number = |name| field(row, name).parse::<f64>().unwrap();
            assert_eq!(f64::from(place) * density.step_hz, number("frequency_hz"));
            // SciPy does not double the power at half the sampling rate, which is spread over half
            // a point
            let is_last = number("frequency_hz") == 0.5 / INTERVAL_S;
            let expected = number("density") * if is_last && sides == Sides::One { 2.0 } else { 1.0 };
            let error = point / expected - 1.0;
            assert!(error.abs() < 2e-6, "{series} at {} Hz: {error:e}", number("frequency_hz"));
        }
    }
}

#[test]
fn without_a_full_segment_or_an_interval_there_is_no_density() {
    let nothing = signal(&white(127));
    assert!(nothing.spectrum().density(Sides::One, INTERVAL_S, 0).is_none());
    assert!(lines(&nothing, INTERVAL_S).is_empty());
    let short = signal(&white(128));
    assert_eq!(short.spectrum().density(Sides::One, INTERVAL_S, 0).unwrap().segments, 1);
    for interval_s in [0.0, -1.0, f64::NAN] {
        assert!(short.spectrum().density(Sides::One, interval_s, 0).is_none());
        assert!(lines(&short, interval_s).is_empty());
    }
}

/// After 65 536 places one segment in four is taken.
#[test]
fn segments_are_spaced_by_the_samples_or_by_all_places() {
    let segments = |mut signal: ChannelSignal| {
        signal.gap(Some(65_536));
        signal.push(&white(8192));
        signal.spectrum().density(Sides::One, INTERVAL_S, 0).unwrap().segments
    };
    let by_samples = ChannelSignal::new(&SpectrumPlan::new());
    let mut by_places = by_samples.clone();
    by_places.count_missing();
    assert_eq!((segments(by_samples), segments(by_places)), (31, 8));
}

#[test]
fn a_constant_has_no_line_and_no_noise() {
    let constant = signal(&[-9813; 5000]);
    let density = constant.spectrum().density(Sides::One, INTERVAL_S, 3).unwrap();
    assert!(density.points_unit2_hz.iter().all(|point| *point == 0.0));
    assert_eq!(constant.narrow_bands(1.0, INTERVAL_S), []);
}

#[test]
fn a_line_has_its_frequency_amplitude_and_share() {
    // standard deviation 100, and a sine with the amplitude 50
    for (frequency_hz, interval_s) in [(7.3, 0.025), (18.4, 0.025), (0.21, 1.0), (61.7, 0.005)] {
        let found = only(&signal(&with_sine(&white(100_000), 50.0, frequency_hz * interval_s)), interval_s);
        assert!((found.frequency_hz / frequency_hz - 1.0).abs() < 1e-3, "{found:?} at {frequency_hz} Hz");
        assert!((found.amplitude / 50.0 - 1.0).abs() < 0.05, "{found:?}");
        assert!((found.share_of_variance / (1250.0 / 11_250.0) - 1.0).abs() < 0.1, "{found:?}");
    }
}

#[test]
fn a_line_above_half_the_rate_is_at_its_alias() {
    // sampled at 40 Hz, 51.6 Hz is at 11.6
    let found = only(&signal(&with_sine(&white(50_000), 50.0, 51.6 * INTERVAL_S)), INTERVAL_S);
    assert!((found.frequency_hz - 11.6).abs() < 0.01, "{found:?}");
}

#[test]
fn a_late_line_in_a_long_record_is_found() {
    let mut counts = white(720_000);
    let late = 600_000;
    let shaken = with_sine(&counts[late..], 50.0, 7.3 * INTERVAL_S);
    counts.splice(late.., shaken);
    assert!((only(&signal(&counts), INTERVAL_S).frequency_hz - 7.3).abs() < 0.02);
}

#[test]
fn long_records_take_few_segments_which_average_as_well() {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    let part = white(32_768);
    let (mut least, mut before) = (f64::INFINITY, 0);
    for parts in 1..=256_u64 {
        signal.push(&part);
        let density = signal.spectrum().density(Sides::One, INTERVAL_S, 0).unwrap();
        least = least.min(density.averages);
        if parts.is_power_of_two() {
            assert!(density.segments - before <= 128, "{} more in {parts} parts", density.segments - before);
            before = density.segments;
        }
    }
    assert!(least > 118.0, "{least}");
}

#[test]
fn no_segment_lacks_a_sample_or_reaches_across_a_break() {
    let counts = white(4000);
    for missing in [Some(0), Some(77), None] {
        let mut signal = ChannelSignal::new(&SpectrumPlan::new());
        let (mut end, mut short) = (0_usize, 0);
        for part in counts.chunks(500) {
            signal.push(part);
            signal.gap(missing);
            // after a break, from the next possible start of a long segment on
            let is_break = missing.is_none_or(|missing| missing == 0);
            let first = end.next_multiple_of(if is_break { 256 } else { 64 });
            short += (first..=end + part.len() - 128).step_by(64).count() as u64;
            end += part.len() + missing.unwrap_or(0) as usize;
        }
        // no long segment fits
        let density = signal.spectrum().density(Sides::One, INTERVAL_S, 0).unwrap();
        assert_eq!((density.segment_samples, density.segments), (128, short), "{missing:?}");
    }
}

#[test]
fn endless_gaps_leave_densities_unchanged() {
    // a line lost after each 300, for as long as 40 hours at 40 Hz
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    let counts = white(300);
    for _ in 0..20_000 {
        signal.push(&counts);
        signal.gap(Some(1));
    }
    let density = signal.spectrum().density(Sides::One, 1.0, 0).unwrap();
    assert!(density.segments < 6000, "{}", density.segments);
    let once = self::signal(&counts).spectrum().density(Sides::One, 1.0, 0).unwrap();
    let sum = |density: &imu_noise::Density| density.points_unit2_hz.iter().sum::<f64>();
    assert!((sum(&density) / sum(&once) - 1.0).abs() < 0.02, "{} {}", sum(&density), sum(&once));
}

#[test]
fn samples_after_a_long_gap_have_no_greater_weight() {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    signal.push(&white(20_000));
    signal.gap(Some(100_000_000));
    signal.push(&with_sine(&white(10_000), 50.0, 7.3 * INTERVAL_S));
    let density = signal.spectrum().density(Sides::One, INTERVAL_S, 0).unwrap();
    assert_eq!(density.segments, 77 + 37);
    // a third of the power of the line
    let found = only(&signal, INTERVAL_S);
    assert!((found.amplitude / (50.0 / 3_f64.sqrt()) - 1.0).abs() < 0.05, "{found:?}");
}

fn lines(signal: &ChannelSignal, interval_s: f64) -> Vec<SpectralLine> {
    signal.narrow_bands(1.0, interval_s).iter().filter_map(|band| band.line).collect()
}

fn only(signal: &ChannelSignal, interval_s: f64) -> SpectralLine {
    let lines = lines(signal, interval_s);
    assert_eq!(lines.len(), 1, "{lines:?}");
    lines[0]
}

#[test]
fn cycles_of_seconds_and_of_minutes_are_found_in_hours() {
    // standard deviation 100; from the sums of 32 samples and of 1024
    let (samples, periods, amplitudes) = (400_000, [480.0, 16_000.0], [10.0, 20.0]);
    let cycles = |i: usize| -> f64 {
        let of = |(period, amplitude): (&f64, f64)| amplitude * (TAU * i as f64 / period).sin();
        periods.iter().zip(amplitudes).map(of).sum()
    };
    let counts: Vec<i32> = white(samples).iter().zip(0..).map(|(x, i)| x + cycles(i).round() as i32).collect();
    let whole = signal(&counts);
    let found = lines(&whole, INTERVAL_S);
    let [slow, fast] = &found[..] else { panic!("{found:?}") };
    for (line, (period, amplitude)) in [fast, slow].into_iter().zip(periods.into_iter().zip(amplitudes)) {
        assert!((line.frequency_hz * period * INTERVAL_S - 1.0).abs() < 0.02, "{line:?}");
        assert!((line.amplitude / amplitude - 1.0).abs() < 0.1, "{line:?}");
        assert!((line.share_of_variance / (amplitude * amplitude / 2e4) - 1.0).abs() < 0.2, "{line:?}");
    }
    assert_eq!(whole.narrow_bands(1.0, INTERVAL_S).len(), 2);
    // a loss leaves no segment of the fast spectra complete, and removes a few windows from a sum of 1024
    let mut lossy = ChannelSignal::new(&SpectrumPlan::new());
    for part in counts.chunks(2000) {
        lossy.push(&part[150..]);
        lossy.gap(Some(150));
    }
    let near = |line: &SpectralLine| (line.frequency_hz / slow.frequency_hz - 1.0).abs() < 0.02;
    assert_eq!(lines(&lossy, INTERVAL_S).iter().filter(|line| near(line)).count(), 1);
}

fn signal(counts: &[i32]) -> ChannelSignal {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    signal.push(counts);
    signal
}

fn with_sine(counts: &[i32], amplitude: f64, cycles_per_sample: f64) -> Vec<i32> {
    let sine = |i: usize| (amplitude * (TAU * cycles_per_sample * i as f64).sin()).round() as i32;
    counts.iter().enumerate().map(|(i, count)| count + sine(i)).collect()
}

/// Nearly normal counts with the standard deviation 100: sums of twelve uniform numbers.
fn white(samples: usize) -> Vec<i32> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut uniform = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..samples).map(|_| (100.0 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)).round() as i32).collect()
}

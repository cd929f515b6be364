//! Tests of the components: each has its true value, alone and in the sum.

use std::{
    collections::HashSet,
    f64::consts::{LN_2, PI},
};

use rand::Rng;

use super::*;

/// Tolerance of a test in standard deviations; the seeds are fixed, so it never fails by chance.
const SIGMAS: f64 = 4.5;

fn stream(noise: &NoiseTruth, rate_hz: u32, seed: u64) -> ChannelStream {
    ChannelStream::new(noise, AveragingWindow::None, NonZeroU32::new(rate_hz).unwrap(), seed, 0)
}

fn samples(noise: &NoiseTruth, rate_hz: u32, seed: u64, n: usize) -> Vec<f64> {
    let mut stream = stream(noise, rate_hz, seed);
    (0..n).map(|_| stream.next_sample()).collect()
}

/// Fully overlapping Allan variance at averaging factor m.
fn avar(values: &[f64], m: usize) -> f64 {
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, value| {
        *sum += value;
        Some(*sum)
    }));
    let squares = (0..=values.len() - 2 * m).map(|i| (sums[i + 2 * m] - 2.0 * sums[i + m] + sums[i]).powi(2));
    squares.sum::<f64>() / ((values.len() - 2 * m + 1) as f64 * 2.0 * (m * m) as f64)
}

/// Mean of the Allan variances of several seeds at octave m.
fn mean_avar(records: &[Vec<f64>], m: usize) -> f64 {
    records.iter().map(|record| avar(record, m)).sum::<f64>() / records.len() as f64
}

fn assert_within(found: f64, expected: f64, edf: f64, what: &str) {
    // a chi-square with edf degrees of freedom varies by sqrt(2/edf) of itself
    let tolerance = SIGMAS * (2.0 / edf).sqrt();
    let relative = found / expected - 1.0;
    assert!(relative.abs() < tolerance, "{what}: {relative} of the truth, allowed {tolerance}");
}

#[test]
fn white_is_n_over_sqrt_tau() {
    let noise = NoiseTruth { white_density: 2e-3, ..NoiseTruth::default() };
    let n = 1 << 18;
    let record = samples(&noise, 40, 1, n);
    for m in [1, 4, 64, 1024] {
        let tau_s = m as f64 / 40.0;
        // edf of white noise is at least n/m times 2/3 (NIST SP 1065, 5.4.1)
        assert_within(avar(&record, m), 4e-6 / tau_s, n as f64 / m as f64 / 1.5, &format!("m {m}"));
    }
}

#[test]
fn walk_is_k_sqrt_tau_over_3() {
    let noise = NoiseTruth { random_walk: 1e-3, ..NoiseTruth::default() };
    let n = 1 << 14;
    let records: Vec<_> = (0..32).map(|seed| samples(&noise, 40, seed, n)).collect();
    assert_eq!(records[0][0], 0.0);
    for m in [1, 2, 8, 64, 512] {
        let factor = m as f64;
        // sampled: K²τ/3 · (1 + 1/2m²)
        let expected = 1e-6 * factor / 40.0 / 3.0 * (1.0 + 0.5 / (factor * factor));
        // disjoint pairs of blocks are nearly independent
        assert_within(mean_avar(&records, m), expected, 32.0 * n as f64 / factor / 2.0, &format!("m {m}"));
    }
}

#[test]
fn flicker_is_flat_from_a_minute_to_a_day() {
    let noise = NoiseTruth { bias_instability: 3.0, ..NoiseTruth::default() };
    let n = 1 << 20;
    let seeds = 8;
    let records: Vec<_> = (0..seeds).map(|seed| samples(&noise, 1, seed, n)).collect();
    for m in (6..=17).map(|octave| 1 << octave) {
        let (n, m_) = (n as f64, m as f64);
        // edf of flicker, overlapping (Howe, Allan and Barnes, 1981)
        let edf = seeds as f64 * 5.0 * n * n / (4.0 * m_ * (n + 3.0 * m_));
        assert_within(mean_avar(&records, m), 9.0 * 2.0 * LN_2 / PI, edf, &format!("m {m}"));
    }
}

#[test]
fn ramp_is_r_tau_over_sqrt_2() {
    let noise = NoiseTruth { mean: 5.0, ramp: 1e-3, ..NoiseTruth::default() };
    let record = samples(&noise, 40, 1, 4096);
    assert_eq!(record[0], 5.0);
    for m in [1, 16, 256] {
        let tau_s = m as f64 / 40.0;
        let relative = avar(&record, m).sqrt() / (1e-3 * tau_s / 2.0_f64.sqrt());
        assert!((relative - 1.0).abs() < 1e-6, "m {m}: {relative}");
    }
}

#[test]
fn line_has_its_frequency_and_amplitude_and_a_phase_of_the_seed() {
    let line = Vibration { amplitude: 0.5, frequency_hz: 3.7 };
    let noise = NoiseTruth { lines: vec![line], ..NoiseTruth::default() };
    let record = samples(&noise, 40, 1, 1 << 16);
    for m in [1, 2, 3, 7, 20] {
        let (f, m_) = (PI * line.frequency_hz / 40.0, m as f64);
        let expected = line.amplitude * (f * m_).sin().powi(2) / (m_ * f.sin());
        // the record does not end with a whole period
        let relative = avar(&record, m).sqrt() / expected;
        assert!((relative - 1.0).abs() < 1e-3, "m {m}: {relative}");
    }
    assert_ne!(record[0], samples(&noise, 40, 2, 1)[0]);
}

#[test]
fn components_do_not_disturb_each_other() {
    let nothing = NoiseTruth::default();
    let line = |amplitude, frequency_hz| Vibration { amplitude, frequency_hz };
    let parts = [
        NoiseTruth { mean: 3.0, ..nothing.clone() },
        NoiseTruth { white_density: 0.1, ..nothing.clone() },
        NoiseTruth { bias_instability: 0.2, ..nothing.clone() },
        NoiseTruth { random_walk: 0.3, ..nothing.clone() },
        NoiseTruth { ramp: -0.4, ..nothing.clone() },
        NoiseTruth { processes: vec![GaussMarkov { correlation_time_s: 0.4, sigma: 0.6 }], ..nothing.clone() },
        NoiseTruth { lines: vec![line(0.5, 1.3), line(0.2, 9.1)], ..nothing.clone() },
    ];
    let all = NoiseTruth {
        mean: 3.0,
        white_density: 0.1,
        bias_instability: 0.2,
        random_walk: 0.3,
        ramp: -0.4,
        processes: parts[5].processes.clone(),
        lines: parts[6].lines.clone(),
        resolution: 0.0,
    };
    let mut parts = parts.map(|part| stream(&part, 40, 9));
    for found in samples(&all, 40, 9, 1000) {
        let sum: f64 = parts.iter_mut().map(ChannelStream::next_sample).sum();
        assert!((found - sum).abs() < 1e-12, "{found} {sum}");
    }
}

#[test]
fn every_component_of_every_channel_has_its_own_stream() {
    let mut seen = HashSet::new();
    for channel in 0..12 {
        use NoiseComponent::{Flicker, LinePhase, Processes, TurnOnBias, Walk, White};
        for component in [White, Flicker, Walk, LinePhase, TurnOnBias, Processes] {
            assert!(seen.insert(random_stream(1, channel, component).next_u64()));
        }
    }
}

#[test]
fn silence_is_zero() {
    assert_eq!(samples(&NoiseTruth::default(), 200, 1, 10), [0.0; 10]);
}

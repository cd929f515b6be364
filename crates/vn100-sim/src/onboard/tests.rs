//! Tests of the window: correlation between neighbours, and the density of the output.

use super::*;
use rand::SeedableRng;

/// Tolerance of a test in standard deviations; the seeds are fixed, so it never fails by chance.
const SIGMAS: f64 = 4.5;

fn white(window: AveragingWindow, rate_hz: u32, samples: usize) -> Vec<f64> {
    let rng = ChaCha8Rng::seed_from_u64(7);
    let mut white = White::new(1.0, window, NonZeroU32::new(rate_hz).unwrap(), rng);
    let mut next = || {
        white.advance();
        white.mean()
    };
    (0..samples).map(|_| next()).collect()
}

/// The window of a channel at the factory default.
fn delivered(channel: usize) -> AveragingWindow {
    crate::Profile::datasheet().channels[channel].window
}

fn boxcar(samples: u32) -> AveragingWindow {
    AveragingWindow::Boxcar { refresh_hz: 800, samples, low_pass: LowPass::NONE }
}

fn autocorrelation(values: &[f64], lag: usize) -> f64 {
    let products = |lag: usize| -> f64 { values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum() };
    products(lag) / products(0)
}

/// Density at m = 64 from disjoint pairs of neighbouring means, and its relative standard
/// deviation: the squares of n independent differences vary by sqrt(2/n), their root by half.
fn apparent_density(values: &[f64], rate_hz: f64) -> (f64, f64) {
    let m = 64;
    let means: Vec<f64> = values.chunks_exact(m).map(|block| block.iter().sum::<f64>() / m as f64).collect();
    let pairs = means.chunks_exact(2);
    let n = pairs.len() as f64;
    let avar = pairs.map(|pair| (pair[1] - pair[0]).powi(2) / 2.0).sum::<f64>() / n;
    ((avar * m as f64 / rate_hz).sqrt(), (2.0 / n).sqrt() / 2.0)
}

#[test]
fn boxcar_correlates_neighbours() {
    let n = 400_000;
    for (rate_hz, samples, expected) in
        [(800, 4, [0.75, 0.5, 0.25, 0.0, 0.0]), (200, 4, [0.0; 5]), (200, 20, [0.8, 0.6, 0.4, 0.2, 0.0])]
    {
        let values = white(boxcar(samples), rate_hz, n);
        // Bartlett: far from lag 0 the variance is (1 + 2 sum of squared correlations)/n, near it less
        let squares: f64 = expected.iter().map(|r: &f64| r * r).sum();
        let tolerance = SIGMAS * ((1.0 + 2.0 * squares) / n as f64).sqrt();
        for (lag, expected) in (1..).zip(expected) {
            let found = autocorrelation(&values, lag);
            let what = format!("{samples} samples at {rate_hz} Hz, lag {lag}: {found}");
            assert!((found - expected).abs() < tolerance, "{what}");
        }
    }
}

/// One second of a real sensor with firmware 3.1, with the factory default of the window.
#[test]
fn neighbours_are_correlated_as_in_a_real_sensor() {
    for (window, measured) in
        [(delivered(9), [0.83, 0.49, 0.17, -0.02, -0.05]), (delivered(6), [0.86, 0.60, 0.35, 0.14, 0.08])]
    {
        let values = white(window, 800, 400_000);
        for (lag, measured) in (1..).zip(measured) {
            let found = autocorrelation(&values, lag);
            // one standard deviation of 800 such samples
            assert!((found - measured).abs() < 0.066, "{window:?}, lag {lag}: {found}, measured {measured}");
        }
    }
}

#[test]
fn density_rises_by_aliasing() {
    for (rate_hz, window, factor) in [
        (200, boxcar(4), 1.0),
        (100, boxcar(4), 2.0_f64.sqrt()),
        (40, boxcar(4), 5.0_f64.sqrt()),
        (40, boxcar(20), 1.0),
        (40, delivered(9), 2.307),
        (40, delivered(6), 2.082),
        (200, delivered(9), 1.0),
        (800, delivered(6), 1.0),
        (40, AveragingWindow::None, 1.0),
        (40, delivered(3), 6.25_f64.sqrt()),
        (200, delivered(3), 1.25_f64.sqrt()),
    ] {
        let values = white(window, rate_hz, 800_000);
        let (density, deviation) = apparent_density(&values, f64::from(rate_hz));
        let relative = density / factor - 1.0;
        assert!(relative.abs() < SIGMAS * deviation, "{rate_hz} Hz {window:?}: {density}");
    }
}

#[test]
fn output_faster_than_the_refresh_repeats() {
    let values = white(delivered(3), 800, 3200);
    let changes = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
    // 5 refreshes in 16 samples: 1000 in total, but the first or the last may fall outside
    assert!((999..=1000).contains(&changes), "{changes}");
}

#[test]
fn a_window_of_zero_is_a_window_of_one() {
    let one = AveragingWindow::Boxcar { refresh_hz: 250, samples: 1, low_pass: LowPass::NONE };
    let one = white(one, 40, 100);
    assert_eq!(white(delivered(3), 40, 100), one);
}

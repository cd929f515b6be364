//! Disturbances of about a second: a slammed door, steps, a bumped table.

use super::chi_squared;
use crate::accumulate::blocks::WINDOW;
use crate::accumulate::signal::ChannelSignal;
use crate::accumulate::window_statistics::{Magnitudes, PeakWindows, WindowStatistics};
use schemars::JsonSchema;
use serde::Serialize;

/// Probability that a clean record of twelve channels shows a disturbance of one of the two kinds.
const FALSE_ALARM: f64 = 1e-4;

/// For the uncertainty of the usual size and for tails somewhat heavier than Gaussian.
const MARGIN: f64 = 1.15;

const MIN_WINDOWS: u32 = 64;

/// Disturbances this many windows apart are one.
const JOINED_WINDOWS: u64 = 2;

/// Quantile of |z| = 0.6745 and 1.6449 of a standard normal variable.
const HALF: (f64, f64) = (0.5, 0.674_490);
const NINE_TENTHS: (f64, f64) = (0.9, 1.644_854);

/// Quantiles of a normal variable one and two standard deviations above its median.
const ONE_ABOVE: f64 = 0.841_345;
const TWO_ABOVE: f64 = 0.977_250;

/// Growth of the logarithm of the spread from one to two standard deviations in normal noise.
const NORMAL_GROWTH: f64 = 0.23;

/// By how much of what it grows more, times the logarithm of the number of windows over the false
/// alarms, a disturbance must stand higher.
const HEAVY_TAIL: f64 = 0.22;

/// A short interval that the rest of the record does not explain.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Disturbance {
    /// Start in seconds of data from the first sample, to a window of 32 samples.
    pub start_s: f64,
    /// End in seconds of data.
    pub end_s: f64,
    /// How far out the worst window is, in standard deviations of the usual windows.
    pub sigmas: f64,
}

impl ChannelSignal {
    /// Short intervals that the rest of the record does not explain, in time order, at most 32: see
    /// [`Disturbance`]. Empty below 64 windows of 32 samples.
    pub fn disturbances(&self, interval_s: f64) -> Vec<Disturbance> {
        let windows = &self.windows;
        let mut found: Vec<_> = windows.changed_means().chain(windows.changed_spreads()).collect();
        found.sort_by_key(|(stretch, _)| stretch.first_window);
        let mut joined: Vec<(PeakWindows, f64)> = Vec::new();
        for (stretch, sigmas) in found {
            match joined.last_mut() {
                Some((before, most)) if stretch.first_window <= before.last_window + 1 + JOINED_WINDOWS => {
                    before.last_window = before.last_window.max(stretch.last_window);
                    *most = most.max(sigmas);
                }
                _ => joined.push((stretch, sigmas)),
            }
        }
        let window_s = WINDOW as f64 * interval_s;
        let disturbance = |(stretch, sigmas): (PeakWindows, f64)| Disturbance {
            start_s: stretch.first_window as f64 * window_s,
            end_s: (stretch.last_window + 1) as f64 * window_s,
            sigmas,
        };
        joined.into_iter().map(disturbance).collect()
    }
}

impl WindowStatistics {
    fn changed_means(&self) -> impl Iterator<Item = (PeakWindows, f64)> {
        let deviation = [HALF, NINE_TENTHS].map(|(p, deviate)| self.changes.quantile(p).map(|size| size / deviate));
        let usual = deviation.into_iter().flatten().reduce(f64::max);
        // Half of the false alarms on either side.
        let threshold = threshold(self.changes.total, FALSE_ALARM / 2.0);
        outliers(&self.changes, threshold, move |size| {
            // Nothing below a mean of one count is a disturbance: noise below the last digit shows up in jumps.
            (size > WINDOW as f64).then_some(size / usual?)
        })
    }

    fn changed_spreads(&self) -> impl Iterator<Item = (PeakWindows, f64)> {
        // The cube root of a variance is nearly normal (Wilson and Hilferty, 1931).
        let root = |p: f64| self.spreads.quantile(p).map(f64::cbrt);
        let tests = f64::from(self.spreads.total) * chi_squared::CHANNELS;
        let usual = root(0.5).zip(root(ONE_ABOVE)).zip(root(TWO_ABOVE)).map(|((median, one), two)| {
            // That of independent samples; correlated ones vary more.
            let least = median * (2.0 / (9.0 * (WINDOW - 1) as f64)).sqrt();
            let deviation = (one - median).max((two - median) / 2.0).max(least);
            // Heavy tails fall exponentially with the logarithm.
            let growth = 3.0 * (two / one).ln() - NORMAL_GROWTH;
            (median, deviation * (HEAVY_TAIL * growth.max(0.0) * (tests / FALSE_ALARM).ln()).exp())
        });
        outliers(&self.spreads, threshold(self.spreads.total, FALSE_ALARM), move |spread| {
            let (median, deviation) = usual?;
            // As above, a standard deviation of one count.
            (spread > (WINDOW * (WINDOW - 1)) as f64).then_some((spread.cbrt() - median) / deviation)
        })
    }
}

/// Sigmas that the largest of `windows` windows exceeds with probability `false_alarm`.
fn threshold(windows: u32, false_alarm: f64) -> Option<f64> {
    let tests = f64::from(windows) * chi_squared::CHANNELS;
    (windows >= MIN_WINDOWS).then(|| -MARGIN * chi_squared::normal_quantile(false_alarm / tests))
}

fn outliers(
    magnitudes: &Magnitudes,
    threshold: Option<f64>,
    sigmas: impl Fn(f64) -> Option<f64>,
) -> impl Iterator<Item = (PeakWindows, f64)> {
    magnitudes.highest().into_iter().filter_map(move |stretch| {
        let sigmas = sigmas(stretch.peak)?;
        (sigmas > threshold?).then_some((stretch, sigmas))
    })
}

//! The rates that a sensor has, and the evidence that samples arrive at another one of them.

/// The number of samples that are needed to show a rate.
pub(super) const RUN: usize = 32;

/// Relative error of the rate of a [`RUN`] of samples, far above that of a clock.
pub(super) const LISTED_TOLERANCE: f64 = 0.01;

/// Periods by which an interval may differ from a whole number of periods.
pub(super) const WHOLE_TOLERANCE: f64 = 0.2;

/// The factor above its fastest rate at which samples cannot come from a sensor. Chosen.
pub(super) const TOO_FAST: f64 = 1.25;

/// A higher rate is above the present one by at least this factor, which is less than the smallest
/// step between rates of a sensor; a lower rate is below it by at least the second factor.
const HIGHER: f64 = 1.1;
const LOWER: f64 = 0.9;

/// Early samples after which their rate counts, listed or not: no backlog is so long. Chosen.
const MANY_EARLY: usize = 16 * RUN;

/// The rates of a sensor in Hz; empty for any sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SensorRates(pub(super) &'static [f64]);

impl SensorRates {
    /// The fastest rate in Hz; infinite if none is listed.
    pub(super) fn fastest(self) -> f64 {
        self.0.iter().copied().max_by(f64::total_cmp).unwrap_or(f64::INFINITY)
    }

    /// The listed rate nearest to a measured one, if within the relative tolerance.
    pub(super) fn nearest(self, measured_hz: f64, tolerance: f64) -> Option<f64> {
        let distance = |rate_hz: f64| (measured_hz / rate_hz - 1.0).abs();
        let nearest = self.0.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
        (distance(nearest) <= tolerance).then_some(nearest)
    }

    /// The higher rate in Hz at which early samples arrive: a rate of the sensor, or any other
    /// after too many of them for a backlog.
    pub(super) fn higher(self, stamps_s: &[f64], period_s: f64) -> Option<f64> {
        let hz = mean_hz(stamps_s)?;
        let half_hz = mean_hz(&stamps_s[stamps_s.len() / 2..])?;
        if stamps_s.len() < 2 * RUN || hz * period_s < HIGHER {
            return None;
        }
        let listed_hz = self.nearest(hz, LISTED_TOLERANCE);
        let is_listed = listed_hz.is_some() && listed_hz == self.nearest(half_hz, 3.0 * LISTED_TOLERANCE);
        let is_any = self.0.is_empty() && near(stamps_s, hz, 0.5 * WHOLE_TOLERANCE) >= 0.9;
        if is_listed { listed_hz } else { (is_any || stamps_s.len() >= MANY_EARLY).then_some(hz) }
    }

    /// The rate in Hz of early samples after which none follows, if no sensor is so fast.
    pub(super) fn too_fast(self, stamps_s: &[f64]) -> Option<f64> {
        let is_backlog = stamps_s.len() < 4 * RUN;
        mean_hz(stamps_s).filter(|hz| !is_backlog && *hz > TOO_FAST * self.fastest())
    }

    /// The lower rate in Hz at which late samples arrive evenly: a rate of the sensor, or any rate if the
    /// present one is not confirmed yet. Samples missing at random leave no even intervals.
    pub(super) fn lower(self, stamps_s: &[f64], period_s: f64, is_unconfirmed: bool) -> Option<f64> {
        let hz = mean_hz(stamps_s).filter(|hz| hz * period_s < LOWER)?;
        let listed_hz = self.nearest(hz, LISTED_TOLERANCE);
        let is_even = near(stamps_s, hz, WHOLE_TOLERANCE) >= 0.75;
        let is_exact = near(stamps_s, hz, 0.5 * WHOLE_TOLERANCE) >= 0.9;
        let may_be_other = is_unconfirmed || self.0.is_empty();
        listed_hz.filter(|_| is_even).or_else(|| (may_be_other && is_exact).then_some(hz))
    }
}

/// The share of the intervals within this many periods of a single one.
pub(super) fn near(stamps_s: &[f64], hz: f64, within: f64) -> f64 {
    let single = stamps_s.windows(2).filter(|pair| ((pair[1] - pair[0]) * hz - 1.0).abs() < within).count();
    single as f64 / (stamps_s.len() - 1) as f64
}

/// The rate from the first and the last stamp; infinite if no time passes between them, and `None`
/// below two stamps.
pub(super) fn mean_hz(stamps_s: &[f64]) -> Option<f64> {
    let (first_s, last_s) = (stamps_s.first()?, stamps_s.last()?);
    (stamps_s.len() > 1).then(|| (stamps_s.len() - 1) as f64 / (last_s - first_s))
}

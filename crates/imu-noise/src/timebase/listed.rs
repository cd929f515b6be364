//! The rates a sensor has, as a list that may be empty.

/// Above the sensor's fastest rate by this factor, lines come from no sensor.
pub(super) const TOO_FAST: f64 = 1.25;

/// The sensor's fastest rate in Hz; no limit when none is listed.
pub(super) fn fastest(rates_hz: &[f64]) -> f64 {
    let fastest_hz = rates_hz.iter().copied().max_by(f64::total_cmp);
    fastest_hz.unwrap_or(f64::INFINITY)
}

/// The rate of the list nearest to a measured one, if within the tolerance.
pub(super) fn snap(rates_hz: &[f64], measured_hz: f64, tolerance: f64) -> Option<f64> {
    let distance = |rate_hz: f64| (measured_hz / rate_hz - 1.0).abs();
    let nearest = rates_hz.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
    (distance(nearest) <= tolerance).then_some(nearest)
}

//! The ticks of the sensor's clock, and the period of its samples in them.

use super::super::whole_steps::single_step;

/// The sensor measures 800 times per second, and sends every n-th of these measurements (VN-100
/// User Manual, register 75).
const TICK_NS: f64 = 1_250_000.0;

/// The fraction of a tick by which an interval may differ from whole ticks, and the relative error of
/// the mean tick. Chosen: four times the error over 31 intervals with the jitter of a real sensor, a
/// fortieth of a tick.
const TICK_TOLERANCE: f64 = 0.1;
const MEAN_TICK_TOLERANCE: f64 = 0.005;

/// The number of ticks in an interval, at least one; `None` if it is not a whole number.
pub(super) fn whole_ticks(interval_ns: u64) -> Option<u64> {
    let ticks = interval_ns as f64 / TICK_NS;
    let whole = ticks.round();
    ((ticks - whole).abs() <= TICK_TOLERANCE && whole >= 1.0).then_some(whole as u64)
}

/// The nearest whole number of ticks, in nanoseconds.
pub(super) fn round_to_ticks(period_ns: f64) -> f64 {
    (period_ns / TICK_NS).round() * TICK_NS
}

/// The period in nanoseconds of these intervals, which must not be zero; `None` if there are none.
/// Whole ticks if the sum of the intervals is a whole number of ticks.
pub(super) fn period_ns(intervals: impl Iterator<Item = u64> + Clone) -> Option<f64> {
    let mean_ns = single_step(intervals.clone())?;
    let ticks_of = |ns: f64| (ns / TICK_NS).round();
    let (all_ns, all_ticks) =
        intervals.fold((0.0, 0.0), |(all_ns, ticks), ns| (all_ns + ns as f64, ticks + ticks_of(ns as f64)));
    let ticks = ticks_of(mean_ns);
    let is_whole = ticks >= 1.0
        && (mean_ns / TICK_NS - ticks).abs() <= TICK_TOLERANCE
        && (all_ns / (all_ticks * TICK_NS) - 1.0).abs() <= MEAN_TICK_TOLERANCE;
    Some(if is_whole { ticks * TICK_NS } else { mean_ns })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_within_a_tenth_of_a_tick_are_whole_ticks() {
        let of = [0, 100_000, 1_130_000, 1_250_000, 1_800_000, 25_000_000, 25_120_000, 25_130_000];
        assert_eq!(of.map(whole_ticks), [None, None, Some(1), Some(1), None, Some(20), Some(20), None]);
    }
}

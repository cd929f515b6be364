//! The rate of the first lines, from their intervals and from their stretches.

use super::stretches::Stretch;

/// An interval this near to a whole number of periods, in periods, is taken for that many.
const WHOLE_TOLERANCE: f64 = 0.2;

/// Fewest intervals that are not whole by chance.
const LEAST_WHOLE: usize = 31;

/// Intervals of more median ones are pauses: they say nothing of the period.
const LONGEST_MEDIANS: f64 = 16.0;

/// Periods by which the ends of stretches may be late against each other: reads delay each by less
/// than one, jitter by some more.
const BENT_PERIODS: f64 = 1.5;

/// A measured rate is rounded by no more than this part, the error of a good clock.
const ROUNDING: f64 = 50e-6;

/// The rate of lines that come alone, lost ones counted: half the intervals at least are one
/// period, nine in ten a whole number of them. Bunched lines have none.
pub(super) fn steady(stamps_s: &[f64]) -> Option<f64> {
    let mut intervals_s: Vec<f64> = stamps_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let lower_middle = intervals_s.len().checked_sub(1)? / 2;
    let median_s = *intervals_s.select_nth_unstable_by(lower_middle, f64::total_cmp).1;
    if median_s <= 0.0 {
        return None;
    }
    intervals_s.retain(|interval_s| *interval_s < LONGEST_MEDIANS * median_s);
    let single = |interval_s: &&f64| (*interval_s / median_s - 1.0).abs() < WHOLE_TOLERANCE;
    let singles = intervals_s.iter().filter(single).count();
    let single_s = intervals_s.iter().filter(single).sum::<f64>() / singles as f64;
    let (mut span_s, mut periods, mut whole) = (0.0, 0.0, 0);
    for interval_s in &intervals_s {
        let near = (interval_s / single_s).round();
        span_s += interval_s;
        periods += near;
        if near >= 1.0 && (interval_s / single_s - near).abs() < WHOLE_TOLERANCE {
            whole += 1;
        }
    }
    let is_steady = 2 * singles >= intervals_s.len() && 10 * whole >= 9 * intervals_s.len();
    is_steady.then(|| periods / span_s)
}

/// The lowest of these rates at which the lines that come are [`whole`](is_whole). By chance four
/// in ten intervals are.
pub(super) fn whole(stamps_s: &[f64], rates_hz: &[f64]) -> Option<f64> {
    let rates_hz = rates_hz.iter().copied().filter(|_| stamps_s.len() > LEAST_WHOLE);
    rates_hz.filter(|hz| is_whole(stamps_s, *hz)).min_by(f64::total_cmp)
}

/// Whether nine in ten intervals are whole periods of this rate, and one in twenty at least a
/// single one: more than half of the lines may be lost, but those that come must come alone.
pub(super) fn is_whole(stamps_s: &[f64], hz: f64) -> bool {
    let (mut intervals, mut whole, mut single) = (0, 0, 0);
    for pair in stamps_s.windows(2) {
        let periods = (pair[1] - pair[0]) * hz;
        let near = periods.round();
        intervals += 1;
        if near >= 1.0 && (periods - near).abs() < WHOLE_TOLERANCE {
            whole += 1;
            single += usize::from(near == 1.0);
        }
    }
    single > 0 && 20 * single >= intervals && 10 * whole >= 9 * intervals
}

/// The rate of stretches that follow each other without a loss: all their ends lie near one
/// straight line, fitted by least squares.
pub(super) fn even(stretches: &[Stretch]) -> Option<f64> {
    if stretches.is_empty() {
        return None;
    }
    let ends = stretches.iter().scan((0.0, 0.0), |(line, at_s), stretch| {
        *line += stretch.intervals as f64;
        *at_s += stretch.span_s;
        Some((*line, *at_s))
    });
    let ends: Vec<(f64, f64)> = std::iter::once((0.0, 0.0)).chain(ends).collect();
    let (mean_line, mean_s) = (mean(ends.iter().map(|end| end.0)), mean(ends.iter().map(|end| end.1)));
    let variance = mean(ends.iter().map(|(line, _)| (line - mean_line).powi(2)));
    let period_s = mean(ends.iter().map(|(line, at_s)| (line - mean_line) * (at_s - mean_s))) / variance;
    let lags_s = ends.iter().map(|(line, at_s)| at_s - line * period_s);
    let (least_s, most_s) =
        lags_s.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), lag_s| (least.min(lag_s), most.max(lag_s)));
    (most_s - least_s <= BENT_PERIODS * period_s).then(|| period_s.recip())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// The shortest decimal near a rate in Hz: more digits would tell of the stamps, not of the sensor.
pub(super) fn rounded(hz: f64) -> f64 {
    let decimals = (0..9).map(|places| {
        let units_per_hz = 10_f64.powi(places);
        (hz * units_per_hz).round() / units_per_hz
    });
    let mut near = decimals.filter(|decimal| (decimal / hz - 1.0).abs() <= ROUNDING);
    near.next().unwrap_or(hz)
}

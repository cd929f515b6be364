//! Estimates of the sample rate from a few stamps: by the single intervals, which dropped samples
//! do not bias, and by the ends of stretches of 32 samples, which bunching does not bias.

/// The number of samples that together show a rate. Bunching shifts the ends of such a stretch by
/// one of 31 periods at most, 3 %: less than [`COARSE_TOLERANCE`], and half of the step between
/// rates of a sensor.
pub(super) const RUN: usize = 32;

/// Relative error of a rate by several stretches or whole intervals: far above that of a clock,
/// below the 5 % by which a reader that drops samples evenly may be near another rate.
pub(super) const LISTED_TOLERANCE: f64 = 0.01;

/// Relative error of a rate by one stretch, see [`RUN`]; also how far a known rate may be off.
pub(super) const COARSE_TOLERANCE: f64 = 0.05;

/// The factor above its fastest rate at which samples cannot be those of a sensor. Chosen.
pub(super) const TOO_FAST: f64 = 1.25;

/// Periods by which an interval may differ from a whole number of periods. Four in ten random
/// intervals do not differ by more.
pub(super) const WHOLE_TOLERANCE: f64 = 0.2;

/// Intervals longer than this many median intervals are pauses and show no period. Chosen.
const PAUSE_MEDIANS: f64 = 16.0;

/// Periods by which the ends of stretches may scatter: a read delays each end by less than one.
const SCATTER_PERIODS: f64 = 1.5;

/// Relative rounding of a measured rate: the error of a good clock.
const ROUNDING: f64 = 50e-6;

/// The sensor's fastest rate in Hz; infinite if none is listed.
pub(super) fn fastest(rates_hz: &[f64]) -> f64 {
    let fastest_hz = rates_hz.iter().copied().max_by(f64::total_cmp);
    fastest_hz.unwrap_or(f64::INFINITY)
}

/// The listed rate nearest to a measured one, if within the relative tolerance.
pub(super) fn snap(rates_hz: &[f64], measured_hz: f64, tolerance: f64) -> Option<f64> {
    let distance = |rate_hz: f64| (measured_hz / rate_hz - 1.0).abs();
    let nearest = rates_hz.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
    (distance(nearest) <= tolerance).then_some(nearest)
}

/// The shortest decimal near a rate in Hz: further digits would only reflect the resolution of the
/// stamps.
pub(super) fn rounded(hz: f64) -> f64 {
    let decimals = (0..9).map(|places| {
        let units_per_hz = 10_f64.powi(places);
        (hz * units_per_hz).round() / units_per_hz
    });
    let mut near = decimals.filter(|decimal| (decimal / hz - 1.0).abs() <= ROUNDING);
    near.next().unwrap_or(hz)
}

/// The rate of samples that arrive singly, with dropped ones counted: at least half of the
/// intervals are one period, and nine in ten a whole number of periods. `None` for bunched samples.
pub(super) fn rate_by_intervals(stamps_s: &[f64]) -> Option<f64> {
    let mut intervals_s: Vec<f64> = stamps_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let lower_middle = intervals_s.len().checked_sub(1)? / 2;
    let median_s = *intervals_s.select_nth_unstable_by(lower_middle, f64::total_cmp).1;
    if median_s <= 0.0 {
        return None;
    }
    intervals_s.retain(|interval_s| *interval_s < PAUSE_MEDIANS * median_s);
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
    let is_single = 2 * singles >= intervals_s.len() && 10 * whole >= 9 * intervals_s.len();
    is_single.then(|| periods / span_s)
}

/// The lowest rate of which the intervals are whole periods; below [`RUN`] samples that may be the
/// case by chance.
pub(super) fn lowest_whole_rate(stamps_s: &[f64], rates_hz: &[f64]) -> Option<f64> {
    let rates_hz = rates_hz.iter().copied().filter(|_| stamps_s.len() >= RUN);
    rates_hz.filter(|hz| is_whole_periods(stamps_s, *hz)).min_by(f64::total_cmp)
}

/// Whether nine in ten intervals are whole periods of this rate, and one in twenty a single period:
/// more than half of the samples may be dropped, but the others must arrive singly.
pub(super) fn is_whole_periods(stamps_s: &[f64], hz: f64) -> bool {
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

/// The rate by the least-squares line through the ends of stretches without a gap.
pub(super) fn rate_by_stretches(stretches: &[RateStretch]) -> Option<f64> {
    if stretches.is_empty() {
        return None;
    }
    let ends = stretches.iter().scan((0.0, 0.0), |(sample, at_s), stretch| {
        *sample += stretch.intervals as f64;
        *at_s += stretch.span_s;
        Some((*sample, *at_s))
    });
    let ends: Vec<(f64, f64)> = std::iter::once((0.0, 0.0)).chain(ends).collect();
    let (mean_sample, mean_s) = (mean(ends.iter().map(|end| end.0)), mean(ends.iter().map(|end| end.1)));
    let variance = mean(ends.iter().map(|(sample, _)| (sample - mean_sample).powi(2)));
    let period_s = mean(ends.iter().map(|(sample, at_s)| (sample - mean_sample) * (at_s - mean_s))) / variance;
    let lags_s = ends.iter().map(|(sample, at_s)| at_s - sample * period_s);
    let (min_s, max_s) =
        lags_s.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), lag_s| (min.min(lag_s), max.max(lag_s)));
    (max_s - min_s <= SCATTER_PERIODS * period_s).then(|| period_s.recip())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RateStretch {
    pub(super) intervals: u64,
    pub(super) span_s: f64,
}

impl RateStretch {
    pub(super) fn hz(self) -> f64 {
        self.intervals as f64 / self.span_s
    }
}

/// Cuts the stream into stretches of [`RUN`] samples or more: each begins and ends with the last
/// sample of a read, where the lag is least, and ends where the next begins.
#[derive(Clone, Debug, Default)]
pub(super) struct StretchCutter {
    /// Number and stamp of the first sample of the present stretch.
    start: Option<(u64, f64)>,
    next: u64,
    previous_s: f64,
}

impl StretchCutter {
    /// Adds a stamp. Returns the stretch that ended with the sample before, if one did.
    pub(super) fn push(&mut self, at_s: f64) -> Option<RateStretch> {
        let (sample, previous_s) = (self.next, self.previous_s);
        self.next += 1;
        self.previous_s = at_s;
        let waited_s = at_s - previous_s;
        let Some((start, start_s)) = self.start else {
            if sample > 0 && waited_s > 0.0 {
                self.start = Some((sample - 1, previous_s));
            }
            return None;
        };
        let intervals = sample - 1 - start;
        let span_s = previous_s - start_s;
        // a wait of less than half a mean interval is not the end of a read
        if intervals < RUN as u64 - 1 || span_s <= 0.0 || waited_s < 0.5 * span_s / intervals as f64 {
            return None;
        }
        self.start = Some((sample - 1, previous_s));
        Some(RateStretch { intervals, span_s })
    }
}

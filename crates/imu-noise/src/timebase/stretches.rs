//! Rates over stretches of 32 lines, and the nominal rate they speak for.

/// Intervals in a stretch, at least.
const STRETCH_INTERVALS: u64 = 31;

/// A measured rate within this part of one the sensor has is taken for it.
pub(super) const SNAP_TOLERANCE: f64 = 0.05;

/// Cuts the stream into stretches of 32 lines, or some more: each begins and ends with the last line of a read, where
/// the lag is least, so that bunching bends its rate by one period in 31 at most.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretches {
    /// Where the present stretch began: its first line's number and stamp.
    start: Option<(u64, f64)>,
    /// Number of the next line.
    line: u64,
    previous_s: f64,
}

impl Stretches {
    /// Adds a line's stamp; the rate in Hz of the stretch that ended with the line before, when one did.
    pub(super) fn push(&mut self, at_s: f64) -> Option<f64> {
        let (line, previous_s) = (self.line, self.previous_s);
        self.line += 1;
        self.previous_s = at_s;
        let waited_s = at_s - previous_s;
        let Some((start, start_s)) = self.start else {
            if line > 0 && waited_s > 0.0 {
                self.start = Some((line - 1, previous_s));
            }
            return None;
        };
        let intervals = line - 1 - start;
        if intervals < STRETCH_INTERVALS {
            return None;
        }
        let span_s = previous_s - start_s;
        if span_s <= 0.0 || waited_s < 0.5 * span_s / intervals as f64 {
            return None;
        }
        self.start = Some((line - 1, previous_s));
        Some(intervals as f64 / span_s)
    }
}

/// The rate of the list nearest to a measured one, if within the tolerance.
pub(super) fn snap(rates_hz: &[f64], measured_hz: f64, tolerance: f64) -> Option<f64> {
    let distance = |rate_hz: f64| (measured_hz / rate_hz - 1.0).abs();
    let nearest = rates_hz.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
    (distance(nearest) <= tolerance).then_some(nearest)
}

/// The 90th percentile (nearest rank) of the rates.
pub(super) fn percentile_90(rates_hz: &[f64]) -> Option<f64> {
    let mut sorted = rates_hz.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (9 * sorted.len()).div_ceil(10);
    sorted.get(rank.checked_sub(1)?).copied()
}

/// The highest of the rates, from `least_hz` up, whose period half of the intervals between these stamps have: the rate
/// of a steady stream that loses lines all the time.
pub(super) fn steady(rates_hz: &[f64], least_hz: f64, stamps_s: &[f64]) -> Option<f64> {
    let fits = |rate_hz: f64| {
        let intervals = stamps_s.windows(2).map(|pair| pair[1] - pair[0]);
        let even = intervals.filter(|interval_s| (interval_s * rate_hz - 1.0).abs() < 0.1);
        2 * even.count() >= stamps_s.len()
    };
    let candidates = rates_hz.iter().copied().filter(|&hz| hz >= least_hz);
    candidates.filter(|&hz| fits(hz)).max_by(f64::total_cmp)
}

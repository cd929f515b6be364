//! Samples that do not follow by one period, until a later sample decides about them.

use std::time::Duration;

use super::{
    super::sensor_rates::RUN,
    ticks::{round_to_ticks, whole_ticks},
};

/// A sample with its time by both clocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamped {
    pub(super) device_ns: u64,
    pub(super) at: Option<Duration>,
}

/// Whether the sample begins a run, or follows it at the same number of ticks as between the samples
/// of the run. `last_ns` is the device time before the run.
pub(super) fn is_continued_by(run: &[Stamped], stamped: Stamped, last_ns: u64) -> bool {
    let (before_ns, latest_ns) = match run {
        [] => return true,
        [only] => (last_ns, only.device_ns),
        [.., before, latest] => (before.device_ns, latest.device_ns),
    };
    let ticks = |from_ns: u64, to_ns: u64| whole_ticks(to_ns.checked_sub(from_ns)?);
    let expected = ticks(before_ns, latest_ns);
    expected.is_some() && ticks(latest_ns, stamped.device_ns) == expected
}

/// The period in nanoseconds of another rate; `None` while a run is too short to show one.
pub(super) fn period_of_run_ns(run: &[Stamped]) -> Option<f64> {
    let (first, latest) = (run.first()?, run.last()?);
    let mean_ns = || (latest.device_ns - first.device_ns) as f64 / (run.len() - 1) as f64;
    (run.len() >= RUN).then(|| round_to_ticks(mean_ns()))
}

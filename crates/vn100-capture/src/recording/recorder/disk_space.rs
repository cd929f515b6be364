//! The time until the disk of a recording is full at the present rate.

use std::{collections::VecDeque, path::Path, time::Duration};

use crate::recording::part::folder_of;

/// Free space that lasts less than this is reported.
const ENOUGH: Duration = Duration::from_secs(3600);

/// The interval between queries of the disk, in time of the stream.
const ASKED_EVERY_NS: u64 = 10_000_000_000;

/// The present rate is the mean over this time.
const PRESENT_NS: i64 = 300_000_000_000;

/// Shortest time between two measurements of the free space that give a rate: file systems write
/// in bursts.
const SHORTEST_NS: i64 = 60_000_000_000;

/// The free space on a disk that will soon be full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LowSpace {
    /// Free bytes on the disk.
    pub free_bytes: u64,
    /// The time until they are used up if they decline as in the last minutes, through any program.
    pub lasts: Duration,
}

/// Watches the disk while a recording grows.
pub(super) struct DiskWatch {
    free_bytes: Box<dyn FnMut() -> Option<u64> + Send>,
    asked_ns: Option<i64>,
    /// The times of the last queries, and the free bytes at each.
    answers: VecDeque<(i64, u64)>,
    low: Option<LowSpace>,
}

impl DiskWatch {
    /// Queries the disk of the file at `path`.
    pub(super) fn of(path: &Path) -> Self {
        // the query is for the folder, because the file may be moved away
        let folder = folder_of(path).to_owned();
        Self::asking(move || free_bytes(&folder))
    }

    /// Uses another source for the number of free bytes; `None` if it is not known.
    pub(super) fn asking(free_bytes: impl FnMut() -> Option<u64> + Send + 'static) -> Self {
        Self { free_bytes: Box::new(free_bytes), asked_ns: None, answers: VecDeque::new(), low: None }
    }

    /// The recording grows at this time: returns the state to be reported.
    pub(super) fn note(&mut self, at_ns: i64) -> Option<LowSpace> {
        // a clock may be set back
        if self.asked_ns.is_none_or(|asked_ns| at_ns.abs_diff(asked_ns) >= ASKED_EVERY_NS) {
            self.asked_ns = Some(at_ns);
            self.low = self.ask(at_ns).filter(|space| space.lasts < ENOUGH);
        }
        self.low
    }

    /// Queries the disk; `None` if its free space does not decline, or has declined for too short a time.
    fn ask(&mut self, at_ns: i64) -> Option<LowSpace> {
        let free_bytes = (self.free_bytes)()?;
        self.answers.retain(|(then_ns, _)| (0..=PRESENT_NS).contains(&at_ns.saturating_sub(*then_ns)));
        self.answers.push_back((at_ns, free_bytes));
        let (first_ns, first_bytes) = self.answers.front()?;
        let elapsed_ns = Some(at_ns.saturating_sub(*first_ns)).filter(|elapsed_ns| *elapsed_ns >= SHORTEST_NS)?;
        let declined = first_bytes.checked_sub(free_bytes).filter(|declined| *declined > 0)?;
        let lasts_s = free_bytes as f64 * (elapsed_ns as f64 * 1e-9) / declined as f64;
        Some(LowSpace { free_bytes, lasts: Duration::try_from_secs_f64(lasts_s).unwrap_or(Duration::MAX) })
    }
}

#[cfg(target_os = "linux")]
fn free_bytes(path: &Path) -> Option<u64> {
    let space = rustix::fs::statvfs(path).ok()?;
    space.f_bavail.checked_mul(space.f_frsize)
}

#[cfg(not(target_os = "linux"))]
fn free_bytes(_path: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: i64 = 1_000_000_000;

    /// The reported state after bytes were recorded at these seconds, with this number of free
    /// bytes at each.
    fn low(seconds: impl IntoIterator<Item = i64>, free_bytes: fn(i64) -> u64) -> Option<LowSpace> {
        let (sender, now) = std::sync::mpsc::channel();
        let mut watch = DiskWatch::asking(move || now.try_iter().last().map(free_bytes));
        let mut low = None;
        for second in seconds {
            sender.send(second).unwrap();
            low = watch.note(second * SECOND_NS);
        }
        low
    }

    #[test]
    fn a_disk_that_lasts_less_than_an_hour_at_the_present_rate_is_reported() {
        let declining = |second: i64| 20_000_000 - 5000 * second as u64;
        assert_eq!(low(0..=350, declining), None, "3650 s are left");
        let reported = low(0..=1000, declining).unwrap();
        assert_eq!(reported, LowSpace { free_bytes: 15_000_000, lasts: Duration::from_secs(3000) });
    }

    #[test]
    fn the_rate_is_that_of_the_last_minutes() {
        // another program begins to write
        let faster = |second: i64| 100_000_000 - 20_000 * (second - 3600).max(0) as u64;
        assert_eq!(low(0..=3600, faster), None);
        assert_eq!(low(0..=5100, faster).unwrap().lasts, Duration::from_secs(3500));
    }

    #[test]
    fn a_time_without_bytes_does_not_count() {
        let declining = |second: i64| 10_000_000 - 5000 * (second.min(100) + (second - 36_000).max(0)) as u64;
        let seconds = || (0..=100).chain(36_000..=36_120);
        assert_eq!(low(seconds().take(101 + 50), declining), None);
        assert_eq!(low(seconds(), declining).unwrap().lasts, Duration::from_secs(1780));
    }

    #[test]
    fn no_report_if_the_free_space_does_not_decline() {
        assert_eq!(low(0..1000, |_| 4096), None);
        assert_eq!(low(0..1000, |second| 4096 + second as u64), None);
        // files were removed
        let more = |second: i64| if second < 500 { 1_000_000 - 1000 * second as u64 } else { 1_000_000_000 };
        assert!(low(0..500, more).is_some());
        assert_eq!(low(0..600, more), None);
    }

    #[test]
    fn no_report_without_a_rate_or_an_answer_of_the_disk() {
        assert_eq!(low(0..60, |second| 60 - second as u64), None);
        assert!(low(0..=60, |second| 60 - second as u64).is_some());
        // a clock was set back
        assert_eq!(low((1000..1050).chain(0..50), |second| 2000 - second as u64), None);
        let mut unknown = DiskWatch::asking(|| None);
        assert_eq!((0..1000).find_map(|second| unknown.note(second * SECOND_NS)), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_disk_of_a_folder_reports_its_free_space() {
        assert!(free_bytes(&std::env::temp_dir()).is_some_and(|free| free > 0));
        assert_eq!(free_bytes(Path::new("/nowhere/at/all")), None);
    }
}

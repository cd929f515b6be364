//! How long the disk of a recording lasts at the present rate.

use std::{path::Path, time::Duration};

/// Less is reported.
const ENOUGH: Duration = Duration::from_secs(3600);

/// How often the disk is asked, in time of the stream; before the first time no rate is known.
const ASKED_EVERY_NS: u64 = 10_000_000_000;

/// The free space on a disk that will soon be full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LowSpace {
    /// Free bytes on the disk.
    pub free_bytes: u64,
    /// How long these last if the recording grows as fast as before.
    pub lasts: Duration,
}

/// Watches the disk while a recording grows.
pub(super) struct DiskWatch {
    free_bytes: Box<dyn FnMut() -> Option<u64> + Send>,
    begun_ns: Option<i64>,
    asked_ns: i64,
    bytes: u64,
    low: Option<LowSpace>,
}

impl DiskWatch {
    /// Asks the disk of the file at `path`.
    pub(super) fn of(path: &Path) -> Self {
        // of its folder: the file may be moved away
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned();
        Self::asking(move || free_bytes(&folder))
    }

    /// With another answer to how many bytes are free; `None` where that is not known.
    pub(super) fn asking(free_bytes: impl FnMut() -> Option<u64> + Send + 'static) -> Self {
        Self { free_bytes: Box::new(free_bytes), begun_ns: None, asked_ns: 0, bytes: 0, low: None }
    }

    /// So many bytes more were recorded until that time: what is to be reported.
    pub(super) fn note(&mut self, bytes: usize, at_ns: i64) -> Option<LowSpace> {
        self.bytes += bytes as u64;
        let begun_ns = *self.begun_ns.get_or_insert_with(|| {
            self.asked_ns = at_ns;
            at_ns
        });
        // a clock may be set back
        if at_ns.abs_diff(self.asked_ns) < ASKED_EVERY_NS {
            return self.low;
        }
        self.asked_ns = at_ns;
        let elapsed_s = at_ns.abs_diff(begun_ns) as f64 * 1e-9;
        let lasts_s = |free_bytes: u64| free_bytes as f64 * elapsed_s / self.bytes.max(1) as f64;
        let lasts = |free_bytes| Duration::try_from_secs_f64(lasts_s(free_bytes)).unwrap_or(Duration::MAX);
        let asked = (self.free_bytes)();
        self.low = asked
            .map(|free_bytes| LowSpace { free_bytes, lasts: lasts(free_bytes) })
            .filter(|space| space.lasts < ENOUGH);
        self.low
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
    use std::sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    };

    use super::*;

    const SECOND_NS: i64 = 1_000_000_000;

    #[test]
    fn a_disk_that_lasts_less_than_an_hour_at_the_present_rate_is_reported() {
        let free = Arc::new(AtomicU64::new(100_000_000));
        let asked = Arc::clone(&free);
        let mut watch = DiskWatch::asking(move || Some(asked.load(Ordering::Relaxed)));
        // 5000 bytes a second
        let mut record = |seconds: std::ops::Range<i64>| {
            let mut low = None;
            for second in seconds {
                low = watch.note(5000, second * SECOND_NS);
            }
            low
        };
        assert_eq!(record(0..100), None, "20000 s are left");
        free.store(10_000_000, Ordering::Relaxed);
        let low = record(100..120).unwrap();
        assert_eq!(low.free_bytes, 10_000_000);
        assert!((1900.0..2000.0).contains(&low.lasts.as_secs_f64()), "{low:?}");
        free.store(100_000_000, Ordering::Relaxed);
        assert_eq!(record(120..140), None, "someone made room");
    }

    #[test]
    fn before_a_rate_is_known_and_where_the_disk_does_not_say_nothing_is_reported() {
        let mut watch = DiskWatch::asking(|| Some(0));
        assert_eq!(watch.note(5000, 7 * SECOND_NS), None);
        assert_eq!(watch.note(5000, 8 * SECOND_NS), None);
        let mut unknown = DiskWatch::asking(|| None);
        assert_eq!((0..30).find_map(|second| unknown.note(5000, second * SECOND_NS)), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_disk_of_a_folder_says_what_is_free() {
        assert!(free_bytes(&std::env::temp_dir()).is_some_and(|free| free > 0));
        assert_eq!(free_bytes(Path::new("/nowhere/at/all")), None);
    }
}

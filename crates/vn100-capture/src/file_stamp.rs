//! Size and time of change of a capture, used to recognise it.

use std::{
    fs,
    path::{Path, PathBuf},
    time::UNIX_EPOCH,
};

/// The size in bytes and the latest time of change, in nanoseconds since 1970-01-01 UTC, of the
/// files of a capture together: its parts, their timing sidecars, and the files of a bag that is a
/// folder. Both are 0 if no file exists.
pub fn file_stamp(files: &[PathBuf]) -> (u64, i64) {
    let metadata = files.iter().flat_map(|file| with_companions(file)).filter_map(|file| fs::metadata(file).ok());
    metadata.filter(fs::Metadata::is_file).fold((0, 0), |(bytes, latest_ns), found| {
        let since = found.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let changed_ns = since.and_then(|since| i64::try_from(since.as_nanos()).ok()).unwrap_or(0);
        (bytes + found.len(), latest_ns.max(changed_ns))
    })
}

fn with_companions(file: &Path) -> Vec<PathBuf> {
    let mut sidecar = file.to_owned().into_os_string();
    sidecar.push(".timing");
    let entries = fs::read_dir(file).into_iter().flatten().flatten().map(|entry| entry.path());
    [file.to_owned(), sidecar.into()].into_iter().chain(entries).collect()
}

//! The captures below folders, as `vn100 archive` finds them.

use std::path::PathBuf;

use pyo3::prelude::*;
use vn100_capture::{RecordingPart, captures_below, joined_parts};

/// The files of each capture below the paths: one, or the parts of a recording in their order.
#[pyfunction]
#[pyo3(signature = (*paths))]
pub(crate) fn captures(py: Python<'_>, paths: Vec<PathBuf>) -> Vec<Vec<PathBuf>> {
    py.detach(|| {
        let mut files: Vec<PathBuf> = paths.iter().flat_map(|path| captures_below(path)).collect();
        files.sort();
        files.dedup();
        let named = files.into_iter().map(|path| {
            let part = RecordingPart::of(&path);
            (path, part)
        });
        joined_parts(named).into_iter().map(|parts| parts.into_values().collect()).collect()
    })
}

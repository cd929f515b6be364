//! The rows that an archive has of one capture.

use std::path::PathBuf;

use pyo3::{prelude::*, types::PyDict};
use vn100_capture::file_stamp;
use vn100_report::{ArchiveRow, ArchivedFile};
use vn100_session::ReplaySpec;

use crate::{measured, options::ReplayOptions, sessions::session};

/// The rows of a capture, or of the parts of one, as ``vn100 archive`` writes them: a list with a
/// line of JSON for each recording and channel, whose numbers are in its ``unit``.
///
/// ``path`` and ``parts`` are paths; options are those of :func:`replay`. A capture that cannot be
/// read is a row with its error. Raises :exc:`TypeError` and :exc:`ValueError` for options.
#[pyfunction]
#[pyo3(signature = (path, *parts, **options))]
pub(crate) fn archive_rows(
    py: Python<'_>,
    path: PathBuf,
    parts: Vec<PathBuf>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<String>> {
    let mut given = ReplayOptions::of(py, options)?;
    let files: Vec<PathBuf> = std::iter::once(&path).chain(&parts).cloned().collect();
    let (bytes, modified_ns) = py.detach(|| file_stamp(&files));
    let all = ReplaySpec {
        settings: given.settings.clone(),
        read: given.read,
        capture: given.capture.clone(),
        ..ReplaySpec::of(&path)
    };
    let file = ArchivedFile { path: all.name_with_folder(), bytes, modified_ns, options: all.options_digest("") };
    let path = given.join(py, path, parts)?;
    let evaluation = measured::evaluation()?.verdicts_only();
    let mut recordings = Vec::new();
    for spec in py.detach(|| given.specs(&path)) {
        let name = spec.name_with_folder();
        let result = session(py, spec)?;
        let mut measured = py.detach(|| evaluation.complete(measured::of_session(result)));
        measured.source.name = name;
        recordings.push(measured);
    }
    let rows = py.detach(|| ArchiveRow::of_file(&file, &recordings));
    Ok(rows.iter().map(ArchiveRow::json_line).collect())
}

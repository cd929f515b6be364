//! Results as documents, and what went wrong as exceptions, in words for Python.

use pyo3::{
    create_exception,
    exceptions::{PyException, PyOSError, PyRuntimeError},
    prelude::*,
};
use vn100_analysis::SourceResult;
use vn100_capture::OpenError;
use vn100_report::{Asked, Document, Ended, Evaluation, remedies::python_words, warnings::headline};
use vn100_session::{EndReason, SessionResult, StartError};

create_exception!(vn100, CaptureError, PyException, "A capture could not be read, or holds no sample.");

/// What completes every result: the built-in data sheet.
pub(crate) fn evaluation() -> PyResult<Evaluation> {
    Evaluation::new(None, Asked::default())
        .map_err(|error| PyRuntimeError::new_err(format!("the built-in data sheet: {error}")))
}

/// A replay that ended.
pub(crate) fn of_session(result: SessionResult) -> SourceResult {
    let SessionResult { measured, end, unmet, shortfall, .. } = result;
    let end = end.plain();
    Ended { end: &end, shortfall: shortfall.as_ref(), unmet: &unmet, is_live: false, words: python_words }
        .complete(measured)
}

/// Adds the gravest warning to the error of a capture without samples: what was wrong with its
/// bytes.
pub(crate) fn explain(result: &mut SourceResult) {
    if let (0, Some(error), Some(gravest)) = (result.timing.samples, &mut result.source.error, result.warnings.first())
    {
        *error = format!("{error}; {}", headline(gravest));
    }
}

/// The exception of a capture of which nothing could be measured; `None` where anything was.
pub(crate) fn failure(end: &EndReason, result: &SourceResult) -> Option<PyErr> {
    let text = result.source.error.clone()?;
    if let EndReason::NotStarted(StartError::Capture(error @ OpenError::Io { source, .. })) = end
        && source.raw_os_error().is_some()
    {
        return Some(not_opened(error));
    }
    (result.timing.samples == 0).then(|| CaptureError::new_err(text))
}

/// The exception of a capture that cannot be opened: for an error of the operating system the
/// `OSError` of its number.
pub(crate) fn not_opened(error: &OpenError) -> PyErr {
    let text = vn100_session::with_causes(error);
    match error {
        OpenError::Io { path, source } => match source.raw_os_error() {
            // the fourth is the number where the system is Windows
            Some(number) => PyOSError::new_err((number, text, path.clone().into_os_string(), number)),
            None => CaptureError::new_err(text),
        },
        _ => CaptureError::new_err(text),
    }
}

/// The document `vn100.analysis/2`.
pub(crate) fn document(result: &SourceResult) -> PyResult<String> {
    let document = Document::new(result, python_words);
    serde_json::to_string(&document).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

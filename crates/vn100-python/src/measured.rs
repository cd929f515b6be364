//! Results as documents, and what went wrong as exceptions, in the words of the command line.

use std::io;

use pyo3::{
    create_exception,
    exceptions::{PyException, PyFileNotFoundError, PyRuntimeError},
    prelude::*,
};
use vn100_capture::OpenError;
use vn100_pipeline::{EndReason, SessionResult, StartError};
use vn100_report::{Asked, Completion, Document, Evaluation, Measured};

create_exception!(vn100, CaptureError, PyException, "A capture could not be read, or holds no sample.");

/// What completes every result: the built-in data sheet, and models for filters if asked for.
pub(crate) fn evaluation(filter_models: bool) -> PyResult<Evaluation> {
    Evaluation::new(None, Asked::default(), filter_models)
        .map_err(|error| PyRuntimeError::new_err(format!("the built-in data sheet: {error}")))
}

/// A replay that ended.
pub(crate) fn of_session(result: SessionResult) -> Measured {
    let early = vn100_words::ended_early(&result);
    let SessionResult { mut facts, snapshot, assessment, end, unmet, .. } = result;
    facts.error = vn100_words::end(&facts.name, &end, &snapshot);
    let mut measured = Measured::ended(facts, snapshot, assessment, &unmet);
    if matches!(*end, EndReason::NotStarted(StartError::RateUnknown { .. })) {
        measured.completion = Completion::NotGiven;
    }
    early.into_iter().for_each(|(text, details)| measured.note_ended_early(text, details, false));
    measured
}

/// The exception of a capture of which nothing could be measured; `None` where anything was.
pub(crate) fn failure(end: &EndReason, measured: &Measured) -> Option<PyErr> {
    let text = measured.facts.error.clone()?;
    let is_missing = match end {
        EndReason::NotStarted(StartError::Capture(OpenError::Io { source, .. })) => {
            source.kind() == io::ErrorKind::NotFound
        }
        _ => false,
    };
    if is_missing {
        return Some(PyFileNotFoundError::new_err(text));
    }
    (measured.snapshot.timing.samples == 0).then(|| CaptureError::new_err(text))
}

/// The document `vn100.analysis/1`.
pub(crate) fn document(measured: &Measured) -> PyResult<String> {
    let document = Document::new(measured, true, vn100_words::remedy_words);
    serde_json::to_string(&document).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

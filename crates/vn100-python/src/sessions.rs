//! Captures through the pipeline, with the interpreter free, and ended by signals.

use std::{path::PathBuf, time::Duration};

use pyo3::{exceptions::PyRuntimeError, prelude::*, types::PyDict};
use tokio::{runtime::Runtime, time};
use vn100_session::{ReplaySpec, Session, SessionResult};

use crate::{
    measured::{self, Measured},
    options::ReplayOptions,
};

/// How often signals are checked.
const PERIOD: Duration = Duration::from_millis(50);

pub(crate) fn runtime() -> PyResult<Runtime> {
    let built = tokio::runtime::Builder::new_current_thread().enable_time().build();
    built.map_err(|error| PyRuntimeError::new_err(format!("no thread to read with: {error}")))
}

/// The results of all streams of a capture, or of the parts of one.
///
/// # Errors
/// `CaptureError` or `FileNotFoundError` where nothing could be measured.
#[pyfunction]
#[pyo3(signature = (path, *parts, **options))]
pub(crate) fn replay(
    py: Python<'_>,
    path: PathBuf,
    parts: Vec<PathBuf>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<Measured>> {
    let mut given = ReplayOptions::of(py, options)?;
    let path = given.join(py, path, parts)?;
    let evaluation = measured::evaluation()?;
    let mut results = Vec::new();
    for spec in py.detach(|| given.specs(&path)) {
        let is_one_of_several = spec.is_one_of_several;
        let mut result = session(py, spec)?;
        let error = result.start_error.take();
        let mut measured = py.detach(|| evaluation.complete(measured::of_session(result)));
        // what a stream of several lacks is said beside the others
        if !is_one_of_several {
            measured::explain(&mut measured);
            measured::failure(error.as_ref(), &measured).map_or(Ok(()), Err)?;
        }
        results.push(Measured(measured));
    }
    Ok(results)
}

/// Measures one stream of a capture; ends with the exception of a signal, if one comes.
pub(crate) fn session(py: Python<'_>, spec: ReplaySpec) -> PyResult<SessionResult> {
    let stop = spec.stop.clone();
    let runtime = runtime()?;
    let mut session = py.detach(|| runtime.block_on(async { Session::replay(spec) }));
    loop {
        let ended = py.detach(|| runtime.block_on(async { time::timeout(PERIOD, &mut session.result).await }));
        match ended {
            Ok(result) => return result.map_err(|error| PyRuntimeError::new_err(format!("internal error: {error}"))),
            Err(_) => {
                if let Err(interrupt) = py.check_signals() {
                    stop.cancel();
                    let _ = py.detach(|| runtime.block_on(&mut session.result));
                    return Err(interrupt);
                }
            }
        }
    }
}

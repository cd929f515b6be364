//! Captures through the pipeline, with the interpreter free, and ended by signals.

use std::{path::PathBuf, time::Duration};

use pyo3::{exceptions::PyRuntimeError, prelude::*, types::PyDict};
use tokio::{runtime::Runtime, time};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, CaptureOptions};
use vn100_pipeline::{ReplaySpec, Session, SessionResult};

use crate::{measured, options::Options};

/// How often signals are checked.
const PERIOD: Duration = Duration::from_millis(50);

pub(crate) fn runtime() -> PyResult<Runtime> {
    let built = tokio::runtime::Builder::new_current_thread().enable_time().build();
    built.map_err(|error| PyRuntimeError::new_err(format!("no thread to read with: {error}")))
}

/// The documents of all streams of a capture, as JSON.
///
/// # Errors
/// `CaptureError` or `FileNotFoundError` where nothing could be measured.
#[pyfunction]
#[pyo3(signature = (path, **options))]
pub(crate) fn replay(py: Python<'_>, path: PathBuf, options: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<String>> {
    let given = options.map_or_else(|| Ok(Options::default()), Options::of)?;
    let evaluation = measured::evaluation(given.filter_models)?;
    let topics = py.detach(|| Capture::streams(&path, &given.capture));
    let is_one_of_several = topics.len() > 1;
    let mut documents = Vec::new();
    for topic in topics {
        let result = session(py, &path, &given, topic, is_one_of_several)?;
        let end = std::sync::Arc::clone(&result.end);
        let measured = py.detach(|| evaluation.complete(measured::of_session(result)));
        if let Some(error) = measured::failure(&end, &measured) {
            return Err(error);
        }
        documents.push(measured::document(&measured)?);
    }
    Ok(documents)
}

/// Measures one stream of a capture; ends with the exception of a signal, if one comes.
pub(crate) fn session(
    py: Python<'_>,
    path: &std::path::Path,
    options: &Options,
    topic: Option<String>,
    is_one_of_several: bool,
) -> PyResult<SessionResult> {
    let stop = CancellationToken::new();
    let spec = ReplaySpec {
        path: path.to_owned(),
        capture: CaptureOptions { topic, ..options.capture.clone() },
        is_one_of_several,
        settings: options.settings.clone(),
        read: options.read,
        speed: None,
        each_second: false,
        samples: None,
        observer: None,
        stop: stop.clone(),
    };
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

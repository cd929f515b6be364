//! States of recordings, for folds over processes and machines.

use std::path::PathBuf;

use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict, PyTuple},
};
use vn100_analysis::StateError;
use vn100_capture::Capture;

use crate::{measured, options::Options, sessions::session};

/// The mergeable state of recordings: exact sums as bytes.
#[pyclass(module = "vn100", frozen, name = "State")]
pub(crate) struct State {
    /// As bytes: what is shared is never changed.
    bytes: Vec<u8>,
}

impl State {
    pub(crate) fn of(state: &vn100_analysis::State) -> Self {
        Self { bytes: state.to_bytes() }
    }

    fn read(&self) -> PyResult<vn100_analysis::State> {
        vn100_analysis::State::from_bytes(&self.bytes).map_err(refused)
    }
}

fn refused(error: StateError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

#[pymethods]
impl State {
    /// A state of no recording.
    #[new]
    fn new() -> Self {
        Self::of(&vn100_analysis::State::default())
    }

    #[staticmethod]
    #[pyo3(signature = (path, name=None, **options))]
    fn of_file(
        py: Python<'_>,
        path: PathBuf,
        name: Option<String>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let options = options.map_or_else(|| Ok(Options::default()), Options::of)?;
        let topics = py.detach(|| Capture::streams(&path, &options.capture));
        let is_one_of_several = topics.len() > 1;
        let mut all = vn100_analysis::State::default();
        for topic in topics {
            let label = name.as_ref().map(|name| match topic.as_deref().filter(|_| is_one_of_several) {
                Some(topic) => format!("{name} {topic}"),
                None => name.clone(),
            });
            let mut result = session(py, &path, &options, topic, is_one_of_several)?;
            let analysis = result.analysis.take();
            let end = std::sync::Arc::clone(&result.end);
            let state = py.detach(|| {
                let measured = measured::of_session(result);
                if let Some(error) = measured::failure(&end, &measured) {
                    return Err(error);
                }
                let name = label.unwrap_or_else(|| measured.facts.name.clone());
                let started_ns = measured.compared().started_ns;
                let state = match analysis {
                    Some(mut analysis) => vn100_analysis::State::of(&name, started_ns, &mut analysis),
                    None => vn100_analysis::State::default(),
                };
                Ok(match &measured.facts.error {
                    Some(error) => state.with_error(error),
                    None => state,
                })
            })?;
            all = all.merged(state).map_err(refused)?;
        }
        Ok(Self::of(&all))
    }

    /// A recording that could not be read.
    #[staticmethod]
    fn of_error(name: &str, error: &str) -> Self {
        Self::of(&vn100_analysis::State::unreadable(name, error))
    }

    #[staticmethod]
    #[pyo3(signature = (*states))]
    fn merged(py: Python<'_>, states: &Bound<'_, PyTuple>) -> PyResult<Self> {
        let mut all: Vec<Vec<u8>> = Vec::new();
        for state in states {
            if !state.is_none() {
                all.push(state.cast::<Self>()?.get().bytes.clone());
            }
        }
        py.detach(|| {
            let mut merged = vn100_analysis::State::default();
            for bytes in &all {
                merged = merged.merged(vn100_analysis::State::from_bytes(bytes)?)?;
            }
            Ok(Self::of(&merged))
        })
        .map_err(refused)
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        vn100_analysis::State::from_bytes(bytes).map_err(refused)?;
        Ok(Self { bytes: bytes.to_vec() })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = slf.get().to_bytes(slf.py());
        Ok((slf.get_type().getattr("from_bytes")?, (bytes,)))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().bytes == self.bytes)
    }

    fn __hash__(&self) -> u64 {
        self.bytes.iter().fold(0, |hash, byte| hash.wrapping_mul(31) ^ u64::from(*byte))
    }

    /// The recordings by name, and why one could not be read.
    #[getter]
    fn recordings(&self) -> PyResult<Vec<(String, Option<String>)>> {
        let state = self.read()?;
        let named = |recording: vn100_analysis::RecordedPieces<'_>| {
            (recording.name.to_owned(), recording.error.map(str::to_owned))
        };
        Ok(state.recordings().map(named).collect())
    }

    /// The documents of the recordings that could be read, as JSON.
    fn documents(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let state = self.read()?;
        let evaluation = measured::evaluation(false)?;
        let mut documents = Vec::new();
        for recording in state.recordings() {
            let measured = py.detach(|| vn100_report::measured_of_state(&recording, &evaluation));
            if let Some(measured) = measured.map_err(|error| PyValueError::new_err(error.to_string()))? {
                documents.push(measured::document(&measured)?);
            }
        }
        Ok(documents)
    }

    /// The document `vn100.archive/1` of all recordings, as JSON.
    fn archive(&self, py: Python<'_>) -> PyResult<String> {
        let state = self.read()?;
        let evaluation = measured::evaluation(false)?;
        let document =
            py.detach(|| vn100_report::ArchiveDocument::new(&state, &evaluation, crate::ended::remedy_words));
        serde_json::to_string_pretty(&document).map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

//! States of recordings, for folds over processes and machines.

use std::{path::PathBuf, sync::Arc};

use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict, PyTuple},
};
use vn100_analysis::StateError;

use crate::{measured, options::ReplayOptions, sessions::session};

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

    /// Of a capture, or of the parts of one; by its path unless a name is given.
    #[staticmethod]
    #[pyo3(signature = (path, *parts, name=None, **options))]
    fn of_file(
        py: Python<'_>,
        path: PathBuf,
        parts: Vec<PathBuf>,
        name: Option<String>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut options = ReplayOptions::of(py, options)?;
        let path = options.join(py, path, parts)?;
        let specs = py.detach(|| options.specs(&path));
        let mut all = vn100_analysis::State::default();
        for spec in specs {
            let label = match (&name, spec.capture.topic.as_deref().filter(|_| spec.is_one_of_several)) {
                (None, _) => spec.name_with_folder(),
                (Some(name), Some(topic)) => format!("{name} {topic}"),
                (Some(name), None) => name.clone(),
            };
            let is_one_of_several = spec.is_one_of_several;
            let mut result = session(py, spec)?;
            let mut analysis = result.analysis.take();
            let end = Arc::clone(&result.end);
            let (measured, state) = py.detach(|| {
                let measured = measured::of_session(result);
                let state = vn100_report::state_of_measured(&label, &measured, analysis.as_deref_mut());
                (measured, state)
            });
            // what a stream of several lacks is said beside the others
            if let Some(error) = measured::failure(&end, &measured).filter(|_| !is_one_of_several) {
                return Err(error);
            }
            all = all.merged(state).map_err(refused)?;
        }
        Ok(Self::of(&all))
    }

    /// A recording that could not be read.
    #[staticmethod]
    fn of_error(name: &str, error: &str) -> Self {
        Self::of(&vn100_analysis::State::unreadable(name, error))
    }

    /// The union of states, which does not depend on their order; `None` stands for no recording.
    /// Pieces of one recording have one name.
    ///
    /// Raises `ValueError` where pieces of a name overlap, or do not belong together.
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

    /// The state as bytes, with a version and a checksum: the same for the same pieces.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }

    /// The state that `to_bytes` gave.
    ///
    /// Raises `ValueError` for bytes of another kind or version, and for damaged ones.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        vn100_analysis::State::from_bytes(bytes).map_err(refused)?;
        Ok(Self { bytes: bytes.to_vec() })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = slf.get().to_bytes(slf.py());
        Ok((slf.get_type().getattr("from_bytes")?, (bytes,)))
    }

    fn __repr__(&self) -> PyResult<String> {
        let names: Vec<String> = self.recordings()?.into_iter().map(|(name, _)| name).collect();
        Ok(match &names[..] {
            [name] => format!("<vn100.State of {name}>"),
            names => format!("<vn100.State of {} recordings>", names.len()),
        })
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().bytes == self.bytes)
    }

    fn __hash__(&self) -> u64 {
        self.bytes.iter().fold(0, |hash, byte| hash.wrapping_mul(31) ^ u64::from(*byte))
    }

    /// The recordings by name, and why one could not be read. Whether pieces fit together, as in
    /// their rates, shows only in `documents` and `archive`.
    #[getter]
    fn recordings(&self) -> PyResult<Vec<(String, Option<String>)>> {
        let state = self.read()?;
        let named = |recording: vn100_analysis::RecordedPieces<'_>| {
            (recording.name.to_owned(), recording.error.map(str::to_owned))
        };
        Ok(state.recordings().map(named).collect())
    }

    /// The documents of the recordings that could be read, as JSON: `Result(json.loads(text))` is
    /// the result of one.
    ///
    /// Raises `ValueError` where the pieces of a recording do not fit together.
    fn documents(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let state = py.detach(|| self.read())?;
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
        let state = py.detach(|| self.read())?;
        let evaluation = measured::evaluation(false)?;
        let document = py.detach(|| vn100_report::ArchiveDocument::new(&state, &evaluation, vn100_report::words::remedy_words));
        serde_json::to_string_pretty(&document).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The same as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.archive(py)?,))
    }
}

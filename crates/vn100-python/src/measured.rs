//! Results as documents, and what went wrong as exceptions, in words for Python.

use pyo3::{
    create_exception,
    exceptions::{PyException, PyOSError, PyRuntimeError, PyValueError},
    prelude::*,
};
use vn100_analysis::SourceResult;
use vn100_capture::OpenError;
use vn100_report::figure::ReportFigures;
use vn100_report::html::{PageOptions, Program, report_page};
use vn100_report::{Consumer, Document, Ended, Evaluation, FilterNoise, remedies::python_words, warnings::headline};
use vn100_session::{SessionResult, StartError};

create_exception!(vn100, CaptureError, PyException, "A capture could not be read, or holds no sample.");

/// What completes every result: the built-in data sheet.
pub(crate) fn evaluation() -> PyResult<Evaluation> {
    Evaluation::new(None, Vec::new(), false)
        .map_err(|error| PyRuntimeError::new_err(format!("the built-in data sheet: {error}")))
}

/// A replay that ended.
pub(crate) fn of_session(result: SessionResult) -> SourceResult {
    let SessionResult { measured, end, unmet, shortfall, .. } = result;
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
pub(crate) fn failure(error: Option<&StartError>, result: &SourceResult) -> Option<PyErr> {
    let text = result.source.error.clone()?;
    if let Some(StartError::Capture(error @ OpenError::Io { source, .. })) = error
        && source.raw_os_error().is_some()
    {
        return Some(not_opened(error));
    }
    (result.timing.samples == 0).then(|| CaptureError::new_err(text))
}

/// The exception of a capture that cannot be opened: for an error of the operating system the
/// `OSError` of its number.
pub(crate) fn not_opened(error: &OpenError) -> PyErr {
    let text = vn100_capture::with_causes(error);
    match error {
        OpenError::Io { path, source } => match source.raw_os_error() {
            // the fourth is the number where the system is Windows
            Some(number) => PyOSError::new_err((number, text, path.clone().into_os_string(), number)),
            None => CaptureError::new_err(text),
        },
        _ => CaptureError::new_err(text),
    }
}

/// The result of one source, and what is written of it.
#[pyclass(module = "vn100", frozen)]
pub(crate) struct Measured(pub(crate) SourceResult);

#[pymethods]
impl Measured {
    /// The document `vn100.analysis/2`.
    fn document(&self) -> PyResult<String> {
        let document = Document::new(&self.0, python_words);
        serde_json::to_string(&document).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// What can be done about each warning, in the order of the document.
    fn remedies(&self) -> Vec<Vec<String>> {
        self.0.warnings.iter().map(|warning| warning.remedies.iter().map(python_words).collect()).collect()
    }

    /// The page of `vn100 report`; a filter integrates over `span` seconds.
    fn page(&self, py: Python<'_>, span: f64) -> PyResult<Vec<u8>> {
        let options = PageOptions {
            confidence: self.0.confidence,
            asked: "",
            words: python_words,
            program: Program { name: concat!("vn100 ", env!("CARGO_PKG_VERSION"), " for Python"), commit: None },
            span_s: checked_span(span)?,
        };
        let records = std::slice::from_ref(&self.0);
        Ok(py.detach(|| report_page(records, &ReportFigures::of(records), options).into_bytes()))
    }

    /// The file of the filter of that name.
    fn filter_file(&self, name: &str, span: f64, scale_factor: Option<f64>) -> PyResult<String> {
        let consumer = Consumer::named(name).ok_or_else(|| {
            let names: Vec<_> = Consumer::ALL.iter().map(|consumer| consumer.name).collect();
            PyValueError::new_err(format!("{name:?} is none of {}", names.join(", ")))
        })?;
        let mut noise = FilterNoise::of(&self.0, checked_span(span)?);
        noise.scale_factor_ppm = scale_factor;
        consumer.file(&noise).map_err(|error| {
            let advice = error.advice(python_words);
            PyValueError::new_err(format!("no file for {}: {error}. To get it: {advice}", consumer.title))
        })
    }
}

fn checked_span(seconds: f64) -> PyResult<f64> {
    if seconds.is_finite() && seconds > 0.0 {
        Ok(seconds)
    } else {
        Err(PyValueError::new_err(format!("span: {seconds} s is not a duration above 0")))
    }
}

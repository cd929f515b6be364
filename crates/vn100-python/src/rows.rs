//! The samples of a capture, block by block.

use std::{path::PathBuf, time::Duration};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::{prelude::*, types::PyDict};
use tokio::{runtime::Runtime, sync::mpsc, time};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, Event};
use vn100_protocol::stream::Batch;

use crate::{
    measured::{CaptureError, not_opened},
    options::ReplayOptions,
    sessions::runtime,
};

/// A row without a time.
const NO_TIME: i64 = i64::MIN;

/// Time and values of rows.
type Block<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray2<f64>>);

/// The samples of a capture in the units of their channels.
#[pyclass(module = "vn100")]
pub(crate) struct Rows {
    runtime: Runtime,
    events: mpsc::Receiver<Event>,
    /// The first block, which has the channels.
    first: Option<Box<Batch>>,
    #[pyo3(get)]
    channels: Vec<String>,
    #[pyo3(get)]
    units: Vec<String>,
}

#[pymethods]
impl Rows {
    #[new]
    #[pyo3(signature = (path, *parts, **options))]
    fn new(py: Python<'_>, path: PathBuf, parts: Vec<PathBuf>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut options = ReplayOptions::of_rows(py, options)?;
        let path = options.join(py, path, parts)?;
        let ReplayOptions { read, capture, .. } = options;
        let runtime = runtime()?;
        let opened = py.detach(|| {
            let capture = Capture::open(&path, &capture).map_err(|error| not_opened(&error))?;
            let _entered = runtime.enter();
            capture.read(read, CancellationToken::new()).map_err(|error| CaptureError::new_err(error.to_string()))
        });
        let (channels, units) = (Vec::new(), Vec::new());
        let mut rows = Self { runtime, events: opened?, first: None, channels, units };
        let Some(first) = rows.batch(py)? else {
            let text = format!("{}: no valid sample; measure it with replay, which gives the reason", path.display());
            return Err(CaptureError::new_err(text));
        };
        if let Some(layout) = &first.layout {
            rows.channels = layout.channels.iter().map(|channel| channel.name.to_string()).collect();
            rows.units = layout.channels.iter().map(|channel| channel.unit.to_string()).collect();
        }
        rows.first = Some(first);
        Ok(rows)
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Block<'py>>> {
        let Some(batch) = self.first.take().map_or_else(|| self.batch(py), |first| Ok(Some(first)))? else {
            return Ok(None);
        };
        let (times, values) = py.detach(|| (times(&batch), values(&batch)));
        let rows = times.len();
        let width = values.len() / rows.max(1);
        Ok(Some((times.into_pyarray(py), values.into_pyarray(py).reshape([rows, width])?)))
    }
}

impl Rows {
    /// The next one that has rows.
    fn batch(&mut self, py: Python<'_>) -> PyResult<Option<Box<Batch>>> {
        loop {
            let Self { runtime, events, .. } = self;
            let next =
                py.detach(|| runtime.block_on(async { time::timeout(Duration::from_millis(50), events.recv()).await }));
            match next {
                Err(_) => py.check_signals()?,
                Ok(Some(Event::Batch(batch))) if batch.row_count() > 0 => {
                    py.check_signals()?;
                    return Ok(Some(batch));
                }
                Ok(Some(Event::End(end))) => match end.error {
                    Some(error) => return Err(CaptureError::new_err(error.to_string())),
                    None => return Ok(None),
                },
                Ok(Some(Event::Batch(_) | Event::Link(_))) => {}
                Ok(None) => return Ok(None),
            }
        }
    }
}

/// In nanoseconds: of the sensor since it started, else of the arrival.
fn times(batch: &Batch) -> Vec<i64> {
    let rows = batch.row_count();
    if batch.device_ns.len() == rows {
        return batch.device_ns.iter().map(|ns| i64::try_from(*ns).unwrap_or(NO_TIME)).collect();
    }
    let mut times = vec![NO_TIME; rows];
    for arrival in &batch.arrivals {
        times.iter_mut().skip(arrival.from_row).for_each(|time| *time = arrival.at_ns);
    }
    times
}

/// Frame-major; NaN for what is absent.
fn values(batch: &Batch) -> Vec<f64> {
    let Some(layout) = &batch.layout else { return Vec::new() };
    let width = layout.channels.len();
    let value = |(place, count): (usize, &i32)| layout.channels[place % width].value(*count);
    let mut values: Vec<f64> = batch.counts.iter().enumerate().map(value).collect();
    for cell in &batch.absent {
        values[cell.row * width + cell.channel] = f64::NAN;
    }
    values
}

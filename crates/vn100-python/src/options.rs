//! Options of a measurement, by the names of the command line with `_` for `-`.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    types::PyDict,
};
use vn100_analysis::noise::{Deviation, Estimator};
use vn100_analysis::{Detrend, Settings};
use vn100_capture::{Capture, CaptureOptions};
use vn100_pipeline::ReplaySpec;
use vn100_protocol::stream::{MeasuredFrames, ReadOptions};

/// How a capture is read and measured.
#[derive(Debug, Default)]
pub(crate) struct ReplayOptions {
    pub(crate) settings: Settings,
    pub(crate) read: ReadOptions,
    pub(crate) capture: CaptureOptions,
    pub(crate) filter_models: bool,
}

impl ReplayOptions {
    pub(crate) fn of(given: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut options = Self::default();
        let Self { settings, read, capture, filter_models } = &mut options;
        for (name, value) in given {
            let name: String = name.extract()?;
            if value.is_none() {
                continue;
            }
            match name.as_str() {
                "rate" => settings.rate_hz = Some(rate(value.extract()?)?),
                "estimator" => settings.estimator = estimator(&value.extract::<String>()?)?,
                "deviation" => settings.deviation = deviation(&value.extract::<String>()?)?,
                "confidence" => settings.confidence = confidence(value.extract()?)?,
                "skip" => settings.skip = seconds(value.extract()?)?,
                "duration" => settings.duration = Some(seconds(value.extract()?)?),
                "detrend" => {
                    settings.detrend = Some(one_of(
                        "detrend",
                        &value.extract::<String>()?,
                        &[("linear", Detrend::Line), ("temperature", Detrend::Temperature)],
                    )?);
                }
                "quantization" => settings.quantization = value.extract()?,
                "window" => settings.window = Some(value.extract()?),
                "compensated" => settings.compensated = Some(value.extract()?),
                "accept_unchecked" => read.accept_unchecked = value.extract()?,
                "measure" => {
                    read.measured = one_of(
                        "measure",
                        &value.extract::<String>()?,
                        &[("sentences", MeasuredFrames::Sentences), ("packets", MeasuredFrames::Packets)],
                    )?;
                }
                "columns" => {
                    let columns: String = value.extract()?;
                    capture.columns = Some(columns.parse().map_err(|error| PyValueError::new_err(format!("{error}")))?);
                }
                "topic" => capture.topic = Some(value.extract()?),
                "filter_models" => *filter_models = value.extract()?,
                other => return Err(PyTypeError::new_err(format!("there is no option {other:?}"))),
            }
        }
        Ok(options)
    }

    /// Of a recording that continues in these files.
    pub(crate) fn with_parts(mut self, parts: Vec<PathBuf>) -> Self {
        self.capture.later_parts = parts;
        self
    }

    /// How each stream of a file is replayed.
    pub(crate) fn specs(&self, path: &Path) -> Vec<ReplaySpec> {
        let topics = Capture::streams(path, &self.capture);
        let is_one_of_several = topics.len() > 1;
        let spec = |topic| ReplaySpec {
            capture: CaptureOptions { topic, ..self.capture.clone() },
            is_one_of_several,
            settings: self.settings.clone(),
            read: self.read,
            ..ReplaySpec::of(path)
        };
        topics.into_iter().map(spec).collect()
    }
}

pub(crate) fn rate(hz: f64) -> PyResult<f64> {
    let is_rate = hz.is_finite() && (1e-3..=1e5).contains(&hz);
    if is_rate { Ok(hz) } else { Err(PyValueError::new_err(format!("{hz} Hz is not between 0.001 and 100000 Hz"))) }
}

pub(crate) fn confidence(level: f64) -> PyResult<f64> {
    let is_level = level > 0.0 && level < 1.0;
    if is_level {
        Ok(level)
    } else {
        Err(PyValueError::new_err(format!("{level} is not between 0 and 1; 0.95 is usual")))
    }
}

pub(crate) fn estimator(name: &str) -> PyResult<Estimator> {
    let all = [("strided", Estimator::Strided), ("full", Estimator::Full), ("plain", Estimator::Plain)];
    one_of("estimator", name, &all)
}

pub(crate) fn deviation(name: &str) -> PyResult<Deviation> {
    one_of("deviation", name, &[("allan", Deviation::Allan), ("hadamard", Deviation::Hadamard)])
}

fn seconds(seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds).map_err(|error| PyValueError::new_err(format!("{seconds} s: {error}")))
}

fn one_of<T: Copy>(option: &str, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(known, _)| *known == name);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        let known: Vec<_> = choices.iter().map(|(known, _)| *known).collect();
        PyValueError::new_err(format!("{option} {name:?} is none of {}", known.join(", ")))
    })
}

//! Options of a measurement, by the names of the command line with `_` for `-`.

use std::{
    ffi::CString,
    fs::File,
    iter,
    ops::RangeInclusive,
    path::{Path, PathBuf},
    time::Duration,
};

use pyo3::{
    exceptions::{PyTypeError, PyUserWarning, PyValueError},
    prelude::*,
    types::{PyBool, PyDict},
};
use vn100_analysis::noise::{Deviation, Estimator};
use vn100_analysis::{AveragingTimes, Coast, Settings};
use vn100_capture::{CaptureOptions, OpenError, RecordingPart, joined_parts, missing_parts};
use vn100_protocol::stream::{MeasuredFrames, ReadOptions};
use vn100_session::ReplaySpec;

use crate::measured;

/// How a capture is read and measured.
#[derive(Debug, Default)]
pub(crate) struct ReplayOptions {
    pub(crate) settings: Settings,
    pub(crate) read: ReadOptions,
    pub(crate) capture: CaptureOptions,
}

/// Options of how a capture is read; the others concern what is measured.
const READING: [&str; 4] = ["accept_unchecked", "columns", "measure", "topic"];

/// Options that are numbers.
const NUMBERS: [&str; 5] = ["confidence", "duration", "rate", "skip", "window"];

/// Windows of the averaging filter of the sensor, in samples at 800 Hz.
const WINDOWS: RangeInclusive<u32> = 1..=800;

impl ReplayOptions {
    pub(crate) fn of(py: Python<'_>, given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut options = Self::default();
        for (name, value) in given.into_iter().flatten() {
            let name: String = name.extract()?;
            if value.is_none() {
                continue;
            }
            // Python counts a truth value as 0 or 1
            if value.is_instance_of::<PyBool>() && NUMBERS.contains(&name.as_str()) {
                return Err(PyTypeError::new_err(format!("{name}: {value} is no number")));
            }
            named(py, &name, options.set(&name, &value))?;
        }
        check_taus(&options.settings)?;
        let Settings { skip, duration, .. } = options.settings;
        match duration.filter(|duration| *duration <= skip) {
            Some(duration) => Err(PyValueError::new_err(format!(
                "duration: {} s end within the {} s that skip excludes: both count from the first sample",
                duration.as_secs_f64(),
                skip.as_secs_f64()
            ))),
            None => Ok(options),
        }
    }

    /// For the samples alone, which nothing is measured of.
    pub(crate) fn of_rows(py: Python<'_>, given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        for name in given.into_iter().flat_map(|given| given.keys()) {
            let name: String = name.extract()?;
            if !READING.contains(&name.as_str()) {
                let text = format!("rows has no option {name:?}: it takes {}", READING.join(", "));
                return Err(PyTypeError::new_err(text));
            }
        }
        Self::of(py, given)
    }

    fn set(&mut self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let Self { settings, read, capture } = self;
        match name {
            "rate" => settings.rate_hz = Some(rate(value.extract()?)?),
            "estimator" => settings.estimator = estimator(&value.extract::<String>()?)?,
            "deviation" => settings.deviation = deviation(&value.extract::<String>()?)?,
            "confidence" => settings.confidence = confidence(value.extract()?)?,
            "skip" => settings.skip = seconds(value.extract()?)?,
            "duration" => settings.duration = Some(length(value)?),
            "coast" => {
                settings.coasts = value.try_iter()?.map(|coast| self::coast(&coast?)).collect::<PyResult<_>>()?
            }
            "quantization" => settings.quantization = value.extract()?,
            "taus" => settings.averaging_times = taus(value)?,
            "window" => settings.window = Some(window(value.extract()?)?),
            "compensated" => settings.compensated = Some(is_compensated(value)?),
            "accept_unchecked" => read.accept_unchecked = value.extract()?,
            "measure" => {
                let all = [("sentences", MeasuredFrames::Sentences), ("packets", MeasuredFrames::Packets)];
                read.measured = one_of(&value.extract::<String>()?, &all)?;
            }
            "columns" => {
                let columns: String = value.extract()?;
                capture.columns = Some(columns.parse().map_err(|error| PyValueError::new_err(format!("{error}")))?);
            }
            "topic" => capture.topic = Some(value.extract()?),
            _ => return Err(PyTypeError::new_err("there is no such option")),
        }
        Ok(())
    }

    /// Takes the parts of a recording in their order, and returns the first. What is missing
    /// between them is a warning.
    ///
    /// # Errors
    /// `ValueError` unless all files are parts of one recording, each a part of its own; `OSError`
    /// for a file that cannot be opened.
    pub(crate) fn join(&mut self, py: Python<'_>, path: PathBuf, parts: Vec<PathBuf>) -> PyResult<PathBuf> {
        if parts.is_empty() {
            return Ok(path);
        }
        let files = || iter::once(&path).chain(&parts);
        for file in files() {
            File::open(file).map_err(|source| measured::not_opened(&OpenError::Io { path: file.clone(), source }))?;
        }
        let groups = py.detach(|| joined_parts(files().map(|file| (file.clone(), RecordingPart::of(file)))));
        let [parts] = &groups[..] else {
            let names: Vec<_> = files().map(|file| file.display().to_string()).collect();
            let text = format!(
                "{} are not parts of one recording, each given once: measure them one by one",
                names.join(", ")
            );
            return Err(PyValueError::new_err(text));
        };
        let mut files = parts.values().cloned();
        let first = files.next().unwrap_or(path);
        self.capture.later_parts = files.collect();
        if let Some(text) = missing_parts(&parts.keys().copied().collect::<Vec<_>>()) {
            let text = CString::new(format!("{}: {text}", first.display()))?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
        }
        Ok(first)
    }

    /// How each stream of a file is replayed.
    pub(crate) fn specs(&self, path: &Path) -> Vec<ReplaySpec> {
        let (capture, settings) = (self.capture.clone(), self.settings.clone());
        ReplaySpec { capture, settings, read: self.read, ..ReplaySpec::of(path) }.streams()
    }
}

/// With the name of the option before the error.
pub(crate) fn named<T>(py: Python<'_>, option: &str, result: PyResult<T>) -> PyResult<T> {
    result.map_err(|error| PyErr::from_type(error.get_type(py), format!("{option}: {}", error.value(py))))
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
    one_of(name, &[("strided", Estimator::Strided), ("full", Estimator::Full), ("plain", Estimator::Plain)])
}

pub(crate) fn deviation(name: &str) -> PyResult<Deviation> {
    one_of(name, &[("allan", Deviation::Allan), ("hadamard", Deviation::Hadamard)])
}

/// A name, or seconds.
pub(crate) fn taus(value: &Bound<'_, PyAny>) -> PyResult<AveragingTimes> {
    let text = match value.extract::<Vec<f64>>() {
        Ok(seconds) => seconds.iter().map(f64::to_string).collect::<Vec<_>>().join(","),
        Err(_) => value.extract()?,
    };
    text.parse().map_err(|error| PyValueError::new_err(format!("{error}")))
}

/// Others than the octaves take all samples, and are whole numbers of samples.
pub(crate) fn check_taus(settings: &Settings) -> PyResult<()> {
    let times = &settings.averaging_times;
    if *times != AveragingTimes::Octave && settings.estimator != Estimator::Full {
        return Err(PyValueError::new_err("taus: sums are kept of the octaves alone, unless estimator=\"full\""));
    }
    let missing = settings.rate_hz.and_then(|rate_hz| times.no_multiples(1.0 / rate_hz).first().cloned());
    missing.map_or(Ok(()), |missing| Err(PyValueError::new_err(format!("taus: {missing}"))))
}

fn window(samples: i64) -> PyResult<u32> {
    let found = u32::try_from(samples).ok().filter(|samples| WINDOWS.contains(samples));
    found.ok_or_else(|| {
        let (least, most) = WINDOWS.into_inner();
        PyValueError::new_err(format!("{samples} is not between {least} and {most} samples at 800 Hz"))
    })
}

/// A truth value, or `yes` and `no` as on the command line.
pub(crate) fn is_compensated(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    match value.extract::<String>() {
        Ok(word) => one_of(&word, &[("yes", true), ("no", false)]),
        Err(_) => value.extract(),
    }
}

fn seconds(seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds).map_err(|_| PyValueError::new_err(format!("{seconds:?} s is not a duration")))
}

fn length(value: &Bound<'_, PyAny>) -> PyResult<Duration> {
    match seconds(value.extract()?)? {
        Duration::ZERO => Err(PyValueError::new_err("0 s contains no sample")),
        length => Ok(length),
    }
}

/// A coast after a rest as long, or a pair of rest and coast.
fn coast(value: &Bound<'_, PyAny>) -> PyResult<Coast> {
    let (rest, coast) = value.extract().unwrap_or_else(|_| (value.clone(), value.clone()));
    Ok(Coast { rest: length(&rest)?, coast: length(&coast)? })
}

fn one_of<T: Copy>(name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(known, _)| *known == name);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        let known: Vec<_> = choices.iter().map(|(known, _)| *known).collect();
        PyValueError::new_err(format!("{name:?} is none of {}", known.join(", ")))
    })
}

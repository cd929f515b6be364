//! The sums of arrays: what `Analyzer` accumulates.

use std::{mem, sync::Arc};

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{exceptions::PyValueError, prelude::*};
use vn100_analysis::{Analysis, Assessment, Parts, Settings, SourceFacts, SourceResult, WarningKind};
use vn100_protocol::stream::{AbsentCell, Batch};
use vn100_protocol::{Channel, Layout, Quantity};

use crate::{
    measured::{self, Measured},
    options::{self, named},
};

/// Rows that are taken at a time, between looks at signals, while the interpreter is free.
const BLOCK: usize = 1 << 16;

/// 1.5 · 2^52: added to a float below 2^31, it leaves the nearest integer in the low bits.
const SHIFTER: f64 = 6_755_399_441_055_744.0;

/// Counts have 32 bits.
const MOST_COUNTS: f64 = 2_147_483_647.0;

/// Streaming, exact sums over the channels of arrays.
#[pyclass(module = "vn100")]
pub(crate) struct Sums {
    layout: Arc<Layout>,
    analysis: Analysis,
    /// Rows missing since the last one: a gap counts once a row follows, however it was divided.
    missing: u64,
    confidence: f64,
}

/// The quantity of that name, with its SI unit; a neutral series has no unit.
fn quantity(name: &str) -> PyResult<(Quantity, &'static str)> {
    match name {
        "gyro" => Ok((Quantity::AngularRate, "rad/s")),
        "accel" => Ok((Quantity::Acceleration, "m/s^2")),
        "mag" => Ok((Quantity::MagneticField, "gauss")),
        "value" => Ok((Quantity::Value, "")),
        _ => Err(PyValueError::new_err(format!("quantity: {name:?} is none of gyro, accel, mag, value"))),
    }
}

#[pymethods]
impl Sums {
    #[new]
    #[pyo3(signature = (channels, rate, resolution, estimator, deviation, confidence, compensated, taus))]
    #[expect(clippy::too_many_arguments, reason = "the Python class around it names and documents them")]
    fn new(
        py: Python<'_>,
        channels: Vec<(String, String)>,
        rate: f64,
        resolution: Vec<f64>,
        estimator: &str,
        deviation: &str,
        confidence: f64,
        compensated: Option<Bound<'_, PyAny>>,
        taus: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        if channels.is_empty()
            || resolution.len() != channels.len()
            || resolution.iter().any(|step| !(step.is_finite() && *step > 0.0))
        {
            return Err(PyValueError::new_err("resolution: one number above 0 for each channel"));
        }
        let settings = Settings {
            rate_hz: Some(named(py, "rate", options::rate(rate))?),
            estimator: named(py, "estimator", options::estimator(estimator))?,
            deviation: named(py, "deviation", options::deviation(deviation))?,
            confidence: named(py, "confidence", options::confidence(confidence))?,
            compensated: named(py, "compensated", compensated.as_ref().map(options::is_compensated).transpose())?,
            averaging_times: named(py, "taus", taus.as_ref().map(options::taus).transpose())?.unwrap_or_default(),
            ..Settings::default()
        };
        options::check_taus(&settings)?;
        let channel = |((name, word), scale): ((String, String), f64)| {
            let (quantity, unit) = quantity(&word)?;
            Ok(Channel {
                name: name.into(),
                quantity,
                unit: unit.into(),
                decimals: 0,
                scale,
                zero_counts: 0,
                limit_counts: i32::MAX,
                refresh_hz: None,
                increment_step: None,
            })
        };
        let channels: Vec<Channel> = channels.into_iter().zip(resolution).map(channel).collect::<PyResult<_>>()?;
        let layout = Layout { message: "array".into(), compensated: None, channels: channels.into(), columns: None };
        Ok(Self { layout: Arc::new(layout), analysis: Analysis::new(settings), missing: 0, confidence })
    }

    /// Rows in time order, of as many numbers as there are channels; NaN for what is missing.
    /// `gaps` are the rows before which others are missing, in their order, and how many.
    fn push(&mut self, py: Python<'_>, rows: PyReadonlyArray2<'_, f64>, gaps: Vec<(usize, u64)>) -> PyResult<()> {
        let width = self.layout.channels.len();
        if rows.shape()[1] != width {
            let text = format!("rows have {} numbers, and there are {width} channels", rows.shape()[1]);
            return Err(PyValueError::new_err(text));
        }
        let values = rows.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
        let layout = Arc::clone(&self.layout);
        py.detach(|| check(values, &layout)).map_err(PyValueError::new_err)?;
        let mut begin = 0;
        for (row, missing) in gaps.into_iter().map(|(row, missing)| (row, Some(missing))).chain([(usize::MAX, None)]) {
            let end = row.saturating_mul(width).clamp(begin, values.len());
            for block in values[begin..end].chunks(BLOCK * width) {
                py.detach(|| self.absorb(&layout, block));
                py.check_signals()?;
            }
            self.missing += missing.unwrap_or(0);
            begin = end;
        }
        Ok(())
    }

    /// Rows are missing here; `None` for an unknown number.
    #[pyo3(signature = (missing))]
    fn gap(&mut self, missing: Option<u64>) {
        match missing {
            Some(missing) => self.missing += missing,
            None => self.analysis.gap(None),
        }
    }

    #[getter]
    fn samples(&self) -> u64 {
        self.analysis.timing().samples
    }

    /// The result of all rows so far.
    fn result(&mut self, py: Python<'_>) -> PyResult<Measured> {
        let evaluation = measured::evaluation()?;
        Ok(Measured(py.detach(|| {
            let snapshot = Arc::new(self.analysis.final_snapshot());
            let assessment = Arc::new(Assessment::new(&snapshot, self.confidence));
            let facts = SourceFacts { name: "array".into(), ..SourceFacts::default() };
            let mut result = SourceResult::new(facts, snapshot, assessment, Parts::All);
            // the caller names what is missing
            result.timing.missing = Some(result.timing.missing_at_least);
            // no range of the sensor is known; without others that of the VN-100 is assumed
            result.warnings.retain(|warning| warning.kind != WarningKind::FullRange);
            evaluation.complete(result)
        })))
    }
}

impl Sums {
    /// Counts the rows missing before those that follow.
    fn count_missing(&mut self) {
        if let missing @ 1.. = mem::take(&mut self.missing) {
            self.analysis.gap(Some(missing));
        }
    }

    /// Values that were checked.
    fn absorb(&mut self, layout: &Arc<Layout>, values: &[f64]) {
        let width = layout.channels.len();
        let scales: Vec<f64> = layout.channels.iter().map(|channel| 1.0 / channel.scale).collect();
        let mut counts = vec![0; values.len()];
        let mut is_plain = true;
        for (row, out) in values.chunks_exact(width).zip(counts.chunks_exact_mut(width)) {
            for ((value, scale), count) in row.iter().zip(&scales).zip(out) {
                let scaled = value * scale;
                is_plain &= scaled.abs() < MOST_COUNTS;
                *count = (scaled + SHIFTER).to_bits() as i32;
            }
        }
        if is_plain {
            self.count_missing();
            self.analysis.absorb(&Batch { layout: Some(Arc::clone(layout)), counts, ..Batch::default() });
        } else {
            self.absorb_with_missing(layout, values, &counts);
        }
    }

    /// A row without any number is missing; of others the numbers that are none.
    fn absorb_with_missing(&mut self, layout: &Arc<Layout>, values: &[f64], counts: &[i32]) {
        let width = layout.channels.len();
        let is_missing = |row: &[f64]| row.iter().all(|value| value.is_nan());
        let mut rows = values.chunks_exact(width).zip(counts.chunks_exact(width)).peekable();
        while let Some((row, _)) = rows.peek() {
            if is_missing(row) {
                while rows.next_if(|(row, _)| is_missing(row)).is_some() {
                    self.missing += 1;
                }
                continue;
            }
            self.count_missing();
            let mut batch = Batch { layout: Some(Arc::clone(layout)), ..Batch::default() };
            while let Some((row, counts)) = rows.next_if(|(row, _)| !is_missing(row)) {
                let place = batch.counts.len() / width;
                let absent = row.iter().enumerate().filter(|(_, value)| value.is_nan());
                batch.absent.extend(absent.map(|(channel, _)| AbsentCell { row: place, channel }));
                batch.counts.extend_from_slice(counts);
            }
            self.analysis.absorb(&batch);
        }
    }
}

/// Whether all values are numbers that the counts have, or NaN.
fn check(values: &[f64], layout: &Layout) -> Result<(), String> {
    let width = layout.channels.len();
    let scales: Vec<f64> = layout.channels.iter().map(|channel| 1.0 / channel.scale).collect();
    let is_beyond = |row: &[f64]| {
        let lanes = row.iter().zip(&scales);
        lanes.fold(false, |any, (value, scale)| any | ((value * scale).abs() >= MOST_COUNTS))
    };
    let Some(place) = values.chunks_exact(width).position(is_beyond) else { return Ok(()) };
    let row = &values[place * width..][..width];
    let column = (0..width).find(|column| (row[*column] * scales[*column]).abs() >= MOST_COUNTS).unwrap_or(0);
    let (channel, value) = (&layout.channels[column], row[column]);
    Err(if value.is_infinite() {
        format!("{}: {value} in row {place} is not finite: give NaN for a missing number", channel.name)
    } else {
        format!(
            "{}: {value} in row {place} is beyond ±{:.4e}, the range of 32 bits at a resolution of {:e}: give resolution",
            channel.name,
            channel.scale * MOST_COUNTS,
            channel.scale
        )
    })
}

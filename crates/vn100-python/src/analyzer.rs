//! The sums of arrays: what `Analyzer` accumulates.

use std::{mem, sync::Arc};

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{exceptions::PyValueError, prelude::*};
use vn100_analysis::{Analysis, Assessment, Parts, Settings, SourceFacts, SourceResult};
use vn100_protocol::stream::{AbsentCell, Batch};
use vn100_protocol::{Channel, Layout, Quantity};

use crate::{
    measured,
    options::{self, named},
};

/// Rows that are taken at a time, between looks at signals, while the interpreter is free.
const BLOCK: usize = 1 << 16;

/// 1.5 · 2^52: added to a float below 2^31, it leaves the nearest integer in the low bits.
const SHIFTER: f64 = 6_755_399_441_055_744.0;

/// Binary digits of the largest magnitude of the first rows; three are left for what comes later.
const DIGITS: i32 = 28;

/// Counts have 32 bits.
const MOST_COUNTS: f64 = 2_147_483_647.0;

/// Streaming, exact sums over the channels of arrays.
#[pyclass(module = "vn100")]
pub(crate) struct Sums {
    channels: Vec<(String, Quantity, String)>,
    /// What a count is worth, as it was given.
    resolution: Option<Vec<f64>>,
    /// With what a count is worth; `None` until a row has a number.
    layout: Option<Arc<Layout>>,
    /// Channels whose first rows do not say what a count is worth: all of them are zero.
    is_zero: Vec<bool>,
    analysis: Analysis,
    /// Rows missing since the last one: a gap counts once a row follows, however it was divided.
    missing: u64,
    confidence: f64,
}

/// By the first word of the name.
fn quantity(name: &str) -> (Quantity, &'static str) {
    let prefixes = [
        ("gyro", Quantity::AngularRate, "rad/s"),
        ("accel", Quantity::Acceleration, "m/s^2"),
        ("mag", Quantity::MagneticField, "gauss"),
    ];
    let found = prefixes.into_iter().find(|(prefix, ..)| name.split('_').next() == Some(prefix));
    found.map_or((Quantity::Value, ""), |(_, quantity, unit)| (quantity, unit))
}

#[pymethods]
impl Sums {
    #[new]
    #[pyo3(signature = (channels, rate, resolution, estimator, deviation, confidence, compensated))]
    #[expect(clippy::too_many_arguments, reason = "the Python class around it names and documents them")]
    fn new(
        py: Python<'_>,
        channels: Vec<String>,
        rate: f64,
        resolution: Option<Vec<f64>>,
        estimator: &str,
        deviation: &str,
        confidence: f64,
        compensated: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        if channels.is_empty() {
            return Err(PyValueError::new_err("name a channel at least, as in channels=[\"gyro_x\"]"));
        }
        if let Some(name) = channels.iter().enumerate().find(|(place, name)| channels[..*place].contains(name)) {
            return Err(PyValueError::new_err(format!("the channel {} is named twice", name.1)));
        }
        if let Some(steps) = &resolution
            && (steps.len() != channels.len() || steps.iter().any(|step| !(step.is_finite() && *step > 0.0)))
        {
            return Err(PyValueError::new_err("resolution: one number above 0 for each channel"));
        }
        let settings = Settings {
            rate_hz: Some(named(py, "rate", options::rate(rate))?),
            estimator: named(py, "estimator", options::estimator(estimator))?,
            deviation: named(py, "deviation", options::deviation(deviation))?,
            confidence: named(py, "confidence", options::confidence(confidence))?,
            compensated: named(py, "compensated", compensated.as_ref().map(options::is_compensated).transpose())?,
            ..Settings::default()
        };
        let named = |name: String| {
            let (quantity, unit) = quantity(&name);
            (name, quantity, unit.to_owned())
        };
        Ok(Self {
            channels: channels.into_iter().map(named).collect(),
            resolution,
            layout: None,
            is_zero: Vec::new(),
            analysis: Analysis::new(settings),
            missing: 0,
            confidence,
        })
    }

    /// Rows in time order, of as many numbers as there are channels; NaN for what is missing.
    fn push(&mut self, py: Python<'_>, rows: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let width = self.channels.len();
        if rows.shape()[1] != width {
            let text = format!("rows have {} numbers, and there are {width} channels", rows.shape()[1]);
            return Err(PyValueError::new_err(text));
        }
        let values = rows.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
        if values.is_empty() {
            return Ok(());
        }
        if self.layout.is_none() && py.detach(|| values.iter().all(|value| value.is_nan())) {
            self.missing += (values.len() / width) as u64;
            return Ok(());
        }
        let layout = py.detach(|| self.layout_for(values)).map_err(PyValueError::new_err)?;
        for block in values.chunks(BLOCK * width) {
            py.detach(|| self.absorb(&layout, block));
            py.check_signals()?;
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

    /// The document `vn100.analysis/2`.
    fn document(&mut self, py: Python<'_>) -> PyResult<String> {
        let evaluation = measured::evaluation()?;
        let result = py.detach(|| {
            let snapshot = Arc::new(self.analysis.final_snapshot());
            let assessment = Arc::new(Assessment::new(&snapshot, self.confidence));
            let facts = SourceFacts { name: "array".into(), ..SourceFacts::default() };
            let mut result = SourceResult::new(facts, snapshot, assessment, Parts::All);
            // the caller names what is missing
            result.timing.missing = Some(result.timing.missing_at_least);
            evaluation.complete(result)
        });
        measured::document(&result)
    }
}

impl Sums {
    /// Where these values can be counted in it; the first ones decide what a count is worth, if
    /// that is not given.
    fn layout_for(&mut self, values: &[f64]) -> Result<Arc<Layout>, String> {
        if let Some(layout) = &self.layout {
            check(values, layout, &self.is_zero)?;
            return Ok(Arc::clone(layout));
        }
        let width = self.channels.len();
        let most: Vec<f64> = (0..width).map(|place| most(values.iter().skip(place).step_by(width))).collect();
        let steps = match &self.resolution {
            Some(resolution) => resolution.clone(),
            None => {
                self.channels.iter().zip(&most).map(|((name, ..), most)| step(name, *most)).collect::<Result<_, _>>()?
            }
        };
        let channels = self.channels.iter().zip(steps).map(|((name, quantity, unit), step)| Channel {
            name: name.clone().into(),
            quantity: *quantity,
            unit: unit.clone().into(),
            decimals: 0,
            scale: step,
            limit_counts: i32::MAX,
            refresh_hz: None,
            increment_step: None,
        });
        let layout = Layout {
            message: "array".into(),
            compensated: None,
            channels: channels.collect::<Vec<_>>().into(),
            columns: None,
        };
        let is_zero = most.iter().map(|most| self.resolution.is_none() && *most == 0.0).collect::<Vec<_>>();
        check(values, &layout, &is_zero)?;
        self.is_zero = is_zero;
        Ok(Arc::clone(self.layout.insert(Arc::new(layout))))
    }

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
fn check(values: &[f64], layout: &Layout, is_zero: &[bool]) -> Result<(), String> {
    let width = layout.channels.len();
    let scales: Vec<f64> = layout.channels.iter().map(|channel| 1.0 / channel.scale).collect();
    // of a channel that was zero so far any other number
    let limits: Vec<f64> =
        is_zero.iter().map(|is_zero| if *is_zero { f64::MIN_POSITIVE } else { MOST_COUNTS }).collect();
    let is_beyond = |row: &[f64]| {
        let lanes = row.iter().zip(&scales).zip(&limits);
        lanes.fold(false, |any, ((value, scale), limit)| any | ((value * scale).abs() >= *limit))
    };
    let Some(place) = values.chunks_exact(width).position(is_beyond) else { return Ok(()) };
    let row = &values[place * width..][..width];
    let beyond = |column: &usize| (row[*column] * scales[*column]).abs() >= limits[*column];
    let column = (0..width).find(beyond).unwrap_or(0);
    let (channel, value) = (&layout.channels[column], row[column]);
    Err(match is_zero[column] {
        _ if value.is_infinite() => {
            format!("{}: {value} in row {place} is not finite: give NaN for a missing number", channel.name)
        }
        true => format!(
            "{}: the first rows were all 0 or missing, and {value} in row {place} does not follow from them: give resolution",
            channel.name
        ),
        false => format!(
            "{}: {value} in row {place} is beyond ±{:.4e}, the range of 32 bits at a resolution of {:e}: give resolution",
            channel.name,
            channel.scale * MOST_COUNTS,
            channel.scale
        ),
    })
}

fn most<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.filter(|value| value.is_finite()).fold(0.0_f64, |most, value| most.max(value.abs()))
}

/// A power of two by which the largest magnitude has [`DIGITS`] binary digits.
fn step(channel: &str, most: f64) -> Result<f64, String> {
    if most == 0.0 {
        return Ok(1.0);
    }
    if !(1e-290..1e290).contains(&most) {
        return Err(format!(
            "{channel}: numbers up to {most:e} leave the range of floats when they are summed or divided: scale them"
        ));
    }
    Ok(2_f64.powi(most.log2().floor() as i32 + 1 - DIGITS))
}

//! The summary of a result: which sensor, whether the record can be trusted, its noise parameters
//! beside the data sheet, and what to do about problems. Faces lay it out.

pub(crate) mod parameters;
mod statistics;
pub(crate) mod status;

pub use statistics::mean_temperature;
use vn100_analysis::{RateFrom, RemedyWords, Severity, SourceFacts, Timing};

use crate::{
    document::source::RecordingDocument,
    measured::{Measured, Record},
    numbers::plain::{grouped, short, time},
};

/// The number of axes beside each other in a table; further ones are in another table.
pub const AXES: usize = 3;

/// The summary of a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// What was measured: source, sensor, message and rate, length; then date and temperature.
    pub identity: Vec<String>,
    /// How far the record can be trusted, aspect by aspect, in the order of a measurement.
    pub statuses: Vec<AspectStatus>,
    /// The noise parameters; none if the sensor was moved.
    pub sensors: Vec<SensorTable>,
    /// Means and standard deviations of single samples.
    pub statistics: Vec<StatisticsRow>,
    /// What to do, in sentences. [`AspectStatus::findings`] and [`SensorTable::notes`] refer to
    /// them by their places.
    pub notes: Vec<String>,
}

/// The status of one aspect of the record.
#[derive(Debug, Clone, PartialEq)]
pub struct AspectStatus {
    /// The aspect, such as `at rest`.
    pub aspect: &'static str,
    /// The gravest severity among its warnings; `None` without a warning.
    pub severity: Option<Severity>,
    /// The status in one word.
    pub word: &'static str,
    /// What was found, the gravest first; each with the places of its notes, from 0.
    pub findings: Vec<(String, Vec<usize>)>,
}

/// The parameters of up to three axes of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorTable {
    /// The sensor, as a title.
    pub title: &'static str,
    /// Names of the axes, such as `x`.
    pub axes: Vec<String>,
    /// Whether its parameters are compared with a data sheet.
    pub has_datasheet: bool,
    /// Places of the notes on the comparison.
    pub notes: Vec<usize>,
    /// The parameters, each followed by its details.
    pub rows: Vec<ParameterRow>,
}

/// A row of a [`SensorTable`].
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterRow {
    /// The parameter, or the detail that the row adds to the one before.
    pub label: String,
    /// The unit; empty if the row has none.
    pub unit: &'static str,
    /// Whether the row is a detail of the parameter above.
    pub is_detail: bool,
    /// The cells of the axes.
    pub cells: Cells,
    /// The figure of the data sheet, in the same unit, and the verdict; `None` if there is no
    /// figure.
    pub figure: Option<(String, VerdictWord)>,
}

/// The cells of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// One cell for each axis.
    Axes(Vec<String>),
    /// One text for all axes.
    All(&'static str),
}

/// A verdict in one word.
#[derive(Debug, Clone, PartialEq)]
pub struct VerdictWord {
    /// The word, with the letters of the axes where it does not apply to all.
    pub word: String,
    /// Whether the parameter fails a limit.
    pub is_failed: bool,
}

/// Mean or standard deviation of the axes of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct StatisticsRow {
    /// The label, such as `gyro mean`.
    pub label: String,
    /// The unit of the cells.
    pub unit: &'static str,
    /// One cell for each axis.
    pub cells: Vec<String>,
    /// A remark on the row; may be empty.
    pub remark: String,
}

impl Summary {
    /// The summary of a result, with remedies in the words of a face.
    #[must_use]
    pub fn new(record: &Record<'_>, words: RemedyWords) -> Self {
        let mut notes = Notes { words, texts: Vec::new() };
        let statuses = status::statuses(record, &mut notes);
        let sensors = match record.measured.assessment.motion {
            Some(_) => Vec::new(),
            None => parameters::tables(record, &mut notes),
        };
        Self {
            identity: identity(record.measured),
            statuses,
            sensors,
            statistics: statistics::rows(record),
            notes: notes.texts,
        }
    }
}

/// The notes so far.
struct Notes {
    words: RemedyWords,
    texts: Vec<String>,
}

impl Notes {
    /// The place of this note, which is there once.
    fn place(&mut self, text: String) -> usize {
        self.texts.iter().position(|other| *other == text).unwrap_or_else(|| {
            self.texts.push(text);
            self.texts.len() - 1
        })
    }
}

fn identity(measured: &Measured) -> Vec<String> {
    let Measured { facts, snapshot, .. } = measured;
    let SourceFacts { name, stream, recording, .. } = facts;
    let mut parts = vec![match stream {
        Some(stream) => format!("{name} {stream}"),
        None => name.clone(),
    }];
    let register = |number: u8| snapshot.registers.get(&number).map(|text| text.trim().to_owned());
    parts.extend(match (register(1), register(3)) {
        (Some(model), Some(serial)) => Some(format!("{model} s/n {serial}")),
        (model, serial) => model.or(serial.map(|serial| format!("s/n {serial}"))),
    });
    let timing = &snapshot.timing;
    parts.push(match &snapshot.layout {
        Some(layout) => format!("{} {}", layout.message, rate(timing)),
        None => "no message".into(),
    });
    parts.push(match timing.duration_s() {
        seconds @ 60.0.. => time(seconds),
        seconds => format!("{} s", short((seconds * 1000.0).round() / 1000.0)),
    });
    parts.push(format!("{} samples", grouped(timing.samples)));
    let started = recording.as_ref().and_then(|recording| RecordingDocument::new(recording).started);
    parts.extend(started.map(|started| format!("started {started}")));
    parts.extend(mean_temperature(snapshot));
    parts
}

fn rate(timing: &Timing) -> String {
    let assumed = if timing.rate_from == RateFrom::Assumed { " (assumed)" } else { "" };
    format!("{} Hz{assumed}", short(timing.rate_hz))
}

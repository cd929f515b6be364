//! The summary of a result: which sensor, its noise parameters beside the data sheet, whether the
//! record can be trusted, and what to do about problems. Faces lay it out.

pub(crate) mod parameters;
mod statistics;
pub(crate) mod status;

use schemars::JsonSchema;
use serde::{Serialize, Serializer};
use vn100_analysis::{RemedyWords, Severity, SourceFacts, SourceResult, TimeBase};

use crate::{
    drift,
    numbers::plain::{grouped, short, time},
};
pub use statistics::mean_temperature;
pub use status::StatusWord;

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
    /// How far heading, velocity and position drift while the sensor coasts, in one line each.
    pub drift: Vec<String>,
    /// Means and standard deviations of single samples.
    pub statistics: Vec<StatisticsRow>,
    /// What to do, in sentences. [`AspectStatus::findings`] and [`SensorTable::notes`] refer to
    /// them by their places.
    pub notes: Vec<String>,
}

/// How far one aspect of the record can be trusted.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct AspectStatus {
    /// Aspect of the record.
    pub aspect: &'static str,
    /// The gravest severity among its warnings; `None` without a warning.
    #[serde(skip)]
    pub severity: Option<Severity>,
    /// Status of the aspect.
    #[serde(rename = "status")]
    pub word: StatusWord,
    /// What was found, the gravest first; each with the places of its notes, from 0.
    #[serde(serialize_with = "texts")]
    #[schemars(with = "Vec<String>")]
    pub findings: Vec<(String, Vec<usize>)>,
}

fn texts<S: Serializer>(findings: &[(String, Vec<usize>)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(findings.iter().map(|(text, _)| text))
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
    /// The label if there is little room.
    pub short_label: &'static str,
    /// The unit; empty if it is that of the row before.
    pub unit: &'static str,
    /// Whether the row is a detail of the parameter above.
    pub is_detail: bool,
    /// The cells of the axes; a single one of several axes is for all.
    pub cells: Vec<String>,
    /// The figure of the data sheet, in the same unit, and the verdict; `None` if there is no
    /// figure.
    pub figure: Option<(String, VerdictWord)>,
}

/// A verdict in one word.
#[derive(Debug, Clone, PartialEq)]
pub struct VerdictWord {
    /// The word, with the letters of the axes if it does not apply to all.
    pub word: String,
    /// Whether the parameter fails a limit.
    pub is_failed: bool,
}

/// Mean and standard deviation of the axes of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct StatisticsRow {
    /// The label, such as `gyro`.
    pub label: String,
    /// The unit of the cells.
    pub unit: &'static str,
    /// The mean of each axis; empty texts for angles, whose direction says nothing of the sensor.
    pub means: Vec<String>,
    /// The standard deviation of each axis.
    pub stds: Vec<String>,
    /// The length of the mean vector; empty without one.
    pub remark: String,
}

impl Summary {
    /// The summary of a result, with remedies in the words of a face.
    pub fn new(result: &SourceResult, words: RemedyWords) -> Self {
        let mut notes = Notes { words, texts: Vec::new() };
        // what to do about the record before what the data sheet cannot decide
        let statuses = status::statuses(result, |remedy| notes.place(words(remedy)));
        let sensors = match result.motion {
            Some(_) => Vec::new(),
            None => parameters::tables(result, &mut notes),
        };
        let (identity, statistics) = (identity(result), statistics::rows(result));
        Self { identity, statuses, sensors, drift: drift::lines(result), statistics, notes: notes.texts }
    }
}

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

fn identity(result: &SourceResult) -> Vec<String> {
    let SourceFacts { name, stream, recording, device, message, .. } = &result.source;
    let mut parts = vec![match stream {
        Some(stream) => format!("{name} {stream}"),
        None => name.clone(),
    }];
    let device = device.as_ref();
    let (model, serial) =
        (device.and_then(|device| device.model.as_ref()), device.and_then(|device| device.serial_number.as_ref()));
    parts.extend(match (model, serial) {
        (Some(model), Some(serial)) => Some(format!("{model} s/n {serial}")),
        (model, serial) => model.cloned().or(serial.map(|serial| format!("s/n {serial}"))),
    });
    let timing = &result.timing;
    parts.push(match message {
        Some(message) => format!("{message} {}", rate_text(timing)),
        None => "no message".into(),
    });
    parts.push(match timing.duration_s {
        seconds @ 60.0.. => time(seconds),
        seconds => format!("{} s", short((seconds * 1000.0).round() / 1000.0)),
    });
    parts.push(format!("{} samples", grouped(timing.samples)));
    let started = recording.as_ref().and_then(|recording| recording.started());
    parts.extend(started.map(|started| format!("started {started}")));
    parts.extend(mean_temperature(result));
    parts
}

/// The nominal rate, as `40 Hz`, `40 Hz (assumed)` or `rate unknown`.
pub fn rate_text(timing: &TimeBase) -> String {
    let assumed = if timing.is_rate_assumed() { " (assumed)" } else { "" };
    timing.rate_hz.map_or_else(|| "rate unknown".into(), |hz| format!("{} Hz{assumed}", short(hz)))
}

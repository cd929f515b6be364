//! The JSON document of an archive, schema `vn100.archive/1`: a contract with scripts. A row for
//! each recording with its channels, and a pool of the recordings of each sensor.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. Everything is made from a
//! [`State`], so that the result does not depend on where and in which order the recordings were
//! read.

use std::collections::BTreeMap;

use serde::Serialize;
use vn100_analysis::noise::{Parameter, Term};
use vn100_analysis::protocol::Register;
use vn100_analysis::{
    Analysis, Assessment, NotAppended, Pool, RecordedPieces, RecordingFacts, RemedyWords, SourceFacts, State,
    in_parallel,
};

use super::{noise::claim_name, pool::PoolDocument};
use crate::{
    codes::{code_of_status, code_of_verdict, term_name},
    measured::{Completion, Evaluation, Measured},
    units::{channel_values, si_unit},
};

/// The JSON Schema (2020-12) of [`ArchiveDocument`], with a description of every field.
pub const ARCHIVE_SCHEMA: &str = include_str!("../../schemas/archive.json");

/// The JSON document of an archive.
#[derive(Debug, Serialize)]
pub struct ArchiveDocument {
    schema: &'static str,
    /// By name.
    pub(crate) recordings: Vec<RecordingRow>,
    /// By serial number.
    pub(crate) sensors: Vec<SensorDocument>,
    /// Recordings that do not say which sensor they are of: they are pooled with none.
    without_serial: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(crate) struct RecordingRow {
    pub(crate) name: String,
    /// Why it could not be read, or not to its end.
    pub(crate) error: Option<String>,
    pub(crate) serial: Option<String>,
    pub(crate) model: Option<String>,
    pub(crate) message: Option<String>,
    /// Nanoseconds since 1970-01-01 UTC.
    pub(crate) started_ns: Option<i64>,
    pub(crate) rate_hz: Option<f64>,
    pub(crate) duration_s: f64,
    pub(crate) samples: u64,
    pub(crate) missing: u64,
    pub(crate) channels: Vec<ChannelRow>,
    pub(crate) warnings: Vec<WarningRow>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ChannelRow {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) mean: Option<f64>,
    pub(crate) std: Option<f64>,
    pub(crate) noise: Vec<ParameterRow>,
    pub(crate) verdicts: Vec<VerdictRow>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ParameterRow {
    pub(crate) parameter: &'static str,
    pub(crate) status: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) value: Option<f64>,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(crate) struct VerdictRow {
    pub(crate) parameter: &'static str,
    /// Of the data sheet: a limit, or a typical figure.
    pub(crate) claim: &'static str,
    pub(crate) verdict: &'static str,
}

#[derive(Debug, Serialize)]
pub(crate) struct WarningRow {
    pub(crate) kind: &'static str,
    severity: &'static str,
    channels: Vec<String>,
    text: String,
}

#[derive(Debug, Serialize)]
pub(crate) struct SensorDocument {
    serial: String,
    recordings: Vec<String>,
    /// A recording so far off that any would be in less than 5 % of pools.
    outliers: Vec<Outlier>,
    /// One for each stream that the sensor sent.
    pools: Vec<PoolDocument>,
}

#[derive(Debug, Serialize)]
struct Outlier {
    recording: String,
    channel: String,
    parameter: &'static str,
    /// Over what the others foretell.
    ratio: f64,
    /// Corrected for all recordings and parameters.
    p: Option<f64>,
    text: String,
}

/// The result of a recording as a state with this name: its sums, where it has a sample, and why it
/// could not be read, or not to its end.
#[must_use]
pub fn state_of_measured(name: &str, measured: &Measured, analysis: Option<&mut Analysis>) -> State {
    let error = measured.facts.error.as_deref();
    match analysis.filter(|_| measured.snapshot.timing.samples > 0) {
        Some(analysis) => {
            let state = State::of(name, measured.compared().started_ns, analysis);
            error.into_iter().fold(state, State::with_error)
        }
        None => State::unreadable(name, error.unwrap_or("no sample")),
    }
}

/// The result of a recording in a state; `None` where the recording could not be read.
///
/// # Errors
/// [`NotAppended`](vn100_analysis::NotAppended) when the pieces of the recording cannot be appended
/// to each other.
pub fn measured_of_state(
    recording: &RecordedPieces<'_>,
    evaluation: &Evaluation,
) -> Result<Option<Measured>, NotAppended> {
    let Some(analysis) = recording.analysis()? else { return Ok(None) };
    let snapshot = analysis.final_snapshot();
    let assessment = Assessment::new(&snapshot, analysis.settings().confidence);
    let facts = SourceFacts {
        name: recording.name.to_owned(),
        error: recording.error.map(str::to_owned),
        recording: recording
            .started_ns
            .map(|started_ns| RecordingFacts { started_ns: Some(started_ns), ..RecordingFacts::default() }),
        ..SourceFacts::default()
    };
    Ok(Some(evaluation.complete(Measured::ended(facts, snapshot.into(), assessment, &[]))))
}

impl ArchiveDocument {
    /// The document of all recordings of a state; remedies are put into `words`.
    #[must_use]
    pub fn new(state: &State, evaluation: &Evaluation, words: RemedyWords) -> Self {
        let rows = in_parallel(state.recordings(), |recording| match measured_of_state(&recording, evaluation) {
            Ok(Some(measured)) => (RecordingRow::new(&measured, words), Some(without_samples(measured))),
            Ok(None) => (RecordingRow::unreadable(&recording, recording.error.map(str::to_owned)), None),
            Err(error) => (RecordingRow::unreadable(&recording, Some(error.to_string())), None),
        });
        let mut by_serial: BTreeMap<&str, Vec<&Measured>> = BTreeMap::new();
        let mut without_serial = Vec::new();
        for (row, measured) in &rows {
            match (&row.serial, measured) {
                (Some(serial), Some(measured)) => by_serial.entry(serial).or_default().push(measured),
                (None, Some(_)) => without_serial.push(row.name.clone()),
                (_, None) => {}
            }
        }
        let sensors = by_serial.into_iter().map(|(serial, measured)| SensorDocument::new(serial, &measured)).collect();
        Self {
            schema: "vn100.archive/1",
            sensors,
            without_serial,
            recordings: rows.into_iter().map(|(row, _)| row).collect(),
        }
    }

    /// Number of recordings.
    #[must_use]
    pub fn recordings(&self) -> usize {
        self.recordings.len()
    }

    /// The worst completion among the recordings.
    #[must_use]
    pub fn completion(&self) -> Completion {
        let of = |row: &RecordingRow| match (&row.error, row.samples) {
            (None, _) => Completion::Complete,
            (Some(_), 0) => Completion::NoData,
            (Some(_), _) => Completion::Failed,
        };
        self.recordings.iter().map(of).max().unwrap_or(Completion::NoData)
    }

    /// Which recordings could not be read, and which are outliers, in words.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let errors = self.recordings.iter().filter_map(|row| {
            // its source is the file without its folder
            let error = row.error.as_ref()?;
            let (source, rest) = error.split_once(": ").unwrap_or(("", error));
            Some(match row.name.ends_with(source) && !error.contains(&row.name) {
                true => format!("{}: {rest}", row.name),
                false => error.clone(),
            })
        });
        let out = self.sensors.iter().flat_map(|sensor| sensor.outliers.iter().map(|out| out.text.clone()));
        errors.chain(out).collect()
    }
}

/// Pools need the sums of deviations, and not what shows where a record is disturbed.
fn without_samples(mut measured: Measured) -> Measured {
    let snapshot = std::sync::Arc::make_mut(&mut measured.snapshot);
    for channel in &mut snapshot.channels {
        (channel.signal, channel.histogram) = (None, vn100_analysis::noise::Histogram::new());
    }
    (snapshot.temperature, snapshot.recent) = (None, None);
    measured
}

impl RecordingRow {
    fn new(measured: &Measured, words: RemedyWords) -> Self {
        let (snapshot, facts) = (&measured.snapshot, &measured.facts);
        let register = |register: Register| snapshot.registers.get(&register.0).map(|text| text.trim().to_owned());
        let timing = &snapshot.timing;
        let values = channel_values(snapshot, &measured.assessment);
        Self {
            name: facts.name.clone(),
            error: facts.error.clone(),
            serial: register(Register::SERIAL_NUMBER),
            model: register(Register::MODEL),
            message: snapshot.layout.as_ref().map(|layout| layout.message.to_string()),
            started_ns: facts.recording.as_ref().and_then(|recording| recording.started_ns),
            rate_hz: Some(timing.rate_hz),
            duration_s: timing.duration_s(),
            samples: timing.samples,
            missing: timing.missing,
            channels: (values.iter().enumerate())
                .map(|(place, values)| ChannelRow {
                    name: values.name.clone(),
                    unit: values.unit.clone(),
                    mean: values.mean,
                    std: values.std,
                    noise: values.noise.as_ref().map_or_else(Vec::new, |noise| {
                        let found = |term| Some((term, noise.parameter(term)?));
                        let parameters = Term::ALL.into_iter().filter_map(found);
                        let unit = |term| si_unit(noise.sensor, term);
                        parameters.map(|(term, found)| ParameterRow::new(term, found, unit(term))).collect()
                    }),
                    verdicts: (measured.verdicts.iter())
                        .flat_map(|verdicts| verdicts.channels.get(place))
                        .flatten()
                        .map(|judged| VerdictRow {
                            parameter: term_name(judged.figure.term),
                            claim: claim_name(&judged.figure.claim),
                            verdict: code_of_verdict(judged.verdict).code,
                        })
                        .collect(),
                })
                .collect(),
            warnings: (measured.warnings().into_iter())
                .map(|warning| WarningRow {
                    kind: warning.kind.name(),
                    severity: warning.severity.name(),
                    channels: warning.channels.clone(),
                    text: warning.in_words(words),
                })
                .collect(),
        }
    }

    fn unreadable(recording: &RecordedPieces<'_>, error: Option<String>) -> Self {
        Self {
            name: recording.name.to_owned(),
            error,
            serial: None,
            model: None,
            message: None,
            started_ns: recording.started_ns,
            rate_hz: None,
            duration_s: 0.0,
            samples: 0,
            missing: 0,
            channels: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

impl ParameterRow {
    fn new(term: Term, Parameter { status, value, lower, upper, .. }: Parameter, unit: &'static str) -> Self {
        Self { parameter: term_name(term), status: code_of_status(status).code, unit, value, lower, upper }
    }
}

impl SensorDocument {
    fn new(serial: &str, measured: &[&Measured]) -> Self {
        let records: Vec<_> = measured.iter().map(|measured| measured.compared()).collect();
        let confidence = measured.first().map_or(vn100_analysis::DEFAULT_CONFIDENCE, |one| one.assessment.confidence);
        let pools = Pool::by_stream(&records, confidence);
        let measured_by =
            measured.first().map_or_else(Default::default, |one| (one.snapshot.deviation, one.snapshot.estimator));
        let mut outliers = Vec::new();
        for (pool, channel) in pools.iter().flat_map(|pool| pool.channels.iter().map(move |channel| (pool, channel))) {
            for parameter in &channel.parameters {
                let (Some(part), Some(farthest)) = (parameter.outlier(), parameter.pooled.and_then(|all| all.farthest))
                else {
                    continue;
                };
                let (recording, term) = (pool.parts[part].name.clone(), term_name(parameter.term));
                let text = format!(
                    "{recording}: {term} of {} is {:.2} times what the other recordings foretell; one so far off is \
                     in less than 5 % of pools",
                    channel.channel.name, farthest.ratio
                );
                outliers.push(Outlier {
                    recording,
                    channel: channel.channel.name.to_string(),
                    parameter: term,
                    ratio: farthest.ratio,
                    p: parameter.corrected,
                    text,
                });
            }
        }
        Self {
            serial: serial.to_owned(),
            recordings: measured.iter().map(|measured| measured.facts.name.clone()).collect(),
            outliers,
            pools: pools.iter().map(|pool| PoolDocument::new(pool, measured_by)).collect(),
        }
    }
}

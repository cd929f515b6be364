//! Tables as CSV: full precision, nothing if a number is not known.

use std::fmt::Write;

use vn100_analysis::noise::{Claim, Convention, Parameter, Term, conventions, temperature_conventions};
use vn100_analysis::protocol::Register;
use vn100_analysis::{ChannelNoise, RemedyWords};

use crate::warnings::{details, headline};
use crate::{
    codes::{code_of_rate, code_of_status, code_of_verdict, term_name},
    document::{noise::sides_name, source::RecordingDocument},
    graphical::{GRAPHICAL, not_read_code},
    measured::Record,
    names::{p_without, sentence},
    temperature::coefficient_parameter,
    units::{BlockValues, ChannelValues, Point, si_unit},
};

/// A table of a report.
#[derive(Debug, Clone, Copy)]
pub struct CsvTable {
    /// The ending of the name of its file.
    pub ending: &'static str,
    /// Writes the table: a header, and a row for each channel and point. Remedies are put into the
    /// given words.
    pub text: fn(&Record<'_>, RemedyWords) -> String,
}

impl CsvTable {
    /// All tables.
    pub const ALL: [Self; 10] = [
        Self { ending: ".metadata.csv", text: |record, _| metadata(record) },
        Self { ending: ".allan.csv", text: |record, _| allan(record) },
        Self { ending: ".statistics.csv", text: |record, _| statistics(record) },
        Self { ending: ".parameters.csv", text: |record, _| parameters(record) },
        Self { ending: ".fit.csv", text: |record, _| fit(record) },
        Self { ending: ".verdicts.csv", text: |record, _| verdicts(record) },
        Self { ending: ".warnings.csv", text: warnings },
        Self { ending: ".spectrum.csv", text: |record, _| spectrum(record) },
        Self { ending: ".segments.csv", text: |record, _| segments(record) },
        Self { ending: ".histogram.csv", text: |record, _| histogram(record) },
    ];
}

const ALLAN: &str = "channel,unit,m,tau_s,deviation,lower,upper,edf,terms,alpha,fitted";
const STATISTICS: &str = "channel,unit,count,mean,std,min,max,skewness,excess_kurtosis,resolution";
const PARAMETERS: &str = "channel,parameter,status,value,lower,upper,unit,p,sides,is_si";
const FIT: &str = "channel,tau_min_s,tau_max_s,chi2,dof,p";
const VERDICTS: &str = "channel,parameter,verdict,datasheet,figure,claim,measured,measured_lower,measured_upper,expected_low,expected_high,unit,text";
const WARNINGS: &str = "kind,severity,channels,headline,details";
pub(super) const METADATA: &str = "name,value";
/// The beginning of its first row.
pub(super) const METADATA_ROW: &str = "capture,";
const SPECTRUM: &str = "channel,unit,frequency_hz,psd_one_sided";
const SEGMENTS: &str = "channel,unit,start_s,duration_s,count,mean,std,min,max";
const HISTOGRAM: &str = "channel,unit,from,to,count";

/// Of all tables.
pub(super) const HEADERS: [&str; 10] =
    [ALLAN, STATISTICS, PARAMETERS, FIT, VERDICTS, WARNINGS, METADATA, SPECTRUM, SEGMENTS, HISTOGRAM];

pub(super) struct Table(pub(super) String);

impl Table {
    pub(super) fn new(header: &str) -> Self {
        Self(format!("{header}\n"))
    }

    pub(super) fn row(&mut self, cells: &[&str]) {
        let quoted = |cell: &&str| {
            if cell.contains([',', '"', '\n', '\r']) {
                format!("\"{}\"", cell.replace('"', "\"\""))
            } else {
                (*cell).into()
            }
        };
        let row = cells.iter().map(quoted).collect::<Vec<String>>().join(",");
        // a String takes everything
        let _ = writeln!(self.0, "{row}");
    }

    /// A row of numbers of a channel in its unit.
    fn numbers(&mut self, channel: &str, unit: &str, values: &[Option<f64>]) {
        let values: Vec<String> = values.iter().copied().map(number).collect();
        let cells: Vec<&str> = [channel, unit].into_iter().chain(values.iter().map(String::as_str)).collect();
        self.row(&cells);
    }
}

/// The shortest decimal that reads back as the same number.
pub(super) fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value == 0.0 || (1e-4..1e15).contains(&value.abs()) => value.to_string(),
        Some(value) => format!("{value:e}"),
        None => String::new(),
    }
}

fn allan(record: &Record<'_>) -> String {
    let mut table = Table::new(ALLAN);
    for channel in &record.channels {
        for &Point { m, tau_s, deviation, lower, upper, edf, terms, alpha, fitted } in &channel.deviations {
            let (m, terms, alpha) = (Some(m as f64), Some(terms as f64), alpha.map(f64::from));
            let values = [m, Some(tau_s), deviation, lower, upper, edf, terms, alpha, fitted];
            table.numbers(&channel.name, &channel.unit, &values);
        }
    }
    table.0
}

fn statistics(record: &Record<'_>) -> String {
    let mut table = Table::new(STATISTICS);
    for channel in &record.channels {
        let ChannelValues { mean, std, min, max, skewness, excess_kurtosis, .. } = *channel;
        let (count, resolution) = (Some(channel.count as f64), Some(channel.resolution));
        let values = [count, mean, std, min, max, skewness, excess_kurtosis, resolution];
        table.numbers(&channel.name, &channel.unit, &values);
    }
    for norm in &record.norms {
        let values = [Some(norm.count as f64), norm.mean, norm.std, norm.min, norm.max, None, None, None];
        table.numbers(&norm.name, &norm.unit, &values);
    }
    table.0
}

/// Each parameter in every unit in use, the SI unit first.
fn parameters(record: &Record<'_>) -> String {
    let mut table = Table::new(PARAMETERS);
    for channel in &record.channels {
        let Some(noise) = &channel.noise else { continue };
        let mut rows = |name: &str, parameter: Option<Parameter>, conventions: &[Convention]| {
            let Some(Parameter { status, value, lower, upper, p }) = parameter else { return };
            for (place, convention) in conventions.iter().enumerate() {
                let [value, lower, upper] = [value, lower, upper].map(|si| number(si.map(|si| si * convention.factor)));
                let sides = convention.sides.map_or("", sides_name);
                let (status, p) = (code_of_status(status).code, number(p));
                let is_si = if place == 0 { "true" } else { "false" };
                table.row(&[&channel.name, name, status, &value, &lower, &upper, convention.unit, &p, sides, is_si]);
            }
        };
        for term in Term::ALL {
            let parameter = noise.parameter(term).map(|found| Parameter { p: p_without(term, &found), ..found });
            rows(term_name(term), parameter, conventions(noise.sensor, term));
        }
        let of_temperature = noise.temperature.as_ref().map(coefficient_parameter);
        rows("temperature_coefficient", of_temperature, temperature_conventions(noise.sensor));
        rows("curve_minimum", noise.curve_minimum(), conventions(noise.sensor, Term::BiasInstability));
        graphical(&mut table, channel, noise);
    }
    table.0
}

/// What the graphical slope method reads, in the same units; the status says so, or why there is
/// no value.
fn graphical(table: &mut Table, channel: &ChannelValues, noise: &ChannelNoise) {
    for (term, _) in GRAPHICAL {
        let (name, read) = (format!("graphical_{}", term_name(term)), noise.classical.of(term));
        let status = read.map_or_else(not_read_code, |_| "graphical");
        for (place, convention) in conventions(noise.sensor, term).iter().enumerate() {
            let value = number(read.ok().map(|line| line.value * convention.factor));
            let is_si = if place == 0 { "true" } else { "false" };
            let sides = convention.sides.map_or("", sides_name);
            table.row(&[&channel.name, &name, status, &value, "", "", convention.unit, "", sides, is_si]);
        }
    }
}

fn fit(record: &Record<'_>) -> String {
    let mut table = Table::new(FIT);
    for channel in &record.channels {
        let Some(quality) = channel.noise.as_ref().and_then(|noise| noise.fit.quality) else { continue };
        let values = [quality.tau_min_s, quality.tau_max_s, quality.chi2, quality.dof as f64, quality.p];
        let values = values.map(|value| number(Some(value)));
        let cells: Vec<&str> = [&channel.name].into_iter().chain(&values).map(String::as_str).collect();
        table.row(&cells);
    }
    table.0
}

fn verdicts(record: &Record<'_>) -> String {
    let mut table = Table::new(VERDICTS);
    let datasheet = record.measured.verdicts.as_ref().map_or("", |verdicts| &verdicts.datasheet);
    for channel in &record.channels {
        let Some(noise) = &channel.noise else { continue };
        for verdict in record.verdicts(channel) {
            let Parameter { value, lower, upper, .. } = verdict.measured;
            let (low, high) = verdict.expected;
            let [value, lower, upper, low, high] = [value, lower, upper, Some(low), Some(high)].map(number);
            let claim = match verdict.figure.claim {
                Claim::Limit(_) => "limit",
                Claim::Typical { .. } => "typical",
            };
            table.row(&[
                &channel.name,
                term_name(verdict.figure.term),
                verdict.verdict.map_or("", |verdict| code_of_verdict(verdict).code),
                datasheet,
                &verdict.figure.printed,
                claim,
                &value,
                &lower,
                &upper,
                &low,
                &high,
                si_unit(noise.sensor, verdict.figure.term),
                &sentence(noise.sensor, verdict),
            ]);
        }
    }
    table.0
}

fn warnings(record: &Record<'_>, words: RemedyWords) -> String {
    let mut table = Table::new(WARNINGS);
    for warning in record.measured.warnings() {
        let (channels, details) = (warning.channels.join(" "), details(warning, words));
        table.row(&[warning.kind.name(), warning.severity.name(), &channels, &headline(warning), &details]);
    }
    table.0
}

/// What a record is, by name; empty if it is not known.
pub(super) fn identity(record: &Record<'_>) -> Vec<(&'static str, String)> {
    let (facts, snapshot) = (&record.measured.facts, &record.measured.snapshot);
    let register = |register: Register| snapshot.registers.get(&register.0).map(|text| text.trim().to_owned());
    let started = facts.recording.as_ref().and_then(|recording| RecordingDocument::new(recording).started);
    let layout = snapshot.layout.as_ref();
    let optional = [
        ("stream", facts.stream.clone()),
        ("sha256", facts.file.as_ref().map(|file| file.sha256.clone())),
        ("model", register(Register::MODEL)),
        ("serial_number", register(Register::SERIAL_NUMBER)),
        ("firmware", register(Register::FIRMWARE)),
        ("started_utc", started),
        ("message", layout.map(|layout| layout.message.to_string())),
        ("compensated", layout.and_then(|layout| layout.compensated).map(|compensated| compensated.to_string())),
    ];
    let mut cells = vec![("capture", facts.name.clone())];
    cells.extend(optional.map(|(name, value)| (name, value.unwrap_or_default())));
    cells.extend([
        ("rate_hz", number(Some(snapshot.timing.rate_hz))),
        ("rate_from", code_of_rate(snapshot.timing.rate_from).code.to_owned()),
        ("samples", snapshot.timing.samples.to_string()),
        ("duration_s", number(Some(snapshot.timing.duration_s()))),
        ("confidence", number(Some(record.measured.assessment.confidence))),
    ]);
    cells
}

fn metadata(record: &Record<'_>) -> String {
    let mut table = Table::new(METADATA);
    identity(record).iter().for_each(|(name, value)| table.row(&[name, value]));
    table.0
}

fn spectrum(record: &Record<'_>) -> String {
    let mut table = Table::new(SPECTRUM);
    for channel in &record.channels {
        let unit = format!("({})^2/Hz", channel.unit);
        let density = channel.signal.as_ref().and_then(|signal| signal.density.as_ref());
        for point in density.iter().flat_map(|density| &density.points) {
            table.numbers(&channel.name, &unit, &[Some(point.frequency_hz), Some(point.density_unit2_hz)]);
        }
    }
    table.0
}

fn segments(record: &Record<'_>) -> String {
    let mut table = Table::new(SEGMENTS);
    for channel in &record.channels {
        for block in channel.signal.iter().flat_map(|signal| &signal.blocks) {
            let BlockValues { start_s, duration_s, count, mean, std, min, max } = *block;
            let [start_s, duration_s, count, mean, min, max] =
                [start_s, duration_s, count as f64, mean, min, max].map(Some);
            let values = [start_s, duration_s, count, mean, std, min, max];
            table.numbers(&channel.name, &channel.unit, &values);
        }
    }
    table.0
}

fn histogram(record: &Record<'_>) -> String {
    let mut table = Table::new(HISTOGRAM);
    for channel in &record.channels {
        let Some(bars) = &channel.bars else { continue };
        for (index, count) in bars.counts.iter().enumerate() {
            let edge = |index: usize| Some(bars.first + bars.width * index as f64);
            table.numbers(&channel.name, &channel.unit, &[edge(index), edge(index + 1), Some(*count as f64)]);
        }
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be_and_numbers_read_back() {
        let mut table = Table::new("a,b");
        table.row(&["x,\"y\"", "z"]);
        assert_eq!(table.0, "a,b\n\"x,\"\"y\"\"\",z\n");
        for value in [0.0, 1.5, -9.887_886_4, 7.67e-6, 1e20] {
            assert_eq!(number(Some(value)).parse::<f64>().unwrap(), value);
        }
        assert_eq!(number(None), "");
    }
}

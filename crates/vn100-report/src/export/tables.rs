//! Tables as CSV: full precision, nothing if a number is not known.

use std::fmt::Write;

use vn100_analysis::noise::{Parameter, Term, conventions, si_unit};
use vn100_analysis::{
    Completion, Discrete, InUnit, ParameterResult, Point, RemedyWords, SourceResult, Statistics, TemperatureResult,
};

use crate::warnings::{details, headline};
use crate::{codes::name_of, graphical::GRAPHICAL, names::sentence};

/// A table of a report.
#[derive(Debug, Clone, Copy)]
pub struct CsvTable {
    /// The ending of the name of its file.
    pub ending: &'static str,
    header: &'static str,
    rows: fn(&mut Table, &SourceResult, RemedyWords),
}

impl CsvTable {
    /// All tables.
    pub const ALL: [Self; 7] = [
        Self { ending: ".metadata.csv", header: METADATA, rows: |table, record, _| metadata(table, record) },
        Self { ending: ".allan.csv", header: ALLAN, rows: |table, record, _| allan(table, record) },
        Self { ending: ".statistics.csv", header: STATISTICS, rows: |table, record, _| statistics(table, record) },
        Self { ending: ".parameters.csv", header: PARAMETERS, rows: |table, record, _| parameters(table, record) },
        Self { ending: ".verdicts.csv", header: VERDICTS, rows: |table, record, _| verdicts(table, record) },
        Self { ending: ".warnings.csv", header: WARNINGS, rows: warnings },
        Self { ending: ".spectrum.csv", header: SPECTRUM, rows: |table, record, _| spectrum(table, record) },
    ];

    /// The table: a header, and a row for each channel and point.
    pub fn text(&self, record: &SourceResult, words: RemedyWords) -> String {
        let mut table = Table(format!("{}\n", self.header));
        (self.rows)(&mut table, record, words);
        table.0
    }
}

/// Whether that is the first line of one of the tables.
pub(super) fn is_header(line: &str) -> bool {
    CsvTable::ALL.iter().any(|table| table.header == line)
}

const ALLAN: &str = "channel,unit,m,tau_s,deviation,lower,upper,edf,terms,alpha,fitted";
const STATISTICS: &str = "channel,unit,count,mean,std,min,max,skewness,excess_kurtosis,resolution";
const PARAMETERS: &str = "channel,parameter,status,value,lower,upper,unit,p,sides,is_si";
const VERDICTS: &str = "channel,parameter,verdict,datasheet,figure,claim,measured,measured_lower,measured_upper,expected_low,expected_high,unit,text";
const WARNINGS: &str = "kind,severity,channels,headline,details";
pub(super) const METADATA: &str = "name,value";
/// The beginning of its first row.
pub(super) const METADATA_ROW: &str = "capture,";
const SPECTRUM: &str = "channel,unit,frequency_hz,psd_one_sided";

struct Table(String);

impl Table {
    fn row(&mut self, cells: &[&str]) {
        let row = cells.iter().map(|cell| quoted(cell)).collect::<Vec<String>>().join(",");
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

/// A cell, between quotation marks if it has to be.
pub(super) fn quoted(cell: &str) -> String {
    let has_to_be = cell.contains([',', '"', '\n', '\r']);
    if has_to_be { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.into() }
}

/// The shortest decimal that reads back as the same number.
fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value == 0.0 || (1e-4..1e15).contains(&value.abs()) => value.to_string(),
        Some(value) => format!("{value:e}"),
        None => String::new(),
    }
}

fn allan(table: &mut Table, record: &SourceResult) {
    for channel in &record.channels {
        for &Point { m, tau_s, deviation, lower, upper, edf, terms, alpha, fitted } in &channel.allan.points {
            let (m, terms, alpha) = (Some(m as f64), Some(terms as f64), alpha.map(f64::from));
            let values = [m, Some(tau_s), deviation, lower, upper, edf, terms, alpha, fitted];
            table.numbers(&channel.name, &channel.unit, &values);
        }
    }
}

fn statistics(table: &mut Table, record: &SourceResult) {
    for channel in &record.channels {
        let Statistics { mean, std, min, max, skewness, excess_kurtosis, .. } = channel.statistics;
        let (count, resolution) = (Some(channel.statistics.count as f64), Some(channel.statistics.resolution));
        let values = [count, mean, std, min, max, skewness, excess_kurtosis, resolution];
        table.numbers(&channel.name, &channel.unit, &values);
    }
    for norm in &record.norms {
        let values = [Some(norm.count as f64), norm.mean, norm.std, norm.min, norm.max, None, None, None];
        table.numbers(&norm.name, &norm.unit, &values);
    }
}

/// Each parameter in every unit in use, the SI unit first; then what the graphical slope method reads.
fn parameters(table: &mut Table, record: &SourceResult) {
    for channel in &record.channels {
        let Some(noise) = &channel.noise else { continue };
        for term in Term::ALL {
            noise
                .parameter_in_units(term)
                .iter()
                .for_each(|found| of_parameter(table, &channel.name, &name_of(term), found));
        }
        if let Some(TemperatureResult { parameter, unit, conventions, .. }) = &noise.temperature {
            in_units(table, [&channel.name, "temperature_coefficient"], parameter, unit, conventions);
        }
        noise.curve_minimum.iter().for_each(|found| of_parameter(table, &channel.name, "curve_minimum", found));
        for (term, ..) in GRAPHICAL {
            let Some(read) = noise.classical.reading(term) else { continue };
            let name = format!("graphical_{}", name_of(term));
            let status = read.not_read.map_or_else(|| "graphical".into(), name_of);
            for (place, convention) in conventions(noise.sensor, term).iter().enumerate() {
                let value = number(read.value.map(|value| value * convention.factor));
                let sides = convention.sides.map_or_else(String::new, name_of);
                let is_si = if place == 0 { "true" } else { "false" };
                table.row(&[&channel.name, &name, &status, &value, "", "", convention.unit, "", &sides, is_si]);
            }
        }
    }
}

/// A row for each unit of a parameter, and one for its discrete form at the rate of the record.
fn of_parameter(table: &mut Table, channel: &str, name: &str, found: &ParameterResult) {
    let ParameterResult { parameter, unit, conventions, discrete, .. } = found;
    in_units(table, [channel, name], parameter, unit, conventions);
    if let Some(Discrete { unit, value, lower, upper, .. }) = *discrete {
        let sample = Parameter { status: parameter.status, value, lower, upper, p: None };
        in_units(table, [channel, &format!("{name}_discrete")], &sample, unit, &[]);
    }
}

fn in_units(table: &mut Table, [channel, name]: [&str; 2], parameter: &Parameter, unit: &'static str, more: &[InUnit]) {
    let Parameter { status, value, lower, upper, p } = *parameter;
    let si = InUnit { unit, sides: None, value, lower, upper };
    for (place, InUnit { unit, sides, value, lower, upper }) in [&si].into_iter().chain(more).enumerate() {
        let [value, lower, upper, p] = [*value, *lower, *upper, p].map(number);
        let sides = sides.map_or_else(String::new, name_of);
        let is_si = if place == 0 { "true" } else { "false" };
        table.row(&[channel, name, &name_of(status), &value, &lower, &upper, unit, &p, &sides, is_si]);
    }
}

fn verdicts(table: &mut Table, record: &SourceResult) {
    let datasheet = record.datasheet.as_ref().map_or("", |sheet| &sheet.name);
    for channel in &record.channels {
        let Some(noise) = &channel.noise else { continue };
        for verdict in channel.verdicts() {
            let Parameter { value, lower, upper, .. } = verdict.measured;
            let (low, high) = verdict.expected;
            let [value, lower, upper, low, high] = [value, lower, upper, Some(low), Some(high)].map(number);
            table.row(&[
                &channel.name,
                &name_of(verdict.figure.term),
                &verdict.verdict.map_or_else(String::new, name_of),
                datasheet,
                &verdict.figure.printed,
                verdict.figure.claim.name(),
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
}

fn warnings(table: &mut Table, record: &SourceResult, words: RemedyWords) {
    for warning in &record.warnings {
        let (channels, details) = (warning.channels.join(" "), details(warning, words));
        table.row(&[warning.kind.name(), warning.severity.name(), &channels, &headline(warning), &details]);
    }
}

/// The identity of a record, by name; empty if a part is not known.
fn metadata(table: &mut Table, record: &SourceResult) {
    let (source, timing) = (&record.source, &record.timing);
    let device = source.device.clone().unwrap_or_default();
    let optional = [
        ("stream", source.stream.clone()),
        ("sha256", source.file.as_ref().map(|file| file.sha256.clone())),
        ("model", device.model),
        ("serial_number", device.serial_number),
        ("firmware", device.firmware),
        ("started_utc", source.recording.as_ref().and_then(|recording| recording.started())),
        ("message", source.message.clone()),
        ("compensated", source.compensated.map(|compensated| compensated.to_string())),
        ("rate_hz", Some(number(timing.rate_hz))),
        ("rate_from", timing.rate_from.map(name_of)),
        ("samples", Some(timing.samples.to_string())),
        ("missing", timing.missing.map(|missing| missing.to_string())),
        ("duration_s", Some(number(Some(timing.duration_s)))),
        ("confidence", Some(number(Some(record.confidence)))),
        ("complete", Some((record.completion == Completion::Complete).to_string())),
        ("error", source.error.clone()),
    ];
    table.row(&["capture", &source.name]);
    optional.iter().for_each(|(name, value)| table.row(&[name, value.as_deref().unwrap_or_default()]));
}

fn spectrum(table: &mut Table, record: &SourceResult) {
    for channel in &record.channels {
        let unit = format!("({})^2/Hz", channel.unit);
        for (frequency_hz, density) in channel.spectrum.iter().flat_map(|spectrum| spectrum.points()) {
            table.numbers(&channel.name, &unit, &[Some(frequency_hz), Some(density)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be_and_numbers_read_back() {
        let mut table = Table(String::new());
        table.row(&["x,\"y\"", "z"]);
        assert_eq!(table.0, "\"x,\"\"y\"\"\",z\n");
        for value in [0.0, 1.5, -9.887_886_4, 7.67e-6, 1e20] {
            assert_eq!(number(Some(value)).parse::<f64>().unwrap(), value);
        }
        assert_eq!(number(None), "");
    }
}

//! Tables as CSV: full precision, nothing where a number is not known.

use std::fmt::Write;

use vn100_analysis::noise::{Parameter, Term, temperature_conventions};

use crate::{
    codes::code_of_status,
    document::noise::term_name,
    measured::Record,
    temperature::coefficient_parameter,
    units::{BlockValues, ChannelValues, Point, si_unit},
};

/// A table of a report.
#[derive(Debug, Clone, Copy)]
pub struct CsvTable {
    /// How the name of its file ends.
    pub ending: &'static str,
    /// A header, and a row for each channel and point.
    pub text: fn(&Record<'_>) -> String,
}

impl CsvTable {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self { ending: ".allan.csv", text: allan },
        Self { ending: ".statistics.csv", text: statistics },
        Self { ending: ".parameters.csv", text: parameters },
        Self { ending: ".spectrum.csv", text: spectrum },
        Self { ending: ".segments.csv", text: segments },
        Self { ending: ".histogram.csv", text: histogram },
    ];
}

struct Table(String);

impl Table {
    fn new(header: &str) -> Self {
        Self(format!("{header}\n"))
    }

    fn row(&mut self, cells: &[&str]) {
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
fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value == 0.0 || (1e-4..1e15).contains(&value.abs()) => value.to_string(),
        Some(value) => format!("{value:e}"),
        None => String::new(),
    }
}

fn allan(record: &Record<'_>) -> String {
    let mut table = Table::new("channel,unit,m,tau_s,deviation,lower,upper,edf,terms,alpha,fitted");
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
    let mut table = Table::new("channel,unit,count,mean,std,min,max,skewness,excess_kurtosis,resolution");
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

fn parameters(record: &Record<'_>) -> String {
    let mut table = Table::new("channel,parameter,status,value,lower,upper,unit,p");
    for channel in &record.channels {
        let Some(noise) = &channel.noise else { continue };
        let mut row = |name: &str, parameter: Option<Parameter>, unit: &str| {
            let Some(Parameter { status, value, lower, upper, p }) = parameter else { return };
            let [value, lower, upper, p] = [value, lower, upper, p].map(number);
            table.row(&[&channel.name, name, code_of_status(status).code, &value, &lower, &upper, unit, &p]);
        };
        for term in Term::ALL {
            row(term_name(term), noise.parameter(term), si_unit(noise.sensor, term));
        }
        let of_temperature = noise.temperature.as_ref().map(coefficient_parameter);
        let unit = temperature_conventions(noise.sensor)[0].unit;
        row("temperature_coefficient", of_temperature, unit);
        row("curve_minimum", noise.curve_minimum(), si_unit(noise.sensor, Term::BiasInstability));
    }
    table.0
}

fn spectrum(record: &Record<'_>) -> String {
    let mut table = Table::new("channel,unit,frequency_hz,density_one_sided");
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
    let mut table = Table::new("channel,unit,start_s,duration_s,count,mean,std,min,max");
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
    let mut table = Table::new("channel,unit,from,to,count");
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

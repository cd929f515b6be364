//! N, B and K over three recordings or more: a row for each sensor, then median, spread and the
//! interval of the next.

use std::fmt::{self, Write};

use imu_noise::Term;
use vn100_analysis::Population;
use vn100_report::{
    names::no_prediction,
    numbers::plain::{digits, short},
    printable,
    units::parameter_unit,
};

use super::{fill, parameter_name};

/// Of the column that names the rows of a table with an axis in each of the others.
const LABEL: usize = 24;

const COLUMN: usize = 17;

pub(crate) fn write_populations(out: &mut String, populations: &[Population], confidence: f64) -> fmt::Result {
    if populations.is_empty() {
        return Ok(());
    }
    let legend = format!(
        "A row for each sensor: the mean of its recordings. The spread is the standard deviation between recordings. \"next\" is the \
         prediction interval of one more sensor, or of one more recording if all are of one, by t on logarithms at {} % confidence.",
        short(100.0 * confidence)
    );
    writeln!(out, "\nSensors\n{}", fill(&legend, "", ""))?;
    let mut sensors: Vec<_> = populations.iter().map(|population| population.sensor).collect();
    sensors.dedup();
    for sensor in sensors {
        for term in Term::ALL {
            let axes: Vec<&Population> = populations
                .iter()
                .filter(|population| (population.sensor, population.term) == (sensor, term))
                .collect();
            if !axes.is_empty() {
                let (unit, factor) = parameter_unit(sensor, term);
                writeln!(out, "{}, {unit}", parameter_name(sensor, term))?;
                write_axes(out, &axes, factor)?;
            }
        }
    }
    Ok(())
}

fn write_axes(out: &mut String, axes: &[&Population], factor: f64) -> fmt::Result {
    row(out, "  sensor", axes, |axis| axis.channel.clone())?;
    let mut names: Vec<&str> = Vec::new();
    for unit in axes.iter().flat_map(|axis| &axis.units) {
        if !names.contains(&&*unit.name) {
            names.push(&unit.name);
        }
    }
    for name in names {
        let label: String = format!("  {}", printable(name)).chars().take(23).collect();
        row(out, &label, axes, |axis| {
            let unit = axis.units.iter().find(|unit| unit.name == name);
            unit.map_or("-".into(), |unit| value(unit.is_bound, unit.value * factor))
        })?;
    }
    let next = |end: Option<f64>| end.map_or("-".into(), |end| digits(end * factor, 4));
    let of_all = |axis: &Population, all| value(axis.units.iter().any(|unit| unit.is_bound), all * factor);
    row(out, "  median", axes, |axis| of_all(axis, axis.median))?;
    row(out, "    lowest", axes, |axis| of_all(axis, axis.lowest))?;
    row(out, "    highest", axes, |axis| of_all(axis, axis.highest))?;
    row(out, "  spread, %", axes, |axis| axis.spread.map_or("-".into(), |spread| format!("{:.1}", 100.0 * spread)))?;
    row(out, "  next, lower", axes, |axis| next(axis.next_lower))?;
    row(out, "    upper", axes, |axis| next(axis.next_upper))?;
    let mut reasons = Vec::new();
    for why in axes.iter().filter_map(|axis| axis.no_interval) {
        if !reasons.contains(&why) {
            reasons.push(why);
        }
    }
    reasons
        .iter()
        .try_for_each(|why| writeln!(out, "{}", fill(&format!("no interval: {}", no_prediction(*why)), "  ", "    ")))
}

fn value(is_bound: bool, value: f64) -> String {
    format!("{}{}", if is_bound { "<= " } else { "" }, digits(value, 4))
}

/// A row of a table with an axis in each column.
fn row<T>(out: &mut String, label: &str, cells: &[T], cell: impl Fn(&T) -> String) -> fmt::Result {
    let mut line = format!("{label:<LABEL$}");
    for value in cells {
        write!(line, " {:>COLUMN$}", cell(value))?;
    }
    writeln!(out, "{}", line.trim_end())
}

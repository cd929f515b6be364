//! The main results in one table.

use maud::{Markup, html};
use vn100_analysis::Motion;
use vn100_analysis::noise::{Parameter, Sensor, Term, Verdict};

use crate::{
    figure::pretty_unit,
    findings::{AxisFindings, Findings, SensorFindings, Worst},
    measured::Record,
    names::{in_words, shown_in, verdict_name},
    numbers::{NOTHING, digits, with_interval},
};

const COLUMNS: [&str; 5] = [
    "sensor",
    "white noise N, worst axis",
    "bias instability B, worst axis",
    "rate random walk K, worst axis",
    "N beside the data sheet",
];

pub(super) fn summary(record: &Record<'_>, findings: &Findings) -> Markup {
    let warnings = record.measured.warnings().count();
    html! {
        section.summary {
            h2 { "In short" }
            div.scroll {
                table {
                    thead { tr { @for name in COLUMNS { th scope="col" { (name) } } } }
                    tbody {
                        @for sensor in &findings.sensors {
                            tr {
                                th scope="row" { (sensor.name) }
                                td data-label=(COLUMNS[1]) { (white(sensor)) }
                                td data-label=(COLUMNS[2]) { (slow(sensor, Term::BiasInstability, |axis| axis.bias_instability)) }
                                td data-label=(COLUMNS[3]) { (slow(sensor, Term::RateRandomWalk, |axis| axis.random_walk)) }
                                td data-label=(COLUMNS[4]) { @if findings.motion.is_some() { (NOTHING) } @else { (verdict(sensor)) } }
                            }
                        }
                    }
                }
            }
            @if findings.motion.is_some() { p { b { (Motion::MEANING) } } }
            p {
                @match warnings {
                    0 => "Nothing was found that would spoil these numbers.",
                    1 => { "One thing may spoil these numbers: see the warning." }
                    count => { (count) " things may spoil these numbers or change what they mean: see the warnings." }
                }
            }
        }
    }
}

fn white(sensor: &SensorFindings) -> String {
    let Some(worst) = sensor.worst(|axis| axis.white) else {
        return sensor.axes.iter().find_map(|axis| axis.white).map_or(NOTHING, |white| in_words(white.status)).into();
    };
    let without_bound = sensor.axes.iter().filter(|axis| axis.white.is_none_or(|white| white.upper.is_none()));
    let without_bound: Vec<&str> = without_bound.map(|axis| axis.name.as_str()).collect();
    let unknown =
        if without_bound.is_empty() { String::new() } else { format!("; not known: {}", without_bound.join(", ")) };
    of_worst(sensor, Term::White, &worst, &unknown)
}

/// Of the axis with the largest upper end, with what else there is to say of it.
fn of_worst(sensor: &SensorFindings, term: Term, worst: &Worst<'_>, more: &str) -> String {
    let (unit, factor) = shown_in(sensor.sensor, term);
    let amount = match worst.parameter {
        Parameter { value: Some(value), lower: Some(lower), upper: Some(upper), .. } => {
            with_interval(value * factor, lower * factor, upper * factor)
        }
        Parameter { upper, .. } => format!("≤ {}", upper.map_or(NOTHING.into(), |upper| digits(upper * factor, 2))),
    };
    format!("{amount} {} ({}{more})", pretty_unit(unit), worst.axis.name)
}

/// The axis with the largest upper end; that one may not show the noise is said.
fn slow(sensor: &SensorFindings, term: Term, of: fn(&AxisFindings) -> Option<Parameter>) -> String {
    match sensor.worst(of) {
        Some(worst) => {
            let none_is_seen = sensor.largest(of).is_none();
            format!("{}{}", if none_is_seen { "not seen, " } else { "" }, of_worst(sensor, term, &worst, ""))
        }
        None => match sensor.axes.iter().find_map(of) {
            Some(parameter) => in_words(parameter.status).into(),
            // the field around a magnetometer is never quiet
            None if sensor.sensor == Sensor::Magnetometer => "not of the sensor".into(),
            None => NOTHING.into(),
        },
    }
}

fn verdict(sensor: &SensorFindings) -> String {
    let found = |verdict: &Verdict| {
        sensor
            .axes
            .iter()
            .flat_map(|axis| &axis.verdicts)
            .any(|(term, found, _)| *term == Term::White && found == verdict)
    };
    Verdict::ALL.into_iter().find(found).map_or(NOTHING, verdict_name).into()
}

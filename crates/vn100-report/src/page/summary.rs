//! The answers in one table, for those who read no further.

use maud::{Markup, html};
use vn100_analysis::Motion;
use vn100_analysis::noise::{Parameter, Sensor, Status, Term, Verdict};

use crate::{
    figure::pretty_unit,
    findings::{AxisFindings, Findings, SensorFindings},
    measured::Record,
    names::{in_words, shown_in, verdict_name},
    numbers::{NOTHING, digits, with_interval},
};

const COLUMNS: [&str; 5] =
    ["sensor", "white noise N, worst axis", "bias instability B", "rate random walk K", "N beside the data sheet"];

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
    let (unit, factor) = shown_in(sensor.sensor, Term::White);
    let worst = sensor.worst(|axis| axis.white).map(|worst| worst.axis);
    match worst.and_then(|axis| Some((axis, axis.white?))) {
        Some((axis, Parameter { value: Some(value), lower: Some(lower), upper: Some(upper), .. })) => {
            let others: Vec<&str> = (sensor.axes.iter())
                .filter(|other| other.white_value().is_none())
                .map(|other| other.name.as_str())
                .collect();
            let unknown = if others.is_empty() { String::new() } else { format!("; not known: {}", others.join(", ")) };
            format!(
                "{} {} ({}{unknown})",
                with_interval(value * factor, lower * factor, upper * factor),
                pretty_unit(unit),
                axis.name
            )
        }
        _ => {
            let found = || sensor.axes.iter().filter_map(|axis| axis.white);
            match found().filter_map(|white| white.upper).reduce(f64::max) {
                Some(upper) => format!("≤ {} {}", digits(upper * factor, 2), pretty_unit(unit)),
                None => found().next().map_or(NOTHING, |white| in_words(white.status)).into(),
            }
        }
    }
}

/// The largest where one is estimated, else the largest bound.
fn slow(sensor: &SensorFindings, term: Term, of: fn(&AxisFindings) -> Option<Parameter>) -> String {
    let (unit, factor) = shown_in(sensor.sensor, term);
    let all: Vec<(&AxisFindings, Parameter)> = sensor.axes.iter().filter_map(|axis| Some((axis, of(axis)?))).collect();
    let largest = |value: fn(&Parameter) -> Option<f64>| {
        let known = all.iter().filter_map(|(axis, parameter)| Some((axis.name.as_str(), value(parameter)?)));
        known.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let estimated = largest(|parameter| parameter.value.filter(|_| parameter.status == Status::Estimated));
    let bounded = largest(|parameter| parameter.upper.filter(|_| parameter.status == Status::Bounded));
    match (estimated, bounded) {
        (Some((axis, value)), _) => format!("{} {} ({axis})", digits(value * factor, 3), pretty_unit(unit)),
        (None, Some((_, upper))) => format!("not seen, ≤ {} {}", digits(upper * factor, 2), pretty_unit(unit)),
        (None, None) => match all.first() {
            Some((_, parameter)) => in_words(parameter.status).into(),
            // the field around a magnetometer is never quiet
            None if sensor.sensor == Sensor::Magnetometer => "not of the sensor".into(),
            None => NOTHING.into(),
        },
    }
}

fn verdict(sensor: &SensorFindings) -> String {
    const WORST_FIRST: [Verdict; 5] =
        [Verdict::Fail, Verdict::Undecided, Verdict::Consistent, Verdict::NotComparable, Verdict::Pass];
    let found = |verdict: &Verdict| {
        sensor
            .axes
            .iter()
            .flat_map(|axis| &axis.verdicts)
            .any(|(term, found, _)| *term == Term::White && found == verdict)
    };
    WORST_FIRST.into_iter().find(found).map_or(NOTHING, verdict_name).into()
}

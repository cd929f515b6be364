//! How noisy each axis is, and what a filter that uses the stream is given.

use crate::{
    names::parameter_names,
    numbers::{digits, four_digits, trimmed, with_interval},
    units::{pretty_unit, si_unit},
};
use vn100_analysis::noise::{Parameter, Sensor, Status, Term, conventions};
use vn100_analysis::{LongTauValidity, Motion, Remedy, RemedyWords};

use super::listed;
use crate::html::findings::{AxisFindings, Findings, SensorFindings};

pub(super) fn noise(findings: &Findings) -> Vec<String> {
    let mut sentences: Vec<String> = findings.sensors.iter().flat_map(of_sensor).collect();
    if findings.motion.is_some() {
        sentences.insert(0, Motion::MEANING.into());
    }
    if sentences.is_empty() {
        sentences.push("There are no axes of a sensor in this record, or no samples.".into());
    }
    sentences
}

fn of_sensor(sensor: &SensorFindings) -> Vec<String> {
    let mut sentences: Vec<String> = sensor.axes.iter().map(|axis| white(sensor.sensor, axis)).collect();
    if sensor.long_taus == LongTauValidity::Sensor {
        let slow = [
            (
                Term::BiasInstability,
                "Bias Instability B",
                (|axis| axis.bias_instability) as fn(&AxisFindings) -> Option<Parameter>,
            ),
            (Term::RateRandomWalk, "Random Walk K", |axis| axis.random_walk),
        ];
        for (term, name, of) in slow {
            sentences.extend(slow_noise(sensor, term, name, of));
        }
    }
    sentences.extend(match sensor.long_taus {
        LongTauValidity::Compensated => Some(format!(
            "Bias instability B and rate random walk K of the {} are not measurable in this message, however long the record: the sensor removes its bias.",
            sensor.name
        )),
        LongTauValidity::LooksCompensated => Some(format!(
            "Bias instability B and rate random walk K of the {} are not given: the curve falls below its own white noise, because a filter removes the bias.",
            sensor.name
        )),
        LongTauValidity::Sensor | LongTauValidity::Surroundings | LongTauValidity::Motion => None,
    });
    sentences
}

/// N in SI units and in the one that data sheets print.
fn white(sensor: Sensor, axis: &AxisFindings) -> String {
    let units = conventions(sensor, Term::White);
    let name = parameter_names(sensor, Term::White).name;
    let printed = match sensor {
        Sensor::Gyroscope => "deg/sqrt(h)",
        Sensor::Accelerometer => "ug/sqrt(Hz)",
        Sensor::Magnetometer => "nT/sqrt(Hz)",
    };
    let other = units.iter().find(|unit| unit.unit == printed).filter(|unit| unit.factor != 1.0);
    match axis.white {
        Some(Parameter { value: Some(value), lower: Some(lower), upper: Some(upper), .. }) => {
            let other = other.map_or_else(String::new, |unit| {
                format!(", {} {}", digits(value * unit.factor, 3), pretty_unit(unit.unit))
            });
            let one = axis.std.map_or_else(String::new, |std| {
                let unit = pretty_unit(&axis.unit);
                // what white noise of that density alone would give a sample: more, where it was fitted to long times only
                let alone = value * axis.rate_hz.sqrt();
                let share = match digits(alone, 3) {
                    alone_in_digits if alone < 1.01 * std => format!(" (white noise alone: {alone_in_digits})"),
                    _ => String::new(),
                };
                format!(
                    "; standard deviation of one {} Hz sample: {} {unit}{share}",
                    trimmed(axis.rate_hz, 3),
                    digits(std, 3)
                )
            });
            format!(
                "{}: {name} N = {} {}{other}{one}.",
                axis.name,
                with_interval(value, lower, upper),
                pretty_unit(units[0].unit)
            )
        }
        Some(Parameter { upper: Some(upper), .. }) => {
            format!(
                "{}: {name} N not detected, upper bound {} {}.",
                axis.name,
                four_digits(upper),
                pretty_unit(units[0].unit)
            )
        }
        Some(Parameter { status: Status::ModelRejected, .. }) => {
            format!(
                "{}: no noise model fits any range of averaging times, so N is not given{}; see the disturbances below.",
                axis.name,
                by_rule(axis, units[0].unit)
            )
        }
        _ if !axis.lines.is_empty() => format!(
            "{}: {name} not observable: vibration covers the averaging times that would show it{}.",
            axis.name,
            by_rule(axis, units[0].unit)
        ),
        _ => {
            format!("{}: {name} not observable: the record is too short, or the values do not vary.", axis.name)
        }
    }
}

/// What older reports would have called N.
fn by_rule(axis: &AxisFindings, unit: &str) -> String {
    axis.white_by_rule.map_or_else(String::new, |read| {
        format!("; the curve at 1 s is {} {}, disturbance included", four_digits(read), pretty_unit(unit))
    })
}

fn slow_noise(
    sensor: &SensorFindings,
    term: Term,
    name: &str,
    of: fn(&AxisFindings) -> Option<Parameter>,
) -> Option<String> {
    let unit = conventions(sensor.sensor, term).first()?;
    let values: Vec<String> = (sensor.axes.iter())
        .filter_map(|axis| {
            let parameter = of(axis)?;
            Some(match (parameter.value, parameter.lower, parameter.upper) {
                (Some(value), Some(lower), Some(upper)) => {
                    format!("{} {}", axis.name, with_interval(value, lower, upper))
                }
                (None, _, Some(upper)) => format!("{} ≤ {}", axis.name, four_digits(upper)),
                _ => format!("{} not observable", axis.name),
            })
        })
        .collect();
    if values.is_empty() {
        return None;
    }
    let any_bounded = sensor.axes.iter().filter_map(of).any(|parameter| parameter.status == Status::Bounded);
    let meaning = if any_bounded { " ≤: upper bound; the term was not detected and may be zero." } else { "" };
    Some(format!("{name} of the {} in {}: {}.{meaning}", sensor.name, pretty_unit(unit.unit), listed(&values)))
}

pub(super) fn filters(findings: &Findings, words: RemedyWords) -> Vec<String> {
    if findings.motion.is_some() {
        return vec!["None from this record: the sensor was moved.".into()];
    }
    let sensors: Vec<&SensorFindings> =
        findings.sensors.iter().filter(|sensor| sensor.sensor != Sensor::Magnetometer).collect();
    let mut sentences: Vec<String> =
        sensors.iter().flat_map(|sensor| [filter_white(sensor), filter_walk(sensor)]).collect();
    if !sensors.is_empty() {
        sentences.push(format!(
            "Kalibr's imu.yaml is in the section on filters, with the status of each value; {} writes the file.",
            words(&Remedy::ExportKalibr)
        ));
    }
    sentences
}

fn filter_white(sensor: &SensorFindings) -> String {
    let unit = si_unit(sensor.sensor, Term::White);
    match sensor.largest(|axis| axis.white) {
        Some(worst) => format!(
            "{}: noise density as measured in this stream, {} {} ({}).",
            sensor.name,
            four_digits(worst.value),
            pretty_unit(unit),
            worst.named()
        ),
        None => format!("{}: noise density unknown from this record.", sensor.name),
    }
}

fn filter_walk(sensor: &SensorFindings) -> String {
    let unit = si_unit(sensor.sensor, Term::RateRandomWalk);
    let name = sensor.name;
    if let Some(worst) = sensor.largest(|axis| axis.random_walk) {
        return format!("{name}: random walk, {} {} ({}).", four_digits(worst.value), pretty_unit(unit), worst.named());
    }
    let absent = match sensor.long_taus {
        LongTauValidity::Sensor => "random walk not detected; Kalibr gets its upper bound, or the walk equivalent to B",
        _ => "random walk not measurable in this stream, so Kalibr gets none",
    };
    format!("{name}: {absent}.")
}

//! What a filter that uses the stream is to be told.

use imu_noise::{Sensor, Status, Term, conventions};
use vn100_pipeline::LongTaus;

use super::super::{
    figure::pretty_unit,
    findings::{AxisFindings, Findings, SensorFindings},
    numbers::four_digits,
};

pub(super) fn filters(findings: &Findings) -> Vec<String> {
    let sensors = findings.sensors.iter().filter(|sensor| sensor.sensor != Sensor::Magnetometer);
    let mut sentences: Vec<String> = sensors.flat_map(|sensor| [white(sensor), walk(sensor)]).collect();
    if !sentences.is_empty() {
        sentences.push(
            "The section on filters has these as the lines of Kalibr's imu.yaml; --export kalibr writes the file."
                .into(),
        );
    }
    sentences
}

fn white(sensor: &SensorFindings) -> String {
    let value = |axis: &AxisFindings| axis.white_value();
    let unit = conventions(sensor.sensor, Term::White).first().map_or("", |si| si.unit);
    match worst(sensor, value) {
        Some((axis, value)) => format!(
            "{}: the noise density as measured in this stream, {} {} ({axis}, the worst axis), not divided by anything.",
            sensor.name,
            four_digits(value),
            pretty_unit(unit)
        ),
        None => format!("{}: no noise density is known from this record.", sensor.name),
    }
}

fn walk(sensor: &SensorFindings) -> String {
    let value = |axis: &AxisFindings| {
        axis.random_walk.filter(|walk| walk.status == Status::Estimated).and_then(|walk| walk.value)
    };
    let unit = conventions(sensor.sensor, Term::RateRandomWalk).first().map_or("", |si| si.unit);
    match (worst(sensor, value), sensor.long_taus) {
        (Some((axis, value)), _) => {
            format!(
                "{}: the random walk, {} {} ({axis}, the worst axis).",
                sensor.name,
                four_digits(value),
                pretty_unit(unit)
            )
        }
        (None, LongTaus::Sensor) => format!(
            "{}: no random walk was seen, and none is made up; below stand a noise density and a random walk that lie above the whole curve instead.",
            sensor.name
        ),
        (None, _) => format!(
            "{}: its random walk is not in this stream, and none is made up; below stand a noise density and a random walk that lie above the whole curve instead.",
            sensor.name
        ),
    }
}

fn worst(sensor: &SensorFindings, value: impl Fn(&AxisFindings) -> Option<f64>) -> Option<(&str, f64)> {
    let known = sensor.axes.iter().filter_map(|axis| Some((axis.name.as_str(), value(axis)?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}

//! The noise parameters for a filter that uses the stream.

use imu_noise::{Sensor, Term, conventions};
use vn100_analysis::{LongTauValidity, Remedy, RemedyWords};

use crate::{
    figure::pretty_unit,
    findings::{Findings, SensorFindings},
    numbers::four_digits,
};

pub(super) fn filters(findings: &Findings, words: RemedyWords) -> Vec<String> {
    if findings.motion.is_some() {
        return vec!["Nothing of this record: the sensor was moved, and its noise is not seen.".into()];
    }
    let sensors: Vec<&SensorFindings> =
        findings.sensors.iter().filter(|sensor| sensor.sensor != Sensor::Magnetometer).collect();
    let mut sentences: Vec<String> = sensors.iter().flat_map(|sensor| [white(sensor), walk(sensor)]).collect();
    let is_complete = |sensor: &&SensorFindings| {
        sensor.worst(|axis| axis.white).is_some() && sensor.worst(|axis| axis.random_walk).is_some()
    };
    if !sensors.is_empty() {
        let file = match sensors.len() == 2 && sensors.iter().all(is_complete) {
            true => String::new(),
            false => {
                format!(" only together with {}, for not all of them are measured", words(&Remedy::FilterModels))
            }
        };
        let export = words(&Remedy::ExportKalibr);
        sentences.push(format!(
            "The section on filters has these as the lines of Kalibr's imu.yaml; {export} writes the file{file}."
        ));
    }
    sentences
}

fn white(sensor: &SensorFindings) -> String {
    let unit = conventions(sensor.sensor, Term::White).first().map_or("", |si| si.unit);
    match sensor.worst(|axis| axis.white) {
        Some(worst) => format!(
            "{}: the noise density as measured in this stream, {} {} ({}), not divided by anything.",
            sensor.name,
            four_digits(worst.value),
            pretty_unit(unit),
            worst.named()
        ),
        None => format!("{}: no noise density is known from this record.", sensor.name),
    }
}

fn walk(sensor: &SensorFindings) -> String {
    let unit = conventions(sensor.sensor, Term::RateRandomWalk).first().map_or("", |si| si.unit);
    let name = sensor.name;
    if let Some(worst) = sensor.worst(|axis| axis.random_walk) {
        return format!(
            "{name}: the random walk, {} {} ({}).",
            four_digits(worst.value),
            pretty_unit(unit),
            worst.named()
        );
    }
    let absent = match sensor.long_taus {
        LongTauValidity::Sensor => "no random walk was seen",
        _ => "its random walk is not in this stream",
    };
    let instead = match sensor.axes.iter().any(|axis| axis.known_to_s.is_some()) {
        true => "; below stand a noise density and a random walk that lie above the whole curve instead",
        false => "",
    };
    format!("{name}: {absent}, and none is made up{instead}.")
}

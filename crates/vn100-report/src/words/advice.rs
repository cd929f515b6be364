//! What would make a better record, the greatest gain first.

use imu_noise::{Sensor, Status};
use vn100_analysis::{LongTauValidity, RateFrom, Remedy, RemedyWords, Setting, WarningKind};

use crate::{
    findings::Findings,
    numbers::{duration, trimmed},
};

pub(super) fn advice(findings: &Findings, words: RemedyWords) -> Vec<String> {
    let mut advice = Vec::new();
    if findings.motion.is_some() {
        advice.push("Let the sensor lie still, and record that.".into());
    }
    let is_ours = findings.message.is_some();
    if is_ours && findings.sensor(Sensor::Gyroscope).is_some_and(|gyro| gyro.long_taus == LongTauValidity::Compensated)
    {
        advice.push(format!(
            "Send VNIMU instead of a compensated message: it carries the sensor's own rates, and temperature and pressure too ({}). Only then can B and K of the gyroscope be measured.",
            words(&Remedy::MeasureWith(Setting::Message("VNIMU")))
        ));
    }
    let window = findings.sensors.iter().filter_map(|sensor| sensor.onboard).find(|onboard| {
        onboard.refresh_hz > 400.0 && (onboard.window.length != onboard.unaliased_window() || !onboard.window_known)
    });
    if let Some(onboard) = window {
        advice.push(format!(
            "Average exactly as many refreshes as are skipped, {} at {} Hz, so that nothing folds and N can be compared with the data sheet ({}).",
            onboard.unaliased_window(),
            trimmed(findings.rate_hz, 3),
            words(&Remedy::MeasureWith(Setting::Window(onboard.unaliased_window())))
        ));
    }
    if findings.warns(WarningKind::VibrationLine) {
        let (hz, _) = findings
            .axes()
            .filter_map(|axis| axis.lines.first().copied())
            .fold((0.0, 0.0), |most, line| if line.1 > most.1 { line } else { most });
        advice.push(format!("Stop what shakes at {hz:.1} Hz (or at an alias of it), or decouple the sensor: a heavy base on soft feet, away from fans, motors and footsteps, without a hanging cable."));
    }
    if findings.warns(WarningKind::NotStationary) && findings.motion.is_none() {
        advice.push(
            "Measure where and when nobody walks, closes doors or touches the table; at night if need be.".into(),
        );
    }
    let warm_up = findings.axes().filter_map(|axis| axis.warm_up_s).reduce(f64::max);
    if let Some(skip_s) = warm_up {
        advice.push(format!(
            "Let the sensor warm up before, or leave the first {} out ({}).",
            duration((skip_s / 60.0).ceil() * 60.0),
            words(&Remedy::Skip(None))
        ));
    }
    let unseen = findings
        .sensors
        .iter()
        .filter(|sensor| sensor.sensor != Sensor::Magnetometer)
        .flat_map(|sensor| &sensor.axes)
        .any(|axis| {
            [axis.bias_instability, axis.random_walk]
                .iter()
                .flatten()
                .any(|parameter| matches!(parameter.status, Status::Bounded | Status::NotObservable))
        });
    if unseen || findings.duration_s < 3.0 * 3600.0 {
        advice.push("Record longer: N is known to a few percent after minutes, B of a sensor like this asks for an hour or more, K for many hours at a steady temperature.".into());
    }
    if is_ours && (!findings.has_stamps || !findings.has_registers || !findings.has_conditions) {
        advice.push(format!("Record with {}: that keeps arrival times, registers, temperature and the conditions, which this record lacks in part.", words(&Remedy::Record)));
    }
    if findings.rate_from == RateFrom::Assumed {
        advice.push(format!("Say the rate ({}), if it was not as assumed.", words(&Remedy::GiveRate(None))));
    }
    if advice.is_empty() {
        advice.push("Nothing in this record calls for another one; repeat it over power cycles and days to see how far the numbers hold.".into());
    }
    advice
}

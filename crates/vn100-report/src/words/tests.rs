//! Every sentence, and that it is said only where it holds.

use vn100_analysis::noise::{BoxcarWindow, FitQuality, Parameter, Sensor, Status, Term, Verdict};
use vn100_analysis::{
    LongTauValidity, MissingFrom, Motion, Onboard, Outages, RateFrom, Remedy, Timing, WarningKind, WindowFrom,
};

use super::*;
use crate::findings::{AxisFindings, SensorFindings};

fn estimated(value: f64) -> Parameter {
    Parameter::estimated(value, 0.98 * value, 1.02 * value)
}

fn bounded(upper: f64) -> Parameter {
    Parameter { upper: Some(upper), ..Parameter::without_value(Status::Bounded) }
}

fn axis(name: &str) -> AxisFindings {
    AxisFindings {
        name: name.into(),
        unit: "rad/s".into(),
        white: Some(estimated(1e-4)),
        white_by_rule: Some(1.1e-4),
        bias_instability: Some(estimated(2e-5)),
        random_walk: Some(estimated(1e-6)),
        quality: Some(FitQuality { tau_min_s: 0.025, tau_max_s: 3277.0, chi2: 9.0, dof: 12, p: 0.7 }),
        first_tau_s: Some(0.025),
        known_to_s: Some(3277.0),
        lines: Vec::new(),
        disturbances: 0,
        steps: false,
        cycles: false,
        noise_changes: false,
        detectable_factor: Some(1.03),
        warm_up_s: None,
        std: Some(6.4e-4),
        has_temperature_coefficient: false,
        verdicts: Vec::new(),
    }
}

/// A long record of the best kind: nothing to complain of.
fn flawless() -> Findings {
    let window = BoxcarWindow { length: 20, decimation: 20.0 };
    let gyro = SensorFindings {
        sensor: Sensor::Gyroscope,
        name: "gyroscope",
        long_taus: LongTauValidity::Sensor,
        onboard: Some(Onboard { refresh_hz: 800.0, window, window_from: WindowFrom::Register }),
        axes: vec![axis("gyro_x"), axis("gyro_y")],
    };
    Findings {
        message: Some("VNIMU".into()),
        compensated: Some(false),
        timing: Timing {
            rate_hz: 40.0,
            rate_from: RateFrom::Device,
            samples: 1_440_000,
            excluded: 0,
            missing: 0,
            missing_from: MissingFrom::Arrival,
            gaps: 0,
            segments: 1,
        },
        offset_ppm: Some(-12.0),
        outages: Outages::default(),
        has_stamps: true,
        has_registers: true,
        has_conditions: true,
        datasheet: Some("VectorNav VN-100".into()),
        sensors: vec![gyro],
        motion: None,
        warnings: Vec::new(),
    }
}

fn text_of(findings: &Findings) -> String {
    conclusions(findings, Remedy::to_string)
        .into_iter()
        .flat_map(|(_, sentences)| sentences)
        .collect::<Vec<_>>()
        .join("\n")
}

/// Checks that the conclusions hold these parts after `change`, and not before.
#[track_caller]
fn changes(change: impl FnOnce(&mut Findings), expected: &[&str]) {
    let mut findings = flawless();
    let before = text_of(&findings);
    change(&mut findings);
    let after = text_of(&findings);
    for part in expected {
        assert!(after.contains(part), "{part:?} is not in:\n{after}");
        assert!(!before.contains(part), "{part:?} was told before");
    }
}

#[test]
fn a_flawless_record_is_not_talked_down() {
    let text = text_of(&flawless());
    for part in [
        "gyro_x: white noise N = 1.000 (0.980 to 1.020)·10⁻⁴ rad/s/√Hz, 0.344 °/√h",
        "bias instability B of the gyroscope, in rad/s: gyro_x 2.000",
        "No sample is missing",
        "of one piece. Noise 1.03 times as high",
        "Nothing in this record calls for another one",
    ] {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
    for part in ["warming", "a skip", "Record longer", "shook", "folds", "not known", "At most"] {
        assert!(!text.contains(part), "{part:?} is in:\n{text}");
    }
}

#[test]
fn each_state_of_a_parameter_has_its_words() {
    let white =
        |parameter: Parameter| move |findings: &mut Findings| findings.sensors[0].axes[0].white = Some(parameter);
    changes(white(bounded(3e-4)), &["gyro_x: white noise N is at most 3.000·10⁻⁴"]);
    changes(white(Parameter::without_value(Status::NotObservable)), &["gyro_x: white noise is not observable"]);
    changes(
        |findings| {
            let axis = &mut findings.sensors[0].axes[0];
            (axis.white, axis.quality) = (Some(Parameter::without_value(Status::ModelRejected)), None);
        },
        &[
            "gyro_x: no range of averaging times",
            "at 1 s the curve reads 1.100·10⁻⁴ rad/s/√Hz",
            "It explains no range of gyro_x",
            "gyro_y, the largest estimate",
        ],
    );
    changes(
        |findings| findings.sensors[0].axes[1].random_walk = Some(bounded(5e-7)),
        &["gyro_y at most 5.000·10⁻⁷", "Record longer"],
    );
    changes(
        |findings| findings.sensors[0].axes.iter_mut().for_each(|axis| axis.random_walk = Some(bounded(5e-7))),
        &["no random walk was seen"],
    );
    changes(
        |findings| findings.sensors[0].axes.iter_mut().for_each(|axis| axis.white = Some(bounded(5e-4))),
        &["no noise density is known"],
    );
    changes(
        |findings| findings.sensors[0].axes[1].bias_instability = Some(Parameter::without_value(Status::NotObservable)),
        &["gyro_y not observable"],
    );
}

#[test]
fn what_lies_between_stream_and_sensor_is_explained() {
    changes(
        |findings| {
            findings.compensated = Some(true);
            findings.sensors[0].long_taus = LongTauValidity::Compensated;
        },
        &["taken out inside the sensor", "Send VNIMU", "compensated values", "cannot be compared: the message carries"],
    );
    changes(
        |findings| findings.sensors[0].long_taus = LongTauValidity::LooksCompensated,
        &["something takes the bias out"],
    );
    changes(
        |findings| {
            let onboard = findings.sensors[0].onboard.as_mut().unwrap();
            (onboard.window.length, onboard.window_from) = (4, WindowFrom::Default);
        },
        &[
            "2.24 ± 0.22 times",
            "which this record does not tell",
            "register 85 set to 20",
            "about gyro_x 2.6·10⁻³ and gyro_y 2.6·10⁻³ °/s/√Hz",
        ],
    );
    changes(
        |findings| findings.sensors[0].onboard.as_mut().unwrap().window.length = 60,
        &["neighbouring samples share refreshes"],
    );
    changes(
        |findings| findings.sensors[0].axes[0].verdicts = vec![(Term::White, Verdict::Fail, "measured much".into())],
        &["N of gyro_x: fail", "Beside the figures of VectorNav VN-100"],
    );
    changes(|findings| findings.datasheet = None, &["No data sheet was compared"]);
}

#[test]
fn each_disturbance_of_the_record_is_named_with_its_remedy() {
    changes(
        |findings| {
            findings.sensors[0].axes[1].lines = vec![(18.4, 0.41)];
            findings.sensors[0].axes[1].quality.as_mut().unwrap().tau_min_s = 0.8;
            findings.warnings.push(WarningKind::VibrationLine);
        },
        &["gyro_y 18.4 Hz (41 %)", "gyro_y below 0.8 s", "Stop what shakes at 18.4 Hz"],
    );
    changes(
        |findings| {
            findings.sensors[0].axes[0].disturbances = 2;
            findings.sensors[0].axes[1].steps = true;
            findings.sensors[0].axes[0].cycles = true;
            findings.sensors[0].axes[1].noise_changes = true;
            findings.warnings.push(WarningKind::NotStationary);
        },
        &[
            "disturbed for moments: gyro_x; with noise that changes: gyro_y; with a change of level: gyro_y; with a cycle of the level: gyro_x",
            "nobody walks",
        ],
    );
    changes(
        |findings| findings.sensors[0].axes[0].warm_up_s = Some(601.0),
        &["still settling, as in a warm-up", "leave the first 11 min out"],
    );
    changes(
        |findings| (findings.timing.missing, findings.timing.gaps) = (24, 1),
        &["24 of 1\u{202f}440\u{202f}024 samples are missing, in 1 gap."],
    );
    changes(
        |findings| findings.timing.rate_from = RateFrom::Assumed,
        &["is assumed", "Say the rate (the sample rate)"],
    );
    changes(|findings| findings.warnings.push(WarningKind::RateOffNominal), &["not the one taken"]);
    changes(
        |findings| (findings.has_stamps, findings.has_registers, findings.has_conditions) = (false, false, false),
        &[
            "for want of arrival times",
            "Record with a recording",
            "registers are not in the record",
            "were not written down",
        ],
    );
    changes(
        |findings| {
            let (channel, unit) = ("gyro_y".to_owned(), "rad/s".to_owned());
            findings.motion = Some(Motion { axes: vec![channel.clone()], channel, std: 4.6, limit: 0.05, unit });
            findings.warnings.push(WarningKind::NotStationary);
        },
        &[
            "No: the sensor was moved: gyro_y has a standard deviation of 4.600 rad/s, at rest less than 0.05",
            "nothing here compares",
            "lie still",
            "these figures describe the motion",
            "it covers the noise",
            "Nothing of this record",
        ],
    );
    changes(
        |findings| findings.sensors[0].axes.iter_mut().for_each(|axis| axis.has_temperature_coefficient = true),
        &["misalignment, sensitivity to supply and acceleration"],
    );
    changes(|findings| findings.timing.samples = 24_000, &["10 min of data", "Record longer"]);
}

#[test]
fn the_file_for_kalibr_is_promised_only_where_nothing_lacks() {
    let mut findings = flawless();
    let accelerometer =
        SensorFindings { sensor: Sensor::Accelerometer, name: "accelerometer", ..findings.sensors[0].clone() };
    findings.sensors.push(accelerometer);
    let complete = text_of(&findings);
    assert!(complete.contains("Kalibr writes the file.") && !complete.contains("the models for filters"), "{complete}");
    findings.sensors[1].axes.iter_mut().for_each(|axis| axis.random_walk = Some(bounded(5e-7)));
    let lacking = text_of(&findings);
    assert!(lacking.contains("accelerometer: no random walk was seen"), "{lacking}");
    assert!(lacking.contains("only together with the models for filters"), "{lacking}");
}

#[test]
fn a_bound_that_lies_lower_leaves_the_worst_axis_the_worst() {
    let walk = |parameter: Parameter| {
        let mut findings = flawless();
        findings.sensors[0].axes[1].random_walk = Some(parameter);
        text_of(&findings)
    };
    assert!(walk(bounded(5e-7)).contains("(gyro_x, the worst axis)"));
    assert!(walk(bounded(5e-6)).contains("(gyro_x, the largest estimate; an axis that is not estimated may be worse)"));
}

#[test]
fn a_record_of_nothing_says_so() {
    let mut findings = Findings { sensors: Vec::new(), ..flawless() };
    findings.timing.samples = 0;
    let text = text_of(&findings);
    assert!(text.contains("no axes of a sensor") && text.contains("0 samples are too few"), "{text}");
    assert!(!text.contains("missing") && !text.contains("of one piece"), "{text}");
}

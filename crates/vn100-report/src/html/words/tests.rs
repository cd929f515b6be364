//! Every sentence, and that it is said only where it holds.

use vn100_analysis::noise::{BoxcarWindow, FitQuality, Parameter, Sensor, Status, Term, Verdict};
use vn100_analysis::{
    LongTauValidity, MissingFrom, Motion, Onboard, Outages, RateFrom, Remedy, Timing, WarningKind, WindowFrom,
};

use super::*;
use crate::html::findings::{AxisFindings, SensorFindings};

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
        rate_hz: 40.0,
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
        onboard: Some(Onboard { refresh_hz: 800.0, rate_hz: 40.0, window, window_from: WindowFrom::Register }),
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
        assert!(!before.contains(part), "{part:?} is repeated");
    }
}

#[test]
fn a_flawless_record_is_not_talked_down() {
    let text = text_of(&flawless());
    for part in [
        "gyro_x: Angle Random Walk N = 1.000 (0.980 to 1.020)·10⁻⁴ rad/s/√Hz, 0.344 °/√h",
        "Bias Instability B of the gyroscope in rad/s: gyro_x 2.000",
        "No sample was dropped",
        "is stationary. A noise increase of 1.03 times",
        "Nothing in this record needs improvement",
    ] {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
    for part in ["warm-up transient", "a skip", "Record longer", "Vibration", "aliases", "not known", "≤"] {
        assert!(!text.contains(part), "{part:?} is in:\n{text}");
    }
}

#[test]
fn what_was_sent_during_an_outage_is_counted_where_a_clock_ran_on() {
    let down_ns = Some(34_900_000_000);
    for (missing_from, expected) in [
        (MissingFrom::DeviceTime, "samples sent then are among these where the clock of the sensor ran on"),
        (MissingFrom::Arrival, "34.9 s without it: samples sent then are not counted"),
    ] {
        changes(
            |findings| {
                (findings.timing.missing, findings.timing.gaps, findings.timing.missing_from) = (6978, 1, missing_from);
                findings.outages = Outages { times: 1, down_ns, ..Outages::default() };
            },
            &[expected],
        );
    }
}

#[test]
fn each_state_of_a_parameter_has_its_words() {
    let white =
        |parameter: Parameter| move |findings: &mut Findings| findings.sensors[0].axes[0].white = Some(parameter);
    changes(white(bounded(3e-4)), &["gyro_x: Angle Random Walk N not detected, upper bound 3.000·10⁻⁴"]);
    changes(white(Parameter::without_value(Status::NotObservable)), &["gyro_x: Angle Random Walk not observable"]);
    changes(
        |findings| {
            let axis = &mut findings.sensors[0].axes[0];
            (axis.white, axis.quality) = (Some(Parameter::without_value(Status::ModelRejected)), None);
        },
        &[
            "gyro_x: no noise model fits",
            "the curve at 1 s is 1.100·10⁻⁴ rad/s/√Hz",
            "Model rejected for gyro_x",
            "gyro_y, the largest estimate",
        ],
    );
    changes(
        |findings| findings.sensors[0].axes[1].random_walk = Some(bounded(5e-7)),
        &["gyro_y ≤ 5.000·10⁻⁷", "Record longer"],
    );
    changes(
        |findings| findings.sensors[0].axes.iter_mut().for_each(|axis| axis.random_walk = Some(bounded(5e-7))),
        &["random walk not detected"],
    );
    changes(
        |findings| findings.sensors[0].axes.iter_mut().for_each(|axis| axis.white = Some(bounded(5e-4))),
        &["noise density unknown"],
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
        &[
            "the sensor removes its bias",
            "Use the uncompensated message VNIMU",
            "compensated values",
            "cannot be compared: the message carries",
        ],
    );
    changes(
        |findings| findings.sensors[0].long_taus = LongTauValidity::LooksCompensated,
        &["because a filter removes the bias"],
    );
    changes(
        |findings| {
            let onboard = findings.sensors[0].onboard.as_mut().unwrap();
            (onboard.window.length, onboard.window_from) = (4, WindowFrom::Default);
        },
        &[
            "2.24 ± 0.22 times",
            "factory default, not in this record",
            "register 85 set to 20",
            "about gyro_x 2.6·10⁻³ and gyro_y 2.6·10⁻³ °/s/√Hz",
        ],
    );
    changes(
        |findings| findings.sensors[0].onboard.as_mut().unwrap().window.length = 60,
        &["neighbouring samples share values"],
    );
    changes(
        |findings| findings.sensors[0].axes[0].verdicts = vec![(Term::White, Verdict::Fail, "measured much".into())],
        &["N of gyro_x: fail", "Compared with VectorNav VN-100"],
    );
    changes(
        |findings| {
            let onboard = findings.sensors[0].onboard.as_mut().unwrap();
            (onboard.rate_hz, onboard.window) = (800.0, BoxcarWindow { length: 4, decimation: 1.0 });
        },
        &["Set the averaging window to 1 at 800 Hz, so that neighbouring samples share no values"],
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
        &[
            "gyro_y 18.4 Hz (41 %)",
            "below 0.8 s on gyro_y: N excludes the vibration",
            "Remove the 18.4 Hz vibration source",
        ],
    );
    changes(
        |findings| {
            for axis in &mut findings.sensors[0].axes {
                axis.quality.as_mut().unwrap().tau_min_s = 0.8;
            }
        },
        &["No spectral peak was found.", "below 0.8 s on gyro_x and gyro_y: averaging and low pass within the sensor"],
    );
    changes(|findings| findings.timing.missing_from = MissingFrom::DeviceTime, &["judged by device time"]);
    changes(
        |findings| {
            findings.sensors[0].axes[0].disturbances = 2;
            findings.sensors[0].axes[1].steps = true;
            findings.sensors[0].axes[0].cycles = true;
            findings.sensors[0].axes[1].noise_changes = true;
            findings.warnings.push(WarningKind::NotStationary);
        },
        &[
            "momentary disturbances: gyro_x; changing noise level: gyro_y; step of the level: gyro_y; cycle of the level: gyro_x",
            "without footsteps",
        ],
    );
    changes(
        |findings| findings.sensors[0].axes[0].warm_up_s = Some(601.0),
        &["warm-up transient", "exclude the first 11 min"],
    );
    changes(
        |findings| (findings.timing.missing, findings.timing.gaps) = (24, 1),
        &["24 of 1\u{202f}440\u{202f}024 samples were dropped, in 1 gap."],
    );
    changes(|findings| findings.timing.rate_from = RateFrom::Assumed, &["is assumed", "Set the sample rate if"]);
    changes(|findings| findings.warnings.push(WarningKind::RateOffNominal), &["differs from the one used"]);
    changes(
        |findings| (findings.has_stamps, findings.has_registers, findings.has_conditions) = (false, false, false),
        &[
            "cannot be detected without arrival times",
            "Record with `a recording`",
            "does not contain its registers",
            "were not recorded",
        ],
    );
    changes(
        |findings| {
            (findings.has_stamps, findings.timing.missing_from) = (false, MissingFrom::DeviceTime);
        },
        &["without arrival times the sensor's clock is not verified"],
    );
    changes(
        |findings| {
            let (channel, unit) = ("gyro_y".to_owned(), "rad/s".to_owned());
            findings.motion = Some(Motion { axes: vec![channel.clone()], channel, std: 4.6, limit: 0.05, unit });
            findings.warnings.push(WarningKind::NotStationary);
        },
        &[
            "No: sensor moved: standard deviation of gyro_y 4.600 rad/s, at rest below 0.05",
            "nothing is compared with",
            "Record the sensor at rest",
            "these figures describe the motion",
            "it covers the noise",
            "None from this record",
        ],
    );
    changes(
        |findings| findings.sensors[0].axes.iter_mut().for_each(|axis| axis.has_temperature_coefficient = true),
        &["misalignment, sensitivity to supply and acceleration"],
    );
    changes(|findings| findings.timing.samples = 24_000, &["10 min of data", "Record longer"]);
}

#[test]
fn a_walk_that_is_not_detected_differs_from_one_that_is_not_in_the_stream() {
    let mut findings = flawless();
    assert!(text_of(&findings).contains("gyroscope: random walk, "));
    findings.sensors[0].axes.iter_mut().for_each(|axis| axis.random_walk = Some(bounded(5e-7)));
    let text = text_of(&findings);
    assert!(text.contains("gyroscope: random walk not detected") && text.contains("Kalibr writes the file."), "{text}");
    findings.sensors[0].long_taus = LongTauValidity::Compensated;
    assert!(text_of(&findings).contains("gyroscope: random walk not measurable in this stream"));
}

#[test]
fn the_origin_and_the_window_of_a_stream_limit_it_where_they_do() {
    changes(
        |findings| findings.warnings.push(WarningKind::CompensationUnknown),
        &["Origin: it is unknown whether a filter has removed the gyroscope bias; "],
    );
    changes(
        |findings| findings.sensors[0].onboard.as_mut().unwrap().window.length = 4,
        &["Rate and averaging window: white noise is aliased into the band, see above."],
    );
    let mut findings = flawless();
    findings.sensors[0].onboard = None;
    assert!(!text_of(&findings).contains("Rate and averaging window"));
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
    assert!(!text.contains("dropped") && !text.contains("is stationary"), "{text}");
}

//! How long a record has to be: plans before it, goals while it lasts.

use imu_noise::{Claim, Sensor, Term};
use vn100_analysis::{
    Analysis, Assessment, DatasheetFigure, Given, Goal, Plan, PlannedMessage, Settings, TakenFrom, Want,
};
use vn100_protocol::BaudRate;

use super::sheets::{figure, sheet};
use super::simulated::Simulated;

#[test]
fn plans_take_the_sensors_own_settings_where_they_fit() {
    let quoted = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(6e-5))]);
    let free = Given { message: None, rate_hz: None, baud: None, confidence: 0.95 };
    let wants = |texts: &[&str]| texts.iter().map(|text| text.parse().unwrap()).collect::<Vec<Want>>();
    let plan = |texts: &[&str], given| Plan::new(&wants(texts), given, &quoted);
    let white = plan(&["gyro N ±5%"], free).unwrap();
    assert_eq!((white.message.name(), white.frame_bytes), ("BINARY", 44));
    assert_eq!((white.rate_hz, white.window, white.warm_up_s), (200, 4, 600.0));
    assert_eq!((white.baud, white.wants[0].without_bias_instability_s), (BaudRate::DEFAULT, None));
    let record_s = white.record_s.unwrap();
    assert!(record_s % 60.0 == 0.0 && record_s >= white.wants[0].record_s.unwrap() && record_s <= 600.0, "{record_s}");
    let walk = plan(&["gyro K >= 1e-5 rad/s/sqrt(s)"], free).unwrap();
    assert_eq!((walk.warm_up_s, walk.wants[0].record_s), (1800.0, walk.wants[0].without_bias_instability_s));
    let fast = Given { rate_hz: Some(800), ..free };
    let faster = plan(&["gyro N ±5%"], fast).unwrap();
    assert_eq!((faster.rate_hz, faster.window, faster.baud), (800, 1, BaudRate::new(460_800).unwrap()));
    let slow = Given { baud: Some(BaudRate::ALL[0]), ..fast };
    let fitting = plan(&["gyro N ±5%"], Given { rate_hz: None, ..slow }).unwrap();
    assert_eq!(fitting.baud, BaudRate::ALL[0]);
    let cure = format!("do not fit 9600 baud; reduce the rate to {} Hz, or use a higher baud rate", fitting.rate_hz);
    let error = plan(&["gyro N ±5%"], slow).unwrap_err().to_string();
    assert_eq!(error, format!("44 bytes 800 times a second {cure}"));
    for baud in BaudRate::ALL {
        let given = Given { baud: Some(baud), ..free };
        let planned = plan(&["gyro N ±5%"], given).unwrap();
        let load = 10.0 * f64::from(planned.frame_bytes * planned.rate_hz) / f64::from(baud.bits_per_s());
        assert!(load <= Plan::MOST_LOAD, "{load} of {baud:?}");
    }
    let none = plan(&["gyro N ±5%"], Given { rate_hz: Some(300), ..free }).unwrap_err().to_string();
    assert!(none.starts_with("BINARY has no rate of 300 Hz: use one of 800, 400, 200, "), "{none}");
    for (text, expected) in [("gyro B", "its own size"), ("accel N ±5%", "the white noise")] {
        let error = plan(&[text], free).unwrap_err().to_string();
        let expected =
            format!("the length for {text:?} depends on {expected}, which the data sheet \"a sheet\" does not");
        assert!(error.replace(" %", "%").starts_with(&expected), "{error}");
    }
}

#[test]
fn plans_of_sentences_have_their_rates_and_the_magnetic_field_has_its_packets() {
    let quoted = sheet(vec![
        figure(Sensor::Gyroscope, Term::White, Claim::Limit(6e-5)),
        figure(Sensor::Magnetometer, Term::White, Claim::Limit(1.4e-4)),
    ]);
    let plan = |want: &str, message, rate_hz| {
        let given = Given { message, rate_hz, baud: None, confidence: 0.95 };
        Plan::new(&[want.parse().unwrap()], given, &quoted)
    };
    let sentences = Some(PlannedMessage::Sentences);
    let usual = plan("gyro N ±5%", sentences, None).unwrap();
    assert_eq!(
        (usual.message.name(), usual.rate_hz, usual.window, usual.baud.bits_per_s()),
        ("VNIMU", 40, 20, 115_200)
    );
    let fast = plan("gyro N ±5%", sentences, Some(200)).unwrap();
    assert_eq!((fast.rate_hz, fast.window, fast.baud.bits_per_s()), (200, 4, 460_800));
    for rate_hz in [0, 160, 400] {
        assert!(plan("gyro N ±5%", sentences, Some(rate_hz)).is_err(), "{rate_hz}");
    }
    let field = plan("mag N ±5%", None, None).unwrap();
    assert_eq!((field.message.name(), field.rate_hz, field.window, field.frame_bytes), ("BINARY+MAG", 160, 5, 60));
    // above 250 Hz its samples are farther apart than the rows
    let lengths = [400, 800].map(|hz| plan("mag N ±5%", None, Some(hz)).unwrap().wants[0].record_s.unwrap());
    assert_eq!(lengths[0], lengths[1], "200 Hz both");
    let without = PlannedMessage::named("BINARY");
    let error = plan("mag N ±5%", without, None).unwrap_err().to_string();
    assert!(error.contains("BINARY, which has no magnetometer: use BINARY+MAG or VNIMU"), "{error}");
    for name in ["BINARY", "binary+mag", "VNIMU"] {
        assert!(PlannedMessage::named(name).is_some_and(|message| message.name().eq_ignore_ascii_case(name)));
    }
    assert_eq!(PlannedMessage::named("VNYMR"), None);
}

/// A verdict compares the minimum of the deviation with a figure that is one, and else B.
#[test]
fn a_limit_on_bias_instability_is_what_the_verdict_compares() {
    let (white, bias) = (Term::White, Term::BiasInstability);
    let given = Given { message: None, rate_hz: None, baud: None, confidence: 0.95 };
    let plan = |is_minimum, limit: &str| {
        let typical = DatasheetFigure { is_minimum, ..figure(Sensor::Accelerometer, bias, Claim::Limit(4e-4)) };
        let quoted = sheet(vec![figure(Sensor::Accelerometer, white, Claim::Limit(1.4e-3)), typical]);
        let want = format!("accel B <= {limit} m/s^2").parse().unwrap();
        Plan::new(&[want], given, &quoted).unwrap().wants.remove(0)
    };
    let (minimum, parameter) = (plan(true, "4e-4"), plan(false, "4e-4"));
    for (planned, is_minimum) in [(&minimum, true), (&parameter, false)] {
        let taken = planned.taken_at.unwrap();
        assert!((taken.value / 3.2e-4 - 1.0).abs() < 1e-9, "{taken:?}");
        assert_eq!((taken.from, taken.is_minimum), (TakenFrom::Limit, is_minimum));
    }
    // the minimum of 4e-4 is a B of 4e-4/0.664, which shows sooner
    assert!(minimum.record_s.unwrap() < 0.9 * parameter.record_s.unwrap(), "{minimum:?} {parameter:?}");
    let of_sheet = [plan(true, "8e-4"), plan(false, "8e-4")].map(|planned| planned.taken_at.unwrap());
    assert!(of_sheet.iter().all(|taken| taken.from == TakenFrom::Datasheet && (taken.value / 4e-4 - 1.0).abs() < 1e-9));
}

#[test]
fn a_goal_is_met_by_every_axis_meant_or_says_how_far_each_is() {
    let (snapshot, assessment) = Simulated::default().record();
    let goal = |text: &str| text.parse::<Goal>().unwrap();
    // Ten minutes of white noise: half widths of 0.9 %.
    for (text, is_met) in
        [("gyro N ±1.2%", true), ("accel N ±1.2%", true), ("gyro N ±0.6%", false), ("gyro K ±50%", false)]
    {
        assert_eq!(goal(text).is_met(&snapshot, &assessment), is_met, "{text}");
    }
    let unmet = Goal::unmet(&[goal("gyro N ±1.2%"), goal("gyro N ±0.6%")], &snapshot, &assessment);
    assert_eq!(unmet, [goal("gyro N ±0.6%")]);
    let axes = unmet[0].relative_half_widths(&snapshot, &assessment);
    assert_eq!(axes.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["gyro_x", "gyro_y", "gyro_z"]);
    assert!(axes.iter().all(|(_, width)| width.is_some_and(|width| (0.007..0.012).contains(&width))), "{axes:?}");
    let empty = Analysis::new(Settings::default()).snapshot();
    assert!(!goal("gyro N ±1.2%").is_met(&empty, &Assessment::new(&empty, 0.95)));
}

//! How long a record has to be: plans before it, goals while it lasts.

use imu_noise::{Claim, Sensor, Term};
use vn100_analysis::{Analysis, Assessment, Given, Goal, Plan, PlanningError, Settings, UnmetGoal, Want, WhyUnmet};
use vn100_protocol::{AsyncRate, AsyncType, BaudRate};

use crate::sheets::{figure, sheet};
use crate::simulated::Simulated;

#[test]
fn plans_take_the_sensors_own_settings_where_they_fit() {
    let quoted = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(6e-5))]);
    let free = Given { rate: None, baud: None, confidence: 0.95 };
    let wants = |texts: &[&str]| texts.iter().map(|text| text.parse().unwrap()).collect::<Vec<Want>>();
    let plan = |texts: &[&str], given| Plan::new(&wants(texts), given, &quoted);
    let white = plan(&["gyro N ±5%"], free).unwrap();
    assert_eq!((white.message, white.rate.hz(), white.window, white.warm_up_s), (AsyncType::IMU, 40, 20, 600.0));
    assert_eq!((white.baud, white.wants[0].by_rule_s), (BaudRate::DEFAULT, None));
    let record_s = white.record_s.unwrap();
    assert!(record_s % 60.0 == 0.0 && record_s >= white.wants[0].record_s.unwrap() && record_s <= 600.0, "{record_s}");
    let walk = plan(&["gyro K >= 1e-5"], free).unwrap();
    let by_rule_s = walk.wants[0].by_rule_s.unwrap();
    assert!((by_rule_s - 20.0 * 3_f64.sqrt() * 6.0).abs() < 1e-6, "{by_rule_s}");
    assert_eq!((walk.warm_up_s, walk.wants[0].record_s), (1800.0, walk.wants[0].without_bias_instability_s));
    let fast = Given { rate: AsyncRate::new(200), ..free };
    let faster = plan(&["gyro N ±5%"], fast).unwrap();
    assert_eq!((faster.rate.hz(), faster.window), (200, 4));
    let slow = Given { baud: Some(BaudRate::ALL[0]), ..fast };
    let Err(PlanningError::DoesNotFit { rate_hz: 200, baud: 9600, highest_hz: Some(highest), .. }) =
        plan(&["gyro N ±5%"], slow)
    else {
        panic!("it fits");
    };
    let fitting = plan(&["gyro N ±5%"], Given { rate: None, ..slow }).unwrap();
    assert_eq!((fitting.rate.hz(), fitting.baud), (highest, BaudRate::ALL[0]));
    for (text, expected) in [("gyro B", "its own size"), ("accel N ±5%", "the white noise")] {
        let Err(PlanningError::NotQuoted { missing, datasheet, .. }) = plan(&[text], free) else { panic!("{text}") };
        assert_eq!((missing, datasheet.as_str()), (expected, "a sheet"));
    }
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
    let unmet = UnmetGoal::of(&[goal("gyro N ±1.2%"), goal("gyro N ±0.6%")], &snapshot, &assessment);
    let [UnmetGoal { goal: unmet, why: WhyUnmet::EndedBefore(axes) }] = &unmet[..] else { panic!("{unmet:?}") };
    assert_eq!(unmet, &goal("gyro N ±0.6%"));
    assert_eq!(axes.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["gyro_x", "gyro_y", "gyro_z"]);
    assert!(axes.iter().all(|(_, width)| width.is_some_and(|width| (0.007..0.012).contains(&width))), "{axes:?}");
    let empty = Analysis::new(Settings::default()).snapshot();
    assert!(!goal("gyro N ±1.2%").is_met(&empty, &Assessment::new(&empty, 0.95)));
}

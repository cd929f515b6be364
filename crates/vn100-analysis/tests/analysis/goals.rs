//! Where a measurement with goals ends: at the second at which an assessment of all of it says so.

use std::sync::Arc;

use proptest::prelude::*;
use vn100_analysis::{Analysis, Assessment, Goal, Settings};
use vn100_protocol::{Layout, Quantity, VNIMU, stream::Batch};

use crate::noise_shapes::Lcg;

const RATE_HZ: u64 = 10;

/// White noise, correlated noise of four times beside it that together look like flicker noise, and
/// a walk; in counts.
struct Noise {
    random: Lcg,
    white: f64,
    flicker: f64,
    step: f64,
    slow: [f64; 4],
    walk: f64,
}

impl Noise {
    fn next(&mut self) -> f64 {
        let mut value = self.white * self.random.normal();
        for (level, samples) in self.slow.iter_mut().zip([10_f64, 80.0, 640.0, 5120.0]) {
            let memory = (-1.0 / samples).exp();
            *level = memory * *level + self.flicker * (1.0 - memory * memory).sqrt() * self.random.normal();
            value += *level;
        }
        self.walk += self.step * self.random.normal();
        value + self.walk
    }
}

/// One axis of the gyroscope: a goal asks each axis by itself.
fn layout() -> Arc<Layout> {
    let axis = VNIMU.channels.iter().find(|channel| channel.quantity == Quantity::AngularRate).unwrap();
    Arc::new(Layout { channels: vec![axis.clone()].into(), ..VNIMU.clone() })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, ..ProptestConfig::default() })]

    #[test]
    fn a_goal_ends_at_the_second_at_which_the_whole_assessment_says_so(
        seed in any::<u64>(),
        flicker in prop_oneof![Just(0.0), 5.0..100.0_f64],
        step in prop_oneof![Just(0.0), 0.2..10.0_f64],
        letter in prop_oneof![Just("N"), Just("B"), Just("K")],
        percent in 1.5..80.0_f64,
        minutes in 2_u64..25,
    ) {
        let goal: Goal = format!("gyro {letter} ±{percent}%").parse().unwrap();
        let settings = Settings { rate_hz: Some(RATE_HZ as f64), until: vec![goal.clone()], ..Settings::default() };
        let mut analysis = Analysis::new(settings);
        let layout = layout();
        let mut noise = Noise { random: Lcg(seed), white: 300.0, flicker, step, slow: [0.0; 4], walk: 0.0 };
        let mut second: u64 = 0;
        while second < 60 * minutes {
            let grown = second.div_ceil(20).max(1);
            let counts = (0..grown * RATE_HZ).map(|_| noise.next().round() as i32).collect();
            analysis.absorb(&Batch { layout: Some(Arc::clone(&layout)), counts, ..Batch::default() });
            second += grown;
            let snapshot = analysis.snapshot();
            let is_met = goal.is_met(&snapshot, &Assessment::new(&snapshot, 0.95));
            prop_assert_eq!(analysis.goals_are_decided(), is_met, "at {} s", second);
            if is_met {
                break;
            }
        }
    }
}

#[test]
fn without_goals_or_samples_nothing_is_decided_and_what_is_out_of_reach_is_at_once() {
    let analysis = |goals: &[&str]| {
        let until = goals.iter().map(|goal| goal.parse().unwrap()).collect();
        Analysis::new(Settings { rate_hz: Some(10.0), until, ..Settings::default() })
    };
    assert!(!analysis(&["gyro N ±5%"]).goals_are_decided());
    let row = Batch { layout: Some(layout()), counts: vec![1], ..Batch::default() };
    for (goals, expected) in [(&[][..], false), (&["gyro N ±5%"], false), (&["gyro N ±5%", "accel N ±5%"], true)] {
        let mut analysis = analysis(goals);
        analysis.absorb(&row);
        assert_eq!(analysis.goals_are_decided(), expected, "{goals:?}");
    }
}

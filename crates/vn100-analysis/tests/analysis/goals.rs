//! Where a measurement with goals ends: at the second at which an assessment of all of it says so.

use std::sync::Arc;

use proptest::prelude::*;
use vn100_analysis::{Analysis, Assessment, Goal, Settings};
use vn100_protocol::{Layout, Quantity, VNIMU, stream::Batch};

const RATE_HZ: u64 = 10;

/// White noise, correlated noise of four times beside it that together look like flicker noise, and
/// a walk; in counts.
struct Noise {
    state: u64,
    white: f64,
    flicker: f64,
    step: f64,
    slow: Vec<[f64; 5]>,
}

impl Noise {
    fn normal(&mut self) -> f64 {
        let uniform = (0..12).map(|_| {
            self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.state >> 11) as f64 / 2_f64.powi(53)
        });
        uniform.sum::<f64>() - 6.0
    }

    fn next(&mut self, channel: usize) -> f64 {
        let mut slow = self.slow[channel];
        let mut value = self.white * self.normal();
        for (level, samples) in slow.iter_mut().zip([10_f64, 80.0, 640.0, 5120.0]) {
            let memory = (-1.0 / samples).exp();
            *level = memory * *level + self.flicker * (1.0 - memory * memory).sqrt() * self.normal();
            value += *level;
        }
        slow[4] += self.step * self.normal();
        self.slow[channel] = slow;
        value + slow[4]
    }
}

/// The axes of the gyroscope alone.
fn layout() -> Arc<Layout> {
    let axes = VNIMU.channels.iter().filter(|channel| channel.quantity == Quantity::AngularRate);
    Arc::new(Layout { channels: axes.cloned().collect::<Vec<_>>().into(), ..VNIMU.clone() })
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
        let mut noise = Noise { state: seed, white: 300.0, flicker, step, slow: vec![[0.0; 5]; layout.channels.len()] };
        let mut second: u64 = 0;
        while second < 60 * minutes {
            let grown = second.div_ceil(20).max(1);
            let values = (0..grown * RATE_HZ).flat_map(|_| 0..layout.channels.len());
            let counts = values.map(|channel| noise.next(channel).round() as i32).collect();
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
    let row = Batch { layout: Some(layout()), counts: vec![1, 2, 3], ..Batch::default() };
    for (goals, expected) in [(&[][..], false), (&["gyro N ±5%"], false), (&["gyro N ±5%", "accel N ±5%"], true)] {
        let mut analysis = analysis(goals);
        analysis.absorb(&row);
        assert_eq!(analysis.goals_are_decided(), expected, "{goals:?}");
    }
}

//! When a measurement has reached its goals.

use imu_noise::chi_squared;

use crate::{accumulate::analysis::Analysis, assessment::Assessment, end::End, goal::Goal, snapshot::Snapshot};

impl Goal {
    /// Whether the parameter is estimated with that precision on every axis of the goal.
    pub fn is_met(&self, snapshot: &Snapshot, assessment: &Assessment) -> bool {
        let axes = self.relative_half_widths(snapshot, assessment);
        !axes.is_empty() && axes.iter().all(|(_, width)| width.is_some_and(|width| width <= self.relative_half_width))
    }

    /// Those of the `goals` that are not met.
    pub fn unmet(goals: &[Self], snapshot: &Snapshot, assessment: &Assessment) -> Vec<Self> {
        goals.iter().filter(|goal| !goal.is_met(snapshot, assessment)).cloned().collect()
    }

    /// Why no record of this message shows the parameter; `None` if one may, or without a message.
    pub fn out_of_reach(&self, snapshot: &Snapshot) -> Option<String> {
        self.figure.absent_from(snapshot.layout.as_ref()?)
    }

    /// Half the width of the interval over the value, by axis; `None` if it is not estimated.
    pub fn relative_half_widths(&self, snapshot: &Snapshot, assessment: &Assessment) -> Vec<(String, Option<f64>)> {
        (snapshot.layout_channels().iter().zip(&assessment.channels))
            .filter(|(channel, _)| self.figure.concerns(&channel.name, channel.quantity))
            .map(|(channel, assessed)| {
                let parameter = assessed.noise.as_ref().and_then(|noise| noise.parameter(self.figure.term));
                let width = parameter.and_then(|parameter| parameter.relative_half_width());
                (channel.name.to_string(), width)
            })
            .collect()
    }
}

impl Analysis {
    /// Whether all goals of the settings are met, or one is out of reach; `false` without goals. The
    /// answer is that of [`Goal::is_met`](crate::Goal::is_met) with the assessment of this moment.
    pub fn goals_are_decided(&self) -> bool {
        let (goals, confidence) = (&self.settings().until, self.settings().confidence);
        let (Some(layout), false) = (self.layout(), goals.is_empty()) else { return false };
        if goals.iter().any(|goal| goal.figure.absent_from(layout).is_some()) {
            return true;
        }
        let snapshot = self.snapshot();
        // no parameter is known better than white noise alone would be (Cramér-Rao), or hardly
        let samples = (snapshot.timing.samples + snapshot.timing.missing) as f64;
        let least = 0.9 * chi_squared::normal_two_sided(confidence).unwrap_or(0.0) / (2.0 * samples).sqrt();
        if goals.iter().any(|goal| goal.relative_half_width < least) {
            return false;
        }
        let assessment = Assessment::new(&snapshot, confidence);
        goals.iter().all(|goal| goal.is_met(&snapshot, &assessment))
    }
}

/// Checks whether the goals are met or out of reach: at every second of data time at first, later
/// whenever the record has grown by a twentieth, so that the end depends only on the samples.
#[derive(Debug, Default)]
pub struct GoalCheck {
    next_second: u64,
}

impl GoalCheck {
    /// Why the measurement is over; `None` while it is not, or it is not time to check its goals. The samples
    /// that decide the goals are the record.
    #[must_use]
    pub fn end(&mut self, analysis: &mut Analysis) -> Option<End> {
        if analysis.is_complete() {
            return Some(End::DurationReached);
        }
        let second = analysis.seconds();
        if analysis.settings().until.is_empty() || second < self.next_second {
            return None;
        }
        self.next_second = second + second.div_ceil(20).max(1);
        let is_decided = analysis.goals_are_decided();
        is_decided.then(|| {
            analysis.end_here();
            End::GoalsDecided
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_protocol::{VNIMU, stream::Batch};

    use super::*;
    use crate::settings::Settings;

    /// A record at 1 Hz of white noise, with this goal.
    fn analysis(goal: &str) -> Analysis {
        Analysis::new(Settings { rate_hz: Some(1.0), until: vec![goal.parse().unwrap()], ..Settings::default() })
    }

    fn add_second(analysis: &mut Analysis, state: &mut u32) {
        let channels = VNIMU.channels.len();
        let noise = |_| {
            *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (*state >> 24) as i32
        };
        let counts = (0..channels).map(noise).collect();
        analysis.absorb(&Batch { layout: Some(Arc::new(VNIMU.clone())), counts, ..Batch::default() });
    }

    #[test]
    fn goals_are_checked_every_second_and_later_every_twentieth() {
        let (mut analysis, mut state) = (analysis("gyro N ±0.0001%"), 1);
        let mut goals = GoalCheck::default();
        let mut looked = Vec::new();
        for second in 1..=48 {
            add_second(&mut analysis, &mut state);
            let before = goals.next_second;
            assert_eq!(goals.end(&mut analysis), None);
            looked.extend((goals.next_second != before).then_some(second));
        }
        let expected: Vec<_> = (1..=20).chain([21, 23, 25, 27, 29, 31, 33, 35, 37, 39, 41, 44, 47]).collect();
        assert_eq!(looked, expected);
    }
}

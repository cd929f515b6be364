//! The one assessment of a source, refreshed as its record grows.

use std::sync::{Arc, Mutex, PoisonError};

use vn100_analysis::{Analysis, Assessment, Snapshot};

/// The assessment of one source, made on the thread of the first reader that requests it, and made
/// again after the record has grown by a twentieth. An assessment takes as long as the measurement
/// of many seconds of data, and the measurement never waits for it. Clones share it.
#[derive(Debug, Clone)]
pub struct Assessor {
    confidence: f64,
    latest: Arc<Mutex<Option<Arc<Assessment>>>>,
}

impl Assessor {
    /// An assessor at the level `confidence`, 0 < p < 1.
    pub(crate) fn new(confidence: f64) -> Self {
        Self { confidence, latest: Arc::default() }
    }

    /// The assessment of this snapshot, or of an earlier one with more than nineteen twentieths of
    /// its samples. The call takes milliseconds if a new assessment is made.
    pub(crate) fn latest(&self, snapshot: &Snapshot) -> Arc<Assessment> {
        // an assessment that panicked was not kept
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let samples = snapshot.timing.samples;
        if let Some(latest) = &*latest
            && (latest.samples..latest.samples + latest.samples.div_ceil(20)).contains(&samples)
            && latest.channels.len() == snapshot.channels.len()
        {
            return Arc::clone(latest);
        }
        let assessment = Arc::new(self.exact(snapshot));
        *latest = Some(Arc::clone(&assessment));
        assessment
    }

    /// The assessment of exactly this snapshot, for a final result.
    #[must_use]
    pub fn exact(&self, snapshot: &Snapshot) -> Assessment {
        Assessment::new(snapshot, self.confidence)
    }
}

/// Checks whether the goals are met or out of reach: at every second of data time at first, later
/// whenever the record has grown by a twentieth. It always assesses the samples of that moment, so
/// that the end of the measurement depends only on the samples.
#[derive(Debug, Default)]
pub(crate) struct GoalCheck {
    next_second: u64,
}

impl GoalCheck {
    pub(crate) fn is_decided(&mut self, analysis: &Analysis) -> bool {
        let second = analysis.seconds();
        if analysis.settings().until.is_empty() || second < self.next_second {
            return false;
        }
        self.next_second = second + second.div_ceil(20).max(1);
        analysis.goals_are_decided()
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::Settings;
    use vn100_analysis::protocol::{VNIMU, stream::Batch};

    use super::*;

    /// A record at 1 Hz of white noise, with this goal.
    fn analysis(goal: Option<&str>) -> Analysis {
        let until = goal.map(|goal| goal.parse().unwrap()).into_iter().collect();
        Analysis::new(Settings { rate_hz: Some(1.0), until, ..Settings::default() })
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
        let (mut analysis, mut state) = (analysis(Some("gyro N ±0.0001%")), 1);
        let mut goals = GoalCheck::default();
        let mut looked = Vec::new();
        for second in 1..=48 {
            add_second(&mut analysis, &mut state);
            let before = goals.next_second;
            assert!(!goals.is_decided(&analysis));
            looked.extend((goals.next_second != before).then_some(second));
        }
        let expected: Vec<_> = (1..=20).chain([21, 23, 25, 27, 29, 31, 33, 35, 37, 39, 41, 44, 47]).collect();
        assert_eq!(looked, expected);
    }

    #[test]
    fn a_goal_that_is_met_decides_and_none_never_does() {
        let (mut wanted, mut goalless, mut state) = (analysis(Some("gyro N ±60%")), analysis(None), 1);
        let (mut goals, assessor) = (GoalCheck::default(), Assessor::new(0.95));
        let mut decided_at = None;
        for second in 1..=400 {
            add_second(&mut wanted, &mut state);
            add_second(&mut goalless, &mut state);
            assert!(!GoalCheck::default().is_decided(&goalless));
            if goals.is_decided(&wanted) {
                decided_at = Some(second);
                break;
            }
        }
        assert!((3..300).contains(&decided_at.unwrap()), "{decided_at:?}");
        let snapshot = wanted.snapshot();
        assert!(wanted.settings().until[0].is_met(&snapshot, &assessor.exact(&snapshot)));
    }
}

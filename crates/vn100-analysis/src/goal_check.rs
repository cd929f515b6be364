//! Whether a measurement may end. The cheapest test comes first, so that a fit is made only where
//! its answer may be yes.

use imu_noise::{OctaveSum, Term, least_half_width};

use crate::{
    accumulate::analysis::Analysis,
    assessment::{Assessment, SingleAxes},
    goal::Goal,
    snapshot::{ChannelSnapshot, Snapshot},
};

/// Wider goals are left to the fit: the asymmetry of so wide an interval cannot be predicted.
const WIDEST: f64 = 0.5;

impl Analysis {
    /// Whether all goals of the settings are met, or one is out of reach; `false` without goals.
    /// The answer is that of [`Goal::is_met`] with the assessment of this moment, mostly without
    /// making one.
    #[must_use]
    pub fn goals_are_decided(&self) -> bool {
        let (goals, confidence) = (&self.settings().until, self.settings().confidence);
        let (Some(layout), false) = (self.layout(), goals.is_empty()) else { return false };
        if goals.iter().any(|goal| goal.figure.absent_from(layout).is_some()) {
            return true;
        }
        let samples = self.timing().samples + self.timing().missing;
        if !goals.iter().all(|goal| goal.is_within(samples, confidence)) {
            return false;
        }
        let snapshot = self.snapshot();
        if !goals.iter().all(|goal| goal.is_within_octaves(&snapshot, confidence)) {
            return false;
        }
        let mut axes = SingleAxes::new(&snapshot, confidence);
        if !goals.iter().all(|goal| goal.is_met_by_each(&snapshot, &mut axes)) {
            return false;
        }
        // a slow term may be estimated on one axis alone and not be significant on all axes
        // together
        let is_slow = |goal: &Goal| goal.figure.term != Term::White;
        let assessment = goals.iter().any(is_slow).then(|| Assessment::new(&snapshot, confidence));
        assessment.is_none_or(|assessment| goals.iter().all(|goal| goal.is_met(&snapshot, &assessment)))
    }
}

impl Goal {
    /// Whether a record of this many samples may meet the goal.
    fn is_within(&self, samples: u64, confidence: f64) -> bool {
        self.figure.term != Term::White || self.allows(std::iter::empty(), samples, confidence)
    }

    /// Whether a record with these octaves may meet the goal.
    fn is_within_octaves(&self, snapshot: &Snapshot, confidence: f64) -> bool {
        let samples = snapshot.timing.samples + snapshot.timing.missing;
        let octaves = |results: &ChannelSnapshot| {
            let of = |sum: &OctaveSum| Some((sum.octave().m, sum.variance_counts2()?));
            results.octaves.iter().filter_map(of).collect::<Vec<_>>()
        };
        let mut concerned = snapshot.measured().filter(|(channel, _)| self.figure.concerns(channel));
        concerned.all(|(_, results)| self.allows(octaves(results).into_iter(), samples, confidence))
    }

    fn allows(&self, octaves: impl Iterator<Item = (u64, f64)> + Clone, samples: u64, confidence: f64) -> bool {
        let least = least_half_width(self.figure.term, octaves, samples, confidence);
        self.relative_half_width > WIDEST || least <= self.relative_half_width
    }

    /// Whether each axis of the goal meets it, independently of the others.
    fn is_met_by_each(&self, snapshot: &Snapshot, axes: &mut SingleAxes<'_>) -> bool {
        let mut concerned = (snapshot.layout_channels().iter().enumerate())
            .filter(|(_, channel)| self.figure.concerns(channel))
            .peekable();
        let mut is_met = |(place, _)| {
            let width = axes.parameter(place, self.figure.term).and_then(|parameter| parameter.relative_half_width());
            width.is_some_and(|width| width <= self.relative_half_width)
        };
        concerned.peek().is_some() && concerned.all(&mut is_met)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn so_few_samples_rule_out_a_narrow_goal_and_no_wide_one() {
        for (text, samples, is_within) in [
            ("gyro N ±5%", 40, false),
            ("gyro N ±5%", 100_000, true),
            ("gyro N ±50%", 2, false),
            ("gyro N ±51%", 2, true),
            ("gyro B ±5%", 2, true),
        ] {
            assert_eq!(text.parse::<Goal>().unwrap().is_within(samples, 0.95), is_within, "{text}, {samples}");
        }
    }
}

//! When a measurement has reached its goals.

use crate::{accumulate::analysis::Analysis, assessment::Assessment};

impl Analysis {
    /// Whether all goals of the settings are met, or one is out of reach; `false` without goals. The
    /// answer is that of [`Goal::is_met`] with the assessment of this moment, which is made only if
    /// its answer may be yes.
    #[must_use]
    pub fn goals_are_decided(&self) -> bool {
        let (goals, confidence) = (&self.settings().until, self.settings().confidence);
        let (Some(layout), false) = (self.layout(), goals.is_empty()) else { return false };
        if goals.iter().any(|goal| goal.figure.absent_from(layout).is_some()) {
            return true;
        }
        let snapshot = self.snapshot();
        goals.iter().all(|goal| goal.may_be_met(&snapshot, confidence)) && {
            let assessment = Assessment::new(&snapshot, confidence);
            goals.iter().all(|goal| goal.is_met(&snapshot, &assessment))
        }
    }
}

//! What a measurement ends by, how far the measurement is, and how much more time it takes. Texts
//! are as on a terminal, see [`plain`](crate::numbers::plain).

use std::time::Duration;

use vn100_analysis::{Assessment, Goal, LinkStatus, Settings, Snapshot};

use crate::numbers::plain::{digits_trimmed, span, time};

/// What a measurement ends by.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Goals {
    /// Data time to be measured; `None` for no limit.
    pub duration: Option<Duration>,
    /// Time by the clock, from the start of the command; `None` for no limit.
    pub wall: Option<Duration>,
    /// Precisions to be reached.
    pub until: Vec<Goal>,
}

impl Goals {
    /// The goals in these settings, and this limit by the clock.
    #[must_use]
    pub fn of(settings: &Settings, wall: Option<Duration>) -> Self {
        Self { duration: settings.duration, wall, until: settings.until.clone() }
    }

    /// Whether there is no goal.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.duration.is_none() && self.wall.is_none() && self.until.is_empty()
    }

    /// One text for each goal, the times first; `elapsed` is the time by the clock. While nothing is
    /// received from the link of the source, no text foretells how much more data time a goal takes.
    #[must_use]
    pub fn texts(
        &self,
        snapshot: &Snapshot,
        assessment: &Assessment,
        elapsed: Duration,
        link: Option<LinkStatus>,
    ) -> Vec<String> {
        let is_receiving = link.is_none_or(|status| status == LinkStatus::Connected);
        let duration = self.duration.map(|duration| progress(data_time_s(snapshot), duration, is_receiving));
        let wall = self.wall.map(|wall| format!("by the clock {}", progress(elapsed.as_secs_f64(), wall, true)));
        let until = self.until.iter().map(|goal| of_goal(snapshot, assessment, goal, is_receiving));
        duration.into_iter().chain(wall).chain(until).collect()
    }
}

/// How far the warm-up is, if all data so far lie in it: `17 s of 20 s`; else `None`.
#[must_use]
pub fn warm_up(snapshot: &Snapshot) -> Option<String> {
    let skip_s = snapshot.skipped.as_secs_f64();
    snapshot.is_in_warm_up().then(|| format!("{} of {}", time(data_time_s(snapshot).min(skip_s)), span(skip_s, " ")))
}

/// Data time so far, with what is excluded as warm-up.
fn data_time_s(snapshot: &Snapshot) -> f64 {
    let (timing, skipped) = (&snapshot.timing, snapshot.skipped);
    match timing.samples {
        0 => timing.excluded as f64 / timing.rate_hz,
        _ => timing.duration_s() + skipped.as_secs_f64(),
    }
}

/// In place of the time that a goal still takes.
const NOTHING_RECEIVED: &str = "nothing is received now";

fn progress(passed_s: f64, whole: Duration, goes_on: bool) -> String {
    let whole_s = whole.as_secs_f64();
    let more = match whole_s - passed_s {
        more_s if more_s <= 0.0 => String::new(),
        more_s if goes_on => format!(", {} more", time(more_s.ceil())),
        _ => format!(", {NOTHING_RECEIVED}"),
    };
    format!("{} of {}{more}", time(passed_s), span(whole_s, " "))
}

fn of_goal(snapshot: &Snapshot, assessment: &Assessment, goal: &Goal, is_receiving: bool) -> String {
    let asked = 100.0 * goal.relative_half_width;
    if let Some(why) = goal.out_of_reach(snapshot) {
        return format!("{goal}: out of reach, {why}");
    }
    let widths = goal.relative_half_widths(snapshot, assessment);
    let widest = widths.iter().map(|(_, width)| *width).try_fold(0.0, |widest: f64, width| Some(widest.max(width?)));
    let Some(widest) = widest.filter(|_| !widths.is_empty()) else {
        return format!("{goal}: not estimated yet");
    };
    let decimals = usize::from(widest < 0.0995);
    let known = format!("{} ±{:.decimals$} % of ±{} %", goal.figure, 100.0 * widest, digits_trimmed(asked, 4));
    if widest <= goal.relative_half_width {
        return format!("{known}, reached");
    }
    if !is_receiving {
        return format!("{known}, {NOTHING_RECEIVED}");
    }
    // an interval narrows as the root of the time
    let ratio = widest / goal.relative_half_width;
    let more_s = snapshot.timing.duration_s() * (ratio * ratio - 1.0);
    format!("{known}, about {} more", about(more_s))
}

/// With a single figure or two: an estimate is no better.
fn about(seconds: f64) -> String {
    let (unit, name) = match seconds {
        86_400.0.. => (86_400.0, "d"),
        5400.0.. => (3600.0, "h"),
        90.0.. => (60.0, "min"),
        _ => (1.0, "s"),
    };
    let count = seconds / unit;
    let count = if count < 3.0 && unit > 1.0 { (2.0 * count).round() / 2.0 } else { count.ceil() };
    format!("{} {name}", digits_trimmed(count, 4))
}

#[cfg(test)]
mod tests {
    use vn100_analysis::Analysis;

    use super::*;

    #[test]
    fn a_warm_up_is_as_far_as_its_samples() {
        let skip = Duration::from_secs(20);
        let mut snapshot = Analysis::new(Settings { skip, ..Settings::default() }).snapshot();
        assert_eq!(warm_up(&snapshot), None, "nothing arrived");
        snapshot.timing.excluded = 17 * 40;
        assert_eq!(warm_up(&snapshot).as_deref(), Some("17 s of 20 s"));
        snapshot.timing.samples = 1;
        assert_eq!(warm_up(&snapshot), None, "the measurement has begun");
        (snapshot.timing.samples, snapshot.skipped) = (0, Duration::ZERO);
        assert_eq!(warm_up(&snapshot), None, "excluded for another reason");
    }

    #[test]
    fn no_time_is_foretold_while_nothing_is_received() {
        let goals = Goals { duration: Some(Duration::from_secs(60)), ..Goals::default() };
        let snapshot = Analysis::new(Settings::default()).snapshot();
        let assessment = Assessment::new(&snapshot, 0.95);
        let texts = |link| goals.texts(&snapshot, &assessment, Duration::ZERO, link).concat();
        assert_eq!(texts(None), "0 s of 1 min, 1 min more");
        assert_eq!(texts(Some(LinkStatus::Connected)), "0 s of 1 min, 1 min more");
        assert_eq!(texts(Some(LinkStatus::Lost)), "0 s of 1 min, nothing is received now");
    }

    #[test]
    fn the_remaining_time_is_rounded() {
        for (seconds, text) in [
            (0.4, "1 s"),
            (59.2, "60 s"),
            (100.0, "1.5 min"),
            (240.0, "4 min"),
            (6000.0, "1.5 h"),
            (20_000.0, "6 h"),
            (200_000.0, "2.5 d"),
        ] {
            assert_eq!(about(seconds), text);
        }
    }
}

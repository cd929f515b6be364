//! What a measurement ends by, how far the measurement is, and how much more time it takes. Texts
//! are as on a terminal, see [`plain`](crate::numbers::plain).

use std::time::Duration;

use vn100_analysis::{Goal, LinkStatus, Settings, SourceResult, TimeBase};

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
    pub fn of(settings: &Settings, wall: Option<Duration>) -> Self {
        Self { duration: settings.duration, wall, until: settings.until.clone() }
    }

    /// One text for each goal, the times first; `elapsed` is the time by the clock. While nothing is
    /// received from the link of the source, no text foretells how much more data time a goal takes.
    pub fn texts(&self, result: &SourceResult, elapsed: Duration) -> Vec<String> {
        let link = result.source.link.as_ref();
        let is_receiving = link.is_none_or(|link| link.status == LinkStatus::Connected);
        let duration = self.duration.map(|duration| progress(data_time_s(&result.timing), duration, is_receiving));
        let wall = self.wall.map(|wall| format!("by the clock {}", progress(elapsed.as_secs_f64(), wall, true)));
        let own = self.until.iter().filter(|goal| !result.is_elsewhere(&goal.figure));
        let until = own.map(|goal| of_goal(result, goal, is_receiving));
        duration.into_iter().chain(wall).chain(until).collect()
    }
}

/// How far the warm-up is, if all data so far lie in it: `17 s of 20 s`; else `None`.
pub fn warm_up(timing: &TimeBase) -> Option<String> {
    let skip_s = timing.skipped_s;
    timing.is_in_warm_up().then(|| format!("{} of {}", time(data_time_s(timing).min(skip_s)), span(skip_s, " ")))
}

/// Data time so far, with what is excluded as warm-up.
fn data_time_s(timing: &TimeBase) -> f64 {
    match (timing.samples, timing.rate_hz) {
        (0, Some(hz)) => timing.excluded as f64 / hz,
        (0, None) => 0.0,
        _ => timing.duration_s + timing.skipped_s,
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

fn of_goal(result: &SourceResult, goal: &Goal, is_receiving: bool) -> String {
    let asked = 100.0 * goal.relative_half_width;
    if let Some(why) = result.out_of_reach(goal) {
        return format!("{goal}: out of reach, {why}");
    }
    let Some(widest) = widest(result, goal) else { return format!("{goal}: not estimated yet") };
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
    let more_s = result.timing.duration_s * (ratio * ratio - 1.0);
    format!("{known}, about {} more", about(more_s))
}

/// Half the relative width of the interval of the axis known least, if all are estimated.
pub(crate) fn widest(result: &SourceResult, goal: &Goal) -> Option<f64> {
    result.half_widths(goal).iter().map(|(_, width)| *width).reduce(|a, b| Some(a?.max(b?))).flatten()
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
    use vn100_analysis::{Analysis, LinkFacts};

    use super::*;
    use crate::tests::fixture::{facts, nothing, result};

    #[test]
    fn a_warm_up_is_as_far_as_its_samples() {
        let skip = Duration::from_secs(20);
        let snapshot = Analysis::new(Settings { skip, ..Settings::default() }).snapshot();
        let mut timing = result(facts("a"), snapshot).timing;
        assert_eq!(warm_up(&timing), None, "nothing arrived");
        (timing.excluded, timing.rate_hz) = (17 * 40, Some(40.0));
        assert_eq!(warm_up(&timing).as_deref(), Some("17 s of 20 s"));
        timing.samples = 1;
        assert_eq!(warm_up(&timing), None, "the measurement has begun");
        (timing.samples, timing.skipped_s) = (0, 0.0);
        assert_eq!(warm_up(&timing), None, "excluded for another reason");
    }

    #[test]
    fn no_time_is_foretold_while_nothing_is_received() {
        let goals = Goals { duration: Some(Duration::from_secs(60)), ..Goals::default() };
        let mut result = result(facts("a"), nothing());
        let mut texts = |status: Option<LinkStatus>| {
            result.source.link = status.map(|status| LinkFacts { status, ..LinkFacts::default() });
            goals.texts(&result, Duration::ZERO).concat()
        };
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

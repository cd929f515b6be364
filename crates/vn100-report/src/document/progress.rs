//! Short lines about a measurement under way, schema `vn100.progress/1`: one for each second of
//! data, and heartbeats while no data comes.

use std::{collections::BTreeMap, time::Duration};

use serde::Serialize;
use vn100_analysis::noise::{Parameter, Term};
use vn100_analysis::{Goal, LinkFacts};

use super::source::utc;
use crate::{
    codes::{code_of_end, code_of_status},
    measured::Measured,
    units::{ChannelValues, channel_values},
};

/// The JSON Schema (2020-12) of [`ProgressDocument`] and [`HeartbeatDocument`].
pub const PROGRESS_SCHEMA: &str = include_str!("../../schemas/progress.json");

const SCHEMA: &str = "vn100.progress/1";

/// One second of data in less than 2000 bytes.
#[derive(Debug, Serialize)]
pub struct ProgressDocument {
    schema: &'static str,
    #[serde(rename = "type")]
    kind: &'static str,
    source: String,
    /// Data time.
    elapsed_s: f64,
    samples: u64,
    missing: u64,
    rate_hz: f64,
    /// `None` for what is no link.
    link: Option<&'static str>,
    channels: Vec<ProgressChannel>,
    /// How many of each kind.
    warnings: BTreeMap<&'static str, u64>,
    goals: Vec<GoalProgress>,
    /// `None` while it is under way.
    end_reason: Option<&'static str>,
}

/// Values are rounded to four digits, in the units of the whole document.
#[derive(Debug, Serialize)]
struct ProgressChannel {
    name: String,
    std: Option<f64>,
    /// N; not there for what has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    white: Option<ShortParameter>,
}

#[derive(Debug, Serialize)]
struct ShortParameter {
    status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lower: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper: Option<f64>,
}

#[derive(Debug, Serialize)]
struct GoalProgress {
    goal: String,
    /// Of the axis known least; `None` if one is not estimated.
    relative_half_width: Option<f64>,
    met: bool,
}

impl ProgressDocument {
    /// The line of a measurement with these goals, under way or over.
    #[must_use]
    pub fn new(measured: &Measured, goals: &[Goal]) -> Self {
        let Measured { facts, snapshot, assessment, .. } = measured;
        let timing = &snapshot.timing;
        let mut warnings = BTreeMap::new();
        measured.warnings().iter().for_each(|warning| *warnings.entry(warning.kind.name()).or_default() += 1);
        let progress = |goal: &Goal| {
            let axes = goal.relative_half_widths(snapshot, assessment);
            let widest = axes.iter().map(|(_, width)| *width).reduce(|a, b| Some(a?.max(b?))).flatten();
            let met = goal.is_met(snapshot, assessment);
            GoalProgress { goal: goal.to_string(), relative_half_width: widest.map(short), met }
        };
        Self {
            schema: SCHEMA,
            kind: "progress",
            source: facts.name.clone(),
            elapsed_s: (timing.duration_s() * 1e3).round() / 1e3,
            samples: timing.samples,
            missing: timing.missing,
            rate_hz: timing.rate_hz,
            link: facts.link.as_ref().map(|link| link.status.name()),
            channels: channel_values(snapshot, assessment).into_iter().map(ProgressChannel::new).collect(),
            warnings,
            goals: goals.iter().map(progress).collect(),
            end_reason: facts.end.map(|end| code_of_end(end).code),
        }
    }
}

impl ProgressChannel {
    fn new(values: ChannelValues) -> Self {
        let white = values.noise.as_ref().and_then(|noise| noise.parameter(Term::White));
        Self {
            name: values.name,
            std: values.std.map(short),
            white: white.map(|Parameter { status, value, lower, upper, .. }| ShortParameter {
                status: code_of_status(status).code,
                value: value.map(short),
                lower: lower.map(short),
                upper: upper.map(short),
            }),
        }
    }
}

/// A value with four digits.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// The line of a second by the clock in which no data came.
#[derive(Debug, Serialize)]
pub struct HeartbeatDocument {
    schema: &'static str,
    #[serde(rename = "type")]
    kind: &'static str,
    source: String,
    samples: u64,
    /// `None` for what is no link.
    link: Option<&'static str>,
    /// When the latest sample came, or else the start; `None` if the clock is not set.
    since: Option<String>,
    silent_s: f64,
    /// Failed attempts to connect since the sensor was connected last.
    tries: u32,
    cause: Option<String>,
}

impl HeartbeatDocument {
    /// The line of a source that has given this number of samples, and none for `silent` until
    /// `now_ns`, in nanoseconds since 1970.
    #[must_use]
    pub fn new(source: &str, samples: u64, link: Option<&LinkFacts>, silent: Duration, now_ns: i64) -> Self {
        let silent_ns = i64::try_from(silent.as_nanos()).unwrap_or(i64::MAX);
        Self {
            schema: SCHEMA,
            kind: "heartbeat",
            source: source.to_owned(),
            samples,
            link: link.map(|link| link.status.name()),
            since: now_ns.checked_sub(silent_ns).and_then(utc),
            silent_s: (silent.as_secs_f64() * 10.0).round() / 10.0,
            tries: link.map_or(0, |link| link.attempts),
            cause: link.and_then(|link| link.cause.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::LinkStatus;

    use super::*;

    #[test]
    fn a_heartbeat_says_what_the_link_does_and_since_when() {
        let link = LinkFacts {
            status: LinkStatus::Lost,
            cause: Some("there is no such port".into()),
            attempts: 4,
            ..LinkFacts::default()
        };
        let now_ns = 1_763_700_003_200_000_000;
        let beat = HeartbeatDocument::new("/dev/imu", 480, Some(&link), Duration::from_millis(3_177), now_ns);
        assert_eq!(
            serde_json::to_string(&beat).unwrap(),
            r#"{"schema":"vn100.progress/1","type":"heartbeat","source":"/dev/imu","samples":480,"link":"lost","since":"2025-11-21T04:40:00.023Z","silent_s":3.2,"tries":4,"cause":"there is no such port"}"#
        );
        let stream = HeartbeatDocument::new("-", 0, None, Duration::from_secs(1), 0);
        assert_eq!((stream.link, stream.since, stream.tries), (None, None, 0));
    }

    #[test]
    fn values_have_four_digits() {
        for (value, rounded) in [(0.000_638_561_2, 0.000_638_6), (-12_345.6, -12_350.0), (0.0, 0.0)] {
            assert_eq!(short(value), rounded);
        }
    }
}

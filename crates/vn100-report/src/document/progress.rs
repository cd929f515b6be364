//! Short lines about a measurement under way, schema `vn100.progress/2`: one for each second of
//! data, and heartbeats while no data comes.

use std::{collections::BTreeMap, time::Duration};

use schemars::{JsonSchema, Schema};
use serde::Serialize;
use vn100_analysis::noise::{Parameter, Status, Term};
use vn100_analysis::{ChannelResult, EndKind, Goal, LinkFacts, SourceResult, utc};

use crate::{codes::name_of, goals::widest, schema::schema_of};

/// The JSON Schema (2020-12) of [`ProgressDocument`] and [`HeartbeatDocument`].
pub fn progress_schema() -> Schema {
    schema_of::<Line>()
}

/// A line about a measurement under way: progress for each second of data and at the end, heartbeat
/// for each second by the clock without data. Fields may be added.
#[derive(JsonSchema, Serialize)]
#[serde(untagged)]
#[schemars(title = "vn100.progress/2")]
#[expect(dead_code, reason = "the schema alone describes both")]
enum Line {
    /// A second of data, or the end.
    Progress(ProgressDocument),
    /// A second by the clock without data.
    Heartbeat(HeartbeatDocument),
}

const SCHEMA: &str = "vn100.progress/2";

/// A second of data, or the end, in less than 2000 bytes.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ProgressDocument {
    /// Name of this schema.
    #[schemars(extend("const" = "vn100.progress/2"))]
    schema: &'static str,
    /// Kind of line.
    #[serde(rename = "type")]
    #[schemars(extend("const" = "progress"))]
    kind: &'static str,
    /// Name of the file or port, without its folder.
    source: String,
    /// Data time measured, in seconds.
    elapsed_s: f64,
    /// Number of samples.
    samples: u64,
    /// Missing samples; null if samples may be missing unseen.
    missing: Option<u64>,
    /// Nominal sample rate in Hz; null while it is not known.
    rate_hz: Option<f64>,
    /// What the link does; null for a source without a link.
    link: Option<String>,
    /// The channels, with values of four digits in the units of vn100.analysis/2.
    channels: Vec<ProgressChannel>,
    /// How many warnings there are of each kind.
    warnings: BTreeMap<&'static str, u64>,
    /// What is to be known before the measurement ends.
    goals: Vec<GoalProgress>,
    /// Why the measurement ended; null while it is under way.
    end_reason: Option<EndKind>,
}

/// A channel.
#[derive(Debug, JsonSchema, Serialize)]
struct ProgressChannel {
    /// Name of the channel.
    name: String,
    /// Standard deviation of one sample.
    std: Option<f64>,
    /// N, the density of the white noise; absent for a channel without noise parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    white: Option<ShortParameter>,
}

/// A parameter, without the parts that are not known.
#[derive(Debug, JsonSchema, Serialize)]
struct ShortParameter {
    /// What is known of the parameter.
    status: Status,
    /// Estimate; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    /// Lower end of the interval; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    lower: Option<f64>,
    /// Upper end of the interval, or upper bound; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    upper: Option<f64>,
}

/// A goal.
#[derive(Debug, JsonSchema, Serialize)]
struct GoalProgress {
    /// The goal, such as gyro N ±5 %.
    goal: String,
    /// Half the width of the interval over the value, of the axis known least; null if one axis is not
    /// estimated.
    relative_half_width: Option<f64>,
    /// Whether the goal is met.
    met: bool,
}

impl ProgressDocument {
    /// The line of a measurement with these goals, under way or over.
    pub fn new(result: &SourceResult, goals: &[Goal]) -> Self {
        let timing = &result.timing;
        let mut warnings = BTreeMap::new();
        result.warnings.iter().for_each(|warning| *warnings.entry(warning.kind.name()).or_default() += 1);
        let progress = |goal: &Goal| {
            let widest = widest(result, goal);
            let met = widest.is_some_and(|widest| widest <= goal.relative_half_width);
            GoalProgress { goal: goal.to_string(), relative_half_width: widest.map(short), met }
        };
        Self {
            schema: SCHEMA,
            kind: "progress",
            source: result.source.name.clone(),
            elapsed_s: (timing.duration_s * 1e3).round() / 1e3,
            samples: timing.samples,
            missing: timing.missing,
            rate_hz: timing.rate_hz,
            link: result.source.link.as_ref().map(|link| name_of(link.status)),
            channels: result.channels.iter().map(ProgressChannel::new).collect(),
            warnings,
            goals: goals.iter().map(progress).collect(),
            end_reason: result.end_reason,
        }
    }
}

impl ProgressChannel {
    fn new(channel: &ChannelResult) -> Self {
        let white = channel.noise.as_ref().and_then(|noise| noise.parameter(Term::White));
        Self {
            name: channel.name.clone(),
            std: channel.statistics.std.map(short),
            white: white.map(|Parameter { status, value, lower, upper, .. }| ShortParameter {
                status,
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

/// A second by the clock without data.
#[derive(Debug, JsonSchema, Serialize)]
pub struct HeartbeatDocument {
    /// Name of this schema.
    #[schemars(extend("const" = "vn100.progress/2"))]
    schema: &'static str,
    /// Kind of line.
    #[serde(rename = "type")]
    #[schemars(extend("const" = "heartbeat"))]
    kind: &'static str,
    /// Name of the port.
    source: String,
    /// Samples so far.
    samples: u64,
    /// What the link does; null for a source without a link.
    link: Option<String>,
    /// When the latest sample came, or else the measurement began, RFC 3339; null without a date.
    since: Option<String>,
    /// Seconds since then.
    silent_s: f64,
    /// Failed attempts to connect since the sensor was connected last.
    tries: u32,
    /// Why the link is down; null if it is not.
    cause: Option<String>,
}

impl HeartbeatDocument {
    /// The line of a source that has given this number of samples, and none for `silent` until
    /// `now_ns`, in nanoseconds since 1970.
    pub fn new(source: &str, samples: u64, link: Option<&LinkFacts>, silent: Duration, now_ns: i64) -> Self {
        let silent_ns = i64::try_from(silent.as_nanos()).unwrap_or(i64::MAX);
        Self {
            schema: SCHEMA,
            kind: "heartbeat",
            source: source.to_owned(),
            samples,
            link: link.map(|link| name_of(link.status)),
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
            r#"{"schema":"vn100.progress/2","type":"heartbeat","source":"/dev/imu","samples":480,"link":"lost","since":"2025-11-21T04:40:00.023Z","silent_s":3.2,"tries":4,"cause":"there is no such port"}"#
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

//! How far the record can be trusted: one line for each aspect, with what was found.

use schemars::JsonSchema;
use serde::Serialize;
use vn100_analysis::protocol::Quantity;
use vn100_analysis::protocol::stream::BagReport;
use vn100_analysis::{
    Aspect, ChannelResult, Completion, RateFrom, Remedy, Severity, SourceFacts, SourceResult, Warning, WarningKind,
};

use super::AspectStatus;
use crate::{
    codes::word_of,
    goals::warm_up,
    names::{outages, rejected_lines},
    numbers::plain::{counted, grouped, ppm, short},
    warnings::headline,
};

/// The status of an aspect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StatusWord {
    /// The sensor was moved.
    Moved,
    /// Numbers of the result are wrong, or not those of the sensor, or the record is not complete.
    Problem,
    /// Numbers of the result are less certain, or mean less.
    Check,
    /// The stream does not show all that the sensor has.
    Limited,
    /// The record does not show the aspect.
    Untested,
    /// Nothing was found.
    Ok,
}

impl StatusWord {
    pub(crate) const ALL: [Self; 6] =
        [Self::Moved, Self::Problem, Self::Check, Self::Limited, Self::Untested, Self::Ok];

    const fn of(severity: Option<Severity>, is_moved: bool) -> Self {
        match severity {
            Some(Severity::Problem) if is_moved => Self::Moved,
            Some(Severity::Problem) => Self::Problem,
            Some(Severity::Caution) => Self::Check,
            Some(Severity::Note) => Self::Limited,
            None => Self::Ok,
        }
    }

    /// The word, in capitals if the numbers are not to be used as they stand.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Moved => "MOVED",
            Self::Problem => "PROBLEM",
            Self::Check => "CHECK",
            Self::Limited => "limited",
            Self::Untested => "untested",
            Self::Ok => "ok",
        }
    }
}

/// In the order of a measurement; aspects without anything to say are omitted. `place` is that of the
/// note for a remedy.
pub(crate) fn statuses(result: &SourceResult, mut place: impl FnMut(&Remedy) -> usize) -> Vec<AspectStatus> {
    let all = Aspect::ALL.into_iter().map(|aspect| found(aspect, result, &mut place));
    all.filter(|found| !found.findings.is_empty()).collect()
}

fn found(aspect: Aspect, result: &SourceResult, mut place: impl FnMut(&Remedy) -> usize) -> AspectStatus {
    let of_aspect = |warning: &&Warning| warning.kind.aspect() == aspect;
    let warnings: Vec<&Warning> = result.warnings.iter().filter(of_aspect).collect();
    // a note stands beside graver ones in full results alone
    let is_shown = |warning: &&&Warning| {
        aspect == Aspect::Message || warning.kind == WarningKind::Incomplete || warning.severity < Severity::Note
    };
    let mut findings: Vec<(String, Vec<usize>)> = (warnings.iter().filter(is_shown))
        .map(|warning| (headline(warning), warning.remedies.iter().map(&mut place).collect()))
        .collect();
    let mut severity = warnings.iter().map(|warning| warning.severity).min();
    if aspect == Aspect::Data {
        let cut = failure(result).filter(|_| warnings.iter().all(|warning| warning.kind != WarningKind::Incomplete));
        severity = cut.map_or(severity, |_| Some(Severity::Problem));
        let texts = source(&result.source).into_iter().chain(cut.map(str::to_owned));
        findings.splice(0..0, texts.map(|text| (text, Vec::new())));
    }
    let severity = severity.filter(|severity| *severity < Severity::Note || aspect == Aspect::Message);
    let untested = untested(aspect, result).filter(|_| severity.is_none());
    let is_moved = result.motion.is_some() && aspect == Aspect::AtRest;
    let (severity, word) = match untested {
        Some(_) => (Some(Severity::Note), StatusWord::Untested),
        None => (severity, StatusWord::of(severity, is_moved)),
    };
    let undisturbed = || undisturbed(aspect, result).filter(|_| severity.is_none());
    // with and without losses of other kinds
    let outages = outages(&result.link).filter(|_| aspect == Aspect::Data && result.timing.samples > 0);
    let texts = untested.or_else(undisturbed).into_iter().chain(outages.map(|outages| format!("link {outages}")));
    findings.extend(texts.map(|text| (text, Vec::new())));
    AspectStatus { aspect: aspect.name(), severity, word, findings }
}

/// Why the measurement failed, if it did.
fn failure(result: &SourceResult) -> Option<&str> {
    let SourceFacts { name, error, .. } = &result.source;
    let error = error.as_deref().filter(|_| result.completion == Completion::Failed)?;
    Some(error.strip_prefix(&**name).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(error))
}

/// The numbers of a bag or a table that are used, and their times.
fn source(facts: &SourceFacts) -> Option<String> {
    if let Some(BagReport { topic, type_name, messages, used, stamps, unpacked_bytes, .. }) = &facts.bag {
        let unpacked = match unpacked_bytes {
            0 => String::new(),
            bytes => format!("; unpacked to {} bytes", grouped(*bytes)),
        };
        let counted = match messages == used {
            true => format!("{} messages", grouped(*messages)),
            false => format!("{} of {} messages used", grouped(*used), grouped(*messages)),
        };
        return Some(format!("{topic} ({type_name}), {counted}, stamps {stamps}{unpacked}"));
    }
    let csv = facts.csv.as_ref()?;
    let times =
        csv.times.as_ref().map_or_else(|| "no times".into(), |times| format!("times of column {}", named_unit(times)));
    let unused = match csv.ignored_columns.len() as u64 {
        0 => String::new(),
        count => format!(", {} unused", counted(count, "column")),
    };
    let left_out: Vec<_> = csv.left_out.iter().map(|column| format!("{} ({})", column.name, column.reason)).collect();
    let left_out = if left_out.is_empty() { String::new() } else { format!("; left out: {}", left_out.join(", ")) };
    // they are counted at the end of the measurement
    let rows = if csv.lines == 0 { String::new() } else { format!("{} rows, ", grouped(csv.rows)) };
    Some(format!("{rows}{times}{unused}{left_out}"))
}

/// Its name and unit, as in `time [ns]:ns`, as a reader says them.
fn named_unit(column: &str) -> String {
    match column.rsplit_once(':') {
        Some((name, unit)) => {
            let name = name.strip_suffix(&format!("[{unit}]")).map_or(name, str::trim_end);
            format!("{name}, {unit}")
        }
        None => column.to_owned(),
    }
}

/// In a shorter record no warm-up and no slow motion would be found.
const LEAST_AT_REST_S: f64 = 10.0;

/// Whether a channel would show motion: one of a sensor that has axes.
fn may_be_moved(result: &SourceResult) -> bool {
    let has_axes = |channel: &ChannelResult| {
        !matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure | Quantity::Value)
    };
    result.streamed().any(has_axes)
}

/// Why an aspect could not be tested; `None` if it was.
fn untested(aspect: Aspect, result: &SourceResult) -> Option<String> {
    match aspect {
        Aspect::Data => warm_up(&result.timing).map(|passed| format!("no sample: warm-up excluded, {passed}")),
        Aspect::AtRest => {
            let is_searched =
                |channel: &ChannelResult| channel.stationarity.as_ref().is_some_and(|found| found.level_searched);
            let is_short = !result.streamed().any(is_searched) || result.timing.duration_s < LEAST_AT_REST_S;
            (may_be_moved(result) && is_short && result.timing.samples > 0)
                .then(|| "the record is too short to show it".into())
        }
        Aspect::Time | Aspect::Message | Aspect::Values => None,
    }
}

/// What an aspect without a warning says; `None` for nothing.
fn undisturbed(aspect: Aspect, result: &SourceResult) -> Option<String> {
    let timing = &result.timing;
    match aspect {
        Aspect::Data | Aspect::Time | Aspect::AtRest if timing.samples == 0 => None,
        Aspect::Data => {
            let rejected = rejected_lines(&result.link);
            let dropped = match timing.missing {
                None => "missing ones undetectable (no times)".to_owned(),
                Some(missing) => {
                    format!("{} dropped samples, {}", grouped(missing), counted(timing.segments, "segment"))
                }
            };
            Some(format!("{rejected} rejected lines; {dropped}"))
        }
        Aspect::Time => match (timing.measured_hz, timing.rate_from) {
            (Some(hz), _) => {
                let off = timing.offset_ppm.map_or_else(String::new, |off| format!(", {} from nominal", ppm(off)));
                Some(format!("{hz:.4} Hz measured{off}"))
            }
            (None, Some(from @ RateFrom::DeviceTime)) => {
                Some(format!("{} Hz, {} in each packet", short(timing.rate_hz?), word_of("rate_from", from)))
            }
            _ => None,
        },
        Aspect::AtRest => may_be_moved(result).then(|| "no motion, vibration, step or warm-up found".into()),
        Aspect::Message => {
            let has_rates = result.streamed().any(|channel| channel.quantity == Quantity::AngularRate);
            let message = result.source.message.as_ref().filter(|_| result.source.compensated == Some(false))?;
            has_rates.then(|| format!("{message} carries the rates of the sensor, uncompensated"))
        }
        Aspect::Values => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_times_is_said_once() {
        for (column, said) in [("time [ns]:ns", "time, ns"), ("t:s", "t, s"), ("stamp", "stamp")] {
            assert_eq!(named_unit(column), said);
        }
    }
}

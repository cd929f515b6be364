//! How far the record can be trusted: one line for each aspect, with what was found.

use vn100_analysis::protocol::Quantity;
use vn100_analysis::protocol::stream::BagReport;
use vn100_analysis::timebase::TimebaseSummary;
use vn100_analysis::{Assessment, MissingFrom, RateFrom, Severity, Snapshot, SourceFacts, Warning, WarningKind};

use super::{AspectStatus, Notes};
use crate::warnings::headline;
use crate::{
    codes::code_of_rate,
    goals::warm_up,
    measured::Record,
    names::rejected_lines,
    numbers::plain::{counted, grouped, ppm, short},
};

/// What a warning concerns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Aspect {
    /// Whether all samples arrived, and intact.
    Data,
    /// Rate and time stamps.
    Time,
    /// Whether the sensor lay still.
    AtRest,
    /// What the stream carries of the sensor's own noise.
    Message,
    /// What the numbers can resolve.
    Values,
}

impl Aspect {
    const ALL: [Self; 5] = [Self::Data, Self::Time, Self::AtRest, Self::Message, Self::Values];

    const fn of(kind: WarningKind) -> Self {
        use WarningKind as Kind;
        match kind {
            Kind::Incomplete
            | Kind::NoValidLines
            | Kind::OtherMessages
            | Kind::LinkErrors
            | Kind::StreamChanged
            | Kind::Gaps
            | Kind::RejectedLines
            | Kind::RepeatedLines
            | Kind::TooShort => Self::Data,
            Kind::RateAssumed | Kind::RateOffNominal | Kind::StampsDoubtful => Self::Time,
            Kind::VibrationLine
            | Kind::NotStationary
            | Kind::WarmUp
            | Kind::FollowsTemperature
            | Kind::MagnitudeOff => Self::AtRest,
            Kind::CompensatedStream | Kind::CompensationUnknown | Kind::LowPass | Kind::SensorSettings => Self::Message,
            Kind::QuantisationFloor | Kind::CorrelatedNoise | Kind::FullRange | Kind::UnitDoubtful => Self::Values,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Data => "data",
            Self::Time => "time",
            Self::AtRest => "at rest",
            Self::Message => "message",
            Self::Values => "values",
        }
    }
}

/// How an aspect of the record stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StatusWord {
    Moved,
    Problem,
    Check,
    Limited,
    Untested,
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

    /// In capitals where the numbers are not to be used as they stand.
    pub(crate) const fn word(self) -> &'static str {
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

/// In the order of a measurement; aspects without anything to say are omitted.
pub(super) fn statuses(record: &Record<'_>, notes: &mut Notes) -> Vec<AspectStatus> {
    let measured = record.measured;
    let warnings = measured.warnings();
    let mut statuses = Vec::new();
    for aspect in Aspect::ALL {
        // what is no more than a note stands beside graver ones in full results alone
        let found: Vec<&Warning> =
            warnings.iter().copied().filter(|warning| Aspect::of(warning.kind) == aspect).collect();
        let severity = found.iter().map(|warning| warning.severity).min();
        let is_shown = |warning: &&&Warning| {
            aspect == Aspect::Message || warning.kind == WarningKind::Incomplete || warning.severity < Severity::Note
        };
        let mut findings: Vec<(String, Vec<usize>)> =
            (found.iter().filter(is_shown)).map(|warning| (headline(warning), actions(warning, notes))).collect();
        if aspect == Aspect::Data {
            findings.splice(0..0, source(&measured.facts).map(|text| (text, Vec::new())));
        }
        let is_moved = measured.assessment.motion.is_some() && aspect == Aspect::AtRest;
        let severity = severity.filter(|severity| *severity < Severity::Note || aspect == Aspect::Message);
        let untested = untested(aspect, &measured.snapshot, &measured.assessment).filter(|_| severity.is_none());
        let (severity, word) = match untested {
            Some(_) => (Some(Severity::Note), StatusWord::Untested),
            None => (severity, StatusWord::of(severity, is_moved)),
        };
        let undisturbed = || undisturbed(aspect, &measured.snapshot).filter(|_| severity.is_none());
        findings.extend(untested.or_else(undisturbed).map(|text| (text, Vec::new())));
        if findings.is_empty() {
            continue;
        }
        let word = word.word();
        statuses.push(AspectStatus { aspect: aspect.name(), severity, word, findings });
    }
    statuses
}

/// Which numbers of a bag or a table were taken, and their times.
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
    Some(format!("{} rows, {times}{unused}{left_out}", grouped(csv.rows)))
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

/// Places of the sentences that name what the user can do.
fn actions(warning: &Warning, notes: &mut Notes) -> Vec<usize> {
    let words = warning.remedies.iter().map(notes.words);
    words.map(|action| notes.place(action)).collect()
}

/// In a shorter record no warm-up and no slow motion would be found.
const LEAST_AT_REST_S: f64 = 10.0;

/// Whether a channel would show motion: one of a sensor that has axes.
fn may_be_moved(snapshot: &Snapshot) -> bool {
    snapshot.layout_channels().iter().zip(&snapshot.channels).any(|(channel, results)| {
        let has_axes = !matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure | Quantity::Value);
        has_axes && results.signal.is_some()
    })
}

/// Why an aspect could not be tested; `None` if it was.
fn untested(aspect: Aspect, snapshot: &Snapshot, assessment: &Assessment) -> Option<String> {
    match aspect {
        Aspect::Data => warm_up(snapshot).map(|passed| format!("no sample: warm-up excluded, {passed}")),
        Aspect::AtRest => {
            let is_searched = assessment.channels.iter().any(|channel| channel.disturbed.detectable_step.is_some());
            let is_short = !is_searched || snapshot.timing.duration_s() < LEAST_AT_REST_S;
            (may_be_moved(snapshot) && is_short && snapshot.timing.samples > 0)
                .then(|| "the record is too short to show it".into())
        }
        Aspect::Time | Aspect::Message | Aspect::Values => None,
    }
}

/// What an aspect without a warning says; `None` for nothing.
fn undisturbed(aspect: Aspect, snapshot: &Snapshot) -> Option<String> {
    let timing = &snapshot.timing;
    match aspect {
        Aspect::Data | Aspect::Time | Aspect::AtRest if timing.samples == 0 => None,
        Aspect::Data => {
            let tally = &snapshot.link.tally;
            let rejected = rejected_lines(tally);
            let dropped = match timing.missing_from {
                MissingFrom::RejectedRows => "missing ones undetectable (no times)".to_owned(),
                MissingFrom::DeviceTime | MissingFrom::Counter | MissingFrom::Arrival => {
                    format!("{} dropped samples, {}", grouped(timing.missing), counted(timing.segments, "segment"))
                }
            };
            let outages = match snapshot.outages.times {
                0 => String::new(),
                _ => format!("; link {}", snapshot.outages),
            };
            Some(format!("{rejected} rejected lines; {dropped}{outages}"))
        }
        Aspect::Time => match snapshot.arrivals {
            Some(TimebaseSummary { measured_hz: Some(hz), offset_ppm, .. }) => {
                let off = offset_ppm.map_or_else(String::new, |offset| format!(", {} from nominal", ppm(offset)));
                Some(format!("{hz:.4} Hz measured{off}"))
            }
            _ if timing.rate_from == RateFrom::DeviceTime => {
                Some(format!("{} Hz, {} in each packet", short(timing.rate_hz), code_of_rate(timing.rate_from).word))
            }
            _ => None,
        },
        Aspect::AtRest => may_be_moved(snapshot).then(|| "no motion, vibration, step or warm-up found".into()),
        Aspect::Message => {
            let layout = snapshot.layout.as_ref().filter(|layout| layout.compensated == Some(false))?;
            let has_rates = layout.channels.iter().any(|channel| channel.quantity == Quantity::AngularRate);
            has_rates.then(|| format!("{} carries the rates of the sensor, uncompensated", layout.message))
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

//! Why a result is not whole, and what can be done, in the terms of the command line: the one
//! module of a library that names options and commands. The program says these words in text, in the
//! live view and in documents; the exceptions of the Python package have them too, since its options
//! have the same names.

use std::time::Duration;

use vn100_analysis::{End, RateChange, Remedy, Setting, Shortfall, StartCure};

use crate::numbers::plain::{tau, time};

/// The text, with the source it is about before it where it does not name that itself.
#[must_use]
pub fn about(name: &str, text: &str) -> String {
    let mut words = text.split_whitespace().map(|word| word.trim_end_matches([':', ';', ',']));
    if words.any(|word| word == name) { text.to_owned() } else { format!("{name}: {text}") }
}

/// Why the result of that source is not complete, after so many bytes of sentences and packets;
/// `None` if it is.
#[must_use]
pub fn end(name: &str, end: &End, framed_bytes: u64) -> Option<String> {
    const LOST: &str =
        ", as after a restart that lost settings that were not saved; the result holds what came before. ";
    match end {
        End::NotStarted { text, names_source, cure, .. } => Some(not_started(name, text, *names_source, cure.as_ref())),
        End::SourceFailed(error) => Some(match framed_bytes {
            // no sensor was found: nothing was cut short
            0 => about(name, error),
            bytes => format!("{name}: reading failed after {bytes} bytes, the result holds what came before: {error}"),
        }),
        End::OtherMessages { message, other, rate_hz, after } => {
            let instead = other.map_or("binary packets".into(), |other| format!("other messages, such as {other}"));
            let rate = rate_hz.map_or(String::new(), |hz| format!(" --set-rate {hz}"));
            let seconds = after.as_secs();
            Some(format!(
                "{name}: no {message} has arrived for {seconds} s but {instead}{LOST}`vn100 configure {name} --set-message {message}{rate}` \
                 restores it; --save keeps it"
            ))
        }
        End::OtherRate(RateChange { from_hz, to_hz, .. }) => Some(format!(
            "{name}: lines come at {to_hz} Hz, no longer at {from_hz}{LOST}`vn100 configure {name} --set-rate {from_hz}` restores it; --save \
             keeps it"
        )),
        End::SourceEnded
        | End::DurationReached
        | End::GoalsDecided
        | End::Stopped
        | End::NoMeasurement
        | End::GaveUp { .. }
        | End::WallTime(_) => None,
    }
}

/// How much shorter a result is than was asked for, and what was wrong with the link; `None` where
/// it is not.
#[must_use]
pub fn ended_early(
    end: &End,
    shortfall: Option<&Shortfall>,
    has_unmet: bool,
    duration_s: f64,
) -> Option<(String, String)> {
    let when = match shortfall {
        Some(shortfall) => shortfall_words(shortfall),
        None => format!("after {} of data", seconds(Duration::from_secs_f64(duration_s))),
    };
    let why = match end {
        // nothing of it was measured
        End::NotStarted { .. } => return None,
        End::GaveUp { after, .. } => format!("no sample came for {}", seconds(*after)),
        // what is unmet is said by itself
        End::WallTime(_) if shortfall.is_none() && has_unmet => return None,
        End::WallTime(wall) => format!("the wall time of {} is over", seconds(*wall)),
        _ if shortfall.is_none() => return None,
        End::Stopped => "it was stopped".into(),
        End::SourceEnded => "the data ended".into(),
        _ => "the measurement ended".into(),
    };
    let details = match end {
        End::GaveUp { cause: Some(cause), .. } => format!("The link is down: {cause}"),
        _ => String::new(),
    };
    Some((format!("{why} {when}"), details))
}

/// When the data ended; the difference itself where both times would read the same.
fn shortfall_words(&Shortfall { wanted, measured }: &Shortfall) -> String {
    let (data, goal) = (seconds(measured), seconds(wanted));
    match wanted.saturating_sub(measured) {
        _ if data != goal => format!("after {data} of data of the {goal} asked for"),
        missing if missing < Duration::from_millis(1) => format!("just before the {goal} asked for"),
        missing if missing < Duration::from_secs(1) => {
            format!("{} ms before the {goal} asked for", missing.as_millis())
        }
        missing => format!("{} before the {goal} asked for", seconds(missing)),
    }
}

/// To a tenth of a second if that is worth reading.
fn seconds(duration: Duration) -> String {
    match duration.as_secs_f64() {
        whole @ 60.0.. => time(whole),
        part => format!("{} s", tau((part * 10.0).round() / 10.0)),
    }
}

fn not_started(name: &str, text: &str, names_source: bool, cure: Option<&StartCure>) -> String {
    let text = format!("{text}{}", cure.map_or_else(String::new, cure_words));
    if names_source { text } else { about(name, &text) }
}

/// The option that would make the source readable; on a line of its own after a list of topics.
fn cure_words(cure: &StartCure) -> String {
    match cure {
        StartCure::Columns(Some(map)) => format!(
            "; by names and magnitudes this fits: {} (vn100 replay --help lists channels, units and forms of time)",
            map_option(map)
        ),
        StartCure::Columns(None) => {
            "; name them and their units with --columns, as in gyro_x=NAME:rad/s,accel_x=NAME:m/s^2,t=NAME:s, with a name or a \
             number from 1 for each column (vn100 replay --help lists channels, units and forms of time)"
                .into()
        }
        StartCure::DateOrder(map) => format!("; name the order, as in {} (or mdy)", map_option(map)),
        StartCure::StampUnit(map) => format!("; name the unit, as in {} (or s, us, ns)", map_option(map)),
        StartCure::Topic => "\nName one of them with --topic".into(),
        StartCure::TopicAndColumns => {
            "\nIf one of them has the numbers of a sensor, name it with --topic, and the numbers with --columns".into()
        }
        StartCure::ColumnsOfTopic => {
            "; if some are those of a sensor, name them with --columns, as in gyro_x=PATH:rad/s,accel_x=PATH:m/s^2"
                .into()
        }
        StartCure::Rate { has_times } => {
            let times = if *has_times { "a better one" } else { "one" };
            format!(
                "; give it with --rate HZ, or name the column of its times, where it has {times}, as in --columns t=NAME:s"
            )
        }
    }
}

/// The option with a map of columns, as a shell takes it. A line of text may end after a comma.
fn map_option(map: &str) -> String {
    let quoted = map.replace('\'', "'\\''").replace(',', ", ");
    format!("--columns '{quoted}'")
}

/// The option or the command.
#[must_use]
pub fn remedy_words(remedy: &Remedy) -> String {
    let setting = |setting: &Setting| match setting {
        Setting::Message(header) => format!("PORT --set-message {header}"),
        Setting::Window(refreshes) => format!("PORT --window {refreshes}"),
    };
    match remedy {
        Remedy::GiveRate(None) => "--rate".into(),
        Remedy::GiveRate(Some(hz)) => format!("--rate {hz:.4}"),
        Remedy::Skip(None) => "--skip".into(),
        Remedy::Skip(Some(minutes)) => format!("--skip {minutes}min"),
        Remedy::EndEarlier => "--duration".into(),
        Remedy::AcceptUnchecked => "--accept-unchecked".into(),
        Remedy::MapColumns(None) => "--columns".into(),
        Remedy::MapColumns(Some(map)) => map_option(map),
        Remedy::SayCompensated => "--compensated".into(),
        Remedy::GiveDatasheet => "--datasheet".into(),
        Remedy::GiveWindow => "--window".into(),
        Remedy::MeasurePackets => "--measure packets".into(),
        Remedy::TypicalIsLimit => "--typical-is-limit".into(),
        Remedy::Configure(what) => format!("vn100 configure {}", setting(what)),
        Remedy::MeasureWith(what) => format!("vn100 attach {}", setting(what)),
        Remedy::MeasureLive => "`vn100 attach`".into(),
        Remedy::ReadTemperature => "vn100 attach --temperature".into(),
        Remedy::Record => "vn100 attach PORT --record FILE.mcap --temperature --meta CONDITIONS.toml".into(),
        Remedy::Plan => "vn100 plan".into(),
        Remedy::ExportKalibr => "--export kalibr".into(),
        Remedy::SayStayedOn => "`vn100 compare --stayed-on`".into(),
        // one that is new there has no option here yet
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_named_once() {
        let named = "cannot open /dev/ttyUSB0: there is no such port";
        assert_eq!(about("/dev/ttyUSB0", named), named);
        assert_eq!(about("/dev/ttyUSB", named), format!("/dev/ttyUSB: {named}"));
        assert_eq!(about("-", "no bytes came"), "-: no bytes came");
    }

    #[test]
    fn a_shortfall_is_never_of_nothing() {
        let words = |wanted, measured| {
            shortfall_words(&Shortfall {
                wanted: Duration::from_millis(wanted),
                measured: Duration::from_millis(measured),
            })
        };
        assert_eq!(words(12_000, 8000), "after 8 s of data of the 12 s asked for");
        assert_eq!(words(12_000, 11_975), "25 ms before the 12 s asked for");
        let nearly = Shortfall { wanted: Duration::from_secs(1), measured: Duration::from_micros(999_900) };
        assert_eq!(shortfall_words(&nearly), "just before the 1 s asked for");
        assert_eq!(words(7_200_000, 7_198_500), "after 1 h 59 min of data of the 2 h asked for");
        assert_eq!(words(7_230_000, 7_205_000), "25 s before the 2 h asked for");
    }
}

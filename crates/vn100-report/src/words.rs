//! Why a result is not whole.

use std::time::Duration;

use vn100_analysis::{End, RateChange, Remedy, RemedyWords, Shortfall, StartCure, protocol::stream::OpenHint};

use crate::numbers::plain::{tau, time};

/// The text, with the source it is about before it unless it names that itself.
pub fn about(name: &str, text: &str) -> String {
    let mut words = text.split_whitespace().map(|word| word.trim_end_matches([':', ';', ',']));
    if words.any(|word| word == name) { text.to_owned() } else { format!("{name}: {text}") }
}

/// Why the result of that source is not complete, after so many bytes; `None` if it is.
pub fn end(name: &str, end: &End, framed_bytes: u64, words: RemedyWords) -> Option<String> {
    const LOST: &str =
        ", as after a restart that lost settings that were not saved; the result holds what came before. ";
    match end {
        End::NotStarted { text, names_source, cure, .. } => {
            let text = format!("{text}{}", cure.as_ref().map_or_else(String::new, |cure| cure_words(cure, words)));
            Some(if *names_source { text } else { about(name, &text) })
        }
        End::SourceFailed(error) => Some(match framed_bytes {
            // no sensor was found: nothing was cut short
            0 => about(name, error),
            bytes => format!("{name}: reading failed after {bytes} bytes, the result holds what came before: {error}"),
        }),
        End::OtherMessages { message, other, rate_hz, after } => {
            let instead = other.map_or("binary packets".into(), |other| format!("other messages, such as {other}"));
            let restore = Remedy::Restore { port: name.into(), message: Some(message.clone()), rate_hz: *rate_hz };
            let (seconds, cure) = (after.as_secs(), words(&restore));
            Some(format!("{name}: no {message} has arrived for {seconds} s but {instead}{LOST}To continue, {cure}"))
        }
        End::OtherRate(RateChange { from_hz, to_hz, .. }) => {
            let cure = words(&Remedy::Restore { port: name.into(), message: None, rate_hz: Some(*from_hz) });
            Some(format!("{name}: lines come at {to_hz} Hz, no longer at {from_hz}{LOST}To continue, {cure}"))
        }
        End::SourceEnded
        | End::DurationReached
        | End::GoalsDecided
        | End::Stopped
        | End::NoMeasurement
        | End::GaveUp { .. }
        | End::WallTime(_) => None,
    }
}

/// How much shorter a result is than was asked for, and why; `None` if it is not.
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

/// When the data ended; the difference itself if both times would read the same.
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

/// What would make the source readable; on a line of its own after a list of topics.
fn cure_words(cure: &StartCure, words: RemedyWords) -> String {
    use StartCure::Capture;
    let columns = || words(&Remedy::MapColumns(None));
    let as_mapped = |map: &String| words(&Remedy::MapColumns(Some(map.clone())));
    let topic = || words(&Remedy::GiveTopic);
    match cure {
        Capture(OpenHint::Columns(Some(map))) => format!("; by names and magnitudes this fits: {}", as_mapped(map)),
        Capture(OpenHint::Columns(None) | OpenHint::ColumnsOfTopic) => {
            format!("; if some are those of a sensor, {}", columns())
        }
        Capture(OpenHint::DateOrder(map)) => format!("; name the order (dmy or mdy): {}", as_mapped(map)),
        Capture(OpenHint::StampUnit(map)) => format!("; name the unit (s, ms, us or ns): {}", as_mapped(map)),
        Capture(OpenHint::Topic(_)) => format!("\nOne of them is to be chosen: {}", topic()),
        Capture(OpenHint::TopicAndColumns(_)) => {
            format!("\nIf one of them has the numbers of a sensor, {}, and {}", topic(), columns())
        }
        StartCure::OneSource => {
            let rate = words(&Remedy::GiveRate(None));
            format!("; of two sources, read a file with the rows of one; of a buffer of two, {rate}")
        }
        StartCure::Rate { has_times } => {
            let times = if *has_times { "better times" } else { "the times" };
            let of_times = words(&Remedy::MapColumns(Some("t=NAME:s".into())));
            format!("; {}; if a column has {times}, {of_times}", words(&Remedy::GiveRate(None)))
        }
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

//! Rate, counts and losses of a source as rows with a name and a value, for pages and terminals.

use vn100_analysis::{MissingFrom, SourceResult};

use crate::{
    codes::word_of,
    names::{missing_text, outages, pending_text, rejected_lines},
    numbers::{
        plain::{counted, grouped, ppm, short, time},
        trimmed,
    },
};

/// The text for what is absent.
pub const NOT_RECORDED: &str = "not recorded";

/// A name and a value; [`NOT_RECORDED`] for one that is absent.
pub type Row = (String, String);

pub(crate) fn fact(name: &str, value: impl Into<String>) -> Row {
    (name.to_owned(), value.into())
}

pub(crate) fn or_not_recorded(name: &str, value: Option<String>) -> Row {
    fact(name, value.filter(|value| !value.trim().is_empty()).unwrap_or_else(|| NOT_RECORDED.into()))
}

/// Rate, counts and losses.
pub fn timing(result: &SourceResult) -> Vec<Row> {
    let SourceResult { timing, link, .. } = result;
    let from = timing.rate_from.map_or_else(|| "unknown".into(), |from| word_of("rate_from", from));
    let by = match timing.missing_from {
        MissingFrom::RejectedRows => "rejected lines; entirely missing lines cannot be detected".into(),
        by => word_of("missing_from", by),
    };
    let measured = timing.measured_hz.map(|hz| {
        let off = |offset| format!(", {} from nominal", ppm(offset));
        format!("{hz:.4} Hz{}", timing.offset_ppm.map_or_else(String::new, off))
    });
    let steps = timing.arrivals.map(|times| {
        let [median, most, longest] = [times.p50_us, times.p99_us, times.max_us].map(grouped);
        format!("{median} µs median, {most} µs 99th percentile, {longest} µs longest")
    });
    let excluded = match (timing.excluded, timing.skipped_s) {
        (0, _) => "nothing".into(),
        (count, skipped_s) if skipped_s > 0.0 => format!(
            "{} samples: the first {} as requested, or after the requested end",
            grouped(count),
            time(skipped_s)
        ),
        (count, _) => format!("{} samples after the requested end, or after a change of rate", grouped(count)),
    };
    let length =
        if timing.duration_s < 60.0 { format!("{} s", short(timing.duration_s)) } else { time(timing.duration_s) };
    let (gaps, pending) = (counted(timing.gaps, "gap"), pending_text(timing));
    let dropped = format!("{} in {gaps}, by {by}{pending}", missing_text(timing));
    let (replies, others) = (link.replies, link.other_messages);
    let echoes = if link.echoes == 0 { String::new() } else { format!("{} echoed questions, ", link.echoes) };
    let sentences = format!("{} ({replies} replies, {echoes}{others} other messages)", grouped(link.frames));
    let bytes = format!(
        "{} ({} discarded, {} lost before this program)",
        grouped(link.bytes),
        grouped(link.skipped_bytes),
        grouped(link.overrun_bytes)
    );
    let rate = timing.rate_hz.map(|hz| format!("{} Hz, {from}", trimmed(hz, 6)));
    let mut rows = vec![
        fact("Samples", format!("{} in {length}", grouped(timing.samples))),
        or_not_recorded("Sample rate", rate),
        or_not_recorded("Measured rate", measured),
        or_not_recorded("Interarrival times", steps),
        fact("Dropped samples", dropped),
        fact("Segments", timing.segments.to_string()),
        fact("Excluded", excluded),
        fact("Rejected lines", rejected_lines(link)),
        fact("Damaged packets", grouped(link.damaged_packets)),
        fact("Packets", grouped(link.binary_packets)),
        match result.source.csv {
            Some(_) => fact("Valid rows", grouped(link.frames)),
            None => fact("Valid sentences", sentences),
        },
        fact("Bytes", bytes),
        fact("Reconnections", link.reconnects.to_string()),
    ];
    rows.extend(outages(link).map(|outages| fact("Link", outages)));
    rows
}

//! A result as text for people: a summary, or the head of a recording.

mod populations;
mod summary;

use std::fmt::{self, Write};

use imu_noise::{Sensor, Term};
use vn100_analysis::timebase::{Arrivals, TimebaseSummary};
use vn100_analysis::{Snapshot, SourceFacts};
use vn100_protocol::stream::{AbsentValues, BagReport, CsvReport};
use vn100_report::{
    Measured, RecordingDocument, code_of_missing, code_of_rate,
    names::{ParameterNames, damaged_packets, echoes, parameter_names, rejected_lines},
    numbers::plain::{counted, ppm, short},
    printable,
};

pub(crate) use populations::write_populations;
pub(crate) use summary::summary;
use vn100_report::{remedies::remedy_words, warnings::in_words};

/// Columns a line may take; what every terminal has.
pub(crate) const WIDTH: usize = 80;

/// What `write` puts into a text.
pub(crate) fn text(write: impl FnOnce(&mut String) -> fmt::Result) -> String {
    let mut out = String::new();
    // a String takes everything
    let _ = write(&mut out);
    out
}

pub(crate) fn fill(text: &str, first_indent: &str, indent: &str) -> String {
    let options = textwrap::Options::new(WIDTH).initial_indent(first_indent).subsequent_indent(indent);
    // an exponent stays with its number
    textwrap::fill(text, options.word_splitter(textwrap::WordSplitter::NoHyphenation))
}

/// Name, short name and symbol: `Angle Random Walk (ARW) N`.
pub(crate) fn parameter_name(sensor: Sensor, term: Term) -> String {
    let ParameterNames { name, short, symbol, .. } = parameter_names(sensor, term);
    let short = if short.is_empty() { String::new() } else { format!(" ({short})") };
    format!("{name}{short} {symbol}")
}

/// The source, and its warnings. Ends with a line feed.
pub(crate) fn head(measured: &Measured) -> String {
    text(|out| {
        write_source(out, measured)?;
        write_warnings(out, measured)
    })
}

fn write_source(out: &mut String, measured: &Measured) -> fmt::Result {
    let Measured { facts, snapshot, .. } = measured;
    write_head(out, facts, snapshot)?;
    if let Some(csv) = &facts.csv {
        write_csv(out, csv)?;
    }
    if let Some(bag) = &facts.bag {
        write_bag(out, bag)?;
    }
    if let Some(recording) = &facts.recording {
        let text = format!("  recorded   {}", printable(&RecordingDocument::new(recording).text()));
        write_wrapped(out, &text)?;
    }
    Ok(())
}

fn write_warnings(out: &mut String, measured: &Measured) -> fmt::Result {
    let warnings = measured.warnings();
    for warning in &warnings {
        let text =
            format!("{} ({}): {}", warning.kind.name(), warning.severity.name(), in_words(warning, remedy_words));
        writeln!(out, "{}", fill(&text, "! ", "  "))?;
    }
    match warnings.first() {
        Some(first) => writeln!(out, "  (`vn100 explain {}` explains a kind of warning)", first.kind.name()),
        None => Ok(()),
    }
}

fn write_head(out: &mut String, facts: &SourceFacts, snapshot: &Snapshot) -> fmt::Result {
    let timing = &snapshot.timing;
    let message = snapshot.layout.as_ref().map_or("no message", |layout| &layout.message);
    let rate_from = code_of_rate(timing.rate_from).word;
    let evidence = code_of_missing(timing.missing_from).word;
    writeln!(
        out,
        "{}: {} of {message} in {} s at {} Hz ({rate_from})",
        printable(&facts.name),
        counted(timing.samples, "sample"),
        short(timing.duration_s()),
        short(timing.rate_hz)
    )?;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let rejected = format!("  rejected   {}{}", rejected_lines(tally), damaged_packets(tally));
    write_wrapped(out, &rejected)?;
    writeln!(
        out,
        "  dropped    {} in {}, by {evidence}; {}",
        counted(timing.missing, "sample"),
        counted(timing.gaps, "gap"),
        counted(timing.segments, "segment")
    )?;
    if snapshot.outages.times > 0 {
        writeln!(out, "  link       {}: samples of that time are not counted as dropped", snapshot.outages)?;
    }
    if let Some(TimebaseSummary { measured_hz: Some(hz), offset_ppm, .. }) = snapshot.arrivals {
        let off = offset_ppm.map_or_else(String::new, |offset| format!(", {} from nominal", ppm(offset)));
        writeln!(out, "  rate       {hz:.4} Hz measured{off}")?;
    }
    if let Some(Arrivals { p50_us, p99_us, max_us, .. }) = snapshot.arrivals.and_then(|arrivals| arrivals.arrivals) {
        writeln!(out, "  intervals  {p50_us} us median, {p99_us} us 99th percentile, {max_us} us longest")?;
    }
    writeln!(
        out,
        "  valid      {} sentences ({} replies, {}{} other messages, {} excluded)",
        tally.valid_sentences(),
        link.answers(),
        echoes(link.echoes),
        link.other_messages(),
        timing.excluded
    )?;
    writeln!(
        out,
        "  bytes      {} ({} discarded, {} binary packets)",
        link.bytes(),
        link.skipped_bytes(),
        tally.packets
    )
}

/// A row of the head, which may be longer than a line.
fn write_wrapped(out: &mut String, text: &str) -> fmt::Result {
    writeln!(out, "{}", textwrap::fill(text, textwrap::Options::new(WIDTH).subsequent_indent("             ")))
}

fn write_bag(out: &mut String, bag: &BagReport) -> fmt::Result {
    let line = |out: &mut String, name: &str, text: &str| {
        writeln!(out, "{}", fill(text, &format!("  {name:<11}"), "             "))
    };
    let BagReport { topic, type_name, messages, used, .. } = bag;
    line(out, "topic", &printable(&format!("{topic} ({type_name}): {messages} messages, {used} used")))?;
    line(out, "stamps", &printable(&bag.stamps.to_string()))?;
    let counts = [
        (bag.without_sample, "without a sentence or a number in range"),
        (bag.unreadable, "cut or malformed"),
        (bag.reordered, "out of order, reordered"),
        (bag.late, "out of order, too late to reorder"),
    ];
    for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
        line(out, "", &format!("{count} {what}"))?;
    }
    write_absent(out, &bag.absent, ("messages", "message"))?;
    for unread in &bag.unread {
        line(out, "not read", &printable(&unread.to_string()))?;
    }
    if bag.unpacked_bytes > 0 {
        line(out, "unpacked", &format!("{} bytes, in a temporary file", bag.unpacked_bytes))?;
    }
    Ok(())
}

fn write_csv(out: &mut String, csv: &CsvReport) -> fmt::Result {
    writeln!(out, "  CSV lines  {} ({} rows, {} header, comment or blank)", csv.lines, csv.rows, csv.skipped_lines)?;
    for rejected in &csv.rejected {
        let text = format!(
            "  rejected   {} ({}), the first is line {}: {}",
            rejected.count, rejected.reason, rejected.first_line, rejected.first_text
        );
        write_wrapped(out, &text)?;
    }
    if let Some(rows) = csv.other_stream_rows {
        writeln!(out, "  other rows {rows}, of other streams")?;
    }
    if let Some(times) = &csv.times {
        write_wrapped(out, &format!("  times from  {times}"))?;
    }
    for (name, columns) in [("unused     ", &csv.ignored_columns), ("rounded    ", &csv.rounded)] {
        if !columns.is_empty() {
            let text = format!("  {name}columns {}", columns.join(", "));
            write_wrapped(out, &text)?;
        }
    }
    for column in &csv.left_out {
        write_wrapped(out, &format!("  left out    {}: {}", column.name, column.reason))?;
    }
    write_absent(out, &csv.absent, ("rows", "line"))
}

/// How often channels are absent in the rows or messages that are used.
fn write_absent(out: &mut String, all: &[AbsentValues], (of, numbered): (&str, &str)) -> fmt::Result {
    for absent in all {
        let AbsentValues { channel, empty, not_a_number, out_of_range, first_line } = absent;
        let reasons = [(empty, "empty"), (not_a_number, "not a number"), (out_of_range, "out of range")];
        let reasons: Vec<_> = reasons
            .iter()
            .filter(|(count, _)| **count > 0)
            .map(|(count, reason)| format!("{count} {reason}"))
            .collect();
        let text = format!(
            "  absent     {channel} in {} {of} ({}), the first is {numbered} {first_line}",
            absent.total(),
            reasons.join(", ")
        );
        write_wrapped(out, &text)?;
    }
    Ok(())
}

//! A capture's result as text for people: what is wrong first, then the statistics, then the
//! deviations.

pub(crate) mod comparison;
mod deviations;
mod distribution;
mod filter_models;
mod layout;
mod noise;
mod plan;
mod statistics;
mod verdict;

use std::fmt::{self, Write};

use imu_noise::{Arrivals, TimebaseSummary};
use vn100_analysis::{
    Assessment, Comparison, CsvFacts, Datasheet, Given, MissingFrom, Plan, RateFrom, Snapshot, SourceFacts,
};

use crate::remedy_words::remedy_words;
use deviations::write_deviations;
use distribution::{write_distribution, write_parts};
use filter_models::write_filter_models;
use layout::{WIDTH, fill};
use noise::write_noise;
use statistics::write_statistics;
use verdict::write_verdicts;
use vn100_report::{
    Measured, RecordingDocument,
    names::{echoes, rejected_lines},
    numbers::plain::{counted, ppm, short},
    printable,
    units::channel_values,
};
/// The whole result. Ends with a line feed.
pub(crate) fn result(measured: &Measured) -> String {
    let mut out = String::new();
    // a String takes everything
    let _ = write_result(&mut out, measured);
    out
}

/// What came and what may be wrong with it, without statistics and deviations. Ends with a line
/// feed.
pub(crate) fn summary(facts: &SourceFacts, snapshot: &Snapshot, assessment: &Assessment) -> String {
    let mut out = String::new();
    let _ = write_summary(&mut out, facts, snapshot, assessment);
    out
}

/// Several captures side by side. Ends with a line feed.
pub(crate) fn comparison(all: &[Measured], comparison: &Comparison) -> String {
    let mut out = String::new();
    let _ = comparison::write(&mut out, all, comparison);
    out
}

/// How to measure. Ends with a line feed.
pub(crate) fn plan(plan: &Plan, given: Given, datasheet: &Datasheet, asked: bool) -> String {
    let mut out = String::new();
    let _ = plan::write(&mut out, plan, given, datasheet, asked);
    out
}

fn write_result(out: &mut String, measured: &Measured) -> fmt::Result {
    let Measured { facts, snapshot, assessment, filter_models, verdicts, .. } = measured;
    write_summary(out, facts, snapshot, assessment)?;
    let channels = channel_values(snapshot, assessment);
    if !channels.is_empty() {
        write_statistics(out, snapshot, &channels)?;
        write_distribution(out, &channels)?;
        write_parts(out, &channels, snapshot.skipped.as_secs_f64())?;
        write_deviations(out, snapshot, &channels, assessment.confidence)?;
        write_noise(out, &channels, assessment, snapshot.deviation)?;
        write_filter_models(out, &channels, filter_models)?;
        write_verdicts(out, &channels, verdicts.as_ref(), assessment.motion.as_ref())?;
    }
    writeln!(out)
}

fn write_summary(out: &mut String, facts: &SourceFacts, snapshot: &Snapshot, assessment: &Assessment) -> fmt::Result {
    write_head(out, facts, snapshot)?;
    if let Some(csv) = &facts.csv {
        write_csv(out, csv)?;
    }
    if let Some(recording) = &facts.recording {
        let text = format!("  recorded   {}", printable(&RecordingDocument::new(recording).text()));
        write_wrapped(out, &text)?;
    }
    for warning in snapshot.warnings.iter().chain(&assessment.warnings) {
        writeln!(out, "{}", fill(&warning.in_words(remedy_words), "! ", "  "))?;
    }
    Ok(())
}

fn write_head(out: &mut String, facts: &SourceFacts, snapshot: &Snapshot) -> fmt::Result {
    let timing = &snapshot.timing;
    let message = snapshot.layout.as_ref().map_or("no message", |layout| &layout.message);
    let rate_from = match timing.rate_from {
        RateFrom::Option => "as asked",
        RateFrom::Device => "as the sensor says",
        RateFrom::Arrival => "by the arrival of its lines",
        RateFrom::Assumed => "assumed",
    };
    let judged = match snapshot.timing.missing_from {
        MissingFrom::Counter => "the counter in each line",
        MissingFrom::Arrival => "arrival times",
        MissingFrom::RejectedRows => "bad lines",
    };
    writeln!(
        out,
        "{}: {} of {message} in {} s at {} Hz ({rate_from})",
        printable(&facts.name),
        counted(timing.samples, "sample"),
        short(timing.duration_s()),
        short(timing.rate_hz)
    )?;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let bad = format!("  bad lines  {}", rejected_lines(tally));
    write_wrapped(out, &bad)?;
    writeln!(
        out,
        "  missing    {} in {}, judged by {judged}; {}",
        counted(timing.missing, "sample"),
        counted(timing.gaps, "gap"),
        counted(timing.segments, "segment")
    )?;
    if snapshot.outages.times > 0 {
        writeln!(out, "  link       {}: what was sent then is not among the missing", snapshot.outages)?;
    }
    if let Some(TimebaseSummary { measured_hz: Some(hz), offset_ppm: Some(offset_ppm), .. }) = snapshot.arrivals {
        writeln!(out, "  rate       {hz:.4} Hz measured, {} from nominal", ppm(offset_ppm))?;
    }
    if let Some(Arrivals { p50_us, p99_us, max_us, .. }) = snapshot.arrivals.and_then(|arrivals| arrivals.arrivals) {
        writeln!(out, "  intervals  {p50_us} us median, {p99_us} us 99th percentile, {max_us} us longest")?;
    }
    writeln!(
        out,
        "  good lines {} ({} replies, {}{} other messages, {} left out)",
        tally.valid_sentences(),
        link.answers(),
        echoes(link.echoes),
        link.other_messages(),
        timing.excluded
    )?;
    writeln!(out, "  bytes      {} ({} skipped, {} binary packets)", link.bytes(), link.skipped_bytes(), tally.packets)
}

/// A row of the head, which may be longer than a line.
fn write_wrapped(out: &mut String, text: &str) -> fmt::Result {
    writeln!(out, "{}", textwrap::fill(text, textwrap::Options::new(WIDTH).subsequent_indent("             ")))
}

fn write_csv(out: &mut String, csv: &CsvFacts) -> fmt::Result {
    writeln!(out, "  CSV lines  {} ({} rows, {} header, comment or blank)", csv.lines, csv.rows, csv.skipped_lines)?;
    for rejected in &csv.rejected {
        let text = format!(
            "  odd rows   {} ({}), the first is line {}: {}",
            rejected.count, rejected.reason, rejected.first_line, rejected.first_text
        );
        write_wrapped(out, &text)?;
    }
    for (name, columns) in [("unused     ", &csv.ignored_columns), ("rounded    ", &csv.rounded)] {
        if !columns.is_empty() {
            let text = format!("  {name}columns {}", columns.join(", "));
            write_wrapped(out, &text)?;
        }
    }
    Ok(())
}

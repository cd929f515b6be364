//! A capture's result as text for people: what is wrong first, then the statistics, then the deviations.

mod comparison;
mod distribution;
mod filter_models;
mod noise;
mod plan;
mod statistics;
mod verdict;

use std::fmt::{self, Write};

use imu_noise::{Arrivals, Deviation, Estimator, TimebaseSummary};
use vn100_driver::CsvReport;
use vn100_pipeline::{Assessment, Comparison, Datasheet, Given, MissingFrom, Plan, RateFrom, Snapshot};
use vn100_protocol::{Quantity, Tally};

pub(crate) use comparison::folding;
use distribution::{write_distribution, write_parts};
use filter_models::write_filter_models;
pub(crate) use noise::four_digits;
pub(crate) use noise::in_words;
use noise::write_noise;
pub(crate) use statistics::EARTH_RATE_RAD_S;
use statistics::write_statistics;
use verdict::write_verdicts;

use crate::{
    exit::printable,
    measured::Measured,
    recorded::RecordedDocument,
    source_document::Origin,
    units::{ChannelValues, Point, channel_values},
};

/// Columns a line may take; what every terminal has.
const WIDTH: usize = 80;

/// Of the column that names the rows of a table with an axis in each of the others.
const LABEL: usize = 24;

/// Of the column of an axis.
const COLUMN: usize = 17;

/// With fewer degrees of freedom an interval spans more than a factor of ten, and is left to the document.
pub(crate) const LEAST_EDF: f64 = 2.0;

/// The whole result. Ends with a line feed.
pub(crate) fn result(measured: &Measured) -> String {
    let mut out = String::new();
    // a String takes everything
    let _ = write_result(&mut out, measured);
    out
}

/// What came and what may be wrong with it, without statistics and deviations. Ends with a line feed.
pub(crate) fn summary(origin: &Origin, snapshot: &Snapshot, assessment: &Assessment) -> String {
    let mut out = String::new();
    let _ = write_summary(&mut out, origin, snapshot, assessment);
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
    let Measured { origin, snapshot, assessment, filter_models, verdicts, .. } = measured;
    write_summary(out, origin, snapshot, assessment)?;
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

fn write_summary(out: &mut String, origin: &Origin, snapshot: &Snapshot, assessment: &Assessment) -> fmt::Result {
    write_head(out, origin, snapshot)?;
    if let Some(csv) = &origin.csv {
        write_csv(out, csv)?;
    }
    if let Some(recorded) = &origin.recorded {
        let text = format!("  recorded   {}", printable(&RecordedDocument::new(recorded).text()));
        writeln!(out, "{}", textwrap::fill(&text, textwrap::Options::new(WIDTH).subsequent_indent("             ")))?;
    }
    for warning in snapshot.warnings.iter().chain(&assessment.warnings) {
        writeln!(out, "{}", fill(&warning.to_string(), "! ", "  "))?;
    }
    Ok(())
}

fn write_head(out: &mut String, origin: &Origin, snapshot: &Snapshot) -> fmt::Result {
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
        MissingFrom::BadLines => "bad lines",
    };
    writeln!(
        out,
        "{}: {} of {message} in {} s at {} Hz ({rate_from})",
        printable(&origin.name),
        counted(timing.samples, "sample"),
        short(timing.duration_s()),
        short(timing.rate_hz)
    )?;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let bad = format!("  bad lines  {}", bad_lines(tally));
    writeln!(out, "{}", textwrap::fill(&bad, textwrap::Options::new(WIDTH).subsequent_indent("             ")))?;
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
    if let Some(TimebaseSummary { measured_hz: Some(hz), offset_ppm: Some(ppm), .. }) = snapshot.arrivals {
        writeln!(out, "  rate       {hz:.4} Hz measured, {ppm:+.0} ppm from nominal")?;
    }
    if let Some(Arrivals { p50_us, p99_us, max_us, .. }) = snapshot.arrivals.and_then(|arrivals| arrivals.arrivals) {
        writeln!(out, "  intervals  {p50_us} us median, {p99_us} us 99th percentile, {max_us} us longest")?;
    }
    writeln!(
        out,
        "  good lines {} ({} replies, {}{} other messages, {} left out)",
        tally.good_lines(),
        link.answers(),
        echoes(link.echoes),
        link.other_messages(),
        timing.left_out
    )?;
    writeln!(out, "  bytes      {} ({} skipped, {} binary packets)", link.bytes(), link.skipped_bytes(), tally.packets)
}

/// Nothing on a line that does not echo.
pub(crate) fn echoes(count: u64) -> String {
    if count == 0 { String::new() } else { format!("{count} echoed questions, ") }
}

fn write_csv(out: &mut String, csv: &CsvReport) -> fmt::Result {
    writeln!(out, "  CSV lines  {} ({} rows, {} header, comment or blank)", csv.lines, csv.rows, csv.skipped_lines)?;
    for odd in &csv.odd {
        let text = format!(
            "  odd rows   {} ({}), the first is line {}: {}",
            odd.count, odd.reason, odd.first_line, odd.first_text
        );
        writeln!(out, "{}", textwrap::fill(&text, textwrap::Options::new(WIDTH).subsequent_indent("             ")))?;
    }
    for (name, columns) in [("unused     ", &csv.ignored_columns), ("rounded    ", &csv.rounded)] {
        if !columns.is_empty() {
            let text = format!("  {name}columns {}", columns.join(", "));
            writeln!(
                out,
                "{}",
                textwrap::fill(&text, textwrap::Options::new(WIDTH).subsequent_indent("             "))
            )?;
        }
    }
    Ok(())
}

/// How many, and of which kinds.
pub(crate) fn bad_lines(tally: &Tally) -> String {
    let bad = &tally.bad;
    let kinds = [
        ("checksum", bad.checksum),
        ("unchecked", bad.unchecked),
        ("grammar", bad.grammar),
        ("range", bad.range),
        ("truncated", bad.truncated),
        ("too long", bad.too_long),
    ];
    let present: Vec<_> =
        kinds.iter().filter(|(_, count)| *count > 0).map(|(kind, count)| format!("{count} {kind}")).collect();
    if present.is_empty() { "0".into() } else { format!("{} ({})", bad.total(), present.join(", ")) }
}

/// To six digits, without zeros behind: what rates and times need.
fn short(value: f64) -> String {
    let decimals = if value > 0.0 { (5 - value.log10().floor() as i32).clamp(0, 9) as usize } else { 0 };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A paragraph.
fn fill(text: &str, first_indent: &str, indent: &str) -> String {
    let options = textwrap::Options::new(WIDTH).initial_indent(first_indent).subsequent_indent(indent);
    // an exponent stays with its number
    textwrap::fill(text, options.word_splitter(textwrap::WordSplitter::NoHyphenation))
}

/// One table for each sensor, its axes side by side.
fn write_deviations(out: &mut String, snapshot: &Snapshot, channels: &[ChannelValues], confidence: f64) -> fmt::Result {
    let deviation = match snapshot.deviation {
        Deviation::Allan => "Allan deviation",
        Deviation::Hadamard => "Hadamard deviation",
    };
    let windows = match snapshot.estimator {
        Estimator::Strided => "windows at stride tau/16, all overlaps up to m = 16",
        Estimator::Full => "all overlaps",
        Estimator::Plain => "no overlap",
    };
    let detrended = if snapshot.detrended { ", a line removed from each channel" } else { "" };
    writeln!(out, "\n{deviation}, {windows}{detrended}")?;
    let legend = format!(
        "Behind each, how far the truth may lie above and below, in percent, at a confidence of {}. Each holds alone: octaves share samples, \
         and all together hold less often. \"few\": below {LEAST_EDF} degrees of freedom.",
        short(confidence)
    );
    writeln!(out, "{}", fill(&legend, "", ""))?;
    // what was asked for between the lines has no deviation
    let measured: Vec<_> = channels.iter().filter(|channel| !channel.deviations.is_empty()).collect();
    for group in measured.chunk_by(|a, b| a.quantity == b.quantity) {
        write!(out, "\n{}, {}\n{:>8} {:>7} {:>7}", sensor(group[0].quantity), group[0].unit, "tau (s)", "m", "terms")?;
        for channel in group {
            write!(out, " {:>COLUMN$}", channel.name)?;
        }
        writeln!(out)?;
        let octaves = group.iter().map(|channel| channel.deviations.len()).max().unwrap_or(0);
        for octave in 0..octaves {
            let Some(first) = group.iter().find_map(|channel| channel.deviations.get(octave)) else {
                continue;
            };
            write!(out, "{:>8} {:>7} {:>7}", short(first.tau_s), first.m, first.terms)?;
            for channel in group {
                write!(out, " {:>COLUMN$}", channel.deviations.get(octave).map_or("-".into(), with_bounds))?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

fn with_bounds(point: &Point) -> String {
    let Some(deviation) = point.deviation else { return "-".into() };
    let percent = |bound: f64| 100.0 * (bound / deviation - 1.0);
    match (point.edf, point.lower, point.upper) {
        (Some(LEAST_EDF..), Some(lower), Some(upper)) if deviation > 0.0 => {
            let (above, below) = (percent(upper), percent(lower));
            let decimals = usize::from(above < 9.95);
            format!("{deviation:.3e} {:>7}", format!("{above:+.decimals$}{below:+.decimals$}"))
        }
        _ => format!("{deviation:.3e} {:>7}", "few"),
    }
}

pub(crate) fn sensor(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Angle => "orientation",
        Quantity::MagneticField => "magnetic field",
        Quantity::Acceleration => "acceleration",
        Quantity::AngularRate => "angular rate",
        Quantity::Temperature => "temperature",
        Quantity::Pressure => "pressure",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.025, "0.025"),
            (1.0 / 3.0, "0.333333"),
            (60.0, "60"),
            (60.150_375_9, "60.1504"),
            (5e-6, "0.000005"),
            (1e7, "10000000"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}

//! `vn100 compare`: captures side by side. Differences of the setup first, then the ranking,
//! what differs, and how far means lie apart.

use std::fmt::{self, Write};

use anyhow::Result;
use vn100_analysis::{Chance, ChannelMeans, Comparison, DEFAULT_CONFIDENCE, OctaveTest, Ranking};
use vn100_report::{
    ComparisonDocument, Completion, Measured,
    names::{folding, names_of, recommendation, untested},
    numbers::plain::{counted, four_digits, short},
    printable, record_letter,
    units::tests_by_channel,
};

use crate::{
    args::CompareArgs,
    exit::{print, print_json, report},
    inputs::inputs,
    replay::measure_files,
    text::{fill, text},
    user_files::evaluation,
    words::remedy_words,
};

pub(crate) fn compare(args: &CompareArgs) -> Result<Completion> {
    let evaluation = evaluation(&args.files.measure, false)?;
    let mut all: Vec<Measured> = Vec::new();
    measure_files(&args.files, &inputs(&args.files), evaluation, false, |measured| {
        measured.facts.error.iter().chain(&measured.unmet).for_each(|text| report(text));
        all.push(measured);
        Ok(())
    })?;
    let records: Vec<_> = all.iter().map(Measured::compared).collect();
    let confidence = args.files.measure.confidence.unwrap_or(DEFAULT_CONFIDENCE);
    let comparison = Comparison::of(&records, args.stayed_on, confidence);
    if args.json {
        print_json(&ComparisonDocument::new(&all, &comparison, remedy_words))?;
    } else {
        print(&text(|out| write_comparison(out, &all, &comparison)))?;
    }
    Ok(all.iter().map(|measured| measured.completion).max().unwrap_or(Completion::Complete))
}

fn write_comparison(out: &mut String, all: &[Measured], comparison: &Comparison) -> fmt::Result {
    writeln!(
        out,
        "{} compared, at a confidence of {}",
        counted(all.len() as u64, "record"),
        short(comparison.confidence)
    )?;
    for (number, measured) in all.iter().enumerate() {
        let timing = &measured.snapshot.timing;
        let held = match &measured.snapshot.layout {
            Some(layout) => {
                format!("{}, {} s at {} Hz", layout.message, short(timing.duration_s()), short(timing.rate_hz))
            }
            None => "nothing to compare".into(),
        };
        let line = format!("{:<3}{}: {held}", record_letter(number), printable(&measured.facts.name));
        writeln!(out, "{}", fill(&line, "  ", "     "))?;
    }
    for caveat in &comparison.caveats {
        let text = format!("{}: {}", caveat.kind.name(), printable(&caveat.text.in_words(remedy_words)));
        writeln!(out, "{}", fill(&text, "! ", "  "))?;
    }
    writeln!(out, "{}", fill(&recommendation(comparison.recommended), "", "  "))?;
    for ranking in &comparison.rankings {
        write_ranking(out, ranking, comparison)?;
    }
    write_octaves(out, comparison)?;
    write_disturbances(out, comparison)?;
    write_means(out, comparison)
}

fn write_ranking(out: &mut String, ranking: &Ranking, comparison: &Comparison) -> fmt::Result {
    writeln!(
        out,
        "\nwhite noise N of the {}, {}, the quietest first",
        names_of(ranking.quantity).quantity,
        ranking.unit
    )?;
    for ranked in &ranking.records {
        let axes: Vec<String> =
            ranked.axes.iter().map(|(name, white)| format!("{name} {}", four_digits(*white))).collect();
        let (white, lower, upper) = (ranked.white, ranked.lower, ranked.upper);
        let line = format!(
            "{:<3}{} ({} to {}): {}",
            record_letter(ranked.record),
            four_digits(white),
            four_digits(lower),
            four_digits(upper),
            axes.join(", ")
        );
        writeln!(out, "{}", fill(&line, "  ", "     "))?;
    }
    if !ranking.not_ranked.is_empty() {
        let names: Vec<String> = ranking.not_ranked.iter().map(|record| record_letter(*record)).collect();
        let text = format!("not ranked, N is not estimated on every axis: {}", names.join(", "));
        writeln!(out, "{}", fill(&text, "  ", "  "))?;
    }
    if !ranking.folds_alike {
        writeln!(out, "{}", fill(&folding(ranking), "  ", "  "))?;
    }
    if let ([first, second, ..], Some(lead)) = (&ranking.records[..], ranking.lead()) {
        let (percent, a, b) =
            (100.0 * (1.0 - first.white / second.white), record_letter(first.record), record_letter(second.record));
        let text = if comparison.is_significant(lead) {
            format!(
                "{a} is the quietest: its N lies {percent:.1} % below that of {b}, beyond chance ({})",
                chance(lead)
            )
        } else {
            format!(
                "none is the quietest beyond chance: {a} lies {percent:.1} % below {b}, as chance alone makes it ({})",
                chance(lead)
            )
        };
        writeln!(out, "{}", fill(&text, "  ", "  "))?;
    }
    Ok(())
}

fn write_octaves(out: &mut String, comparison: &Comparison) -> fmt::Result {
    let tests = comparison.octaves.len();
    writeln!(out, "\ndeviations that differ beyond chance")?;
    if tests == 0 {
        return writeln!(out, "  nothing could be tested");
    }
    let legend = format!(
        "F-test of each octave with its degrees of freedom, Holm's correction for all {tests} tests; p is corrected. Octaves share samples, which \
         makes the correction err towards no difference."
    );
    writeln!(out, "{}", fill(&legend, "", ""))?;
    let mut any = false;
    for channel in tests_by_channel(&comparison.octaves) {
        for pair in channel.chunk_by(|a, b| a.records == b.records) {
            let differ: Vec<&OctaveTest> =
                pair.iter().copied().filter(|test| comparison.is_significant(test.chance)).collect();
            let surest = differ.iter().min_by(|a, b| a.chance.p.total_cmp(&b.chance.p));
            let (Some(surest), Some(first), Some(last)) = (surest, differ.first(), differ.last()) else { continue };
            any = true;
            let ratio = larger_over_smaller(surest.records, surest.deviations);
            let text = format!(
                "{:<12}{} of {} octaves, tau {} to {} s; surest at {} s: {ratio} ({})",
                surest.channel,
                differ.len(),
                pair.len(),
                short(first.tau_s),
                short(last.tau_s),
                short(surest.tau_s),
                chance(surest.chance)
            );
            writeln!(out, "{}", fill(&text, "  ", "              "))?;
        }
    }
    if any { Ok(()) } else { writeln!(out, "  none") }
}

fn write_disturbances(out: &mut String, comparison: &Comparison) -> fmt::Result {
    if comparison.disturbances.is_empty() {
        return Ok(());
    }
    writeln!(out, "\ndisturbed")?;
    for disturbance in &comparison.disturbances {
        let channels = match &disturbance.warning.channels[..] {
            [] => "all channels".into(),
            channels => channels.join(", "),
        };
        let text = format!(
            "{:<3}{channels}, {}",
            record_letter(disturbance.record),
            disturbance.warning.in_words(remedy_words)
        );
        writeln!(out, "{}", fill(&text, "  ", "     "))?;
    }
    Ok(())
}

fn write_means(out: &mut String, comparison: &Comparison) -> fmt::Result {
    if comparison.means.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nmeans, each with its standard error, and how far they lie apart")?;
    let legend = "The standard error is that under the N, B and K of the record: what repeating it at once would show. A difference is tested \
                  under those of both records and the time between them; p: that noise alone takes two means so far apart, Holm's correction for \
                  all channels. The spread is the turn-on to turn-on bias if each record is a power cycle of one sensor that was not moved \
                  between them; its interval is chi-squared with one degree of freedom less than there are records.";
    writeln!(out, "{}", fill(legend, "", ""))?;
    for channel in &comparison.means {
        let group = if channel.bias_removed { ", bias taken out by the sensor" } else { "" };
        writeln!(out, "{} ({}{group})", channel.channel, channel.unit)?;
        let means: Vec<String> = (channel.means.iter())
            .map(|mean| match mean.error {
                Some(error) => {
                    format!(
                        "{} {} ± {:.1e}",
                        record_letter(mean.record),
                        signed(mean.mean, error.standard_error),
                        error.standard_error
                    )
                }
                None => format!("{} {}", record_letter(mean.record), four_digits(mean.mean)),
            })
            .collect();
        writeln!(out, "{}", fill(&means.join("; "), "  ", "  "))?;
        write_differences(out, channel, comparison)?;
        if let Some(spread) = channel.spread.filter(|_| channel.means.len() > 2) {
            let interval = spread.interval.map_or_else(String::new, |interval| {
                format!(" ({} to {})", four_digits(interval.lower), four_digits(interval.upper))
            });
            writeln!(out, "  spread {}{interval}", four_digits(spread.deviation))?;
        }
    }
    if comparison.means.iter().any(|channel| channel.bias_removed) {
        let text = "The spread of a gyro whose bias is taken out is that of a filter's remainder, not of the sensor's bias; VNIMU carries that.";
        writeln!(out, "{}", fill(text, "", ""))?;
    }
    Ok(())
}

/// Of two records theirs; of more those that are beyond noise.
fn write_differences(out: &mut String, channel: &ChannelMeans, comparison: &Comparison) -> fmt::Result {
    for difference in &channel.differences {
        let [first, second] = difference.records.map(record_letter);
        let differs = difference.test.is_ok_and(|test| comparison.is_significant(test.chance));
        if channel.means.len() > 2 && !differs {
            continue;
        }
        let text = match difference.test {
            Ok(test) => {
                let verdict = if differs { "beyond noise" } else { "as noise alone makes it" };
                let (apart, error) = (signed(difference.difference, test.standard_error), test.standard_error);
                format!("{second} - {first} {apart} ± {error:.1e}: {verdict} ({})", chance(test.chance))
            }
            Err(why) => {
                format!("{second} - {first} {}, without p: {}", four_digits(difference.difference), untested(why))
            }
        };
        writeln!(out, "{}", fill(&text, "  ", "  "))?;
    }
    let tested = channel.differences.iter().filter_map(|difference| difference.test.ok());
    let (tested, differing) = tested.fold((0, 0), |(tested, differing), test| {
        (tested + 1, differing + u64::from(comparison.is_significant(test.chance)))
    });
    if channel.means.len() > 2 && tested > 0 {
        writeln!(out, "  {differing} of {} beyond noise", counted(tested, "difference"))?;
    }
    Ok(())
}

/// The one that is larger, as a multiple of the other.
fn larger_over_smaller(records: [usize; 2], deviations: [f64; 2]) -> String {
    let larger = usize::from(deviations[1] > deviations[0]);
    let [of, over] = [records[larger], records[1 - larger]].map(record_letter);
    format!("{of} is {} times {over}", four_digits(deviations[larger] / deviations[1 - larger]))
}

fn chance(chance: Chance) -> String {
    match chance.corrected {
        ..1e-12 => "p < 1e-12".into(),
        p @ ..0.001 => format!("p {p:.0e}"),
        p => format!("p {}", short((p * 1000.0).round() / 1000.0)),
    }
}

/// With as many decimals as its error has in two digits.
fn signed(value: f64, error: f64) -> String {
    let decimals = (1 - error.log10().floor() as i32).clamp(0, 12) as usize;
    format!("{value:+.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_deviations_the_larger_is_a_multiple_of_the_smaller() {
        assert_eq!(larger_over_smaller([1, 2], [14_475.819, 1.0]), "B is 1.448e4 times C");
        assert_eq!(larger_over_smaller([1, 2], [1.0, 2240.4]), "C is 2240 times B");
        assert_eq!(larger_over_smaller([0, 2], [1.1, 1.0]), "A is 1.100 times C");
    }

    #[test]
    fn a_mean_has_the_digits_that_are_known() {
        assert_eq!(signed(0.020_123_456, 1.3e-5), "+0.020123");
        assert_eq!(signed(-9.806_66, 0.0031), "-9.8067");
        assert_eq!(signed(3.0, 25.0), "+3");
    }
}

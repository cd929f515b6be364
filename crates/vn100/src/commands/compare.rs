//! `vn100 compare`: captures side by side. Differences of the setup first, then the ranking,
//! what differs, and how far means lie apart.

use std::{
    fmt::{self, Write},
    path::Path,
};

use anyhow::Result;
use imu_noise::Term;
use vn100_analysis::{
    Chance, Comparison, Completion, DEFAULT_CONFIDENCE, OctaveTest, Ranking, SourceResult, sensor_of,
};
use vn100_capture::Capture;
use vn100_report::{
    ComparisonDocument,
    caveats::caveat_in_words,
    names::{folding, names_of},
    numbers::plain::{counted, digits, short},
    printable,
    remedies::remedy_words,
    run_name,
    summary::rate_text,
    units::parameter_unit,
    warnings::{headline, in_words},
};
use vn100_session::ReplaySpec;

use crate::{
    args::CompareArgs,
    commands::replay::{Outputs, measure_files},
    exit::{print, print_json, report, unless_closed},
    inputs::inputs,
    text::{fill, parameter_name, text, write_populations},
    user_files::evaluation,
};

pub(crate) fn compare(args: &CompareArgs) -> Result<Completion> {
    let evaluation = evaluation(&args.files.measure)?.verdicts_only();
    let mut all: Vec<SourceResult> = Vec::new();
    let inputs = inputs(&args.files);
    if let [ReplaySpec { path, capture, .. }] = &*inputs
        && (path == Path::new("-") || Capture::open(path, capture).is_ok())
    {
        let text = "contains one stream; give two captures or more, or one with two streams";
        report(&format!("{} {text}", path.display()));
        return Ok(Completion::NotGiven);
    }
    measure_files(&args.files, &inputs, evaluation, Outputs::default(), |measured| {
        measured.failures().for_each(|text| report(text));
        all.push(measured);
        Ok(())
    })?;
    let confidence = args.files.measure.confidence.unwrap_or(DEFAULT_CONFIDENCE);
    let comparison = Comparison::of(&all, &units(&inputs, &all, &args.sensor), confidence);
    if args.output.json {
        unless_closed(print_json(&ComparisonDocument::new(&all, &comparison, remedy_words)))?;
    } else {
        unless_closed(print(&text(|out| write_comparison(out, &all, &comparison))))?;
    }
    Ok(all.iter().map(|measured| measured.completion).max().unwrap_or(Completion::Complete))
}

/// The sensor of each recording: as the user calls it, its serial number, or the folder of the
/// file, which is said to be one.
fn units(inputs: &[ReplaySpec], all: &[SourceResult], given: &[String]) -> Vec<String> {
    let unit = |(number, (input, measured)): (usize, (&ReplaySpec, &SourceResult))| {
        let serial = measured.source.device.as_ref().and_then(|device| device.serial_number.clone());
        let named = given.get(number).or(given.last().filter(|_| given.len() == 1)).cloned();
        let folder = || input.path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
        named.or(serial).unwrap_or_else(|| format!("folder {}", folder().display()))
    };
    inputs.iter().zip(all).enumerate().map(unit).collect()
}

fn write_comparison(out: &mut String, all: &[SourceResult], comparison: &Comparison) -> fmt::Result {
    writeln!(out, "{}, {} % confidence", counted(all.len() as u64, "run"), short(100.0 * comparison.confidence))?;
    for (number, measured) in all.iter().enumerate() {
        let timing = &measured.timing;
        let held = match &measured.source.message {
            Some(message) => format!("{message}, {} s at {}", short(timing.duration_s), rate_text(timing)),
            None => "nothing to compare".into(),
        };
        let line = format!("{}  {}: {held}", run_name(number), printable(&measured.source.name));
        writeln!(out, "{}", fill(&line, "  ", "         "))?;
    }
    for caveat in &comparison.caveats {
        let text = caveat_in_words(caveat, all, comparison, remedy_words);
        writeln!(out, "{}", fill(&printable(&text), "! ", "  "))?;
    }
    for ranking in &comparison.rankings {
        write_ranking(out, ranking)?;
    }
    write_populations(out, &comparison.populations, comparison.confidence)?;
    write_octaves(out, comparison)?;
    write_disturbances(out, comparison)?;
    write_means(out, comparison)
}

fn write_ranking(out: &mut String, ranking: &Ranking) -> fmt::Result {
    let sensor = sensor_of(ranking.quantity);
    let parameter = sensor.map_or("N".into(), |sensor| parameter_name(sensor, Term::White));
    let (unit, factor) = sensor.map_or((ranking.unit, 1.0), |sensor| parameter_unit(sensor, Term::White));
    let number = |white: f64| digits(white * factor, 4);
    let head = format!("{}: {parameter} in {unit}, quietest first", names_of(ranking.quantity).title);
    writeln!(out, "\n{}", fill(&head, "", "  "))?;
    for ranked in &ranking.records {
        let axes: Vec<String> =
            ranked.axes.iter().map(|axis| format!("{} {}", axis.name, number(axis.white))).collect();
        let (white, lower, upper) = (ranked.white, ranked.lower, ranked.upper);
        let line = format!(
            "{}  {} ({} to {}): {}",
            run_name(ranked.record),
            number(white),
            number(lower),
            number(upper),
            axes.join(", ")
        );
        writeln!(out, "{}", fill(&line, "  ", "         "))?;
    }
    if !ranking.not_ranked.is_empty() {
        let names: Vec<String> = ranking.not_ranked.iter().map(|record| run_name(*record)).collect();
        let text = format!("not ranked, because N is not estimated on every axis: {}", names.join(", "));
        writeln!(out, "{}", fill(&text, "  ", "  "))?;
    }
    if !ranking.folds_alike {
        writeln!(out, "{}", fill(&folding(ranking), "  ", "  "))?;
    }
    if let ([first, second, ..], Some(lead)) = (&ranking.records[..], ranking.lead()) {
        let (percent, a, b) =
            (100.0 * (1.0 - first.white / second.white), run_name(first.record), run_name(second.record));
        let text = if lead.differs {
            format!("{a} is significantly the quietest: N {percent:.1} % below {b} ({})", chance(lead))
        } else {
            format!("the two quietest do not differ significantly: {a} is {percent:.1} % below {b} ({})", chance(lead))
        };
        writeln!(out, "{}", fill(&text, "  ", "  "))?;
    }
    Ok(())
}

fn write_octaves(out: &mut String, comparison: &Comparison) -> fmt::Result {
    let tests: usize = comparison.channels.iter().map(|channel| channel.octaves.len()).sum();
    writeln!(out, "\nStatistically significant differences of deviations")?;
    if tests == 0 {
        return writeln!(out, "  nothing could be tested");
    }
    let legend = format!(
        "F-test of each octave with its degrees of freedom; p with Holm's correction for all {tests} tests. Octaves share samples, which makes \
         the correction conservative."
    );
    writeln!(out, "{}", fill(&legend, "", ""))?;
    let mut any = false;
    for channel in &comparison.channels {
        for pair in channel.pairs() {
            let differ: Vec<&OctaveTest> = pair.iter().filter(|test| test.chance.differs).collect();
            let surest = differ.iter().min_by(|a, b| a.chance.p.total_cmp(&b.chance.p));
            let (Some(surest), Some(first), Some(last)) = (surest, differ.first(), differ.last()) else { continue };
            any = true;
            let ratio = larger_over_smaller(surest.records, surest.deviations);
            let text = format!(
                "{:<12}{} of {} octaves, tau {} to {} s; most significant at {} s: {ratio} ({})",
                channel.name,
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
    writeln!(out, "\nDisturbances")?;
    let mut explained = Vec::new();
    for (record, warning) in &comparison.disturbances {
        let channels = match &warning.channels[..] {
            [] => "all channels".into(),
            channels => channels.join(", "),
        };
        // what a kind means and what to do is said once
        let said = if explained.contains(&warning.kind) { headline(warning) } else { in_words(warning, remedy_words) };
        explained.push(warning.kind);
        let text = format!("{}  {channels}: {said}", run_name(*record));
        writeln!(out, "{}", fill(&text, "  ", "         "))?;
    }
    Ok(())
}

fn write_means(out: &mut String, comparison: &Comparison) -> fmt::Result {
    if comparison.means.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nMeans")?;
    let legend = "The spread is the turn-on to turn-on bias if each run is a power cycle of one sensor that was not moved; its interval is \
                  chi-squared with one degree of freedom less than there are runs.";
    writeln!(out, "{}", fill(legend, "", ""))?;
    for channel in &comparison.means {
        let group = if channel.bias_removed { ", bias removed by the sensor" } else { "" };
        writeln!(out, "{} ({}{group})", channel.name, channel.unit)?;
        let means = channel.means.iter().map(|mean| format!("{} {}", run_name(mean.record), digits(mean.mean, 4)));
        writeln!(out, "{}", fill(&means.collect::<Vec<_>>().join("; "), "  ", "  "))?;
        if let Some(spread) = channel.spread {
            let interval = spread
                .lower
                .zip(spread.upper)
                .map_or_else(String::new, |(lower, upper)| format!(" ({} to {})", digits(lower, 4), digits(upper, 4)));
            writeln!(out, "  spread {}{interval}", digits(spread.deviation, 4))?;
        }
    }
    if comparison.means.iter().any(|channel| channel.bias_removed) {
        let text = "The spread of a compensated gyroscope is that of the filter's remaining bias, not of the sensor's; VNIMU is not compensated.";
        writeln!(out, "{}", fill(text, "", ""))?;
    }
    Ok(())
}

/// The one that is larger, as a multiple of the other.
fn larger_over_smaller(records: [usize; 2], deviations: [f64; 2]) -> String {
    let larger = usize::from(deviations[1] > deviations[0]);
    let [of, over] = [records[larger], records[1 - larger]].map(run_name);
    format!("{of} is {} times {over}", digits(deviations[larger] / deviations[1 - larger], 4))
}

fn chance(chance: Chance) -> String {
    match chance.corrected {
        ..1e-12 => "p < 1e-12".into(),
        p @ ..0.001 => format!("p = {p:.0e}"),
        p => format!("p = {}", short((p * 1000.0).round() / 1000.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_deviations_the_larger_is_a_multiple_of_the_smaller() {
        assert_eq!(larger_over_smaller([1, 2], [14_475.819, 1.0]), "run 2 is 14476 times run 3");
        assert_eq!(larger_over_smaller([1, 2], [1.0, 2240.4]), "run 3 is 2240 times run 2");
        assert_eq!(larger_over_smaller([0, 2], [1.1, 1.0]), "run 1 is 1.100 times run 3");
    }
}

//! Several records side by side.

use crate::warnings::{caveat_in_words, in_words};
use crate::{
    figure::Figures,
    names::{folding, names_of, recommendation, untested},
    numbers::{NOTHING, digits, duration, four_digits, grouped, trimmed, with_interval},
    run_name, tests_by_channel,
    units::pretty_unit,
};
use maud::{Markup, html};
use vn100_analysis::Spread;
use vn100_analysis::{Chance, ChannelMeans, Comparison, MeanDifference, OctaveTest, RemedyWords, SourceResult};

use crate::html::{
    caption::Captions,
    elements::{row, table},
    figures::grid,
    glance::with_code,
    options::PageOptions,
};

pub(crate) fn several(
    records: &[SourceResult],
    together: &Figures,
    options: PageOptions<'_>,
    captions: &Captions,
) -> Markup {
    let compared: Vec<_> = records.iter().map(|record| record.compared()).collect();
    let comparison = Comparison::of(&compared, false, options.confidence);
    html! {
        section id="comparison" {
            h2 { "Comparison" }
            (list(records, captions))
            p { b { "Which record to use" } ": " (recommendation(&comparison, run_name)) "." }
            @for caveat in &comparison.caveats { p.warning { b { (caveat.kind.name()) } ": " (with_code(caveat_in_words(caveat, options.words).trim_end_matches('.'))) "." } }
            h3 { "Allan deviation" }
            (grid(&together.allan_axes, captions))
            (rankings(&comparison, captions))
            (octaves(&comparison, captions))
            (disturbances(&comparison, options.words))
            (means(&comparison, captions))
        }
    }
}

fn list(records: &[SourceResult], captions: &Captions) -> Markup {
    let rows = html! {
        @for (index, record) in records.iter().enumerate() {
            @let timing = &record.timing;
            (row(run_name(index), [
                record.source.name.clone(),
                record.source.message.as_deref().unwrap_or(NOTHING).to_owned(),
                grouped(timing.samples),
                duration(timing.duration_s),
                timing.rate_hz.map_or_else(|| NOTHING.into(), |hz| format!("{} Hz", trimmed(hz, 4))),
            ]))
        }
    };
    table(
        &captions.table("Records compared"),
        None,
        &["record", "capture", "message", "samples", "length", "rate"],
        &rows,
    )
}

fn rankings(comparison: &Comparison, captions: &Captions) -> Markup {
    html! {
        @for ranking in &comparison.rankings {
            @let caption = format!("Noise density N of the {} in {}, quietest first", names_of(ranking.quantity).quantity, pretty_unit(ranking.unit));
            @let rows = html! {
                @for ranked in &ranking.records {
                    @let axes: Vec<_> = ranked.axes.iter().map(|(name, white)| format!("{name} {}", four_digits(*white))).collect();
                    (row(run_name(ranked.record), [with_interval(ranked.white, ranked.lower, ranked.upper), axes.join(", ")]))
                }
            };
            (table(&captions.table(&caption), None, &["record", "N of its axes together", "axes"], &rows))
            @if !ranking.folds_alike { p { (folding(ranking, run_name)) "." } }
            @if let ([first, second, ..], Some(lead)) = (&ranking.records[..], ranking.lead()) {
                p {
                    @if comparison.is_significant(lead) { (run_name(first.record)) " is significantly quieter (" (chance(lead)) ")." }
                    @else { "No significant difference between " (run_name(first.record)) " and " (run_name(second.record)) " (" (chance(lead)) ")." }
                }
            }
        }
    }
}

fn octaves(comparison: &Comparison, captions: &Captions) -> Markup {
    let channels = tests_by_channel(&comparison.octaves);
    let pairs = channels.iter().flat_map(|channel| channel.chunk_by(|a, b| a.records == b.records));
    let rows: Vec<(usize, Vec<&OctaveTest>)> = pairs
        .map(|pair| (pair.len(), pair.iter().copied().filter(|test| comparison.is_significant(test.chance)).collect()))
        .filter(|(_, differ): &(usize, Vec<_>)| !differ.is_empty())
        .collect();
    let columns =
        ["channel", "records", "octaves that differ", "from τ (s)", "to τ (s)", "most significant ratio", "p"];
    fn surest<'a>(differ: &[&'a OctaveTest]) -> Option<&'a OctaveTest> {
        differ.iter().copied().min_by(|a, b| a.chance.p.total_cmp(&b.chance.p))
    }
    let differing = html! {
        @for (all, differ) in &rows {
            @if let (Some(first), Some(last), Some(surest)) = (differ.first(), differ.last(), surest(differ)) {
                (row(&surest.channel, [
                    format!("{} over {}", run_name(surest.records[1]), run_name(surest.records[0])),
                    format!("{} of {all}", differ.len()),
                    trimmed(first.tau_s, 3),
                    trimmed(last.tau_s, 3),
                    digits(surest.deviations[1] / surest.deviations[0], 3),
                    chance(surest.chance),
                ]))
            }
        }
    };
    html! {
        h3 { "Statistically significant differences" }
        p { "F-test of each octave with its degrees of freedom, Holm's correction for all " (comparison.octaves.len()) " tests. Octaves share samples, which makes the correction conservative." }
        @if comparison.octaves.is_empty() { p { "Nothing could be tested." } } @else if rows.is_empty() { p { "None." } } @else { (table(&captions.table("Octaves with significant differences"), None, &columns, &differing)) }
    }
}

fn disturbances(comparison: &Comparison, words: RemedyWords) -> Markup {
    html! {
        @if !comparison.disturbances.is_empty() {
            h3 { "Disturbed records" }
            @for disturbance in &comparison.disturbances {
                p.warning { b { (run_name(disturbance.record)) ", " (disturbance.warning.kind.name()) } ": " (in_words(&disturbance.warning, words).trim_end_matches('.')) "." }
            }
        }
    }
}

fn means(comparison: &Comparison, captions: &Captions) -> Markup {
    html! {
        @if !comparison.means.is_empty() {
            h3 { "Means" }
            p {
                "Each with its standard error under the N, B and K of its record: the scatter expected from an immediate repetition. The spread is the turn-on to turn-on bias if each record is a power cycle of one sensor \
                 that was not moved between them."
            }
            (table(&captions.table("Means of the records"), None, &["channel", "unit", "means", "differences", "spread"], &html! { @for channel in &comparison.means { (mean(channel)) } }))
        }
    }
}

fn mean(channel: &ChannelMeans) -> Markup {
    html! {
        tr {
            th scope="row" { (channel.channel) @if channel.bias_removed { " (bias removed)" } }
            td.unit { (pretty_unit(&channel.unit)) }
            td {
                @for (index, mean) in channel.means.iter().enumerate() {
                    @if index > 0 { br; }
                    (run_name(mean.record)) ": " (four_digits(mean.mean))
                    @if let Some(error) = &mean.error { " ± " (digits(error.standard_error, 2)) }
                }
            }
            td {
                @for (index, difference) in channel.differences.iter().enumerate() {
                    @if index > 0 { br; }
                    (apart(difference))
                }
            }
            td { (channel.spread.as_ref().map_or_else(|| NOTHING.into(), spread)) }
        }
    }
}

/// One difference; why it is not tested is among the caveats where that holds for all channels.
fn apart(difference: &MeanDifference) -> String {
    let [first, second] = difference.records.map(run_name);
    let apart = format!("{second} − {first}: {}", digits(difference.difference, 3));
    match difference.test {
        Ok(test) => format!("{apart} ± {} ({})", digits(test.standard_error, 2), chance(test.chance)),
        Err(why) => format!("{apart} ({})", untested(why)),
    }
}

fn spread(spread: &Spread) -> String {
    match &spread.interval {
        Some(interval) => with_interval(spread.deviation, interval.lower, interval.upper),
        None => four_digits(spread.deviation),
    }
}

fn chance(chance: Chance) -> String {
    match chance.corrected {
        ..1e-12 => "p < 10⁻¹²".into(),
        p @ ..0.001 => format!("p = {}", digits(p, 1)),
        p => format!("p = {}", trimmed(p, 3)),
    }
}

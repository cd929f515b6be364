//! Several records side by side.

use crate::{
    caveats::caveat_in_words,
    figure::Figures,
    names::{folding, names_of},
    numbers::{NOTHING, digits, duration, grouped, trimmed, with_interval},
    run_name,
    units::pretty_unit,
    warnings::in_words,
};
use maud::{Markup, html};
use vn100_analysis::{Chance, ChannelMeans, Comparison, OctaveTest, RemedyWords, SourceResult, Spread};

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
    let comparison = Comparison::of(records, &[], options.confidence);
    html! {
        section id="comparison" {
            h2 { "Comparison" }
            (list(records, captions))
            @for caveat in &comparison.caveats { p.warning { (with_code(caveat_in_words(caveat, records, &comparison, options.words).trim_end_matches('.'))) "." } }
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
                    @let axes: Vec<_> = ranked.axes.iter().map(|axis| format!("{} {}", axis.name, digits(axis.white, 4))).collect();
                    (row(run_name(ranked.record), [with_interval(ranked.white, ranked.lower, ranked.upper), axes.join(", ")]))
                }
            };
            (table(&captions.table(&caption), None, &["record", "N of its axes together", "axes"], &rows))
            @if !ranking.folds_alike { p { (folding(ranking)) "." } }
            @if let ([first, second, ..], Some(lead)) = (&ranking.records[..], ranking.lead()) {
                p {
                    @if lead.differs { (run_name(first.record)) " is significantly quieter (" (chance(lead)) ")." }
                    @else { "No significant difference between " (run_name(first.record)) " and " (run_name(second.record)) " (" (chance(lead)) ")." }
                }
            }
        }
    }
}

fn octaves(comparison: &Comparison, captions: &Captions) -> Markup {
    let rows: Vec<(&str, usize, Vec<&OctaveTest>)> = (comparison.channels.iter())
        .flat_map(|channel| channel.pairs().map(|pair| (&*channel.name, pair)))
        .map(|(name, pair)| (name, pair.len(), pair.iter().filter(|test| test.chance.differs).collect()))
        .filter(|(.., differ): &(_, _, Vec<_>)| !differ.is_empty())
        .collect();
    let tests: usize = comparison.channels.iter().map(|channel| channel.octaves.len()).sum();
    let columns =
        ["channel", "records", "octaves that differ", "from τ (s)", "to τ (s)", "most significant ratio", "p"];
    fn surest<'a>(differ: &[&'a OctaveTest]) -> Option<&'a OctaveTest> {
        differ.iter().copied().min_by(|a, b| a.chance.p.total_cmp(&b.chance.p))
    }
    let differing = html! {
        @for (name, all, differ) in &rows {
            @if let (Some(first), Some(last), Some(surest)) = (differ.first(), differ.last(), surest(differ)) {
                (row(name, [
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
        p { "F-test of each octave with its degrees of freedom, Holm's correction for all " (tests) " tests. Octaves share samples, which makes the correction conservative." }
        @if tests == 0 { p { "Nothing could be tested." } } @else if rows.is_empty() { p { "None." } } @else { (table(&captions.table("Octaves with significant differences"), None, &columns, &differing)) }
    }
}

fn disturbances(comparison: &Comparison, words: RemedyWords) -> Markup {
    html! {
        @if !comparison.disturbances.is_empty() {
            h3 { "Disturbed records" }
            @for (record, warning) in &comparison.disturbances {
                p.warning { b { (run_name(*record)) ", " (warning.kind.name()) } ": " (in_words(warning, words).trim_end_matches('.')) "." }
            }
        }
    }
}

fn means(comparison: &Comparison, captions: &Captions) -> Markup {
    html! {
        @if !comparison.means.is_empty() {
            h3 { "Means" }
            p {
                "The spread is the turn-on to turn-on bias if each record is a power cycle of one sensor that was not moved between them."
            }
            (table(&captions.table("Means of the records"), None, &["channel", "unit", "means", "spread"], &html! { @for channel in &comparison.means { (mean(channel)) } }))
        }
    }
}

fn mean(channel: &ChannelMeans) -> Markup {
    html! {
        tr {
            th scope="row" { (channel.name) @if channel.bias_removed { " (bias removed)" } }
            td.unit { (pretty_unit(&channel.unit)) }
            td {
                @for (index, mean) in channel.means.iter().enumerate() {
                    @if index > 0 { br; }
                    (run_name(mean.record)) ": " (digits(mean.mean, 4))
                }
            }
            td { (channel.spread.as_ref().map_or_else(|| NOTHING.into(), spread)) }
        }
    }
}

fn spread(spread: &Spread) -> String {
    match spread.lower.zip(spread.upper) {
        Some((lower, upper)) => with_interval(spread.deviation, lower, upper),
        None => digits(spread.deviation, 4),
    }
}

fn chance(chance: Chance) -> String {
    match chance.corrected {
        ..1e-12 => "p < 10⁻¹²".into(),
        p @ ..0.001 => format!("p = {}", digits(p, 1)),
        p => format!("p = {}", trimmed(p, 3)),
    }
}

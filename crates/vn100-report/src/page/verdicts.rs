//! The figures of the data sheet, and what the record says of each.

use maud::{Markup, html};
use vn100_analysis::{FigureVerdict, Remedy, RemedyWords, StreamUnknown, letter};

use super::{statistics::ORDER, table::table};
use crate::{
    figure::pretty_unit,
    numbers::{NOTHING, digits, four_digits},
    record::Record,
    units::ChannelValues,
    verdict_words::{grade_text, shown_in, verdict_name},
};

pub(super) fn verdicts(record: &Record<'_>, words: RemedyWords) -> Markup {
    let Some(verdicts) = &record.measured.verdicts else {
        return html! {
            h3 { "Data sheet" }
            p { "None was compared: the built-in figures are for the VN-100's own messages; " code { (words(&Remedy::GiveDatasheet)) " FILE.toml" } " gives those of another sensor." }
        };
    };
    if let Some(motion) = &record.assessment().motion {
        return html! {
            h3 { "Beside the data sheet: " (verdicts.datasheet) }
            p { "Nothing is compared: " (pretty_unit(&motion.to_string())) "." }
        };
    }
    let rows: Vec<(&ChannelValues, &FigureVerdict)> = (ORDER.iter())
        .flat_map(|(quantity, _)| record.of(*quantity))
        .flat_map(|channel| record.verdicts(channel).iter().map(move |verdict| (channel, verdict)))
        .collect();
    let columns = ["channel", "", "unit", "data sheet", "read by such a sensor in this stream", "measured", "verdict"];
    let compared = html! {
        @for (channel, verdict) in &rows {
            @if let Some(noise) = &channel.noise {
                @let (unit, factor) = shown_in(noise.sensor, verdict.figure.term);
                tr {
                    th scope="row" { (channel.name) }
                    td { (letter(verdict.figure.term)) }
                    td.unit { (pretty_unit(unit)) }
                    td { (pretty_unit(&verdict.figure.printed)) }
                    td { (range(verdict.expected, factor)) @if verdict.unknown == Some(StreamUnknown::Window) { " *" } }
                    td { (measured(verdict, factor)) }
                    td { b { (verdict_name(verdict.verdict)) } }
                }
            }
        }
    };
    html! {
        h3 { "Beside the data sheet: " (verdicts.datasheet) }
        @if let Some(note) = &verdicts.note { p { "Its figures are " (note) "." } }
        (table(Some("verdicts"), &columns, &compared))
        p {
            "A limit is kept where the whole interval lies below the least that a sensor at the limit reads. A typical value is no guarantee, and a single one stands for all that round to it. "
            @if rows.iter().any(|(_, verdict)| verdict.unknown == Some(StreamUnknown::Window)) {
                "* If register 85 is as sold; the record does not tell, so that a figure may be consistent with it but cannot pass or fail. "
            }
            "In-run bias is compared as data sheets have it, as the minimum of the fitted curve, of N, B and K together."
        }
        (grades(record))
    }
}

fn range((low, high): (f64, f64), factor: f64) -> String {
    if low == high {
        digits(low * factor, 3)
    } else {
        format!("{} to {}", digits(low * factor, 3), digits(high * factor, 3))
    }
}

fn measured(verdict: &FigureVerdict, factor: f64) -> String {
    let found = verdict.measured;
    match (found.value, found.lower, found.upper) {
        (Some(value), Some(lower), Some(upper)) => {
            format!(
                "{} ({} to {})",
                four_digits(value * factor),
                four_digits(lower * factor),
                four_digits(upper * factor)
            )
        }
        (None, Some(lower), Some(upper)) => {
            format!("{} to {}", four_digits(lower * factor), four_digits(upper * factor))
        }
        (None, _, Some(upper)) => format!("≤ {}", four_digits(upper * factor)),
        _ => NOTHING.into(),
    }
}

/// Of the gyroscope.
fn grades(record: &Record<'_>) -> Markup {
    let of = |channel: &ChannelValues| Some(format!("{}: {}", channel.name, grade_text(channel.noise.as_ref()?)?));
    let told: Vec<String> = record.channels.iter().filter_map(of).collect();
    html! {
        @if !told.is_empty() {
            p { "Grade by bias instability (N. El-Sheimy and A. Youssef, Satellite Navigation 1, 2020, table 1: navigation below 0.01 °/h, tactical to 10 °/h, commercial above): " (told.join("; ")) "." }
        }
    }
}

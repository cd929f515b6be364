//! The deviations as numbers.

use maud::{Markup, html};

use super::{statistics::ORDER, table::table};
use crate::{
    figure::pretty_unit,
    numbers::{NOTHING, digits, four_digits, trimmed},
    record::Record,
    units::{ChannelValues, Point},
};

pub(super) fn points(record: &Record<'_>) -> Markup {
    html! {
        details {
            summary { "The deviations as numbers" }
            @for (quantity, name) in ORDER {
                @let channels: Vec<&ChannelValues> = record.of(quantity).into_iter().filter(|channel| !channel.deviations.is_empty()).collect();
                @if let Some(first) = channels.first() {
                    h4 { (name) ", " (pretty_unit(&first.unit)) "; in brackets the interval, edf: equivalent degrees of freedom" }
                    @let axes = channels.iter().flat_map(|channel| [&*channel.name, "edf"]);
                    (table(None, &["τ (s)", "m", "terms"].into_iter().chain(axes).collect::<Vec<_>>(), &octaves(&channels, first)))
                }
            }
        }
    }
}

/// A row for each octave of the `first` channel.
fn octaves(channels: &[&ChannelValues], first: &ChannelValues) -> Markup {
    html! {
        @for (index, point) in first.deviations.iter().enumerate() {
            tr {
                th scope="row" { (trimmed(point.tau_s, 6)) } td { (point.m) } td { (point.terms) }
                @for channel in channels {
                    @let point = channel.deviations.get(index);
                    td { (point.map_or_else(|| NOTHING.into(), value)) }
                    td { (point.and_then(|point| point.edf).map_or_else(|| NOTHING.into(), |edf| digits(edf, 3))) }
                }
            }
        }
    }
}

fn value(point: &Point) -> String {
    let Some(deviation) = point.deviation else { return NOTHING.into() };
    match (point.lower, point.upper) {
        (Some(lower), Some(upper)) => {
            format!("{} ({} to {})", four_digits(deviation), digits(lower, 3), digits(upper, 3))
        }
        _ => four_digits(deviation),
    }
}

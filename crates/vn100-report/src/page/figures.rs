//! The figures, each with what it shows in words, and their numbers.

use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use vn100_analysis::noise::Deviation;

use super::table;
use crate::{
    figure::{Figure, Figures, PlotAxis, PlottedSeries, Rectangle, Scale, pretty_unit},
    measured::Record,
    names::{QUANTITIES, names_of},
    numbers::{NOTHING, digits, four_digits, trimmed},
    units::{ChannelValues, Point},
};

pub(super) fn allan(record: &Record<'_>, figures: &Figures) -> Markup {
    let level = trimmed(100.0 * record.measured.assessment.confidence, 2);
    html! {
        p {
            "Bars are " (level) " % intervals, each alone at that level; points with fewer than two degrees of freedom have none. "
            @if record.measured.snapshot.deviation == Deviation::Allan {
                "The thick line is the whole fitted solution over the averaging times it was fitted to, with terms that are only bounded at their best values, lines and correlated noise; the thin ones are its white noise (dashed), \
                 flat part (dotted) and random walk (dash-dotted), each only where it is estimated, with a mark where its letter is read: N at 1 s, K at 3 s. A term that is only bounded stands in the legend with ≤. Hollow marks are what the graphical rules read: a ring for N, a square for the minimum, a triangle for K."
            } @else {
                "The lines of N, B and K are of the Allan deviation and are not drawn here."
            }
        }
        (grid(&figures.allan_sensors))
        (grid(&figures.allan_axes))
        (points(record))
    }
}

pub(super) fn time(figures: &Figures) -> Markup {
    html! {
        p { "The record in at most 96 blocks of equal length: the range of the samples in each, one standard deviation on either side of their mean, and the mean. Gaps are left open. Angles are continuous over ±180°." }
        (grid(&figures.times))
    }
}

pub(super) fn histograms(figures: &Figures) -> Markup {
    html! {
        p { "The normal curve has the same mean, standard deviation and area as the bars. Whether the values are normally distributed is judged from skewness and kurtosis, with the errors that correlated and rounded samples have [7]." }
        (grid(&figures.histograms))
    }
}

pub(super) fn spectrum(figures: &Figures) -> Markup {
    html! {
        p { "Amplitude density by Welch's method with a Hann window [5], one-sided: white noise lies at √2 N. Marks are lines that a clean record shows with a probability below 10⁻⁴; a line may be the alias of one above half the sample rate." }
        (grid(&figures.spectra))
        p { "The standard deviation of the samples within each segment of the record: level where the record is as quiet all the time." }
        (grid(&figures.segments))
    }
}

pub(super) fn grid(figures: &[Figure]) -> Markup {
    html! {
        @if figures.is_empty() { p.absent { "Too short a record for such a figure." } }
        div.grid {
            @for figure in figures {
                figure id={ "figure-" (figure.id) } { (PreEscaped(figure.svg_element())) }
            }
        }
    }
}

pub(super) fn points(record: &Record<'_>) -> Markup {
    html! {
        details {
            summary { "The deviations as numbers" }
            @for quantity in QUANTITIES {
                @let channels: Vec<&ChannelValues> = record.of(quantity).into_iter().filter(|channel| !channel.deviations.is_empty()).collect();
                @if let Some(first) = channels.first() {
                    h4 { (names_of(quantity).title) ", " (pretty_unit(&first.unit)) "; in brackets the interval, edf: equivalent degrees of freedom" }
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

/// What can be read off a figure, for the script of the page: numbers to six digits.
#[derive(Serialize)]
struct FigureReadout<'a> {
    id: &'a str,
    /// Of the plot: left, top, width, height.
    area: [f64; 4],
    x: Side<'a>,
    y: Side<'a>,
    series: Vec<CurveReadout<'a>>,
}

#[derive(Serialize)]
struct Side<'a> {
    name: &'a str,
    unit: &'a str,
    log: bool,
    from: f64,
    to: f64,
}

#[derive(Serialize)]
struct CurveReadout<'a> {
    name: &'a str,
    x: Vec<f64>,
    y: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reach: Option<Vec<Option<[f64; 2]>>>,
}

/// A JSON array that is safe in a script element.
pub(super) fn readings<'a>(figures: impl Iterator<Item = &'a Figure>) -> serde_json::Result<String> {
    let readings: Vec<FigureReadout<'_>> = figures.map(reading).collect();
    Ok(serde_json::to_string(&readings)?.replace('<', "\\u003c"))
}

fn reading(figure: &Figure) -> FigureReadout<'_> {
    let Rectangle { left, top, width, height } = figure.area;
    FigureReadout {
        id: &figure.id,
        area: [left, top, width, height].map(six_digits),
        x: side(&figure.x),
        y: side(&figure.y),
        series: figure.series.iter().map(curve).collect(),
    }
}

fn curve(series: &PlottedSeries) -> CurveReadout<'_> {
    let values = &series.values;
    let reach = || values.iter().map(|value| value.reach.map(|(low, high)| [low, high].map(six_digits))).collect();
    CurveReadout {
        name: &series.name,
        x: values.iter().map(|value| six_digits(value.x)).collect(),
        y: values.iter().map(|value| six_digits(value.y)).collect(),
        reach: values.iter().any(|value| value.reach.is_some()).then(reach),
    }
}

fn side(axis: &PlotAxis) -> Side<'_> {
    let Scale { from, to, log } = axis.scale;
    Side { name: &axis.name, unit: &axis.unit, log, from: six_digits(from), to: six_digits(to) }
}

/// Rounded in decimals, so that the shortest form of the number is short.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(f64::NAN)
}

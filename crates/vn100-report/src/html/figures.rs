//! The figures, each with what it shows in words, and their numbers.

use crate::{
    figure::{Figure, Figures, PlotAxis, PlottedSeries, PlottedValue, Rectangle, Scale},
    numbers::trimmed,
};
use maud::{Markup, PreEscaped, html};
use serde_json::json;
use vn100_analysis::SourceResult;
use vn100_analysis::noise::Deviation;

use crate::html::caption::Captions;

/// The curves of each sensor, the first one large.
pub(crate) fn together(record: &SourceResult, figures: &Figures, captions: &Captions) -> Markup {
    let level = trimmed(100.0 * record.confidence, 2);
    let (first, others) = figures.allan_sensors.split_at(figures.allan_sensors.len().min(1));
    html! {
        @if first.is_empty() && figures.allan_axes.is_empty() { p.absent { "The record is too short for an Allan deviation." } }
        @for figure in first { div.large { (one(figure, captions)) } }
        @if !others.is_empty() { (grid(others, captions)) }
        p {
            "Bars are pointwise " (level) " % confidence intervals; hollow grey points without a bar have fewer than two equivalent degrees of freedom and show no trend."
            @if record.settings().deviation == Deviation::Allan && record.motion.is_none() {
                " Diamonds: N, read at 1 s. Lines in the colour of an axis: its flicker floor 0.664 B and its random walk K, where they are estimated; upper bounds stand in the legend with ≤."
            }
        }
    }
}

/// The curve of each axis with its model.
pub(crate) fn axes(record: &SourceResult, figures: &Figures, captions: &Captions) -> Markup {
    html! {
        p {
            @if record.settings().deviation == Deviation::Allan {
                "Thick line: the fitted model with all its terms. Thin lines: its white noise (dashed), flicker floor 0.664 B (dotted) and random walk (dash-dotted), where they are estimated, each with its value where it is read: N at 1 s, K at 3 s. \
                 Upper bounds stand in the legend with ≤. Hollow marks in the colour of the text: the graphical slope method, a ring for N, a square for the minimum, a triangle for K."
            } @else {
                "The lines of N, B and K belong to the Allan deviation and are not drawn here."
            }
        }
        (grid(&figures.allan_axes, captions))
    }
}

pub(crate) fn spectrum(figures: &Figures, captions: &Captions) -> Markup {
    html! {
        p { "Amplitude density by Welch's method with a Hann window [5], one-sided: white noise lies at √2 N. Marked peaks are significant at p < 10⁻⁴; a peak may be the alias of one above half the sample rate." }
        (grid(&figures.spectra, captions))
        p { "Standard deviation of the samples within each segment of the record: flat if the noise is stationary." }
        (grid(&figures.segments, captions))
    }
}

pub(crate) fn grid<'a>(figures: impl IntoIterator<Item = &'a Figure>, captions: &Captions) -> Markup {
    let mut figures = figures.into_iter().peekable();
    html! {
        @if figures.peek().is_none() { p.absent { "The record is too short for such a figure." } }
        @else { div.grid { @for figure in figures { (one(figure, captions)) } } }
    }
}

fn one(figure: &Figure, captions: &Captions) -> Markup {
    html! {
        figure id={ "figure-" (figure.id) } {
            (PreEscaped(figure.svg_element()))
            (captions.figure(&figure.title))
            script type="application/json" { (PreEscaped(readout(figure))) }
        }
    }
}

/// What can be read off a figure, for the script of the page: JSON that is safe in a script element.
fn readout(figure: &Figure) -> String {
    let Rectangle { left, top, width, height } = figure.area;
    let area = [left, top, width, height].map(five_digits);
    let side = |PlotAxis { name, unit, scale: Scale { from, to, log } }: &PlotAxis| json!({ "name": name, "unit": unit, "log": log, "from": five_digits(*from), "to": five_digits(*to) });
    let curve = |PlottedSeries { name, values }: &PlottedSeries| {
        let all = |of: fn(&PlottedValue) -> f64| values.iter().map(|value| five_digits(of(value))).collect::<Vec<_>>();
        let reach = |value: &PlottedValue| value.reach.map(|(low, high)| [low, high].map(five_digits));
        let reaches: Vec<_> = values.iter().map(reach).collect();
        let has_reach = reaches.iter().any(Option::is_some);
        json!({ "name": name, "x": all(|value| value.x), "y": all(|value| value.y), "reach": has_reach.then_some(reaches) })
    };
    let readout = json!({
        "id": figure.id,
        "area": area,
        "x": side(&figure.x),
        "y": side(&figure.y),
        "units": (!figure.units.is_empty()).then_some(&figure.units),
        "series": figure.series.iter().map(curve).collect::<Vec<_>>(),
    });
    readout.to_string().replace('<', "\\u003c")
}

/// Rounded in decimals, so that the shortest form of the number is short.
fn five_digits(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(f64::NAN)
}

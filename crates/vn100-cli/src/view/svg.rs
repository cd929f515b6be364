//! The deviation plot as a picture that stands alone: the same points, bars and model as on the
//! screen.

use std::fmt::{self, Write};

use super::{
    curve::{Curve, Plot},
    format::time,
    plot::LogAxis,
    source::Source,
};

const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 560.0;
/// Left, top, right and bottom of the plot.
const PLOT: [f64; 4] = [90.0, 60.0, 770.0, 490.0];

/// The colours of Okabe and Ito, as on the screen.
const COLOURS: [&str; 3] = ["#e69f00", "#56b4e9", "#cc79a7"];

/// The picture; without a curve it says so.
pub(crate) fn plot(plot: &Plot, source: &Source) -> String {
    let mut out = String::new();
    // a String takes everything
    let _ = write_plot(&mut out, plot, source);
    out
}

fn write_plot(out: &mut String, plot: &Plot, source: &Source) -> fmt::Result {
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"14\">"
    )?;
    writeln!(out, "<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>")?;
    let timing = &source.snapshot.timing;
    let title = format!(
        "{}: {} samples in {} at {} Hz, {} % intervals",
        source.name,
        timing.samples,
        time(timing.duration_s()),
        timing.rate_hz,
        100.0 * source.assessment.confidence
    );
    text(out, PLOT[0], 30.0, "start", &title)?;
    let axes = LogAxis::over(plot.taus()).zip(LogAxis::over(plot.curves.iter().flat_map(|curve| {
        curve.points.iter().flat_map(|point| [point.deviation, point.lower, point.upper]).flatten()
    })));
    match axes {
        Some((x, y)) => write_axes(out, plot, Axes { x, y })?,
        None => text(out, PLOT[0], 100.0, "start", "no deviation yet")?,
    }
    writeln!(out, "</svg>")
}

#[derive(Clone, Copy)]
struct Axes {
    x: LogAxis,
    y: LogAxis,
}

impl Axes {
    fn place(self, tau_s: f64, deviation: f64) -> (f64, f64) {
        let x = (tau_s.log10() - self.x.low) / (self.x.high - self.x.low);
        let y = (deviation.log10() - self.y.low) / (self.y.high - self.y.low);
        (PLOT[0] + x * (PLOT[2] - PLOT[0]), PLOT[3] - y * (PLOT[3] - PLOT[1]))
    }
}

fn write_axes(out: &mut String, plot: &Plot, axes: Axes) -> fmt::Result {
    let [left, top, right, bottom] = PLOT;
    for tick in axes.x.ticks(12) {
        let (x, _) = axes.place(10_f64.powf(tick.at), 1.0);
        line(out, [x, top, x, bottom], "#ddd")?;
        text(out, x, bottom + 20.0, "middle", &tick.label)?;
    }
    for tick in axes.y.ticks(12) {
        let (_, y) = axes.place(1.0, 10_f64.powf(tick.at));
        line(out, [left, y, right, y], "#ddd")?;
        text(out, left - 8.0, y + 5.0, "end", &tick.label)?;
    }
    writeln!(
        out,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"black\"/>",
        right - left,
        bottom - top
    )?;
    text(out, f64::midpoint(left, right), bottom + 44.0, "middle", "averaging time τ (s)")?;
    text(out, left, top - 10.0, "start", &format!("deviation σ(τ) ({})", plot.unit))?;
    for curve in &plot.curves {
        write_curve(out, curve, axes)?;
    }
    Ok(())
}

fn write_curve(out: &mut String, curve: &Curve, axes: Axes) -> fmt::Result {
    let colour = COLOURS.get(curve.axis).unwrap_or(&"black");
    for part in &curve.model {
        let seen = |(_, deviation): &&(f64, f64)| axes.y.part(*deviation).is_some();
        let points: Vec<_> =
            part.points.iter().filter(seen).map(|(tau, deviation)| axes.place(*tau, *deviation)).collect();
        polyline(out, &points, "#888", if part.term.is_some() { "4 4" } else { "none" })?;
        if let (Some(letter), Some((x, y))) = (part.term, points.last()) {
            text(out, x + 4.0, *y, "start", letter)?;
        }
    }
    let at = |value: Option<f64>, tau: f64| value.filter(|value| *value > 0.0).map(|value| axes.place(tau, value));
    let points: Vec<_> = curve.points.iter().filter_map(|point| at(point.deviation, point.tau_s)).collect();
    polyline(out, &points, colour, "none")?;
    for point in &curve.points {
        if let Some(((x, low), (_, high))) = at(point.lower, point.tau_s).zip(at(point.upper, point.tau_s)) {
            line(out, [x, low, x, high], colour)?;
        }
        if let Some((x, y)) = at(point.deviation, point.tau_s) {
            sign(out, curve.axis, (x, y), 3.0)?;
        }
    }
    let y = PLOT[1] + 20.0 + 18.0 * curve.axis as f64;
    sign(out, curve.axis, (PLOT[2] - 90.0, y - 5.0), 4.0)?;
    text(out, PLOT[2] - 80.0, y, "start", &curve.name)
}

/// The sign of an axis, as on the screen: a disc, a triangle, a diamond.
fn sign(out: &mut String, axis: usize, (x, y): (f64, f64), radius: f64) -> fmt::Result {
    let colour = COLOURS.get(axis).unwrap_or(&"black");
    let r = 1.3 * radius;
    let corners = match axis {
        1 => vec![(x, y - r), (x + r, y + r), (x - r, y + r)],
        2 => vec![(x, y - r), (x + r, y), (x, y + r), (x - r, y)],
        _ => return writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{colour}\"/>"),
    };
    let corners: Vec<String> = corners.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    writeln!(out, "<polygon points=\"{}\" fill=\"{colour}\"/>", corners.join(" "))
}

fn line(out: &mut String, [x1, y1, x2, y2]: [f64; 4], colour: &str) -> fmt::Result {
    writeln!(out, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{colour}\"/>")
}

fn polyline(out: &mut String, points: &[(f64, f64)], colour: &str, dashes: &str) -> fmt::Result {
    let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    writeln!(
        out,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-dasharray=\"{dashes}\"/>",
        points.join(" ")
    )
}

fn text(out: &mut String, x: f64, y: f64, anchor: &str, text: &str) -> fmt::Result {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>")
}

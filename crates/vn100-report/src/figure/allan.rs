//! The Allan plot: deviation over averaging time, both by decades, with an interval at each point.

use vn100_analysis::noise::{
    Claim, Deviation, STANDARD_GRAVITY_M_S2,
    Term::{BiasInstability, Quantization, RateRamp, RateRandomWalk, White},
    Verdict,
};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, FigureVerdict, Point};

use super::{
    Colour, Dash, Figure, LegendSample, PlotAxis, PlottedSeries, PlottedValue, Primitive, Shape, SlopedLine, Stroke,
    axes::Scale, fitted_model::FittedModel, plot::FLAT, solid,
};
use crate::{names::deviation_name, shortened, units::pretty_unit};

/// Letters of a name in a legend.
const MOST_LETTERS: usize = 34;

/// Each axis of a sensor, in the unit of data sheets: its curve, the fitted model, the lines of its
/// terms, what the graphical rules read. All over the same range, to be compared by eye.
pub(crate) fn allan_of_each(axes: &[&ChannelResult], deviation: Deviation) -> Vec<Figure> {
    let Some((unit, factor)) = axes.first().and_then(|first| curve_units(first.quantity).first()) else {
        return axes.iter().filter_map(|channel| axis_in(channel, &[], 1.0, deviation)).collect();
    };
    let axes: Vec<ChannelResult> = axes.iter().map(|channel| channel.in_unit(unit, *factor)).collect();
    axes.iter().filter_map(|channel| axis_in(channel, &axes, *factor, deviation)).collect()
}

/// The units of a deviation, each with its value for 1 in the unit of the channel; the one that is
/// drawn comes first. None for what is no axis of a sensor.
const fn curve_units(quantity: Quantity) -> &'static [(&'static str, f64)] {
    const DEG: f64 = 180.0 / std::f64::consts::PI;
    const MG: f64 = 1e3 / STANDARD_GRAVITY_M_S2;
    match quantity {
        Quantity::AngularRate => &[("deg/h", 3600.0 * DEG), ("deg/s", DEG), ("rad/s", 1.0)],
        Quantity::Acceleration => &[("mg", MG), ("m/s^2", 1.0)],
        Quantity::MagneticField => &[("mG", 1e3), ("gauss", 1.0), ("nT", 1e5)],
        _ => &[],
    }
}

/// With deviations that are `factor` times as large as the parameters say, over a range that has
/// room for those of `others`, too.
fn axis_in(channel: &ChannelResult, others: &[ChannelResult], factor: f64, deviation: Deviation) -> Option<Figure> {
    let model_of = |channel| FittedModel::of(channel, factor).filter(|_| deviation == Deviation::Allan);
    let model = model_of(channel);
    channel.allan.points.iter().find(|point| point.deviation > Some(0.0))?;
    let shown: Vec<&ChannelResult> = std::iter::once(channel).chain(others).collect();
    let reaches: Vec<f64> =
        (shown.iter()).filter_map(|channel| Some(model_of(channel)?.reaches(channel.octaves()))).flatten().collect();
    let (x, y) = axes(&shown, &reaches, deviation)?;
    let mut legend = vec![(LegendSample::Both(solid(0, 1.0), Shape::Disc.filled()), "measured".to_owned())];
    if let Some(model) = &model {
        model.legend(&mut legend);
    }
    let id = format!("allan-{}", id_of(&channel.name));
    let title = format!("{}: {}", channel.name, deviation_name(deviation));
    let mut plot = Figure::with_square_decades(id, title, x, y, &legend);
    if let Some(model) = &model {
        plot.draw(1, model.below(&plot));
    }
    plot.draw(0, curve(&plot, 0, &channel.allan.points));
    if let Some(model) = &model {
        model.draw_above(&mut plot, channel.octaves());
    }
    let series = vec![series(channel.name.clone(), &channel.allan.points)];
    Some(Figure { series, units: units_of(channel, false), ..plot })
}

/// The axes of one sensor together, in the unit of data sheets, beside the figures of one.
pub(crate) fn allan_of_axes(
    id: &str,
    title: &str,
    axes: &[&ChannelResult],
    verdicts: &[FigureVerdict],
    deviation: Deviation,
) -> Option<Figure> {
    let first = axes.first()?;
    let (unit, factor) = curve_units(first.quantity).first().copied().unwrap_or((&first.unit, 1.0));
    let axes: Vec<ChannelResult> = axes.iter().map(|channel| channel.in_unit(unit, factor)).collect();
    let named: Vec<_> = axes.iter().map(|channel| (channel.name.clone(), channel)).collect();
    let of_allan = verdicts.iter().filter(|_| deviation == Deviation::Allan);
    let sheet: Vec<(SlopedLine, String)> = of_allan.flat_map(|verdict| sheet_lines(verdict, factor)).collect();
    together(format!("allan-{id}"), title, &named, deviation, Some((&sheet, factor)))
}

/// A figure of the data sheet as it shows in this stream, with its text: white noise falls with the root
/// of the averaging time, and what most sheets call bias instability is the minimum of the curve. Of a
/// density of unknown sides both readings; none of a figure that this stream cannot show.
fn sheet_lines(verdict: &FigureVerdict, factor: f64) -> Vec<(SlopedLine, String)> {
    let figure = &verdict.figure;
    let (kind, is_limit) = match figure.claim {
        Claim::Limit(_) => ("max", true),
        Claim::Typical { .. } => ("typ", false),
    };
    let (slope, name, level) = match figure.term {
        White => (-0.5, "N", 1.0),
        BiasInstability if figure.is_curve_minimum() => (0.0, "B", 1.0),
        BiasInstability => (0.0, "B", FLAT),
        Quantization | RateRandomWalk | RateRamp => return Vec::new(),
    };
    if verdict.verdict == Some(Verdict::NotComparable) {
        return Vec::new();
    }
    // what aliasing is known to is no wider than this; of a figure with several readings both ends
    const ONE: f64 = 1.5;
    let (low, high) = verdict.expected;
    let line = |end: f64, which: &str| {
        let line = SlopedLine { tau_s: 1.0, deviation: end * level * factor, slope, dash: Dash::Mixed };
        (line, format!("data sheet {name} {kind}{which}"))
    };
    match (is_limit, high > ONE * low) {
        (true, _) => vec![line(low, "")],
        (false, false) => vec![line(f64::midpoint(low, high), "")],
        (false, true) => vec![line(low, ", least"), line(high, ", most")],
    }
}

/// One channel of several records, each under its name.
pub(crate) fn allan_of_records(
    channel: &str,
    records: &[(String, &ChannelResult)],
    deviation: Deviation,
) -> Option<Figure> {
    let (_, first) = records.first()?;
    let drawn: Vec<(String, ChannelResult)> = match curve_units(first.quantity).first() {
        Some((unit, factor)) => {
            records.iter().map(|(name, channel)| (name.clone(), channel.in_unit(unit, *factor))).collect()
        }
        None => records.iter().map(|(name, channel)| (name.clone(), (*channel).clone())).collect(),
    };
    let drawn: Vec<_> = drawn.iter().map(|(name, channel)| (name.clone(), channel)).collect();
    together(format!("records-{}", id_of(channel)), channel, &drawn, deviation, None)
}

/// Of those that have a curve: what is read from registers now and then has none. `of_sensor`: the
/// figures of its data sheet, and what its parameters are to be multiplied by, of the axes of one
/// sensor; each is then given with its N, B and K.
fn together(
    id: String,
    title: &str,
    curves: &[(String, &ChannelResult)],
    deviation: Deviation,
    of_sensor: Option<(&[(SlopedLine, String)], f64)>,
) -> Option<Figure> {
    let curves: Vec<_> = curves.iter().filter(|(_, channel)| !channel.allan.points.is_empty()).collect();
    let channels: Vec<_> = curves.iter().map(|(_, channel)| *channel).collect();
    let (x, y) = axes(&channels, &[], deviation)?;
    let (sheet, factor) = of_sensor.unwrap_or((&[], 1.0));
    let model =
        |channel| FittedModel::of(channel, factor).filter(|_| of_sensor.is_some() && deviation == Deviation::Allan);
    let models: Vec<_> = channels.iter().map(|channel| model(*channel)).collect();
    let legend: Vec<_> = (curves.iter().zip(&models).enumerate())
        .map(|(index, ((name, _), model))| {
            let values = model.as_ref().map_or_else(Vec::new, FittedModel::values);
            let values = if values.is_empty() { String::new() } else { format!(": {}", values.join(", ")) };
            (
                LegendSample::Both(connecting(index), Shape::of_series(index).filled()),
                shortened(name, MOST_LETTERS) + &values,
            )
        })
        .collect();
    let title = format!("{title}: {}", deviation_name(deviation));
    let mut plot = Figure::with_square_decades(id, title, x, y, &legend);
    plot.draw(channels.len(), sheet.iter().map(|(line, _)| line.drawn(&plot, Colour::Quiet, 1.0)).collect());
    for (index, channel) in channels.iter().enumerate() {
        plot.draw(index, curve(&plot, index, &channel.allan.points));
    }
    for (index, (model, (name, _))) in models.iter().zip(&curves).enumerate() {
        if let Some(model) = model {
            model.draw_among(&mut plot, index, name);
        }
    }
    // level ones first, which have room at the left alone
    let (level, sloped): (Vec<_>, Vec<_>) = sheet.iter().partition(|(line, _)| line.slope == 0.0);
    for (line, text) in level.into_iter().chain(sloped) {
        plot.label(channels.len(), &line.along(&plot), text);
    }
    let series = curves.iter().map(|(name, channel)| series(name.clone(), &channel.allan.points)).collect();
    Some(Figure { series, units: units_of(channels[0], sheet.is_empty()), ..plot })
}

/// The units to choose from where a curve is drawn in the first of them.
fn units_of(channel: &ChannelResult, is_plain: bool) -> Vec<(String, f64)> {
    let units = curve_units(channel.quantity);
    let drawn = units.iter().find(|(unit, _)| *unit == channel.unit);
    let Some((_, drawn)) = drawn.filter(|_| !is_plain || units.len() > 1) else { return Vec::new() };
    units.iter().map(|(unit, factor)| (pretty_unit(unit), factor / drawn)).collect()
}

/// Both sides, around the deviations, their intervals and `more`.
pub(super) fn axes(channels: &[&ChannelResult], more: &[f64], deviation: Deviation) -> Option<(PlotAxis, PlotAxis)> {
    let first = channels.first()?;
    let points =
        || channels.iter().flat_map(|channel| &channel.allan.points).filter(|point| point.deviation > Some(0.0));
    points().next()?;
    let reaches = points().flat_map(|point| {
        let (lower, upper) = interval(point).unzip();
        [point.deviation, lower, upper].into_iter().flatten()
    });
    let x = PlotAxis::new("averaging time τ", "s", Scale::around(points().map(|point| point.tau_s), true));
    let y = PlotAxis::new(
        deviation_name(deviation),
        pretty_unit(&first.unit),
        Scale::around(reaches.chain(more.iter().copied()), true),
    );
    Some((x, y))
}

/// More points are lines: the deviation, and the ends of its intervals.
const MOST_MARKED: usize = 100;

pub(super) fn curve(plot: &Figure, index: usize, points: &[Point]) -> Vec<Primitive> {
    const CAP: f64 = 3.0;
    let places = |is_known: bool| {
        let shown = points.iter().filter(move |point| point.is_known() == is_known);
        shown.filter_map(|point| Some((point.tau_s, point.deviation.filter(|value| *value > 0.0)?)))
    };
    let known: Vec<(f64, f64)> = places(true).collect();
    let mut marks = vec![plot.line(known.iter().copied(), connecting(index))];
    // of so few degrees of freedom that a line to them would show a rise or a fall that is none
    let hollow = Shape::of_series(index).hollow();
    marks.extend(places(false).map(|(tau_s, deviation)| plot.symbol(tau_s, deviation, hollow, Colour::Quiet)));
    if points.len() > MOST_MARKED {
        let bounds = || points.iter().filter_map(|point| Some((point.tau_s, interval(point)?)));
        marks.push(plot.line(bounds().map(|(tau_s, (lower, _))| (tau_s, lower)), solid(index, 0.5)));
        marks.push(plot.line(bounds().map(|(tau_s, (_, upper))| (tau_s, upper)), solid(index, 0.5)));
        return marks;
    }
    for (point, (lower, upper)) in points.iter().filter_map(|point| Some((point, interval(point)?))) {
        let (x, low) = plot.place(point.tau_s, lower);
        let (_, high) = plot.place(point.tau_s, upper);
        for points in
            [vec![(x, low), (x, high)], vec![(x - CAP, low), (x + CAP, low)], vec![(x - CAP, high), (x + CAP, high)]]
        {
            marks.push(Primitive::Line { points, stroke: solid(index, 1.1) });
        }
    }
    marks.extend(known.iter().map(|(x, y)| plot.symbol_of(index, *x, *y)));
    marks
}

/// As far as its interval is finite.
fn interval(point: &Point) -> Option<(f64, f64)> {
    point.lower.zip(point.upper).filter(|_| point.is_known())
}

fn connecting(index: usize) -> Stroke {
    Stroke { colour: Colour::Series(index), width: 1.0, dash: Dash::of_series(index) }
}

pub(super) fn series(name: String, points: &[Point]) -> PlottedSeries {
    let value =
        |point: &Point| Some(PlottedValue { x: point.tau_s, y: point.deviation?, reach: point.lower.zip(point.upper) });
    PlottedSeries { name, values: points.iter().filter_map(value).collect() }
}

/// The name of a channel as it stands in [`Figure::id`]: ASCII letters, digits, `-` and `_` stay,
/// any other character becomes `_`.
pub fn id_of(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect()
}

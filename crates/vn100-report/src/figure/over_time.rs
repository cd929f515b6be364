//! The record over time: for each block of it the range of its samples, its mean, and one standard
//! deviation on either side; and the standard deviation alone of all axes of a sensor.

use super::{
    Colour, Dash, Figure, LegendSample, PlotAxis, PlottedSeries, PlottedValue, Primitive, Shape, Stroke, allan::id_of,
    axes::Scale, solid,
};
use crate::units::pretty_unit;
use vn100_analysis::{BlockValues, ChannelResult, History};

/// A channel over the time of its record. `None` without blocks.
pub(crate) fn envelope(channel: &ChannelResult) -> Option<Figure> {
    let blocks = channel.blocks();
    let last = blocks.last()?;
    let time = time_unit(last.start_s + last.duration_s);
    let id = format!("time-{}", id_of(&channel.name));
    Some(bands(id, format!("{}: time plot", channel.name), ("time", time), (&channel.name, &channel.unit), blocks))
}

/// The range and the mean of the recent samples of the channel `name`, in its `unit`, over the time
/// until the last one. `None` without a sample in these minutes.
pub fn last_minutes(name: &str, unit: &str, history: &History) -> Option<Figure> {
    let blocks: Vec<BlockValues> = history.columns.iter().copied().flatten().collect();
    let (id, title) = (format!("signal-{}", id_of(name)), format!("{name}: the last minutes"));
    let along = ("time until the last sample", ("s", 1.0));
    (!blocks.is_empty()).then(|| bands(id, title, along, (name, unit), &blocks))
}

/// The range of the samples of each block, their mean, and one standard deviation on either side where
/// it is known; `along` names the axis along, with its unit and the seconds of one.
fn bands(
    id: String,
    title: String,
    along: (&str, (&'static str, f64)),
    (name, unit): (&str, &str),
    blocks: &[BlockValues],
) -> Figure {
    let (along, (time, unit_s)) = along;
    let start = |block: &BlockValues| block.start_s / unit_s;
    let end = |block: &BlockValues| (block.start_s + block.duration_s) / unit_s;
    let x =
        PlotAxis::new(along, time, Scale::around(blocks.iter().flat_map(|block| [start(block), end(block)]), false));
    let y = PlotAxis::new(
        name,
        pretty_unit(unit),
        Scale::around(blocks.iter().flat_map(|block| [block.min, block.max]), false),
    );
    let mut legend = vec![(LegendSample::Area(Colour::Series(0), 0.25), "min to max".to_owned())];
    if blocks.iter().any(|block| block.std.is_some()) {
        legend.push((LegendSample::Area(Colour::Series(0), 0.6), "mean ± std".to_owned()));
    }
    legend.push((LegendSample::Line(solid(1, 1.6)), "mean".to_owned()));
    let mut plot = Figure::new(id, title, x, y, &legend);
    let band = |run: &[BlockValues], opacity, range: &dyn Fn(&BlockValues) -> (f64, f64)| {
        let upper = run.iter().flat_map(|block| [start(block), end(block)].map(|x| (x, range(block).1)));
        let lower = run.iter().rev().flat_map(|block| [end(block), start(block)].map(|x| (x, range(block).0)));
        let points = upper.chain(lower).map(|(x, y)| plot.place(x, y)).collect();
        Primitive::Area { points, colour: Colour::Series(0), opacity }
    };
    let mut marks = Vec::new();
    for run in without_gaps(blocks) {
        let std = |block: &BlockValues| block.std.unwrap_or(0.0);
        marks.push(band(run, 0.25, &|block| (block.min, block.max)));
        if run.iter().any(|block| block.std.is_some()) {
            marks.push(band(run, 0.35, &|block| (block.mean - std(block), block.mean + std(block))));
        }
        let steps = run.iter().flat_map(|block| [(start(block), block.mean), (end(block), block.mean)]);
        marks.push(plot.line(steps, solid(1, 1.6)));
    }
    plot.draw(0, marks);
    let value = |block: &BlockValues| PlottedValue {
        x: (start(block) + end(block)) / 2.0,
        y: block.mean,
        reach: Some((block.min, block.max)),
    };
    plot.series = vec![PlottedSeries { name: "mean, min to max".into(), values: blocks.iter().map(value).collect() }];
    plot
}

/// The runs of blocks without a gap: nothing is drawn across one.
fn without_gaps(blocks: &[BlockValues]) -> impl Iterator<Item = &[BlockValues]> {
    blocks.chunk_by(|a, b| b.start_s - a.start_s <= 1.5 * a.duration_s)
}

/// The unit for the length of a record, and its seconds.
fn time_unit(length_s: f64) -> (&'static str, f64) {
    match length_s {
        ..600.0 => ("s", 1.0),
        ..18_000.0 => ("min", 60.0),
        _ => ("h", 3600.0),
    }
}

/// `None` without segments of two samples.
pub(crate) fn segments(id: &str, title: &str, channels: &[&ChannelResult]) -> Option<Figure> {
    let of_channels: Vec<&[BlockValues]> = channels.iter().map(|channel| channel.blocks()).collect();
    let end_s = of_channels.iter().copied().flatten().map(|block| block.start_s + block.duration_s).fold(0.0, f64::max);
    let (unit, unit_s) = time_unit(end_s);
    let middle = |block: &BlockValues| (block.start_s + block.duration_s / 2.0) / unit_s;
    let points =
        |run: &[BlockValues]| run.iter().filter_map(|block| Some((middle(block), block.std?))).collect::<Vec<_>>();
    let curves: Vec<Vec<(f64, f64)>> = of_channels.iter().map(|blocks| points(blocks)).collect();
    let first = channels.first().filter(|_| curves.iter().any(|points| !points.is_empty()))?;
    let x = PlotAxis::new("time", unit, Scale::around(curves.iter().flatten().map(|(x, _)| *x), false));
    let highest = curves.iter().flatten().map(|(_, std)| *std).fold(0.0, f64::max);
    let y = PlotAxis::new(
        "standard deviation",
        pretty_unit(&first.unit),
        Scale { from: 0.0, to: if highest > 0.0 { 1.08 * highest } else { 1.0 }, log: false },
    );
    let stroke = |index| Stroke { colour: Colour::Series(index), width: 1.2, dash: Dash::of_series(index) };
    let legend: Vec<_> = (channels.iter().enumerate())
        .map(|(index, channel)| {
            (LegendSample::Both(stroke(index), Shape::of_series(index).filled()), channel.name.clone())
        })
        .collect();
    let mut plot = Figure::new(format!("segments-{id}"), format!("{title}: deviation per segment"), x, y, &legend);
    for (index, blocks) in of_channels.iter().enumerate() {
        let lines = without_gaps(blocks).flat_map(|run| plot.marked_line(index, &points(run), stroke(index)));
        plot.draw(index, lines.collect());
    }
    let series = channels.iter().zip(&curves).map(|(channel, points)| PlottedSeries::of(&channel.name, points));
    plot.series = series.collect();
    Some(plot)
}

//! The histogram, and the normal curve of the same mean, deviation and area.

use std::f64::consts::TAU;
use vn100_analysis::{ChannelResult, noise::HistogramBars};

use super::{
    Colour, Figure, LegendSample, PlotAxis, PlottedSeries, PlottedValue, Primitive, allan::id_of, axes::Scale, solid,
};
use crate::units::pretty_unit;

/// `None` without samples.
pub(crate) fn histogram(channel: &ChannelResult) -> Option<Figure> {
    let HistogramBars { first, width, counts } = channel.statistics.histogram.as_ref()?;
    let edge = |bar: usize| first + width * bar as f64;
    let total = counts.iter().sum::<u64>() as f64;
    let normal = channel.statistics.mean.zip(channel.statistics.std.filter(|std| *std > 0.0));
    let expected = |x: f64| {
        let (mean, std) = normal?;
        Some(total * width / (std * TAU.sqrt()) * (-(x - mean).powi(2) / (2.0 * std * std)).exp())
    };
    let highest = counts.iter().copied().max().unwrap_or(0) as f64;
    let top = normal.and_then(|(mean, _)| expected(mean)).unwrap_or(0.0).max(highest);
    let x = PlotAxis::new(
        &channel.name,
        pretty_unit(&channel.unit),
        Scale::around([edge(0), edge(counts.len())].into_iter(), false),
    );
    let y = PlotAxis::new("samples per bin", "", Scale { from: 0.0, to: 1.06 * top.max(1.0), log: false });
    let mut legend = vec![(LegendSample::Area(Colour::Series(0), 0.5), "measured".to_owned())];
    if normal.is_some() {
        legend.push((LegendSample::Line(solid(1, 1.8)), "Gaussian, same mean and std".to_owned()));
    }
    let id = format!("histogram-{}", id_of(&channel.name));
    let mut plot = Figure::new(id, format!("{}: histogram", channel.name), x, y, &legend);
    let bars = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    let corners =
        |bar: usize, count: f64| [(edge(bar), 0.0), (edge(bar), count), (edge(bar + 1), count), (edge(bar + 1), 0.0)];
    let marks = bars.map(|(bar, count)| Primitive::Area {
        points: corners(bar, *count as f64).iter().map(|(x, y)| plot.place(*x, *y)).collect(),
        colour: Colour::Series(0),
        opacity: 0.5,
    });
    plot.draw(0, marks.collect());
    if normal.is_some() {
        const STEPS: usize = 120;
        let Scale { from, to, .. } = plot.x.scale;
        let places = (0..=STEPS).map(|step| from + (to - from) * step as f64 / STEPS as f64);
        plot.draw(1, vec![plot.line(places.filter_map(|x| Some((x, expected(x)?))), solid(1, 1.8))]);
    }
    let values = counts.iter().enumerate().map(|(bar, count)| PlottedValue {
        x: edge(bar) + width / 2.0,
        y: *count as f64,
        reach: None,
    });
    plot.series = vec![PlottedSeries { name: "samples".into(), values: values.collect() }];
    Some(plot)
}

//! The last minutes of a channel: the range of the samples and their mean, up to now.

use super::{
    Colour, Figure, LegendSample, Plot, PlotAxis, PlottedSeries, PlottedValue, Primitive, allan::id_of, axes::Scale,
    solid,
};
use crate::units::pretty_unit;
use vn100_analysis::{History, HistoryColumn};

/// The range and the mean of the recent samples of the channel `name`, in its `unit`, over the time
/// until the last one. `None` without a sample in these minutes.
pub(super) fn last_minutes(name: &str, unit: &str, history: &History) -> Option<Figure> {
    let History { columns, column_s } = history;
    let known = || columns.iter().flatten();
    known().next()?;
    let length_s = columns.len() as f64 * column_s;
    let start = |place: usize| place as f64 * column_s - length_s;
    let x = PlotAxis::new("time until the last sample", "s", Scale { from: -length_s, to: 0.0, log: false });
    let y = PlotAxis::new(
        name,
        pretty_unit(unit),
        Scale::around(known().flat_map(|column| [column.min, column.max]), false),
    );
    let legend = [
        (LegendSample::Area(Colour::Series(0), 0.3), "min to max".to_owned()),
        (LegendSample::Line(solid(1, 1.4)), "mean".to_owned()),
    ];
    let mut plot = Plot::new(format!("signal-{}", id_of(name)), format!("{name}: the last minutes"), x, y, &legend);
    let placed: Vec<(usize, Option<HistoryColumn>)> = columns.iter().copied().enumerate().collect();
    let mut marks = Vec::new();
    // nothing is drawn across a gap
    for run in placed.chunk_by(|(_, a), (_, b)| a.is_some() == b.is_some()) {
        let run: Vec<(f64, HistoryColumn)> =
            run.iter().filter_map(|(place, column)| Some((start(*place), (*column)?))).collect();
        if run.is_empty() {
            continue;
        }
        let upper = run.iter().flat_map(|(at, column)| [(*at, column.max), (at + column_s, column.max)]);
        let lower = run.iter().rev().flat_map(|(at, column)| [(at + column_s, column.min), (*at, column.min)]);
        let points = upper.chain(lower).map(|(x, y)| plot.place.of(x, y)).collect();
        marks.push(Primitive::Area { points, colour: Colour::Series(0), opacity: 0.3 });
        let steps = run.iter().flat_map(|(at, column)| [(*at, column.mean), (at + column_s, column.mean)]);
        marks.push(plot.line(steps, solid(1, 1.4)));
    }
    plot.draw(0, marks);
    let value = |(place, column): (usize, &Option<HistoryColumn>)| {
        let column = (*column)?;
        Some(PlottedValue { x: start(place) + column_s / 2.0, y: column.mean, reach: Some((column.min, column.max)) })
    };
    let values = columns.iter().enumerate().filter_map(value).collect();
    Some(plot.done(vec![PlottedSeries { name: "mean, min to max".into(), values }]))
}

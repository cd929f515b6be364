//! The standard deviation of each segment of the record: whether it was as quiet all the time.

use super::{
    Axis, Colour, Dash, DrawingError, Figure, Plot, Sample, Series, Shape, Stroke, Value, axes::Scale,
    envelope::TimeUnit, pretty_unit,
};
use crate::units::{BlockValues, ChannelValues};

/// `None` without segments of two samples. Times are of the data; `skipped_s` lie before the first.
pub(crate) fn segments(
    id: &str,
    title: &str,
    channels: &[&ChannelValues],
    skipped_s: f64,
) -> Result<Option<Figure>, DrawingError> {
    let blocks = |channel: &&ChannelValues| channel.signal.as_ref().map_or(&[][..], |signal| &signal.blocks).to_vec();
    let of_channels: Vec<Vec<BlockValues>> = channels.iter().map(blocks).collect();
    let end_s = of_channels.iter().flatten().map(|block| block.start_s + block.duration_s).fold(0.0, f64::max);
    let unit = TimeUnit::for_record(skipped_s + end_s);
    let middle = |block: &BlockValues| (skipped_s + block.start_s + block.duration_s / 2.0) / unit.seconds;
    let curves: Vec<Vec<(f64, f64)>> = (of_channels.iter())
        .map(|blocks| blocks.iter().filter_map(|block| Some((middle(block), block.std?))).collect())
        .collect();
    let Some(first) = channels.first().filter(|_| curves.iter().any(|points| !points.is_empty())) else {
        return Ok(None);
    };
    let x = Axis {
        name: "time".into(),
        unit: unit.name.into(),
        scale: Scale::around(curves.iter().flatten().map(|(x, _)| *x), false),
    };
    let highest = curves.iter().flatten().map(|(_, std)| *std).fold(0.0, f64::max);
    let y = Axis {
        name: "standard deviation".into(),
        unit: pretty_unit(&first.unit),
        scale: Scale::Linear { from: 0.0, to: if highest > 0.0 { 1.08 * highest } else { 1.0 } },
    };
    let stroke = |index| Stroke { colour: Colour::Series(index), width: 1.2, dash: Dash::of_series(index) };
    let legend: Vec<_> = (channels.iter().enumerate())
        .map(|(index, channel)| (Sample::Both(stroke(index), Shape::of_series(index)), channel.name.clone()))
        .collect();
    let mut plot = Plot::new(format!("segments-{id}"), format!("{title}: deviation per segment"), x, y, &legend)?;
    for (index, points) in curves.iter().enumerate() {
        let mut marks = vec![plot.line(points.iter().copied(), stroke(index))];
        let symbol = |(x, y): &(f64, f64)| plot.symbol(*x, *y, Shape::of_series(index), Colour::Series(index));
        marks.extend(points.iter().map(symbol));
        plot.draw(index, marks);
    }
    let series = channels.iter().zip(&curves).map(|(channel, points)| Series {
        name: channel.name.clone(),
        values: points.iter().map(|(x, y)| Value { x: *x, y: *y, reach: None }).collect(),
    });
    let series = series.collect();
    Ok(Some(plot.done(series)))
}

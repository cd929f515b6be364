//! The record over time: for each block of it the range of its samples, its mean, and one standard
//! deviation on either side.

use super::{
    Axis, Colour, DrawingError, Figure, Mark, Plot, Sample, Series, Value, allan::id_of, axes::Scale, pretty_unit,
    solid,
};
use crate::units::{BlockValues, ChannelValues};

/// `None` without blocks. Times are of the data; `skipped_s` lie before the first.
pub(crate) fn envelope(channel: &ChannelValues, skipped_s: f64) -> Result<Option<Figure>, DrawingError> {
    let blocks = channel.signal.as_ref().map_or(&[][..], |signal| &signal.blocks);
    let Some(last) = blocks.last() else { return Ok(None) };
    let unit = TimeUnit::for_record(skipped_s + last.start_s + last.duration_s);
    let start = |block: &BlockValues| (skipped_s + block.start_s) / unit.seconds;
    let end = |block: &BlockValues| (skipped_s + block.start_s + block.duration_s) / unit.seconds;
    let x = Axis {
        name: "time".into(),
        unit: unit.name.into(),
        scale: Scale::around(blocks.iter().flat_map(|block| [start(block), end(block)]), false),
    };
    let y = Axis {
        name: channel.name.clone(),
        unit: pretty_unit(&channel.unit),
        scale: Scale::around(blocks.iter().flat_map(|block| [block.min, block.max]), false),
    };
    let legend = [
        (Sample::Area(Colour::Series(0), 0.25), "smallest to largest".to_owned()),
        (Sample::Area(Colour::Series(0), 0.6), "mean ± std".to_owned()),
        (Sample::Line(solid(1, 1.6)), "mean".to_owned()),
    ];
    let id = format!("time-{}", id_of(&channel.name));
    let mut plot = Plot::new(id, format!("{}: time plot", channel.name), x, y, &legend)?;
    let mut marks = Vec::new();
    // nothing is drawn across a gap
    for run in blocks.chunk_by(|a, b| b.start_s - a.start_s <= 1.5 * a.duration_s) {
        let std = |block: &BlockValues| block.std.unwrap_or(0.0);
        marks.push(band(&plot, run, start, end, |block| (block.min, block.max), 0.25));
        marks.push(band(&plot, run, start, end, |block| (block.mean - std(block), block.mean + std(block)), 0.35));
        let steps = run.iter().flat_map(|block| [(start(block), block.mean), (end(block), block.mean)]);
        marks.push(plot.line(steps, solid(1, 1.6)));
    }
    plot.draw(0, marks);
    let value = |block: &BlockValues| Value {
        x: (start(block) + end(block)) / 2.0,
        y: block.mean,
        reach: Some((block.min, block.max)),
    };
    Ok(Some(
        plot.done(vec![Series {
            name: "mean, smallest to largest".into(),
            values: blocks.iter().map(value).collect(),
        }]),
    ))
}

fn band(
    plot: &Plot,
    run: &[BlockValues],
    start: impl Fn(&BlockValues) -> f64,
    end: impl Fn(&BlockValues) -> f64,
    range: impl Fn(&BlockValues) -> (f64, f64),
    opacity: f64,
) -> Mark {
    let upper = run.iter().flat_map(|block| [start(block), end(block)].map(|x| (x, range(block).1)));
    let lower = run.iter().rev().flat_map(|block| [end(block), start(block)].map(|x| (x, range(block).0)));
    let points = upper.chain(lower).map(|(x, y)| plot.place.of(x, y)).collect();
    Mark::Area { points, colour: Colour::Series(0), opacity }
}

/// What people would say the length of a record in.
pub(super) struct TimeUnit {
    pub(super) name: &'static str,
    pub(super) seconds: f64,
}

impl TimeUnit {
    pub(super) fn for_record(length_s: f64) -> Self {
        match length_s {
            ..600.0 => Self { name: "s", seconds: 1.0 },
            ..18_000.0 => Self { name: "min", seconds: 60.0 },
            _ => Self { name: "h", seconds: 3600.0 },
        }
    }
}

//! The amplitude spectral density of the axes of one sensor, and the lines that stand out of it.

use anyhow::Result;

use super::{Axis, Colour, Dash, Figure, Plot, Sample, Series, Shape, Stroke, Value, axes::Scale, pretty_unit};
use crate::{report::findings::shakes, units::ChannelValues};

/// Logarithm of the ratio of frequencies that belong to one line, and of those whose numbers would lie on each other.
const SAME: f64 = 0.03;
const APART: f64 = 0.12;

/// Lines with a number beside them.
const MOST_TOLD: usize = 6;

/// `None` where the record is too short for one. The density is one-sided.
pub(crate) fn spectrum(id: &str, title: &str, channels: &[&ChannelValues]) -> Result<Option<Figure>> {
    let curves: Vec<(&ChannelValues, Vec<(f64, f64)>)> = (channels.iter())
        .filter_map(|channel| {
            let density = channel.signal.as_ref()?.density.as_ref()?;
            // the first point lost part of its power with the mean of each segment
            let points = density.points.iter().skip(1);
            let amplitudes = points.map(|point| (point.frequency_hz, point.density_unit2_hz.sqrt()));
            Some((*channel, amplitudes.filter(|(_, amplitude)| *amplitude > 0.0).collect()))
        })
        .collect();
    let all = || curves.iter().flat_map(|(_, points)| points);
    let Some((first, _)) = curves.first().filter(|_| all().next().is_some()) else { return Ok(None) };
    let x = Axis {
        name: "frequency".into(),
        unit: "Hz".into(),
        scale: Scale::around(all().map(|(frequency, _)| *frequency), true),
    };
    let y = Axis {
        name: "amplitude density".into(),
        unit: format!("{}/√Hz", pretty_unit(&first.unit)),
        scale: Scale::around(all().map(|(_, amplitude)| *amplitude), true),
    };
    let stroke = |index| Stroke { colour: Colour::Series(index), width: 1.1, dash: Dash::Solid };
    let legend: Vec<_> = (curves.iter().enumerate())
        .map(|(index, (channel, _))| (Sample::Line(stroke(index)), channel.name.clone()))
        .collect();
    let mut plot = Plot::new(format!("spectrum-{id}"), format!("{title}: spectrum, one-sided"), x, y, &legend)?;
    let mut told: Vec<f64> = Vec::new();
    for (index, (channel, points)) in curves.iter().enumerate() {
        let mut marks = vec![plot.line(points.iter().copied(), stroke(index))];
        let lines = channel.signal.as_ref().map_or_else(Vec::new, |signal| shakes(&signal.disturbed.lines));
        for (hz, _) in lines {
            let near = points.iter().copied().filter(|(frequency, _)| (frequency / hz).ln().abs() < SAME);
            let Some((frequency, amplitude)) = near.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            marks.push(plot.symbol(frequency, amplitude, Shape::of_series(index), Colour::Series(index)));
            // the same line on another axis is not told again, and the strongest leave room for few others
            if told.len() < MOST_TOLD && told.iter().all(|other| (other / hz).ln().abs() > APART) {
                marks.push(plot.note(frequency, amplitude, format!("{hz:.1} Hz")));
                told.push(hz);
            }
        }
        plot.draw(index, marks);
    }
    let series = |(channel, points): &(&ChannelValues, Vec<(f64, f64)>)| Series {
        name: channel.name.clone(),
        values: points.iter().map(|(x, y)| Value { x: *x, y: *y, reach: None }).collect(),
    };
    let series = curves.iter().map(series).collect();
    Ok(Some(plot.done(series)))
}

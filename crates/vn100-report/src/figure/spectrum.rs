//! The amplitude spectral density of the axes of one sensor, and its peaks.

use super::{Colour, Figure, LegendSample, Marker, Plot, PlotAxis, PlottedSeries, Rectangle, axes::Scale, solid};
use crate::units::pretty_unit;
use vn100_analysis::ChannelResult;

/// Logarithm of the ratio of frequencies of one line.
const SAME: f64 = 0.03;

/// Peaks with a number beside them.
const MOST_LABELS: usize = 6;

/// `None` if the record is too short for one. The density is one-sided.
pub(crate) fn spectrum(id: &str, title: &str, channels: &[&ChannelResult]) -> Option<Figure> {
    let curves: Vec<(&ChannelResult, Vec<(f64, f64)>)> = (channels.iter())
        .filter_map(|channel| {
            // the first point lost part of its power with the mean of each segment
            let points = channel.spectrum.as_ref().filter(|spectrum| !spectrum.density.is_empty())?.points().skip(1);
            let amplitudes = points.map(|(frequency_hz, density)| (frequency_hz, density.sqrt()));
            Some((*channel, amplitudes.filter(|(_, amplitude)| *amplitude > 0.0).collect()))
        })
        .collect();
    let all = || curves.iter().flat_map(|(_, points)| points);
    let (first, _) = curves.first().filter(|_| all().next().is_some())?;
    let x = PlotAxis::new("frequency", "Hz", Scale::around(all().map(|(frequency, _)| *frequency), true));
    let y = PlotAxis::new(
        "amplitude density",
        format!("{}/√Hz", pretty_unit(&first.unit)),
        Scale::around(all().map(|(_, amplitude)| *amplitude), true),
    );
    let legend: Vec<_> = (curves.iter().enumerate())
        .map(|(index, (channel, _))| (LegendSample::Line(solid(index, 1.1)), channel.name.clone()))
        .collect();
    let mut plot = Plot::new(format!("spectrum-{id}"), format!("{title}: spectrum, one-sided"), x, y, &legend);
    let mut peaks: Vec<Peak> =
        curves.iter().enumerate().flat_map(|(series, (channel, points))| peaks_of(series, channel, points)).collect();
    peaks.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let symbols: Vec<Rectangle> = peaks.iter().map(|peak| plot.symbol_room(peak.frequency, peak.amplitude)).collect();
    let mut labelled: Vec<(f64, Rectangle)> = Vec::new();
    for peak in &mut peaks {
        // at its highest, and not again on another axis nor over another number or symbol
        let room = plot.note_room(peak.frequency, peak.amplitude, &peak.label());
        if symbols.iter().any(|symbol| room.overlaps(symbol)) {
            continue;
        }
        let is_free = |(hz, other): &(f64, Rectangle)| (hz / peak.hz).ln().abs() > SAME && !room.overlaps(other);
        peak.is_labelled = labelled.len() < MOST_LABELS && labelled.iter().all(is_free);
        labelled.extend(peak.is_labelled.then_some((peak.hz, room)));
    }
    for (index, (_, points)) in curves.iter().enumerate() {
        let mut marks = vec![plot.line(points.iter().copied(), solid(index, 1.1))];
        for peak in peaks.iter().filter(|peak| peak.series == index) {
            let (frequency, amplitude) = (peak.frequency, peak.amplitude);
            marks.push(plot.symbol(frequency, amplitude, Marker::of_series(index), Colour::Series(index)));
            marks.extend(peak.is_labelled.then(|| plot.note(frequency, amplitude, peak.label())));
        }
        plot.draw(index, marks);
    }
    let series = curves.iter().map(|(channel, points)| PlottedSeries::of(&channel.name, points));
    Some(plot.done(series.collect()))
}

struct Peak {
    series: usize,
    hz: f64,
    /// Of the nearby point of the curve that is highest.
    frequency: f64,
    amplitude: f64,
    is_labelled: bool,
}

impl Peak {
    fn label(&self) -> String {
        format!("{:.1} Hz", self.hz)
    }
}

fn peaks_of(series: usize, channel: &ChannelResult, points: &[(f64, f64)]) -> Vec<Peak> {
    let lines = channel.vibrations();
    let peak = |(hz, _): (f64, f64)| {
        let near = points.iter().copied().filter(|(frequency, _)| (frequency / hz).ln().abs() < SAME);
        let (frequency, amplitude) = near.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Peak { series, hz, frequency, amplitude, is_labelled: false })
    };
    lines.into_iter().filter_map(peak).collect()
}

//! The amplitude spectral density of the axes of one sensor, and its peaks.

use super::{Figure, LegendSample, PlotAxis, PlottedSeries, axes::Scale, solid};
use crate::units::pretty_unit;
use vn100_analysis::ChannelResult;

/// Logarithm of the ratio of frequencies of one line.
const SAME: f64 = 0.03;

/// Peaks with a number beside them.
const MOST_LABELS: usize = 6;

/// The one-sided amplitude densities of the axes of a sensor, which the title names. `None` if the record
/// is too short for one.
pub fn spectrum(id: &str, title: &str, channels: &[&ChannelResult]) -> Option<Figure> {
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
    let mut plot = Figure::new(format!("spectrum-{id}"), format!("{title}: spectrum, one-sided"), x, y, &legend);
    let mut peaks: Vec<Peak> =
        curves.iter().enumerate().flat_map(|(series, (channel, points))| peaks_of(series, channel, points)).collect();
    peaks.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    for (index, (_, points)) in curves.iter().enumerate() {
        let of_curve = peaks.iter().filter(|peak| peak.series == index);
        let symbol = |peak: &Peak| plot.symbol_of(index, peak.frequency, peak.amplitude);
        let line = plot.line(points.iter().copied(), solid(index, 1.1));
        plot.draw(index, [line].into_iter().chain(of_curve.map(symbol)).collect());
    }
    let mut labelled: Vec<f64> = Vec::new();
    for peak in &peaks {
        // at its highest, and not again on another axis
        let is_new = labelled.iter().all(|hz| (hz / peak.hz).ln().abs() > SAME);
        if labelled.len() < MOST_LABELS && is_new {
            labelled.push(peak.hz);
            plot.label(peak.series, &[(peak.frequency, peak.amplitude)], &format!("{:.1} Hz", peak.hz));
        }
    }
    plot.series = curves.iter().map(|(channel, points)| PlottedSeries::of(&channel.name, points)).collect();
    Some(plot)
}

struct Peak {
    series: usize,
    hz: f64,
    /// Of the nearby point of the curve that is highest.
    frequency: f64,
    amplitude: f64,
}

fn peaks_of(series: usize, channel: &ChannelResult, points: &[(f64, f64)]) -> Vec<Peak> {
    let lines = channel.vibrations();
    let peak = |(hz, _): (f64, f64)| {
        let near = points.iter().copied().filter(|(frequency, _)| (frequency / hz).ln().abs() < SAME);
        let (frequency, amplitude) = near.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Peak { series, hz, frequency, amplitude })
    };
    lines.into_iter().filter_map(peak).collect()
}

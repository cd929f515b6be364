//! The drift of each angle over the length of a coast after a rest as long.

use vn100_analysis::{ChannelResult, angle_drift};

use crate::numbers::trimmed;

use super::{Figure, LegendSample, PlotAxis, PlottedSeries, Shape, axes::Scale, solid};

/// Half the width of the interval of one drift, at the level of the curves, at each octave. `None` if no
/// axis has a drift.
pub(crate) fn drift(axes: &[&ChannelResult]) -> Option<Figure> {
    let curve = |axis: &ChannelResult| -> Vec<(f64, f64)> {
        let within = |coast_s| Some((coast_s, angle_drift(axis, coast_s)?.half_width(axis.allan.confidence)?));
        axis.octaves().iter().filter_map(|point| within(point.tau_s)).collect()
    };
    let curves: Vec<(&ChannelResult, Vec<(f64, f64)>)> = axes.iter().map(|axis| (*axis, curve(axis))).collect();
    let all = || curves.iter().flat_map(|(_, points)| points);
    let (first, _) = curves.first().filter(|_| all().next().is_some())?;
    let x = PlotAxis::new("coast, after a rest as long", "s", Scale::around(all().map(|(coast_s, _)| *coast_s), true));
    let y = PlotAxis::new("angle", "deg", Scale::around(all().map(|(_, within)| *within), true));
    let legend: Vec<_> = (curves.iter().enumerate())
        .map(|(index, (axis, _))| {
            (LegendSample::Both(solid(index, 1.1), Shape::of_series(index).filled()), axis.name.clone())
        })
        .collect();
    let percent = trimmed(100.0 * first.allan.confidence, 3);
    let title = format!("Drift of the angle while coasting, {percent} % of drifts");
    let mut plot = Figure::new("drift-gyro".into(), title, x, y, &legend);
    for (index, (_, points)) in curves.iter().enumerate() {
        plot.draw(index, plot.marked_line(index, points, solid(index, 1.1)));
    }
    plot.series = curves.iter().map(|(axis, points)| PlottedSeries::of(&axis.name, points)).collect();
    Some(plot)
}

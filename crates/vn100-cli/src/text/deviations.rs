//! The deviations: one table for each sensor, a row for each tau.

use std::fmt::{self, Write};

use imu_noise::{Deviation, Estimator};
use vn100_analysis::Snapshot;
use vn100_report::{
    names::sensor,
    numbers::plain::short,
    units::{ChannelValues, LEAST_EDF, Point},
};

use super::layout::{COLUMN, fill};

/// One table for each sensor, its axes side by side.
pub(super) fn write_deviations(
    out: &mut String,
    snapshot: &Snapshot,
    channels: &[ChannelValues],
    confidence: f64,
) -> fmt::Result {
    let deviation = match snapshot.deviation {
        Deviation::Allan => "Allan deviation",
        Deviation::Hadamard => "Hadamard deviation",
    };
    let windows = match snapshot.estimator {
        Estimator::Strided => "windows at stride tau/16, all overlaps up to m = 16",
        Estimator::Full => "all overlaps",
        Estimator::Plain => "no overlap",
    };
    let detrended = if snapshot.detrended { ", a line removed from each channel" } else { "" };
    writeln!(out, "\n{deviation}, {windows}{detrended}")?;
    let legend = format!(
        "Behind each, how far the truth may lie above and below, in percent, at a confidence of {}. Each holds alone: octaves share samples, \
         and all together hold less often. \"few\": below {LEAST_EDF} degrees of freedom.",
        short(confidence)
    );
    writeln!(out, "{}", fill(&legend, "", ""))?;
    // what was asked for between the lines has no deviation
    let measured: Vec<_> = channels.iter().filter(|channel| !channel.deviations.is_empty()).collect();
    for group in measured.chunk_by(|a, b| a.quantity == b.quantity) {
        write!(out, "\n{}, {}\n{:>8} {:>7} {:>7}", sensor(group[0].quantity), group[0].unit, "tau (s)", "m", "terms")?;
        for channel in group {
            write!(out, " {:>COLUMN$}", channel.name)?;
        }
        writeln!(out)?;
        let octaves = group.iter().map(|channel| channel.deviations.len()).max().unwrap_or(0);
        for octave in 0..octaves {
            let Some(first) = group.iter().find_map(|channel| channel.deviations.get(octave)) else {
                continue;
            };
            write!(out, "{:>8} {:>7} {:>7}", short(first.tau_s), first.m, first.terms)?;
            for channel in group {
                write!(out, " {:>COLUMN$}", channel.deviations.get(octave).map_or("-".into(), with_bounds))?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

fn with_bounds(point: &Point) -> String {
    let Some(deviation) = point.deviation else { return "-".into() };
    let percent = |bound: f64| 100.0 * (bound / deviation - 1.0);
    match (point.lower, point.upper) {
        (Some(lower), Some(upper)) if point.is_known() && deviation > 0.0 => {
            let (above, below) = (percent(upper), percent(lower));
            let decimals = usize::from(above < 9.95);
            format!("{deviation:.3e} {:>7}", format!("{above:+.decimals$}{below:+.decimals$}"))
        }
        _ => format!("{deviation:.3e} {:>7}", "few"),
    }
}

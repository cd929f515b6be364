//! Means, standard deviations and distributions, what they say of a sensor at rest, and the
//! deviations.

use std::fmt::{self, Write};

use imu_noise::{Estimator, STANDARD_GRAVITY_M_S2};
use vn100_analysis::{Detrend, LEAST_EDF, Snapshot};
use vn100_protocol::Quantity;
use vn100_report::{
    names::{NEUTRAL_SERIES, deviation_name, names_of},
    numbers::plain::{short, signed},
    units::{BlockValues, ChannelValues, EARTH_RATE_RAD_S, Point, fitted, norm_values, not_normal},
};

use super::{COLUMN, fill};

/// Every channel, and the length of each vector.
pub(super) fn write_statistics(out: &mut String, snapshot: &Snapshot, channels: &[ChannelValues]) -> fmt::Result {
    writeln!(out)?;
    let width = channels.iter().map(|channel| channel.name.len() + 1).max().unwrap_or(0).max(12);
    writeln!(out, "{:<width$}{:<7}{:>15}{:>15}{:>15}{:>15}", "channel", "unit", "mean", "std", "min", "max")?;
    let mut row = |name: &str, unit: &str, averages: [Option<f64>; 2], samples: [Option<f64>; 2], decimals: usize| {
        // three digits more than the sensor prints: averages resolve more than one sample
        let [mean, std] = averages.map(|value| number(value, decimals + 3));
        let [min, max] = samples.map(|value| number(value, decimals));
        writeln!(out, "{name:<width$}{unit:<7}{mean:>15}{std:>15}{min:>15}{max:>15}")
    };
    for channel in channels {
        let averages = [channel.mean, channel.std];
        row(&channel.name, &channel.unit, averages, [channel.min, channel.max], channel.decimals)?;
    }
    let norms = norm_values(snapshot);
    for norm in &norms {
        // two of its digits are more than the sensor prints already
        let decimals = norm.decimals.saturating_sub(2);
        row(&norm.name, &norm.unit, [norm.mean, norm.std], [norm.min, norm.max], decimals)?;
    }
    for norm in &norms {
        if let Some(text) = norm.of_mean.and_then(|of_mean| at_rest(norm.quantity, of_mean)) {
            writeln!(out, "{}", fill(&text, "", "  "))?;
        }
    }
    Ok(())
}

/// What the length of the mean vector, in SI units or gauss, says if the sensor rested.
fn at_rest(quantity: Quantity, of_mean: f64) -> Option<String> {
    match quantity {
        Quantity::MagneticField => {
            Some(format!("Mean magnetic field: |B| = {of_mean:.4} gauss (the Earth's: 0.22 to 0.67)"))
        }
        Quantity::Acceleration => {
            let off = of_mean - STANDARD_GRAVITY_M_S2;
            let (side, percent) = (if off < 0.0 { "below" } else { "above" }, 100.0 * off / STANDARD_GRAVITY_M_S2);
            Some(format!(
                "Mean specific force: |a| = {of_mean:.4} m/s^2, {:.4} m/s^2 {side} standard gravity ({} %)",
                off.abs(),
                signed(percent, 2)
            ))
        }
        Quantity::AngularRate => Some(format!(
            "Magnitude of the mean rate: {of_mean:.2e} rad/s (bias plus the Earth rate of {EARTH_RATE_RAD_S:.2e} rad/s)"
        )),
        Quantity::Angle | Quantity::Quaternion | Quantity::Temperature | Quantity::Pressure | Quantity::Value => None,
    }
}

fn number(value: Option<f64>, decimals: usize) -> String {
    // a column, and a blank before it
    value.map_or("-".into(), |value| fitted(value, decimals, 14))
}

/// Parts into which the record is divided.
const PARTS: usize = 8;

/// Skewness and excess kurtosis, and whether the values may be normal.
pub(super) fn write_distribution(out: &mut String, channels: &[ChannelValues]) -> fmt::Result {
    writeln!(out, "\n{:<13}{:>8}{:>9}  Gaussian?", "distribution", "skew", "kurtosis")?;
    let not_normal = not_normal(channels);
    for channel in channels {
        let shape =
            |value: Option<f64>, decimals: usize| value.map_or("-".into(), |value| format!("{value:+.decimals$}"));
        let normal = match channel.signal.as_ref().and_then(|signal| signal.normality) {
            Some(Ok(_)) if !not_normal.contains(&&*channel.name) => "consistent".into(),
            Some(Ok(normality)) => format!(
                "rejected (skewness {:.0}σ, kurtosis {:.0}σ)",
                (normality.skewness / normality.skewness_error).abs(),
                (normality.excess_kurtosis / normality.excess_kurtosis_error).abs()
            ),
            Some(Err(reason)) => format!("not tested: {reason}"),
            None => "-".into(),
        };
        let row = format!(
            "{:<13}{:>8}{:>9}  {normal}",
            channel.name,
            shape(channel.skewness, 3),
            shape(channel.excess_kurtosis, 3)
        );
        writeln!(out, "{}", fill(&row, "", "                                  "))?;
    }
    Ok(())
}

/// The standard deviation of each part in percent of the whole.
pub(super) fn write_parts(out: &mut String, channels: &[ChannelValues]) -> fmt::Result {
    let blocks = |channel: &ChannelValues| channel.signal.as_ref().map(|signal| parts(&signal.blocks));
    let Some(first) = channels.iter().find_map(blocks).filter(|parts| parts.len() == PARTS) else { return Ok(()) };
    writeln!(out, "\nstandard deviation over time, % of that of the record; parts start at (s)")?;
    write!(out, "{:<13}", "")?;
    for part in &first {
        write!(out, "{:>8}", short((part.start_s * 10.0).round() / 10.0))?;
    }
    writeln!(out)?;
    for channel in channels {
        let (Some(parts), Some(whole)) = (blocks(channel), channel.std.filter(|std| *std > 0.0)) else { continue };
        write!(out, "{:<13}", channel.name)?;
        for part in parts {
            write!(out, "{:>8}", part.std.map_or("-".into(), |std| format!("{:.0}", 100.0 * std / whole)))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// What would have been found, had it happened in the middle of the record.
pub(super) fn write_detectable(out: &mut String, channels: &[ChannelValues]) -> fmt::Result {
    let found = |channel: &ChannelValues| {
        let disturbed = &channel.signal.as_ref()?.disturbed;
        let (noise, step) = (disturbed.noise.detectable_factor, disturbed.detectable_step);
        (noise.is_some() || step.is_some()).then_some((noise, step))
    };
    let rows: Vec<_> = channels.iter().filter_map(|channel| Some((channel, found(channel)?))).collect();
    if rows.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nsmallest detectable change in mid-record (power 90 %): noise, step")?;
    for (channel, (noise, step)) in rows {
        let noise = noise.map_or("-".into(), |factor| format!("x{factor:.3}"));
        let step = step.map_or("-".into(), |step| format!("{step:.2e} {}", channel.unit));
        writeln!(out, "{:<13}{noise:>8}  {step}", channel.name)?;
    }
    Ok(())
}

/// So many blocks of equal length, of those of a record in time order; fewer where it has fewer.
fn parts(blocks: &[BlockValues]) -> Vec<BlockValues> {
    let (Some(first), Some(last)) = (blocks.first(), blocks.last()) else { return Vec::new() };
    let span_s = last.start_s + last.duration_s - first.start_s;
    let part = |block: &BlockValues| {
        let middle_s = block.start_s + block.duration_s / 2.0 - first.start_s;
        ((middle_s / span_s * PARTS as f64) as usize).min(PARTS - 1)
    };
    blocks.chunk_by(|a, b| part(a) == part(b)).filter_map(joined).collect()
}

/// The statistics of neighbours together: squares within and between them add up.
fn joined(blocks: &[BlockValues]) -> Option<BlockValues> {
    let (first, last) = (blocks.first()?, blocks.last()?);
    let count: u64 = blocks.iter().map(|block| block.count).sum();
    let n = count as f64;
    let mean = blocks.iter().map(|block| block.count as f64 * block.mean).sum::<f64>() / n;
    let squares: f64 = blocks
        .iter()
        .map(|block| {
            let of = block.count as f64;
            (of - 1.0) * block.std.unwrap_or(0.0).powi(2) + of * (block.mean - mean).powi(2)
        })
        .sum();
    Some(BlockValues {
        start_s: first.start_s,
        duration_s: last.start_s + last.duration_s - first.start_s,
        count,
        mean,
        std: (count > 1).then(|| (squares / (n - 1.0)).sqrt()),
        min: blocks.iter().map(|block| block.min).fold(f64::INFINITY, f64::min),
        max: blocks.iter().map(|block| block.max).fold(f64::NEG_INFINITY, f64::max),
    })
}

/// One table for each sensor, its axes side by side.
pub(super) fn write_deviations(
    out: &mut String,
    snapshot: &Snapshot,
    channels: &[ChannelValues],
    confidence: f64,
) -> fmt::Result {
    let deviation = deviation_name(snapshot.deviation);
    let windows = match snapshot.estimator {
        Estimator::Strided => "windows at stride tau/16, fully overlapping up to m = 16",
        Estimator::Full => "fully overlapping",
        Estimator::Plain => "non-overlapping",
    };
    let detrended = match snapshot.detrended {
        None => "",
        Some(Detrend::Line) => ", linear trend removed from each channel",
        Some(Detrend::Temperature) => ", temperature dependence removed from gyro and accel",
    };
    writeln!(out, "\n{deviation}, {windows}{detrended}")?;
    let legend = format!(
        "+ - columns: {} % confidence limits in percent, pointwise, not simultaneous. n/a: fewer than {LEAST_EDF} degrees of freedom.",
        short(100.0 * confidence)
    );
    writeln!(out, "{}", fill(&legend, "", ""))?;
    // what was asked for between the lines has no deviation
    let measured: Vec<_> = channels.iter().filter(|channel| !channel.deviations.is_empty()).collect();
    for group in measured.chunk_by(|a, b| a.quantity == b.quantity) {
        writeln!(out, "\n{}, {}", names_of(group[0].quantity).title, group[0].unit)?;
        if group[0].quantity == Quantity::Value {
            writeln!(out, "{}", fill(NEUTRAL_SERIES, "", ""))?;
        }
        write!(out, "{:>8} {:>7} {:>7}", "tau (s)", "m", "terms")?;
        for channel in group {
            write!(out, " {:>COLUMN$}", channel.name)?;
        }
        writeln!(out)?;
        let points = group.iter().map(|channel| channel.deviations.len()).max().unwrap_or(0);
        for point in 0..points {
            let Some(first) = group.iter().find_map(|channel| channel.deviations.get(point)) else {
                continue;
            };
            write!(out, "{:>8} {:>7} {:>7}", short(first.tau_s), first.m, first.terms)?;
            for channel in group {
                write!(out, " {:>COLUMN$}", channel.deviations.get(point).map_or("-".into(), with_bounds))?;
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
        _ => format!("{deviation:.3e} {:>7}", "n/a"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_together_have_the_statistics_of_their_samples() {
        let block = |start_s: f64, values: &[f64]| {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            BlockValues {
                start_s,
                duration_s: 1.0,
                count: values.len() as u64,
                mean,
                std: (n > 1.0).then(|| (squares / (n - 1.0)).sqrt()),
                min: values.iter().copied().fold(f64::INFINITY, f64::min),
                max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            }
        };
        let whole = block(0.0, &[1.0, 4.0, 2.5, 7.0, -3.0]);
        let found = joined(&[block(0.0, &[1.0, 4.0]), block(1.0, &[2.5]), block(2.0, &[7.0, -3.0])]).unwrap();
        assert_eq!((found.count, found.min, found.max, found.duration_s), (5, -3.0, 7.0, 3.0));
        assert!((found.mean - whole.mean).abs() < 1e-12 && (found.std.unwrap() - whole.std.unwrap()).abs() < 1e-12);
        assert_eq!(joined(&[]), None);
        assert_eq!(parts(&[]), []);
        let many: Vec<_> = (0..20).map(|i| block(f64::from(i), &[1.0, 2.0])).collect();
        assert_eq!(parts(&many).len(), PARTS);
        assert_eq!(parts(&many).iter().map(|part| part.count).sum::<u64>(), 40);
    }
}

//! Warnings about the values of the channels.

use vn100_protocol::{Channel, Quantity};

use super::StreamFindings;
use crate::{
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Finding, Severity, Warning},
};

pub(super) fn warnings(snapshot: &Snapshot, findings: &StreamFindings) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if findings.print_changes > 0 {
        let found = Warning::new(Finding::DecimalsChanged(findings.print_changes));
        warnings.push(found.as_severe_as(Severity::Caution));
    }
    let restarted = Warning::of_any(Finding::TurnsRestarted, findings.restarted.clone());
    warnings.extend(restarted.map(|found| found.as_severe_as(Severity::Note)));
    let stuck = channels_where(snapshot, |channel, results| is_stuck(channel, results, snapshot.rate_of(results)));
    let stuck = Warning::of_any(Finding::TwoValues, stuck);
    warnings.extend(stuck.map(|found| found.as_severe_as(Severity::Problem)));
    warnings.extend(saturated(snapshot));
    let at_limit = channels_where(snapshot, reaches_limit);
    warnings.extend(Warning::of_any(Finding::RangeReached, at_limit));
    warnings.extend(absent(snapshot));
    warnings
}

/// Channels that rows lack.
fn absent(snapshot: &Snapshot) -> Option<Warning> {
    let rows = snapshot.timing.samples;
    let lacking = |(channel, results): (&Channel, &ChannelSnapshot)| {
        // a channel with a rate of its own is not absent from the rows that repeat its value
        let absent = if results.stride == 1 { rows.saturating_sub(results.moments.count()) } else { 0 };
        (absent > 0).then(|| (channel.name.to_string(), absent))
    };
    let lacking: Vec<_> = snapshot.measured().filter_map(lacking).collect();
    let names: Vec<String> = lacking.iter().map(|(channel, _)| channel.clone()).collect();
    Warning::of_any(Finding::Absent(rows, lacking), names)
}

/// The axes that the sensor itself reports at the end of their range, with the time.
fn saturated(snapshot: &Snapshot) -> Option<Warning> {
    let saturation = &snapshot.saturation;
    let (first, last) = saturation.first_at.zip(saturation.last_at)?;
    let axes: Vec<_> = saturation.axes().map(|(axis, count)| (axis.to_owned(), count)).collect();
    let names: Vec<String> = axes.iter().map(|(axis, _)| axis.clone()).collect();
    let found = Finding::Saturated(saturation.samples, axes, [first, last].map(|at| at.as_secs_f64()));
    Some(Warning::new(found).of(names))
}

/// Names of the channels for which `holds`.
fn channels_where(snapshot: &Snapshot, holds: impl Fn(&Channel, &ChannelSnapshot) -> bool) -> Vec<String> {
    (snapshot.measured())
        .filter(|(channel, results)| holds(channel, results))
        .map(|(channel, _)| channel.name.to_string())
        .collect()
}

/// Whether a channel has no more than two values for longer than its quantity may be constant.
fn is_stuck(channel: &Channel, results: &ChannelSnapshot, rate_hz: f64) -> bool {
    let least_s = match channel.quantity {
        // temperature and pressure of a room do not change in seconds; their noise may be finer
        // than the printed digits
        Quantity::Temperature | Quantity::Pressure => 300.0,
        // an element near ±1 changes with the square of the angle
        Quantity::Quaternion => return false,
        // a series of no sensor may well be nearly constant
        Quantity::Value => return false,
        Quantity::AngularRate | Quantity::Acceleration | Quantity::MagneticField | Quantity::Angle => 0.0,
    };
    let (histogram, count) = (&results.histogram, results.moments.count());
    count >= 100
        && count as f64 >= least_s * rate_hz
        && histogram.bin_width_counts() == 1
        && histogram.bins().take(3).count() <= 2
}

fn reaches_limit(channel: &Channel, results: &ChannelSnapshot) -> bool {
    // ranges in the unit of the channel, from quotations of the maker's data sheet; the last digits
    // below them are already doubtful
    let range = match channel.quantity {
        Quantity::MagneticField => 2.5,
        Quantity::Acceleration => 16.0 * 9.80665,
        Quantity::AngularRate => 2000.0_f64.to_radians(),
        _ => return false,
    };
    let extremes = [results.moments.min_counts(), results.moments.max_counts()];
    extremes.into_iter().flatten().any(|counts| channel.value(counts).abs() >= 0.99 * range)
}

//! Whether the sensor was moved, and what one at rest should show: gravity, a magnetic field, a
//! heading as good as the levelling.

use imu_noise::{STANDARD_GRAVITY_M_S2, Sensor};
use vn100_protocol::{Channel, Quantity};

use crate::{
    motion::Motion,
    remedy::Remedy,
    sensor::sensor_of,
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Finding, Severity, Warning},
};

/// Standard deviations that no sensor at rest reaches.
///
/// Resting VN-100s at 40 Hz read 0.0006 to 0.0011 rad/s and 0.012 to 0.026 m/s², quiet or on a
/// shaking table. Of six records of cars, walks and hands the slowest has 0.10 rad/s and 0.68 m/s².
/// A bump of the table is too short to reach them; a sensor that is put into its place at the
/// beginning is not.
const GYRO_LIMIT_RAD_S: f64 = 0.05;
const ACCEL_LIMIT_M_S2: f64 = 0.5;

impl Motion {
    /// By gyroscope and accelerometer; `None` at rest, and for less than four samples.
    pub(super) fn of(snapshot: &Snapshot) -> Option<Self> {
        let beyond: Vec<(&Channel, f64, f64)> = (snapshot.measured())
            .filter_map(|(channel, results)| {
                let (limit, std) = (limit(channel)?, std(channel, results)?);
                let is_moved = inner_std(channel, results)? > limit
                    || std > limit && was_handled(results, snapshot.rate_of(results));
                is_moved.then_some((channel, std, limit))
            })
            .collect();
        let (channel, std, limit) = *beyond.iter().max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
        let axes = beyond.iter().map(|(channel, ..)| channel.name.to_string()).collect();
        Some(Self { channel: channel.name.to_string(), std, limit, unit: channel.unit.to_string(), axes })
    }

    pub(super) fn warning(&self) -> Warning {
        let found = Warning::new(Finding::Moved(self.clone())).of(self.axes.clone());
        found.as_severe_as(Severity::Problem).cured_by(Remedy::Skip(None)).cured_by(Remedy::EndEarlier)
    }
}

fn limit(channel: &Channel) -> Option<f64> {
    match sensor_of(channel.quantity)? {
        Sensor::Gyroscope => Some(GYRO_LIMIT_RAD_S),
        Sensor::Accelerometer => Some(ACCEL_LIMIT_M_S2),
        Sensor::Magnetometer => None,
    }
}

fn std(channel: &Channel, results: &ChannelSnapshot) -> Option<f64> {
    Some(channel.in_unit(results.moments.std_counts()?).abs())
}

/// Whether what was far out lasted more than a second: damaged lines do not.
fn was_handled(results: &ChannelSnapshot, rate_hz: f64) -> bool {
    let disturbances = results.signal.as_ref().map_or_else(Vec::new, |signal| signal.disturbances(rate_hz.recip()));
    disturbances.iter().map(|disturbance| disturbance.end_s - disturbance.start_s).sum::<f64>() > 1.0
}

/// Without the least and the greatest values, one in two hundred of each: damaged lines that pass
/// the checksum are rarer, and a single value may be as far out as the axis goes.
fn inner_std(channel: &Channel, results: &ChannelSnapshot) -> Option<f64> {
    let (histogram, total) = (&results.histogram, results.moments.count());
    let excluded = total.div_ceil(200);
    let (from, to) = (excluded, total.saturating_sub(excluded));
    let (mut before, mut sum, mut squares) = (0, 0.0, 0.0);
    let mean = results.moments.mean_counts()?;
    for (lowest, frequency) in histogram.bins() {
        let kept = (before + frequency).min(to).saturating_sub(before.max(from)) as f64;
        let off = lowest as f64 + 0.5 * (histogram.bin_width_counts() - 1) as f64 - mean;
        before += frequency;
        sum += kept * off;
        squares += kept * off * off;
    }
    let kept = to.checked_sub(from).filter(|kept| *kept > 1)? as f64;
    let variance = ((squares - sum * sum / kept) / (kept - 1.0)).max(0.0);
    Some(channel.in_unit(variance.sqrt()).abs())
}

/// On Earth gravity is 9.764 to 9.834 m/s²; resting sensors were seen to read 9.58 to 10.29.
const GRAVITY_TOLERANCE_M_S2: f64 = 0.6;

/// The Earth's field at its surface, in gauss (0.22 to 0.67).
const FIELD_GAUSS: std::ops::RangeInclusive<f64> = 0.22..=0.67;

pub(super) fn warnings(snapshot: &Snapshot) -> impl Iterator<Item = Warning> {
    let warning = |quantity: Quantity, finding| {
        let axes = snapshot.measured().filter(|(channel, _)| channel.quantity == quantity);
        Warning::new(finding).of(axes.map(|(channel, _)| channel.name.to_string()))
    };
    let is_off = |gravity: &f64| (gravity - STANDARD_GRAVITY_M_S2).abs() > GRAVITY_TOLERANCE_M_S2;
    let gravity = snapshot.mean_magnitude(Quantity::Acceleration).filter(is_off);
    let gravity = gravity.map(|gravity| warning(Quantity::Acceleration, Finding::Gravity(gravity)));
    let field = snapshot.mean_magnitude(Quantity::MagneticField).filter(|field| !FIELD_GAUSS.contains(field));
    let field = field.map(|field| warning(Quantity::MagneticField, Finding::Field(field)));
    gravity.into_iter().chain(field)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_protocol::{Layout, VNIMU, stream::Batch};

    use super::*;
    use crate::{Analysis, Settings};

    /// Of these channels of a message.
    fn measured(channels: std::ops::Range<usize>, counts: Vec<i32>) -> Snapshot {
        let layout = Layout { channels: VNIMU.channels[channels].into(), ..VNIMU.clone() };
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, ..Batch::default() });
        analysis.snapshot()
    }

    #[test]
    fn seconds_of_handling_are_motion_and_damaged_values_are_not() {
        // ten minutes of a gyroscope at rest
        let rest = |row: usize| (row.wrapping_mul(2_654_435_761) >> 7) as i32 % 1500 - 750;
        let moved = |off: fn(usize) -> i32| {
            let counts = (0..24_000).flat_map(|row| [rest(row) + off(row), rest(row + 1), rest(row + 2)]).collect();
            Motion::of(&measured(6..9, counts)).map(|motion| motion.axes)
        };
        assert_eq!(moved(|_| 0), None);
        let handled = moved(|row| if (400..520).contains(&row) { [900_000, -900_000][row / 8 % 2] } else { 0 });
        assert_eq!(handled, Some(vec!["gyro_x".into()]));
        // as many values, far from each other, as damage would put them
        assert_eq!(moved(|row| if row % 200 == 7 { 900_000 } else { 0 }), None);
    }

    #[test]
    fn one_in_two_hundred_at_each_end_is_no_part_of_the_inner_deviation() {
        let of = |counts: &[i32]| {
            let snapshot = measured(6..7, counts.to_vec());
            snapshot.measured().next().and_then(|(channel, results)| inner_std(channel, results))
        };
        let is = |counts: &[i32], variance_counts2: f64| {
            let found = of(counts).unwrap() / 1e-6;
            assert!((found / variance_counts2.sqrt() - 1.0).abs() < 1e-9, "{counts:?}: {found}");
        };
        is(&[-50, 1, 2, 3, 4, 60], 5.0 / 3.0);
        is(&[-50, 7, 9, 60], 2.0);
        is(&[-50, -50, 3, 3, 60], 53.0 * 53.0 / 3.0);
        // two of 400 at each end, so that 99 and 98 values are left
        let mut many: Vec<i32> = (0..396).map(|row| row % 2).collect();
        many.extend([-90, -80, 80, 90]);
        is(&many, 0.25 * 396.0 / 395.0);
        for few in [&[][..], &[5], &[1, 2], &[1, 2, 3]] {
            assert_eq!(of(few), None, "{few:?}");
        }
    }

    #[test]
    fn a_moved_sensor_is_named_by_the_axis_farthest_beyond_its_limit() {
        let moved = |amplitudes: [i32; 4]| {
            let sway = |row| amplitudes.map(|amplitude| if row % 2 == 0 { amplitude } else { -amplitude });
            Motion::of(&measured(3..7, (0..400).flat_map(sway).collect()))
        };
        assert_eq!(moved([400, 490, 450, 49_000]), None);
        let pushed = moved([400, 1000, 600, 60_000]).unwrap();
        assert_eq!((&*pushed.channel, &*pushed.unit, pushed.limit), ("accel_y", "m/s^2", 0.5));
        assert_eq!(pushed.axes, ["accel_y", "accel_z", "gyro_x"]);
        assert!((pushed.std - 1.001).abs() < 1e-3, "{}", pushed.std);
        // a series of no sensor has no limit, however much it varies
        let mut layout = Layout { channels: VNIMU.channels[6..7].into(), ..VNIMU.clone() };
        layout.channels.to_mut()[0].quantity = Quantity::Value;
        let mut analysis = Analysis::new(Settings::default());
        let counts = (0..400).map(|row| [90_000_000, -90_000_000][row % 2]).collect();
        analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, ..Batch::default() });
        assert_eq!(Motion::of(&analysis.snapshot()), None);
        // 0.2 rad/s is four times its limit, 1 m/s² twice
        assert_eq!(moved([0, 1000, 0, 200_000]).unwrap().channel, "gyro_x");
    }
}

//! Units that the columns of a file cannot be in: no sensor at rest measures such magnitudes.

use std::ops::Range;

use imu_noise::STANDARD_GRAVITY_M_S2;
use vn100_protocol::{Channel, ColumnsRead, Layout, Quantity};

use crate::{
    remedy::Remedy,
    snapshot::Snapshot,
    warning::{Doubt, Doubtful, Finding, Warning},
};

/// Units of acceleration, in m/s²; the last are the counts of a sensor of 16 bits with a range of 16, 8, 4 and 2 g.
const ACCELERATIONS: [(&str, f64); 10] = [
    ("m/s^2", 1.0),
    ("g", STANDARD_GRAVITY_M_S2),
    ("mg", STANDARD_GRAVITY_M_S2 / 1e3),
    ("ug", STANDARD_GRAVITY_M_S2 / 1e6),
    ("cm/s^2", 1e-2),
    ("ft/s^2", 0.3048),
    ("4.8828125e-4 g", STANDARD_GRAVITY_M_S2 / 2048.0),
    ("2.44140625e-4 g", STANDARD_GRAVITY_M_S2 / 4096.0),
    ("1.220703125e-4 g", STANDARD_GRAVITY_M_S2 / 8192.0),
    ("6.103515625e-5 g", STANDARD_GRAVITY_M_S2 / 16384.0),
];

/// The unit of rates in counts, whose scale the user knows.
const COUNTS_OF_RATES: &str = "SCALE deg/s";

/// What a column of a quantity is read as, what it is instead, and between which means that is so.
const BEYOND: [(Quantity, &str, &str, Range<f64>); 5] = [
    (Quantity::MagneticField, "gauss", "uT", 15.0..100.0),
    (Quantity::MagneticField, "gauss", "nT", 15e3..100e3),
    (Quantity::Temperature, "degC", "K", 230.0..360.0),
    (Quantity::Pressure, "kPa", "hPa", 500.0..1200.0),
    (Quantity::Pressure, "kPa", "Pa", 50e3..120e3),
];

/// Gravity with the bias and scale of a poor sensor.
const GRAVITY_SHARE: f64 = 0.1;

/// The bias of a poor gyroscope is a tenth of it.
const MEAN_RATE_RAD_S: f64 = 3.0;

/// Twice the noise of a poor gyroscope from sample to sample, 0.4 deg/s; what is in deg/s has
/// more as a rule, read as rad/s.
const NOISE_RAD_S: f64 = 0.015;

/// The share of the whole deviation that neighbours differ by if the rates are white noise; a sensor that
/// is moved turns on for several samples, which leaves less than two thirds.
const WHITE_SHARE: f64 = 0.8;

/// Beyond the range of every inertial sensor: 2000 deg/s.
const RANGE_RAD_S: f64 = 40.0;

/// Asks whether the units of columns or fields are those they are read in, in one warning with the map
/// that corrects them. What a sensor that `was_moved` measures is no noise, unless it is white on every
/// axis. Rates that are `outlying` are not judged by noise and extremes.
pub(super) fn warning(snapshot: &Snapshot, outlying: &[&Channel], was_moved: bool) -> Option<Warning> {
    let layout = snapshot.layout.as_ref()?;
    // the units of the sensor's own messages are known
    let columns = layout.columns.as_ref()?;
    let doubts = doubts(snapshot, layout, columns, outlying, was_moved);
    let is_doubtful = |quantity: Quantity| doubts.iter().find(|doubt| doubt.quantity == quantity);
    let channels = layout.channels.iter().filter(|channel| is_doubtful(channel.quantity).is_some());
    let map = columns.map(&layout.channels, |channel| is_doubtful(channel.quantity).map(|doubt| doubt.likely));
    let channels: Vec<String> = channels.map(|channel| channel.name.to_string()).collect();
    (!doubts.is_empty()).then(|| {
        let found = Warning::new(Finding::UnitDoubtful(doubts)).of(channels);
        found.cured_by(Remedy::MapColumns(Some(map)))
    })
}

fn doubts(
    snapshot: &Snapshot,
    layout: &Layout,
    columns: &ColumnsRead,
    outlying: &[&Channel],
    was_moved: bool,
) -> Vec<Doubtful> {
    let unit_read = |quantity| {
        let place = layout.channels.iter().position(|channel| channel.quantity == quantity)?;
        Some(&*columns.columns.get(place)?.unit)
    };
    let mean_of = |(quantity, read, likely, means): (Quantity, &str, &'static str, Range<f64>)| {
        let mean = snapshot.mean_magnitude(quantity).or_else(|| {
            let (channel, results) = snapshot.measured().find(|(channel, _)| channel.quantity == quantity)?;
            Some(channel.in_unit(results.moments.mean_counts()?))
        });
        let value = mean.filter(|mean| means.contains(mean) && unit_read(quantity) == Some(read))?;
        Some(Doubtful { quantity, by: Doubt::Mean, value, read: read.into(), likely })
    };
    let gravity = unit_read(Quantity::Acceleration).and_then(|read| doubt_of_gravity(snapshot, read));
    let read = layout.channels.iter().zip(&columns.columns);
    let in_rad_s: Vec<&Channel> = read
        .filter(|(channel, column)| channel.quantity == Quantity::AngularRate && column.unit == "rad/s")
        .map(|(channel, _)| channel)
        .collect();
    let are_counts = gravity.as_ref().is_some_and(|gravity| gravity.likely.ends_with(" g"));
    let rates = if are_counts && !in_rad_s.is_empty() {
        let value = snapshot.mean_magnitude(Quantity::AngularRate).unwrap_or_default();
        let (by, read) = (Doubt::Mean, "rad/s".into());
        Some(Doubtful { quantity: Quantity::AngularRate, by, value, read, likely: COUNTS_OF_RATES })
    } else {
        doubt_of_rates(snapshot, &in_rad_s, outlying, was_moved)
    };
    gravity.into_iter().chain(BEYOND.into_iter().filter_map(mean_of)).chain(rates).collect()
}

/// A mean acceleration that is gravity in another unit than in `read`.
fn doubt_of_gravity(snapshot: &Snapshot, read: &str) -> Option<Doubtful> {
    let value = snapshot.mean_magnitude(Quantity::Acceleration)?;
    let (_, scale) = ACCELERATIONS.iter().find(|(unit, _)| *unit == read)?;
    let is_gravity = |in_m_s2: f64| (in_m_s2 / STANDARD_GRAVITY_M_S2 - 1.0).abs() < GRAVITY_SHARE;
    let (likely, _) = ACCELERATIONS.iter().find(|(_, other)| is_gravity(value / scale * other))?;
    let doubt = Doubtful { quantity: Quantity::Acceleration, by: Doubt::Mean, value, read: read.into(), likely };
    (!is_gravity(value)).then_some(doubt)
}

/// Rates read in rad/s that are larger than those of a sensor at rest.
fn doubt_of_rates(
    snapshot: &Snapshot,
    in_rad_s: &[&Channel],
    outlying: &[&Channel],
    was_moved: bool,
) -> Option<Doubtful> {
    let is_judged = |channel: &Channel| in_rad_s.contains(&channel) && !outlying.contains(&channel);
    let rates = || snapshot.measured().filter(|(channel, _)| is_judged(channel));
    let extremes = rates().flat_map(|(channel, results)| {
        let counts = [results.moments.min_counts(), results.moments.max_counts()].into_iter().flatten();
        counts.map(move |counts| channel.value(counts).abs())
    });
    let largest = extremes.fold(0.0, f64::max);
    let mean = snapshot.mean_magnitude(Quantity::AngularRate).unwrap_or(0.0);
    let noises: Vec<(f64, f64)> = rates()
        .filter_map(|(channel, results)| {
            let of_neighbours = results.octaves.first()?.deviation_counts()?;
            Some((channel.in_unit(of_neighbours), of_neighbours / results.moments.std_counts()?))
        })
        .collect();
    let is_noise = !was_moved || noises.iter().all(|(_, share)| *share > WHITE_SHARE);
    let least_noise = noises.into_iter().map(|(noise, _)| noise).reduce(f64::min).filter(|_| is_noise).unwrap_or(0.0);
    let (by, value) = if largest > RANGE_RAD_S {
        (Doubt::Largest, largest)
    } else if mean > MEAN_RATE_RAD_S {
        (Doubt::Mean, mean)
    } else {
        (Doubt::Noise, Some(least_noise).filter(|noise| *noise > NOISE_RAD_S)?)
    };
    let doubt = Doubtful { quantity: Quantity::AngularRate, by, value, read: "rad/s".into(), likely: "deg/s" };
    (!in_rad_s.is_empty()).then_some(doubt)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_protocol::{Channel, ColumnRead, VNIMU, stream::Batch};

    use super::*;
    use crate::{Analysis, Settings};

    /// A file of accelerations and rates, in m/s² and rad/s as read.
    fn measured(accel_m_s2: f64, rate_rad_s: f64, unit: &str, is_file: bool) -> Option<Warning> {
        warning(&snapshot(accel_m_s2, rate_rad_s, (0.0, 1), unit, is_file), &[], false)
    }

    fn doubted(warning: Option<Warning>) -> Vec<Doubtful> {
        match warning.map(|warning| warning.finding) {
            Some(Finding::UnitDoubtful(doubts)) => doubts,
            None => Vec::new(),
            other => panic!("{other:?}"),
        }
    }

    /// The columns of a file, whose names are those of the channels with an `s`.
    fn columns(channels: &[Channel], unit: impl Fn(&Channel) -> String) -> ColumnsRead {
        let column = |channel: &Channel| ColumnRead { name: format!("{}s", channel.name), unit: unit(channel) };
        ColumnsRead { columns: channels.iter().map(column).collect(), times: Some("t:s".into()) }
    }

    /// With as much noise on the rates, whose sign alternates after so many samples.
    fn snapshot(
        accel_m_s2: f64,
        rate_rad_s: f64,
        (noise_rad_s, held): (f64, usize),
        unit: &str,
        is_file: bool,
    ) -> Snapshot {
        let mut layout = Layout { channels: VNIMU.channels[3..9].into(), ..VNIMU.clone() };
        layout.channels.to_mut()[..3]
            .iter_mut()
            .for_each(|channel| (channel.decimals, channel.scale) = (0, 1.0 / 4096.0));
        let read = |channel: &Channel| {
            if channel.quantity == Quantity::Acceleration { unit.to_owned() } else { channel.unit.to_string() }
        };
        layout.columns = is_file.then(|| columns(&layout.channels, read));
        let row = [0.0, 0.0, accel_m_s2, rate_rad_s, 0.0, 0.0];
        let count = |(channel, value): (&Channel, &f64)| (value / channel.in_unit(1.0)).round() as i32;
        let with = |noise: f64| {
            let row = row.map(|value| value + if value == accel_m_s2 { 0.0 } else { noise });
            layout.channels.iter().zip(&row).map(count).collect::<Vec<i32>>()
        };
        let counts = [with(noise_rad_s).repeat(held), with(-noise_rad_s).repeat(held)].concat();
        let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
        analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts: counts.repeat(50), ..Batch::default() });
        analysis.snapshot()
    }

    #[test]
    fn noise_that_no_gyroscope_has_is_asked_about_unless_it_is_motion() {
        let noisy = |noise_rad_s| snapshot(9.8, 0.01, (noise_rad_s, 1), "m/s^2", true);
        let found = doubted(warning(&noisy(0.02), &[], false));
        assert!(matches!(&found[..], [Doubtful { by: Doubt::Noise, likely: "deg/s", .. }]), "{found:?}");
        assert!(warning(&noisy(0.005), &[], false).is_none());
        let mut mixed = noisy(0.02);
        let layout = Arc::make_mut(mixed.layout.as_mut().unwrap());
        layout.columns.as_mut().unwrap().columns[3].unit = "deg/s".into();
        assert!(warning(&mixed, &[], false).is_some(), "two axes are read in rad/s");
        let slow = snapshot(9.8, 0.01, (0.04, 8), "m/s^2", true);
        assert!(warning(&slow, &[], false).is_some() && warning(&slow, &[], true).is_none());
        assert!(warning(&noisy(0.02), &[], true).is_some(), "white noise is no motion");
    }

    #[test]
    fn magnetic_fields_temperatures_and_pressures_are_asked_about_by_their_means() {
        let asked = |first: usize, channels: usize, value: f64| {
            let mut layout = Layout { channels: VNIMU.channels[first..first + channels].into(), ..VNIMU.clone() };
            layout.channels.to_mut().iter_mut().for_each(|channel| (channel.decimals, channel.scale) = (0, 0.01));
            let counts = vec![(value * 100.0).round() as i32; 100 * channels];
            layout.columns = Some(columns(&layout.channels, |channel| channel.unit.to_string()));
            let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
            analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, ..Batch::default() });
            doubted(warning(&analysis.snapshot(), &[], false)).first().map(|doubt| doubt.likely)
        };
        for (first, channels, value, likely) in [
            (0, 3, 25.0, Some("uT")),
            (0, 3, 25_000.0, Some("nT")),
            (0, 3, 0.25, None),
            (9, 1, 298.15, Some("K")),
            (9, 1, 85.0, None),
            (10, 1, 1013.25, Some("hPa")),
            (10, 1, 101_325.0, Some("Pa")),
            (10, 1, 101.3, None),
        ] {
            assert_eq!(asked(first, channels, value), likely, "{value}");
        }
    }

    #[test]
    fn magnitudes_that_no_sensor_has_are_asked_about() {
        for (accel, read, likely) in [
            (-1.02, "m/s^2", "g"),
            (998.0, "m/s^2", "mg"),
            (32.2, "m/s^2", "ft/s^2"),
            (96.2, "g", "m/s^2"),
            (9806.65, "g", "mg"),
            (0.0096, "mg", "g"),
            (0.096, "mg", "m/s^2"),
            (16_500.0, "m/s^2", "6.103515625e-5 g"),
            (2010.0, "m/s^2", "4.8828125e-4 g"),
        ] {
            let found = doubted(measured(accel, 0.0, read, true));
            assert!(found[0].read == read && found[0].likely == likely, "{found:?}");
            let rates: Vec<_> = found[1..].iter().map(|doubt| doubt.likely).collect();
            assert_eq!(rates, if likely.ends_with(" g") { &["SCALE deg/s"][..] } else { &[] });
        }
        let both = measured(1.0, 5.0, "m/s^2", true).unwrap();
        let map = "accel_x=accel_xs:g,accel_y=accel_ys:g,accel_z=accel_zs:g,gyro_x=gyro_xs:deg/s,gyro_y=gyro_ys:deg/s,\
                   gyro_z=gyro_zs:deg/s,t=t:s";
        assert_eq!(both.remedies, [Remedy::MapColumns(Some(map.into()))]);
        assert_eq!(doubted(Some(both)).iter().map(|doubt| doubt.likely).collect::<Vec<_>>(), ["g", "deg/s"]);
        let found = doubted(measured(9.8, 300.0, "m/s^2", true));
        assert!(matches!(&found[..], [Doubtful { by: Doubt::Largest, .. }]), "{found:?}");
        for (accel, rate) in [(9.8, 0.0), (9.2, 0.3), (0.0, 0.0), (5.0, 0.0)] {
            assert_eq!(measured(accel, rate, "m/s^2", true), None, "{accel} {rate}");
        }
        assert!(measured(1.0, 300.0, "m/s^2", false).is_none(), "of sentences");
    }
}

//! Units that the columns of a file cannot be in: no sensor at rest measures such magnitudes.

use std::ops::Range;

use imu_noise::STANDARD_GRAVITY_M_S2;
use vn100_protocol::{Channel, Layout, Quantity};

use crate::{
    remedy::{Remedy, Text},
    snapshot::Snapshot,
    warning::{Warning, WarningKind},
};

/// What a column is read as, what it is instead, and how much longer gravity is read then.
const MISTAKEN: [(&str, &str, f64); 6] = [
    ("m/s^2", "g", 1.0 / STANDARD_GRAVITY_M_S2),
    ("m/s^2", "mg", 1e3 / STANDARD_GRAVITY_M_S2),
    ("g", "m/s^2", STANDARD_GRAVITY_M_S2),
    ("mg", "m/s^2", 1e-3 * STANDARD_GRAVITY_M_S2),
    ("g", "mg", 1e3),
    ("mg", "g", 1e-3),
];

/// What a column of a quantity is read as, what it is instead, and between which means that is so.
const BEYOND: [(Quantity, &str, &str, &str, Range<f64>); 5] = [
    (Quantity::MagneticField, "magnetic field", "gauss", "uT", 15.0..100.0),
    (Quantity::MagneticField, "magnetic field", "gauss", "nT", 15e3..100e3),
    (Quantity::Temperature, "temperature", "degC", "K", 230.0..360.0),
    (Quantity::Pressure, "pressure", "kPa", "hPa", 500.0..1200.0),
    (Quantity::Pressure, "pressure", "kPa", "Pa", 50e3..120e3),
];

/// Gravity with the bias and scale of a poor sensor.
const GRAVITY_SHARE: f64 = 0.1;

/// The bias of a poor gyroscope is a tenth of it.
const MEAN_RATE_RAD_S: f64 = 3.0;

/// Twice the noise of a poor gyroscope from sample to sample, 0.4 deg/s; what is in deg/s has
/// more as a rule, read as rad/s.
const NOISE_RAD_S: f64 = 0.015;

/// Of the whole deviation, what neighbours differ by where the rates are white noise; a sensor that
/// is moved turns on for several samples, which leaves less than two thirds.
const WHITE_SHARE: f64 = 0.8;

/// Beyond the range of every inertial sensor: 2000 deg/s.
const RANGE_RAD_S: f64 = 40.0;

/// Asks whether the units of a file with columns are those it is read in. What a sensor that
/// `was_moved` measures from sample to sample is no noise, unless it is white on every axis.
pub(super) fn warnings(snapshot: &Snapshot, was_moved: bool) -> Vec<Warning> {
    // the units of sentences are known
    let (Some(layout), Some(_)) = (&snapshot.layout, snapshot.link.rejected_rows) else { return Vec::new() };
    let length = |quantity| snapshot.mean_vector(quantity).map(|[x, y, z]: [f64; 3]| x.hypot(y).hypot(z));
    let warning = |quantity, seen: String, read: &str, likely: &str| {
        let of_quantity = layout.channels.iter().filter(|channel| channel.quantity == quantity);
        let headline = format!("{seen}, read as {read}: are the columns in {likely}?");
        let details = Text::from("If they are, set ")
            .remedy(Remedy::MapColumns)
            .then(format!(" {}, with the names of your columns behind each =.", columns(layout, quantity, likely)));
        let channels = of_quantity.map(|channel| channel.name.to_string()).collect();
        Warning::new(WarningKind::UnitDoubtful, channels, headline, details)
    };
    let mut warnings = Vec::new();
    if let Some(gravity) = length(Quantity::Acceleration) {
        let is_so_long = |factor: f64| (gravity / (factor * STANDARD_GRAVITY_M_S2) - 1.0).abs() < GRAVITY_SHARE;
        let unit_read =
            layout.channels.iter().find(|channel| channel.quantity == Quantity::Acceleration).map(unit_read);
        let mistaken = MISTAKEN.into_iter().find(|&(read, _, factor)| unit_read == Some(read) && is_so_long(factor));
        if let Some((read, likely, _)) = mistaken {
            let seen = format!("mean acceleration {gravity:.4}, gravity {STANDARD_GRAVITY_M_S2:.2} m/s^2");
            warnings.push(warning(Quantity::Acceleration, seen, read, likely));
        }
    }
    for (quantity, noun, read, likely, means) in BEYOND {
        let mean = length(quantity).or_else(|| {
            let (channel, results) = snapshot.measured().find(|(channel, _)| channel.quantity == quantity)?;
            Some(channel.in_unit(results.moments.mean_counts()?))
        });
        if let Some(mean) = mean.filter(|mean| means.contains(mean)) {
            warnings.push(warning(quantity, format!("mean {noun} {mean:.1}"), read, likely));
        }
    }
    let rates = || snapshot.measured().filter(|(channel, _)| channel.quantity == Quantity::AngularRate);
    let extremes = rates().flat_map(|(channel, results)| {
        let counts = [results.moments.min_counts(), results.moments.max_counts()].into_iter().flatten();
        counts.map(move |counts| channel.value(counts).abs())
    });
    let largest = extremes.fold(0.0, f64::max);
    let mean = length(Quantity::AngularRate).unwrap_or(0.0);
    let noises: Vec<(f64, f64)> = rates()
        .filter_map(|(channel, results)| {
            let of_neighbours = results.octaves.first()?.deviation_counts()?;
            Some((channel.in_unit(of_neighbours), of_neighbours / results.moments.std_counts()?))
        })
        .collect();
    let is_noise = !was_moved || noises.iter().all(|(_, share)| *share > WHITE_SHARE);
    let least_noise = noises.into_iter().map(|(noise, _)| noise).reduce(f64::min).filter(|_| is_noise).unwrap_or(0.0);
    let seen = if largest > RANGE_RAD_S {
        Some(format!("a rate of {largest:.1}, beyond the range of inertial sensors"))
    } else if mean > MEAN_RATE_RAD_S {
        Some(format!("mean rate {mean:.2}, which no sensor at rest has"))
    } else {
        (least_noise > NOISE_RAD_S)
            .then(|| format!("rates differ by {least_noise:.3} from sample to sample on every axis"))
    };
    warnings.extend(seen.map(|seen| warning(Quantity::AngularRate, seen, "rad/s", "deg/s")));
    warnings
}

/// The unit of a file from which this channel of accelerations is converted: by its scale but for
/// powers of two, which counts may have.
fn unit_read(channel: &Channel) -> &'static str {
    let significand = |scale: f64| scale.to_bits() & ((1 << 52) - 1);
    let units = [("g", STANDARD_GRAVITY_M_S2), ("mg", STANDARD_GRAVITY_M_S2 / 1e3)];
    let unit = units.into_iter().find(|(_, scale)| significand(*scale) == significand(channel.scale));
    unit.map_or("m/s^2", |(unit, _)| unit)
}

/// All columns, those of this quantity in another unit.
fn columns(layout: &Layout, quantity: Quantity, unit: &str) -> String {
    let column = |channel: &Channel| {
        let unit = if channel.quantity == quantity { unit } else { &channel.unit };
        format!("{0}={0}:{unit}", channel.name)
    };
    layout.channels.iter().map(column).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_protocol::{
        VNIMU,
        stream::{Batch, RejectedRowCounts, StreamCounts},
    };

    use super::*;
    use crate::{Analysis, Settings};

    /// A file of accelerations and rates, in m/s² and rad/s as read.
    fn measured(accel_m_s2: f64, rate_rad_s: f64, unit: f64, is_file: bool) -> Vec<Warning> {
        warnings(&snapshot(accel_m_s2, rate_rad_s, (0.0, 1), unit, is_file), false)
    }

    /// With as much noise on the rates, whose sign alternates after so many samples.
    fn snapshot(
        accel_m_s2: f64,
        rate_rad_s: f64,
        (noise_rad_s, held): (f64, usize),
        unit: f64,
        is_file: bool,
    ) -> Snapshot {
        let mut layout = Layout { channels: VNIMU.channels[3..9].into(), ..VNIMU.clone() };
        layout.channels.to_mut()[..3]
            .iter_mut()
            .for_each(|channel| (channel.decimals, channel.scale) = (0, unit / 4096.0));
        let row = [0.0, 0.0, accel_m_s2, rate_rad_s, 0.0, 0.0];
        let count = |(channel, value): (&Channel, &f64)| (value / channel.in_unit(1.0)).round() as i32;
        let with = |noise: f64| {
            let row = row.map(|value| value + if value == accel_m_s2 { 0.0 } else { noise });
            layout.channels.iter().zip(&row).map(count).collect::<Vec<i32>>()
        };
        let counts = [with(noise_rad_s).repeat(held), with(-noise_rad_s).repeat(held)].concat();
        let link = StreamCounts { rejected_rows: is_file.then(RejectedRowCounts::default), ..StreamCounts::default() };
        let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
        analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts: counts.repeat(50), link, ..Batch::default() });
        analysis.snapshot()
    }

    #[test]
    fn noise_that_no_gyroscope_has_is_asked_about_unless_it_is_motion() {
        let noisy = |noise_rad_s| snapshot(9.8, 0.01, (noise_rad_s, 1), 1.0, true);
        let warned = warnings(&noisy(0.02), false);
        assert!(warned[0].headline.starts_with("rates differ by 0.0"), "{}", warned[0].headline);
        assert!(warned[0].headline.ends_with("read as rad/s: are the columns in deg/s?"), "{}", warned[0].headline);
        assert!(warnings(&noisy(0.005), false).is_empty());
        let slow = snapshot(9.8, 0.01, (0.04, 8), 1.0, true);
        assert_eq!((warnings(&slow, false).len(), warnings(&slow, true).len()), (1, 0));
        assert_eq!(warnings(&noisy(0.02), true).len(), 1, "white noise is no motion");
    }

    #[test]
    fn magnetic_fields_temperatures_and_pressures_are_asked_about_by_their_means() {
        let asked = |first: usize, channels: usize, value: f64| {
            let mut layout = Layout { channels: VNIMU.channels[first..first + channels].into(), ..VNIMU.clone() };
            layout.channels.to_mut().iter_mut().for_each(|channel| (channel.decimals, channel.scale) = (0, 0.01));
            let counts = vec![(value * 100.0).round() as i32; 100 * channels];
            let link = StreamCounts { rejected_rows: Some(RejectedRowCounts::default()), ..StreamCounts::default() };
            let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
            analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, link, ..Batch::default() });
            let warned = warnings(&analysis.snapshot(), false);
            warned.first().map(|warning| warning.headline.clone())
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
            let expected = likely.map(|likely| format!(": are the columns in {likely}?"));
            let headline = asked(first, channels, value);
            assert_eq!(headline.is_some(), expected.is_some(), "{value}");
            assert!(headline.zip(expected).is_none_or(|(headline, end)| headline.ends_with(&end)), "{value}");
        }
    }

    #[test]
    fn magnitudes_that_no_sensor_has_are_asked_about() {
        const G: f64 = STANDARD_GRAVITY_M_S2;
        let text =
            |accel, rate| measured(accel, rate, 1.0, true).first().map(|warning| warning.in_words(Remedy::to_string));
        for (accel, unit, read, likely) in [
            (-1.02, 1.0, "m/s^2", "g"),
            (998.0, 1.0, "m/s^2", "mg"),
            (96.2, G, "g", "m/s^2"),
            (9806.65, G, "g", "mg"),
            (0.0096, G / 1e3, "mg", "g"),
            (0.096, G / 1e3, "mg", "m/s^2"),
        ] {
            let warned = measured(accel, 0.0, unit, true);
            let text = &warned.first().unwrap().headline;
            assert!(text.contains(&format!("read as {read}: are the columns in {likely}?")), "{accel}: {text}");
        }
        assert_eq!(
            text(1.0, 0.01).unwrap(),
            "mean acceleration 1.0000, gravity 9.81 m/s^2, read as m/s^2: are the columns in g? If they are, set a map of columns \
             accel_x=accel_x:g,accel_y=accel_y:g,accel_z=accel_z:g,gyro_x=gyro_x:rad/s,gyro_y=gyro_y:rad/s,gyro_z=gyro_z:rad/s, with \
             the names of your columns behind each =."
        );
        assert!(text(9.8, 300.0).unwrap().starts_with("a rate of 300.0, beyond"));
        assert!(text(9.8, 5.0).unwrap().contains("are the columns in deg/s?"));
        for (accel, rate) in [(9.8, 0.0), (9.2, 0.3), (0.0, 0.0), (5.0, 0.0)] {
            assert_eq!(text(accel, rate), None, "{accel} {rate}");
        }
        assert!(measured(1.0, 300.0, 1.0, false).is_empty(), "of sentences");
    }
}

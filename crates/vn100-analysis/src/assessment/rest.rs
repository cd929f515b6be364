//! What a sensor at rest should show: gravity, a magnetic field, a heading as good as the
//! levelling.

use imu_noise::STANDARD_GRAVITY_M_S2;
use vn100_protocol::{Channel, Quantity};

use super::ChannelAssessment;
use crate::{
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Warning, WarningKind},
};

/// On Earth gravity is 9.764 to 9.834 m/s²; resting sensors were seen to read 9.58 to 10.29.
const GRAVITY_TOLERANCE_M_S2: f64 = 0.6;

/// The Earth's field at its surface, in gauss (0.22 to 0.67).
const FIELD_GAUSS: std::ops::RangeInclusive<f64> = 0.22..=0.67;

/// Heading deviates by so much more than pitch and roll where the magnetometer makes it.
const YAW_FACTOR: f64 = 2.0;

type Axis<'a> = (&'a Channel, &'a ChannelSnapshot, &'a ChannelAssessment);

pub(super) fn warnings(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Vec<Warning> {
    let of = |quantity: Quantity| -> Vec<Axis<'_>> {
        (snapshot.measured().zip(assessed))
            .map(|((channel, results), assessed)| (channel, results, assessed))
            .filter(|(channel, ..)| channel.quantity == quantity)
            .collect()
    };
    let names = |axes: &[Axis<'_>]| axes.iter().map(|(channel, ..)| channel.name.to_string()).collect::<Vec<_>>();
    let length = |quantity| snapshot.mean_vector(quantity).map(|[x, y, z]| x.hypot(y).hypot(z));
    let mut warnings = Vec::new();
    let accel = of(Quantity::Acceleration);
    if let Some(gravity) = length(Quantity::Acceleration) {
        let off = gravity - STANDARD_GRAVITY_M_S2;
        if off.abs() > GRAVITY_TOLERANCE_M_S2 {
            let text = format!(
                "the mean acceleration is {gravity:.3} m/s^2 long, {off:+.3} from standard gravity: the sensor moved, or its bias or scale is \
                 off, or the columns hold another unit"
            );
            warnings.push(Warning::new(WarningKind::GravityMagnitude, names(&accel), text));
        }
    }
    let mag = of(Quantity::MagneticField);
    if let Some(field) = length(Quantity::MagneticField).filter(|field| !FIELD_GAUSS.contains(field)) {
        let text = format!(
            "the mean magnetic field is {field:.4} gauss long; the Earth's is {} to {}: iron or a current is near, or the sensor is not \
             calibrated for what it is mounted on",
            FIELD_GAUSS.start(),
            FIELD_GAUSS.end()
        );
        warnings.push(Warning::new(WarningKind::FieldMagnitude, names(&mag), text));
    }
    if let [yaw, pitch, roll] = of(Quantity::Angle)[..]
        && !mag.is_empty()
        && heading_is_worse(yaw, [pitch, roll])
    {
        let text = format!(
            "yaw deviates more than {YAW_FACTOR} times as much as pitch and roll: gravity holds those two, heading rests on the \
             magnetometer, whose noise and surroundings it shows"
        );
        warnings.push(Warning::new(WarningKind::YawFromMagnetometer, names(&[yaw]), text));
    }
    warnings
}

/// At any tau, beyond the intervals.
fn heading_is_worse(yaw: Axis<'_>, others: [Axis<'_>; 2]) -> bool {
    let bounds = |(_, results, assessed): Axis<'_>, octave: usize| {
        let deviation = results.octaves.get(octave)?.deviation_counts()?;
        let relative = assessed.octaves.get(octave)?.relative.filter(|relative| relative.edf > 10.0)?;
        Some((deviation * relative.lower, deviation * relative.upper))
    };
    (0..yaw.1.octaves.len()).any(|octave| {
        let upper = |axis| bounds(axis, octave).map(|(_, upper)| upper);
        let (Some((lower, _)), Some(pitch), Some(roll)) = (bounds(yaw, octave), upper(others[0]), upper(others[1]))
        else {
            return false;
        };
        lower > YAW_FACTOR * pitch.max(roll)
    })
}

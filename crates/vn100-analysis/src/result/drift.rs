//! How far angle, velocity and position drift while the sensor coasts after a rest that gave the
//! bias: from the curves alone.

use std::time::Duration;

use imu_noise::{CurvePoint, Drift, Integral, STANDARD_GRAVITY_M_S2, Status};
use schemars::JsonSchema;
use serde::Serialize;
use vn100_protocol::Quantity;

use super::ChannelResult;
use crate::{assessment::Assessment, coast::Coast, warning::Finding};

/// A minute: beyond it the position depends on more than the noise.
const LONGEST_POSITION: Duration = Duration::from_secs(60);

/// The drift of one axis while the sensor coasts, after a rest over which its mean was taken for its
/// bias. It holds at rest, at constant temperature, for a level start and without an error of the
/// scale factor.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct DriftResult {
    /// Axis, such as gyro_z: the angle about it, or the velocity or position along it.
    pub axis: String,
    /// What drifts.
    pub of: Drifting,
    /// Unit of all values: deg, m/s or m.
    pub unit: &'static str,
    /// Length of the rest in seconds.
    pub rest_s: f64,
    /// Length of the coast in seconds.
    pub coast_s: f64,
    /// Whether there is a value.
    pub status: Status,
    /// Half the width of the interval around 0 that contains one drift at the level of the curves,
    /// with the uncertainty of the standard deviation; null without a value.
    pub within: Option<f64>,
    /// Standard deviation of the drift; null without a value.
    pub std: Option<f64>,
    /// Lower end of the confidence interval of the standard deviation.
    pub lower: Option<f64>,
    /// Upper end of the confidence interval of the standard deviation.
    pub upper: Option<f64>,
    /// Standard deviation from the accelerometer alone, without the tilt that the gyroscopes make of
    /// their drift; null for an angle.
    pub of_accelerometer: Option<f64>,
}

/// What drifts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drifting {
    /// The angle about an axis of the gyroscope: of the vertical axis, the heading.
    Angle,
    /// The velocity along an axis of the accelerometer, with the share of the tilt.
    Velocity,
    /// The position along an axis of the accelerometer, with the share of the tilt.
    Position,
}

/// The axes of one sensor.
fn axes(channels: &[ChannelResult], quantity: Quantity) -> Vec<&ChannelResult> {
    let axes = channels.iter().filter(|channel| channel.quantity == quantity && channel.is_streamed());
    axes.filter(|channel| channel.noise.is_some()).collect()
}

/// The drifts of all axes; none for a stream without a gyroscope and an accelerometer.
pub(super) fn of(channels: &[ChannelResult], coasts: &[Coast], assessment: &Assessment) -> Vec<DriftResult> {
    // the tilt turns gravity, which a dead or wrongly scaled axis does not show
    let has_gravity = !assessment.warnings.iter().any(|warning| matches!(warning.finding, Finding::Gravity(_)));
    let mut distinct: Vec<Coast> = Vec::new();
    for coast in if coasts.is_empty() { &Coast::DEFAULTS } else { coasts } {
        if !distinct.contains(coast) {
            distinct.push(*coast);
        }
    }
    let coasts = distinct;
    let gyroscope = axes(channels, Quantity::AngularRate);
    let accelerometer = axes(channels, Quantity::Acceleration);
    let made = |axis: &ChannelResult, of, coast, found: Result<(Drift, Option<Drift>), Status>| {
        let found = if assessment.motion.is_some() { Err(Status::Moved) } else { found };
        result(axis, of, coast, found, assessment.confidence)
    };
    let angles = gyroscope.iter().flat_map(|axis| {
        coasts.iter().map(|coast| {
            let found = drift(axis, Integral::Once, *coast).map(|drift| (times(drift, 1_f64.to_degrees()), None));
            made(axis, Drifting::Angle, *coast, found)
        })
    });
    let along = accelerometer.iter().enumerate().flat_map(|(place, axis)| {
        let kinds = [
            (Drifting::Velocity, Integral::Once, Integral::Twice),
            (Drifting::Position, Integral::Twice, Integral::ThreeTimes),
        ];
        let coasts = coasts.iter().filter(|coast| coast.coast <= LONGEST_POSITION);
        let all = coasts.flat_map(move |coast| kinds.map(|kind| (kind, *coast)));
        let of_kind = |((of, own, tilted), coast)| {
            let tilt = tilt(&gyroscope, &accelerometer, place, tilted, coast);
            let tilt = if has_gravity { tilt } else { Err(Status::NotMeasurable) };
            let found = tilt.and_then(|tilt| drift(axis, own, coast).map(|own| (sum(&[Some(own), tilt]), Some(own))));
            made(axis, of, coast, found)
        };
        all.map(of_kind).collect::<Vec<_>>()
    });
    angles.chain(along).collect()
}

/// The drift in degrees of the angle about an axis, after a rest as long as the coast of `coast_s`
/// seconds. `None` if the record or the message does not show it.
pub fn angle_drift(axis: &ChannelResult, coast_s: f64) -> Option<Drift> {
    let is_gyroscope = axis.quantity == Quantity::AngularRate;
    let as_long = Duration::try_from_secs_f64(coast_s).ok()?;
    let coast = Coast { rest: as_long, coast: as_long };
    let drift = drift(axis, Integral::Once, coast).ok().filter(|_| is_gyroscope)?;
    Some(times(drift, 1_f64.to_degrees()))
}

/// The drift of an axis, in its unit and seconds.
fn drift(axis: &ChannelResult, integral: Integral, coast: Coast) -> Result<Drift, Status> {
    axis.noise.as_ref().ok_or(Status::NotMeasurable)?.of_sensor()?;
    let point =
        |point: &super::Point| Some(CurvePoint { tau_s: point.tau_s, deviation: point.deviation?, edf: point.edf? });
    let curve: Vec<CurvePoint> = axis.octaves().iter().map_while(point).collect();
    Drift::new(&curve, integral, coast.rest.as_secs_f64(), coast.coast.as_secs_f64()).ok_or(Status::NotObservable)
}

/// What gravity makes of the drift of the two axes across: the mean specific force along one of them
/// times the angle about the other. `None` if neither has a share.
fn tilt(
    gyroscope: &[&ChannelResult],
    accelerometer: &[&ChannelResult],
    place: usize,
    integral: Integral,
    coast: Coast,
) -> Result<Option<Drift>, Status> {
    let is_whole = gyroscope.len() == 3 && accelerometer.len() == 3;
    if !is_whole {
        return Err(Status::NotMeasurable);
    }
    let (next, last) = ((place + 1) % 3, (place + 2) % 3);
    let of_pair = |force: usize, about: usize| {
        let mean = accelerometer[force].statistics.mean.ok_or(Status::NotObservable)?;
        // a level axis has no share
        let is_negligible = mean.abs() < 1e-6 * STANDARD_GRAVITY_M_S2;
        let drift = drift(gyroscope[about], integral, coast)?;
        Ok((!is_negligible).then(|| times(drift, mean.abs())))
    };
    let both = [of_pair(next, last)?, of_pair(last, next)?];
    Ok(both.iter().any(Option::is_some).then(|| sum(&both)))
}

fn times(drift: Drift, factor: f64) -> Drift {
    Drift { std: drift.std * factor, ..drift }
}

/// Of independent drifts (Satterthwaite, 1946); at least one is there.
fn sum(parts: &[Option<Drift>]) -> Drift {
    let parts = || parts.iter().flatten();
    let variance: f64 = parts().map(|part| part.std.powi(2)).sum();
    let error: f64 = parts().map(|part| part.std.powi(4) / part.edf).sum();
    Drift { std: variance.sqrt(), edf: variance * variance / error }
}

fn result(
    axis: &ChannelResult,
    of: Drifting,
    coast: Coast,
    found: Result<(Drift, Option<Drift>), Status>,
    confidence: f64,
) -> DriftResult {
    let drift = found.ok().map(|(drift, _)| drift);
    let interval = drift.and_then(|drift| drift.interval(confidence));
    DriftResult {
        axis: axis.name.clone(),
        of,
        unit: match of {
            Drifting::Angle => "deg",
            Drifting::Velocity => "m/s",
            Drifting::Position => "m",
        },
        rest_s: coast.rest.as_secs_f64(),
        coast_s: coast.coast.as_secs_f64(),
        status: found.err().unwrap_or(Status::Estimated),
        within: drift.and_then(|drift| drift.half_width(confidence)),
        std: drift.map(|drift| drift.std),
        lower: interval.map(|(lower, _)| lower),
        upper: interval.map(|(_, upper)| upper),
        of_accelerometer: found.ok().and_then(|(_, own)| own).map(|own| own.std),
    }
}

//! A column map for a table whose columns are named by letters: only if names, units and magnitudes
//! agree.

use std::borrow::Cow;

use super::{
    HeadRows,
    channels::known,
    column_map::STAMP,
    header::{Header, mean_at},
    name::Meaning,
    numbers_at,
    time_columns::{StampColumns, argument},
};

/// Standard gravity in each unit of an acceleration, and the tolerance for the mean of a sensor at
/// rest.
const GRAVITY: [(&str, f64); 3] = [("m/s^2", 9.80665), ("g", 1.0), ("mg", 1000.0)];
const NEAR_GRAVITY: f64 = 0.1;

/// The largest rate of a gyroscope at rest, in rad/s.
const REST_RAD_S: f64 = 0.15;

/// Three columns of a sensor.
struct Triple {
    places: Vec<usize>,
    channels: Vec<usize>,
    stated: Option<Cow<'static, str>>,
    /// The length of their mean.
    mean: f64,
}

/// The columns of accelerations whose mean is gravity in one unit, and those of rates whose unit is
/// stated or follows: rad/s beside m/s², deg/s beside g if they would be too large in rad/s.
/// `None` if the unit of either is not sure; of one sensor alone the names must say the unit.
pub(super) fn suggestion(header: &Header, stamps: Option<&StampColumns>, rows: &HeadRows) -> Option<String> {
    let (accel, gyro) = (triple(header, "accel", rows), triple(header, "gyro", rows));
    let accel_unit = accel.as_ref().and_then(|accel| {
        let is_gravity = |(_, gravity): &(&str, f64)| (accel.mean / gravity - 1.0).abs() < NEAR_GRAVITY;
        let (unit, _) = GRAVITY.into_iter().find(is_gravity)?;
        Some(unit).filter(|unit| accel.stated.as_ref().is_none_or(|stated| stated == unit))
    });
    let gyro_unit = gyro.as_ref().and_then(|gyro| match (gyro.stated.as_deref(), accel_unit) {
        (Some(unit), _) => Some(unit),
        (None, Some("m/s^2")) if gyro.mean < REST_RAD_S => Some("rad/s"),
        (None, Some("g" | "mg")) if (REST_RAD_S..REST_RAD_S.to_degrees()).contains(&gyro.mean) => Some("deg/s"),
        _ => None,
    });
    let are_both = accel.is_some() && gyro.is_some();
    let mut parts = Vec::new();
    for (triple, unit) in [(&accel, accel_unit), (&gyro, gyro_unit)] {
        let Some(triple) = triple else { continue };
        let unit = unit.filter(|_| are_both || triple.stated.is_some())?;
        let part = |(&channel, &place)| format!("{}={}:{unit}", known(channel).name, header.argument(place));
        parts.extend(triple.channels.iter().zip(&triple.places).map(part));
    }
    let are_some = !parts.is_empty();
    parts.extend(stamps.map(|stamps| format!("{STAMP}={}", argument(stamps, header))));
    are_some.then(|| parts.join(","))
}

/// The only three columns whose names fit the sensor.
fn triple(header: &Header, sensor: &str, rows: &HeadRows) -> Option<Triple> {
    let named = (0..header.names.len()).filter_map(|place| Some((place, Meaning::of(&header.described(place), None)?)));
    let is_of = |(place, meaning): &(usize, Meaning)| {
        meaning.sensor() == sensor && !matches!(meaning.unit, Some(Err(_))) && numbers_at(rows, *place).next().is_some()
    };
    let mut found: Vec<(usize, Meaning)> = named.filter(is_of).collect();
    found.sort_by_key(|(_, meaning)| meaning.channel);
    let channels: Vec<usize> = found.iter().map(|(_, meaning)| meaning.channel).collect();
    let stated = |meaning: &Meaning| meaning.unit.clone().and_then(Result::ok).map(|unit| unit.name);
    let first = &found.first()?.1;
    let are_alike = found.iter().all(|(_, axis)| axis.group == first.group && stated(axis) == stated(first));
    let places: Vec<usize> = found.iter().map(|(place, _)| *place).collect();
    let mean = places.iter().map(|&place| mean_at(rows, place).powi(2)).sum::<f64>().sqrt();
    let are_axes = channels.len() == 3 && channels.is_sorted_by(|a, b| a < b) && are_alike;
    are_axes.then(|| Triple { places, channels, stated: stated(first), mean })
}

//! A column map for a table whose columns are named by letters: only if names, units and magnitudes
//! agree.

use super::{
    HeadRows,
    channels::known,
    column_map::STAMP,
    header::Header,
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
    places: [usize; 3],
    channels: [usize; 3],
    stated: Option<&'static str>,
}

/// The columns of accelerations whose mean is gravity in one unit, and those of rates whose unit is
/// stated or follows: rad/s beside m/s², deg/s beside g if they would be too large in rad/s.
/// `None` if the unit of either is not sure.
pub(super) fn suggestion(header: &Header, stamps: Option<&StampColumns>, rows: &HeadRows) -> Option<String> {
    let accel_unit = |accel: &Triple| {
        let mean = mean_length(rows, accel.places);
        let is_gravity = |(_, gravity): &(&str, f64)| (mean / gravity - 1.0).abs() < NEAR_GRAVITY;
        let (unit, _) = GRAVITY.into_iter().find(is_gravity)?;
        accel.stated.is_none_or(|stated| stated == unit).then_some(unit)
    };
    let accel = match triple(header, "accel", rows) {
        Some(accel) => Some((accel_unit(&accel)?, accel)),
        None => None,
    };
    let gyro_unit = |gyro: &Triple| {
        let rate = mean_length(rows, gyro.places);
        match (gyro.stated, accel.as_ref().map(|(unit, _)| *unit)) {
            (Some(unit), _) => Some(unit),
            (None, Some("m/s^2")) if rate < REST_RAD_S => Some("rad/s"),
            (None, Some("g" | "mg")) if (REST_RAD_S..REST_RAD_S.to_degrees()).contains(&rate) => Some("deg/s"),
            _ => None,
        }
    };
    let gyro = match triple(header, "gyro", rows) {
        Some(gyro) => Some((gyro_unit(&gyro)?, gyro)),
        None => None,
    };
    // of one sensor alone the names must say the unit
    let is_sure = match (&accel, &gyro) {
        (Some(_), Some(_)) => true,
        (Some((_, alone)), None) | (None, Some((_, alone))) => alone.stated.is_some(),
        (None, None) => false,
    };
    if !is_sure {
        return None;
    }
    let parts = accel.into_iter().chain(gyro).flat_map(|(unit, triple)| {
        let part = |(channel, place)| format!("{}={}:{unit}", known(channel).name, header.argument(place));
        triple.channels.into_iter().zip(triple.places).map(part).collect::<Vec<_>>()
    });
    let times = stamps.map(|stamps| format!("{STAMP}={}", argument(stamps, header)));
    Some(parts.chain(times).collect::<Vec<_>>().join(","))
}

/// The only three columns whose names fit the sensor.
fn triple(header: &Header, sensor: &str, rows: &HeadRows) -> Option<Triple> {
    let named = (0..header.names.len()).filter_map(|place| Some((place, Meaning::of(&header.described(place), None)?)));
    let is_of = |(place, meaning): &(usize, Meaning)| {
        known(meaning.channel).name.starts_with(sensor)
            && !matches!(meaning.unit, Some(Err(_)))
            && numbers_at(rows, *place).next().is_some()
    };
    let mut found: Vec<(usize, Meaning)> = named.filter(is_of).collect();
    found.sort_by_key(|(_, meaning)| meaning.channel);
    let [(_, x), (_, y), (_, z)] = &found[..] else { return None };
    let channels = [x.channel, y.channel, z.channel];
    let are_axes = channels.is_sorted_by(|a, b| a < b) && x.unit == y.unit && y.unit == z.unit;
    let stated = x.unit.as_ref().and_then(|unit| unit.as_ref().ok()).map(|unit| &*unit.name);
    let places = [found[0].0, found[1].0, found[2].0];
    (are_axes && x.group == y.group && y.group == z.group).then_some(Triple { places, channels, stated })
}

/// The length of the mean of three columns.
fn mean_length(rows: &HeadRows, places: [usize; 3]) -> f64 {
    let mean = |place: usize| {
        let numbers: Vec<f64> = numbers_at(rows, place).map(|number| number.value()).collect();
        numbers.iter().sum::<f64>() / numbers.len() as f64
    };
    places.map(mean).map(|mean| mean * mean).iter().sum::<f64>().sqrt()
}

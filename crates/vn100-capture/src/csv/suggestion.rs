//! A column map for a table whose columns are named by letters: only if names, units and magnitudes
//! agree.

use super::{
    HeadRows,
    column_map::{STAMP, known},
    header::Header,
    name::{Meaning, StatedUnit},
    numbers_at,
    stamp_search::StampColumns,
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

/// The columns of accelerations whose mean is gravity in one unit, and the columns of rates whose
/// unit is stated or follows: rad/s with m/s², deg/s with g if they would be too large in rad/s.
/// `None` if either is uncertain.
pub(super) fn suggestion(header: &Header, stamps: Option<&StampColumns>, rows: &HeadRows) -> Option<String> {
    let accel = triple(header, "accel", rows)?;
    let (accel_unit, _) = GRAVITY.into_iter().find(|(unit, gravity)| {
        (mean_length(rows, accel.places) / gravity - 1.0).abs() < NEAR_GRAVITY
            && accel.stated.is_none_or(|stated| stated == *unit)
    })?;
    let gyro = triple(header, "gyro", rows)?;
    let rate = mean_length(rows, gyro.places);
    let gyro_unit = match (gyro.stated, accel_unit) {
        (Some(unit), _) => unit,
        (None, "m/s^2") if rate < REST_RAD_S => "rad/s",
        (None, "g" | "mg") if (REST_RAD_S..REST_RAD_S.to_degrees()).contains(&rate) => "deg/s",
        _ => return None,
    };
    let parts = [(accel, accel_unit), (gyro, gyro_unit)].into_iter().flat_map(|(triple, unit)| {
        let part = |(channel, place)| format!("{}={}:{unit}", known(channel).name, header.argument(place));
        triple.channels.into_iter().zip(triple.places).map(part).collect::<Vec<_>>()
    });
    let times = stamps.map(|stamps| format!("{STAMP}={}", stamps.named(header)));
    Some(parts.chain(times).collect::<Vec<_>>().join(","))
}

/// The only three columns whose names fit the sensor.
fn triple(header: &Header, sensor: &str, rows: &HeadRows) -> Option<Triple> {
    let named = (0..header.names.len()).filter_map(|place| Some((place, Meaning::of(&header.described(place), None)?)));
    let is_of = |(place, meaning): &(usize, Meaning)| {
        known(meaning.channel).name.starts_with(sensor)
            && !matches!(meaning.unit, StatedUnit::Unknown(_))
            && numbers_at(rows, *place).next().is_some()
    };
    let mut found: Vec<(usize, Meaning)> = named.filter(is_of).collect();
    found.sort_by_key(|(_, meaning)| meaning.channel);
    let [x, y, z] = found.try_into().ok()?;
    let unit = |(_, meaning): &(usize, Meaning)| match meaning.unit {
        StatedUnit::Known(unit) => Some(&*unit.name),
        StatedUnit::None | StatedUnit::Unknown(_) => None,
    };
    let channels = [x.1.channel, y.1.channel, z.1.channel];
    let are_axes =
        channels[0] < channels[1] && channels[1] < channels[2] && unit(&x) == unit(&y) && unit(&y) == unit(&z);
    let of_one_group = x.1.group == y.1.group && y.1.group == z.1.group;
    (are_axes && of_one_group).then(|| Triple { places: [x.0, y.0, z.0], channels, stated: unit(&x) })
}

/// The length of the mean of three columns.
fn mean_length(rows: &HeadRows, places: [usize; 3]) -> f64 {
    let mean = |place: usize| {
        let numbers: Vec<f64> = numbers_at(rows, place).map(|number| number.value()).collect();
        numbers.iter().sum::<f64>() / numbers.len() as f64
    };
    places.map(mean).map(|mean| mean * mean).iter().sum::<f64>().sqrt()
}

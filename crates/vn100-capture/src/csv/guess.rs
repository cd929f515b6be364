//! A column map that may fit a table whose columns are not known, for its user to check.

use vn100_protocol::Quantity;

use super::{
    column_map::{self, known},
    header::Header,
    stamp_columns::StampColumns,
};

/// Words in the names of columns, for the quantity of an axis.
const AXES: [(&str, &[&str]); 3] = [
    ("gyro", &["gyr", "gyro", "gyroscope", "omega", "angular", "rate", "angvel", "w", "g"]),
    ("accel", &["acc", "accel", "acceleration", "accelerometer", "linear", "a", "f"]),
    ("mag", &["mag", "magn", "magnetic", "magnetometer", "field", "m", "b", "h"]),
];

/// How units are written in the names of columns.
const UNITS: [(&str, &[&str]); 9] = [
    ("deg/s", &["deg/s", "dps", "°/s", "degps", "deg_s"]),
    ("deg/h", &["deg/h", "°/h"]),
    ("mdeg/s", &["mdeg/s", "mdps"]),
    ("rad/s", &["rad/s", "radps", "rad_s"]),
    ("m/s^2", &["m/s^2", "m/s2", "m/s²", "mps2"]),
    ("mg", &["[mg]", "(mg)"]),
    ("g", &["[g]", "(g)"]),
    ("uT", &["ut]", "ut)", "µt"]),
    ("gauss", &["gauss"]),
];

/// Channels by the names of the columns; where these say nothing six numbers side by side, the
/// rates first.
pub(super) fn guess(header: &Header, stamps: Option<&StampColumns>) -> String {
    let is_stamp = |place: usize| stamps.is_some_and(|stamps| stamps.columns.iter().any(|&(taken, _)| taken == place));
    let has_name = |place: usize| !header.names[place].is_empty();
    let free: Vec<usize> = (0..header.names.len()).filter(|&place| has_name(place) && !is_stamp(place)).collect();
    let mut found: Vec<(usize, String)> = Vec::new();
    for &place in &free {
        if let Some(channel) = channel(&header.names[place])
            && found.iter().all(|(_, other)| *other != channel)
        {
            found.push((place, channel));
        }
    }
    if found.is_empty() {
        let names = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"];
        found = free.into_iter().zip(names.map(str::to_owned)).collect();
    }
    let mut parts: Vec<String> = found
        .iter()
        .map(|(place, channel)| {
            format!("{channel}={}:{}", header.argument(*place), unit(&header.names[*place], channel))
        })
        .collect();
    parts.extend(stamps.map(|stamps| format!("{}={}", column_map::STAMP, stamps.named(header))));
    parts.join(",")
}

/// The channel that a column of this name may hold.
fn channel(name: &str) -> Option<String> {
    let name = name.to_lowercase();
    let bare = name.split(['[', '(']).next().unwrap_or_default();
    let words: Vec<&str> = bare.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    if words.iter().any(|word| word.starts_with("temp")) {
        return Some("temperature".into());
    }
    let last = words.last()?;
    let (stem, axis) = last.char_indices().last().map(|(at, axis)| (&last[..at], axis))?;
    let axis = match axis {
        'x' | 'y' | 'z' => axis,
        _ => return None,
    };
    let stems: Vec<&str> = words.iter().rev().skip(1).copied().chain([stem]).filter(|stem| !stem.is_empty()).collect();
    let (sensor, _) = AXES.iter().find(|(_, known)| stems.iter().any(|stem| known.contains(stem)))?;
    Some(format!("{sensor}_{axis}"))
}

/// The unit in the name of a column, else that of the channel.
fn unit(name: &str, channel: &str) -> String {
    let quantity = column_map::by_name(channel).map_or(Quantity::Value, |index| known(index).quantity);
    let units: Vec<&str> = column_map::units(quantity).map(|unit| &*unit.name).collect();
    let name = name.to_lowercase();
    let written =
        UNITS.iter().find(|(unit, forms)| units.contains(unit) && forms.iter().any(|form| name.contains(form)));
    written.map(|(unit, _)| *unit).or(units.first().copied()).unwrap_or("1").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_guessed_by_their_names_and_units_else_by_their_places() {
        for (line, expected) in [
            ("wx,wy,az", "gyro_x=wx:rad/s,gyro_y=wy:rad/s,accel_z=az:m/s^2"),
            (
                "angular_velocity.x;linear_acceleration.z",
                "gyro_x=angular_velocity.x:rad/s,accel_z=linear_acceleration.z:m/s^2",
            ),
            (
                "Gyroscope X (dps),Acc Y [g],Temp",
                "gyro_x=Gyroscope X (dps):deg/s,accel_y=Acc Y [g]:g,temperature=Temp:degC",
            ),
            ("GyrX[deg/s],MagZ [uT]", "gyro_x=GyrX[deg/s]:deg/s,mag_z=MagZ [uT]:uT"),
            ("one,two", "gyro_x=one:rad/s,gyro_y=two:rad/s"),
            (",one,two", "gyro_x=one:rad/s,gyro_y=two:rad/s"),
        ] {
            let guessed = guess(&Header::read(line.as_bytes(), if line.contains(';') { b';' } else { b',' }), None);
            assert_eq!(guessed, expected);
            assert!(guessed.parse::<column_map::ColumnMap>().is_ok(), "{guessed}");
        }
    }
}

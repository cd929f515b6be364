//! A column map that may fit a table with unknown columns, for the user to check.

use vn100_protocol::Quantity;

use super::{
    column_map::{STAMP, by_name, known, units},
    column_name::unit_behind,
    header::Header,
    number::Number,
    stamp_columns::StampColumns,
    time_name::is_time_name,
};

/// Words in the names of columns, for the quantity of an axis.
const AXES: [(&str, &[&str]); 3] = [
    ("gyro", &["gyr", "gyro", "gyroscope", "omega", "angular", "rate", "angvel", "w", "g"]),
    ("accel", &["acc", "accel", "acceleration", "accelerometer", "accl", "linear", "a", "f"]),
    ("mag", &["mag", "magn", "magnetic", "magnetometer", "field", "m", "b", "h"]),
];

/// Channels by the names of the columns; where the names do not help, six neighbouring columns of
/// numbers, the rates first unless the second three measure gravity.
pub(super) fn guess(header: &Header, stamps: Option<&StampColumns>, rows: &[Vec<Vec<u8>>]) -> String {
    let is_stamp = |place: usize| stamps.is_some_and(|stamps| stamps.columns.iter().any(|&(taken, _)| taken == place));
    let may_be_channel = |place: &usize| {
        let name = &header.names[*place];
        !name.is_empty() && !is_time_name(&header.described(*place)) && !is_stamp(*place)
    };
    let free: Vec<usize> = (0..header.names.len()).filter(may_be_channel).collect();
    let mut found: Vec<(usize, String)> = Vec::new();
    for &place in &free {
        if let Some(channel) = channel(&header.names[place])
            && found.iter().all(|(_, other)| *other != channel)
        {
            found.push((place, channel));
        }
    }
    if found.iter().all(|(_, channel)| !channel.starts_with("gyro") && !channel.starts_with("accel")) {
        let mut places: Vec<usize> =
            free.into_iter().filter(|place| found.iter().all(|(taken, _)| taken != place)).collect();
        places.retain(|&place| rows.is_empty() || holds_measurements(rows, place));
        // at least besides the columns that are named as a triple
        if !found.is_empty() && places.len() < 3 {
            places.clear();
        }
        // x, y and z in any order
        places.sort_by_key(|&place| axis(&header.names[place]));
        let is_gravity = places.get(..3).is_some_and(|first| gravity_unit(rows, first).is_some());
        let names = if is_gravity { ["accel", "gyro"] } else { ["gyro", "accel"] };
        let names = names.into_iter().flat_map(|sensor| ["x", "y", "z"].map(|axis| format!("{sensor}_{axis}")));
        found.splice(0..0, places.into_iter().zip(names));
    }
    let is_acceleration = |channel: &str| channel.starts_with("accel");
    let accelerations = found.iter().filter(|(_, channel)| is_acceleration(channel)).map(|(place, _)| *place);
    let gravity = gravity_unit(rows, &accelerations.collect::<Vec<_>>());
    let unit = |place: usize, channel: &str| {
        let quantity = by_name(channel).map_or(Quantity::Value, |index| known(index).quantity);
        let written = unit_behind(&header.described(place), quantity).map(|unit| &*unit.name);
        let own = || units(quantity).next().map(|unit| &*unit.name);
        written.or(gravity.filter(|_| is_acceleration(channel))).or_else(own).unwrap_or("1")
    };
    let mut parts: Vec<String> = found
        .iter()
        .map(|(place, channel)| format!("{channel}={}:{}", header.argument(*place), unit(*place, channel)))
        .collect();
    parts.extend(stamps.map(|stamps| format!("{}={}", STAMP, stamps.named(header))));
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
    let is_axis = |word: &str| matches!(word, "x" | "y" | "z");
    // the axis is a word of its own, else the last letter
    let (axis, stems) = match words.iter().position(|word| is_axis(word)) {
        Some(place) => (words[place], [&words[..place], &words[place + 1..]].concat()),
        None => {
            let (last, others) = words.split_last()?;
            let (stem, axis) = last.split_at_checked(last.len() - 1)?;
            (axis, [others, &[stem]].concat())
        }
    };
    let (sensor, _) = AXES.iter().find(|(_, known)| stems.iter().rev().any(|stem| known.contains(stem)))?;
    is_axis(axis).then(|| format!("{sensor}_{axis}"))
}

/// The place of a name that consists of an axis alone; 0 for any other name.
fn axis(name: &str) -> usize {
    ["x", "y", "z"].iter().position(|axis| name.eq_ignore_ascii_case(axis)).unwrap_or_default()
}

/// Whether a column holds numbers other than the number of the row.
fn holds_measurements(rows: &[Vec<Vec<u8>>], place: usize) -> bool {
    let numbers: Vec<f64> = numbers(rows, place).collect();
    let steps: Vec<f64> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let counts_rows = steps.iter().all(|step| *step == steps[0] && *step != 0.0);
    2 * numbers.len() > rows.len() && (steps.len() < 2 || !counts_rows)
}

/// The unit in which the magnitude of the mean of three axes is that of gravity.
fn gravity_unit(rows: &[Vec<Vec<u8>>], places: &[usize]) -> Option<&'static str> {
    if places.len() != 3 {
        return None;
    }
    let mean = |place: &usize| {
        let numbers: Vec<f64> = numbers(rows, *place).collect();
        numbers.iter().sum::<f64>() / numbers.len() as f64
    };
    let norm = places.iter().map(mean).map(|mean| mean * mean).sum::<f64>().sqrt();
    let near = |gravity: f64| (norm / gravity - 1.0).abs() < 0.05;
    [("m/s^2", 9.80665), ("g", 1.0), ("mg", 1000.0)]
        .into_iter()
        .find_map(|(unit, gravity)| near(gravity).then_some(unit))
}

fn numbers(rows: &[Vec<Vec<u8>>], place: usize) -> impl Iterator<Item = f64> {
    rows.iter().filter_map(move |row| Number::parse(row.get(place)?)).map(|number| number.value())
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
            ("X_GYRO,Z_ACCL,TEMP_OUT", "gyro_x=X_GYRO:rad/s,accel_z=Z_ACCL:m/s^2,temperature=TEMP_OUT:degC"),
            ("seconds_elapsed,z,y,x", "gyro_x=x:rad/s,gyro_y=y:rad/s,gyro_z=z:rad/s"),
            ("temp,a,b,c", "gyro_x=a:rad/s,gyro_y=b:rad/s,gyro_z=c:rad/s,temperature=temp:degC"),
            ("temp,a,b", "temperature=temp:degC"),
        ] {
            let guessed =
                guess(&Header::read(line.as_bytes(), if line.contains(';') { b';' } else { b',' }), None, &[]);
            assert_eq!(guessed, expected);
            assert!(guessed.parse::<crate::ColumnMap>().is_ok(), "{guessed}");
        }
    }

    #[test]
    fn numbers_that_measure_gravity_are_accelerations() {
        let rows = |line: &str| vec![line.split(',').map(|cell| cell.as_bytes().to_vec()).collect::<Vec<_>>(); 2];
        let adis = Header::read(b"X_GYRO,X_ACCL,Y_ACCL,Z_ACCL", b',');
        assert_eq!(
            guess(&adis, None, &rows("0.5,3.0,-10.0,-995.0")),
            "gyro_x=X_GYRO:rad/s,accel_x=X_ACCL:mg,accel_y=Y_ACCL:mg,accel_z=Z_ACCL:mg"
        );
        for (line, expected) in [
            (
                "0.01,0.02,0.03,0.1,0.2,-9.8",
                "gyro_x=1:rad/s,gyro_y=2:rad/s,gyro_z=3:rad/s,accel_x=4:m/s^2,accel_y=5:m/s^2,accel_z=6:m/s^2",
            ),
            (
                "0.01,0.7,0.7,0.1,0.2,0.3",
                "accel_x=1:g,accel_y=2:g,accel_z=3:g,gyro_x=4:rad/s,gyro_y=5:rad/s,gyro_z=6:rad/s",
            ),
            ("0.01,0.02", "gyro_x=1:rad/s,gyro_y=2:rad/s"),
        ] {
            assert_eq!(guess(&Header::read(line.as_bytes(), b','), None, &rows(line)), expected);
        }
    }
}

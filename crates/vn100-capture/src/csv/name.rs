//! The meaning of a column's name: `gyro_x [deg/s]`, `UncompAccZ`, `acc_l_x[mg]`,
//! `field.angular_velocity.x`, `accelerometer_m_s2[2]`, `w_RS_S_x [rad s^-1]`, `X (m/s^2)`.

use vn100_protocol::Quantity::{
    self, Acceleration, Angle, AngularRate, MagneticField, Pressure, Quaternion, Temperature,
};

use super::{
    channels::{Unit, by_name, known, names, quantity_word, unit_of},
    stamp::time_unit,
};

/// Words for a sensor, or two words in one, with the sensor's name in our channels.
const WORDS: [(&str, &[&str]); 3] = [
    (
        "gyro",
        &["gyro", "gyr", "gyros", "gyroscope", "angularvelocity", "angularrate", "angvel", "rotationrate", "rotrate"],
    ),
    ("accel", &["accel", "acc", "accl", "acceleration", "accelerometer"]),
    ("mag", &["mag", "magn", "magnetometer", "magneticfield", "magfield"]),
];

/// Letters for a sensor, valid only together with a unit of its quantity.
const LETTERS: [(&str, &[&str]); 3] =
    [("gyro", &["w", "g", "gy", "omega"]), ("accel", &["a", "ac", "f", "t"]), ("mag", &["m", "b", "h"])];

/// Words that turn the name of a sensor into another quantity.
const OTHER_QUANTITIES: &str = "std stddev sigma cov covariance var variance bias offset scale norm temp temperature time timestamp \
     stamp dt integral clipping status count accuracy flag delta gravity error rms mean max min setpoint ref target jerk world \
     earth ned enu global diff";

const UNCOMPENSATED: [&str; 2] = ["uncomp", "uncompensated"];
const COMPENSATED: [&str; 2] = ["comp", "compensated"];
const WITHOUT_GRAVITY: [&str; 3] = ["linear", "lin", "user"];

/// Words for numbers without a unit.
const RAW: [&str; 5] = ["raw", "lsb", "adc", "counts", "ticks"];

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Meaning {
    /// The channel, as in [`known`].
    pub(super) channel: usize,
    /// The stated unit; an error for a unit that is not known, or is not one of the quantity.
    pub(super) unit: Option<Result<&'static Unit, String>>,
    pub(super) made: Made,
    /// Whether a word or the unit of an axis names the sensor, rather than a single letter.
    pub(super) is_sure: bool,
    /// The common part of the names of one triple of axes.
    pub(super) group: String,
}

/// How numbers of a sensor were made; the first is preferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Made {
    Uncompensated,
    Unsaid,
    Compensated,
    /// Acceleration without gravity.
    WithoutGravity,
}

impl Meaning {
    /// The meaning of the name of a column in the file `file`, whose name may tell the quantity of
    /// bare axes.
    pub(super) fn of(name: &str, file: Option<&str>) -> Option<Self> {
        let (bare, brackets) = without_brackets(name);
        let mut words = words(&bare);
        part_uncompensated(&mut words);
        let of_axis = |content: &str| match content {
            "0" | "x" | "X" => Some('x'),
            "1" | "y" | "Y" => Some('y'),
            "2" | "z" | "Z" => Some('z'),
            _ => None,
        };
        let index = brackets.iter().find_map(|content| of_axis(content));
        let stated = brackets.into_iter().rfind(|content| of_axis(content).is_none() && !content.is_empty());
        if let Some(meaning) = single(&words, stated.as_deref()) {
            return Some(meaning);
        }
        let named = index.or_else(|| take_axis(&mut words));
        // a number may be that of an axis, or of a sensor
        let axis = named.or_else(|| take_number_of_axis(&mut words))?;
        let (sensor, is_sure) = match sensor_word(&words) {
            Some(sensor) => (sensor, named.is_some()),
            None if words.is_empty() => (sensor_of_bare_axis(stated.as_deref(), file)?, true),
            None => (sensor_letter(&words).or_else(|| sensor_of_unit(stated.as_deref()?))?, false),
        };
        let channel = by_name(&format!("{sensor}_{axis}"))?;
        let quantity = known(channel).quantity;
        let has = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
        let is_of_rotation = quantity == Acceleration && has(&["angular", "rotation", "rotational"]);
        let is_other = words.iter().any(|word| OTHER_QUANTITIES.split(' ').any(|other| other == word));
        if is_other || is_of_rotation {
            return None;
        }
        let unit = match (stated, unit_among(quantity, &words)) {
            (Some(stated), _) => Some(unit_of(quantity, &stated).ok_or(stated)),
            (None, Some(unit)) => Some(Ok(unit)),
            (None, None) => has(&RAW).then(|| Err("raw".into())),
        };
        let made = match () {
            () if has(&UNCOMPENSATED) => Made::Uncompensated,
            () if has(&COMPENSATED) => Made::Compensated,
            () if quantity == Acceleration && has(&WITHOUT_GRAVITY) => Made::WithoutGravity,
            () => Made::Unsaid,
        };
        Some(Self { channel, unit, made, is_sure, group: format!("{sensor} {}", words.join(" ")) })
    }
}

/// The channels that have no axes: yaw, temperature and the like, alone or with a unit.
fn single(words: &[String], stated: Option<&str>) -> Option<Meaning> {
    let above = words.iter().take_while(|word| ABOVE.contains(&word.as_str())).count();
    let words = &words[above..];
    let (channel, rest) = (1..=words.len()).rev().find_map(|count| {
        let name = words[..count].concat();
        let name = match name.as_str() {
            "temp" => "temperature",
            "pres" | "press" => "pressure",
            name => name.strip_prefix("quaternion").map_or(name, |_| name),
        };
        let is_so = |channel: &usize| known(*channel).name.replace('_', "") == name.replace("quaternion", "quat");
        let is_single =
            |channel: &usize| matches!(known(*channel).quantity, Angle | Quaternion | Temperature | Pressure);
        let channel = (0..names().count()).find(is_so)?;
        Some((channel, words[count..].concat())).filter(|(channel, _)| is_single(channel))
    })?;
    let quantity = known(channel).quantity;
    let unit = match stated.or(Some(rest.as_str()).filter(|rest| !rest.is_empty())) {
        None => None,
        Some(text) => match unit_of(quantity, text) {
            None if stated.is_none() || !rest.is_empty() => return None,
            known => Some(known.ok_or_else(|| text.to_owned())),
        },
    };
    let group = quantity_word(&known(channel).name).to_owned();
    Some(Meaning { channel, unit, made: Made::Unsaid, is_sure: true, group })
}

/// Prefixes of the name of a sensor that have no meaning.
const ABOVE: [&str; 3] = ["field", "imu", "sensor"];

/// The name without its text in brackets, and that text.
fn without_brackets(name: &str) -> (String, Vec<String>) {
    let (mut bare, mut brackets) = (String::new(), Vec::new());
    let mut rest = name.trim();
    while let Some(begin) = rest.find(['[', '(']) {
        let (before, inside) = rest.split_at(begin);
        bare.extend([before, " "]);
        // units have brackets of their own, as in m/(s^2)
        let close = if inside.starts_with('[') { ']' } else { ')' };
        let end = inside.rfind(close).filter(|_| !inside[1..].contains('[')).or(inside.find(close));
        brackets.push(inside[1..end.unwrap_or(inside.len())].trim().to_owned());
        rest = end.map_or("", |end| &inside[end + 1..]);
    }
    bare.push_str(rest);
    (bare, brackets)
}

/// Separates the words of the maker's messages, as in `uncompgyro.x`.
fn part_uncompensated(words: &mut Vec<String>) {
    let place = words.iter().position(|word| {
        let sensor = word.strip_prefix(UNCOMPENSATED[0]).map(|rest| rest.strip_suffix(['x', 'y', 'z']).unwrap_or(rest));
        sensor.is_some_and(|sensor| WORDS.iter().any(|(_, known)| known.contains(&sensor)))
    });
    if let Some(place) = place {
        let sensor = words[place].split_off(UNCOMPENSATED[0].len());
        words.insert(place + 1, sensor);
    }
}

/// Removes the axis from the words and returns it: a word, or the last letter of the word for the sensor.
fn take_axis(words: &mut Vec<String>) -> Option<char> {
    let is_axis = |word: &str| matches!(word, "x" | "y" | "z");
    if let Some(place) = words.iter().rposition(|word| is_axis(word)) {
        return words.remove(place).chars().next();
    }
    let is_sensor = |stem: &str| WORDS.iter().chain(&LETTERS).any(|(_, known)| known.contains(&stem));
    let place = words.iter().position(|word| {
        let stem = word.strip_suffix(['x', 'y', 'z']);
        stem.is_some_and(is_sensor)
    })?;
    words[place].pop()
}

/// The number of an axis from 1, as MATLAB writes it after the name of a matrix: `AngularVelocity_1`.
fn take_number_of_axis(words: &mut Vec<String>) -> Option<char> {
    let axes = [("1", 'x'), ("2", 'y'), ("3", 'z')];
    let (_, axis) = axes.into_iter().find(|(number, _)| words.last().is_some_and(|last| last == number))?;
    words.pop();
    Some(axis)
}

fn sensor_word(words: &[String]) -> Option<&'static str> {
    let pairs = words.windows(2).map(<[String]>::concat);
    let single = words.iter().map(|word| word.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned());
    let sensor =
        |word: String| WORDS.iter().find(|(_, known)| known.contains(&word.as_str())).map(|(sensor, _)| *sensor);
    pairs.chain(single).find_map(sensor)
}

fn sensor_letter(words: &[String]) -> Option<&'static str> {
    words
        .iter()
        .find_map(|word| LETTERS.iter().find(|(_, known)| known.contains(&word.as_str())))
        .map(|(sensor, _)| *sensor)
}

/// The sensor of columns named only `x`, `y` and `z`, from their unit or the name of the file.
fn sensor_of_bare_axis(stated: Option<&str>, file: Option<&str>) -> Option<&'static str> {
    let file = file.unwrap_or_default().to_lowercase();
    let words = [("gyro", "gyro"), ("accel", "accel"), ("mag", "magnet")];
    let by_file = words.into_iter().find(|(_, word)| file.contains(word)).map(|(sensor, _)| sensor);
    match stated {
        Some(unit) => sensor_of_unit(unit).filter(|by_unit| by_file.is_none_or(|by_file| by_file == *by_unit)),
        None => by_file,
    }
}

/// The sensor whose numbers have this unit; none for degrees, which are those of angles.
fn sensor_of_unit(unit: &str) -> Option<&'static str> {
    let of_sensors = [("gyro", AngularRate), ("accel", Acceleration), ("mag", MagneticField)];
    let sensor = of_sensors.into_iter().find(|(_, quantity)| unit_of(*quantity, unit).is_some());
    sensor.filter(|_| unit_of(Angle, unit).is_none()).map(|(sensor, _)| sensor)
}

/// The unit that words beside the sensor are.
fn unit_among(quantity: Quantity, words: &[String]) -> Option<&'static Unit> {
    let runs = (1..=4_usize.min(words.len())).rev().flat_map(|length| words.windows(length));
    { runs }.find_map(|run| unit_of(quantity, &run.concat()))
}

/// Whether people write a unit of a channel or of a time in this way.
pub(super) fn is_unit(text: &str) -> bool {
    let quantities = [Angle, MagneticField, Acceleration, AngularRate, Temperature, Pressure];
    time_unit(&text.to_lowercase()).is_some()
        || quantities.into_iter().any(|quantity| unit_of(quantity, text).is_some())
}

/// The words of a name in lower case, also words separated by capitals: `UncompGyroX`, `GYR_Z`.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let characters: Vec<char> = name.chars().collect();
    for (at, &c) in characters.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| characters[before]);
        let after = characters.get(at + 1);
        let begins = c.is_uppercase()
            && before.is_some_and(|before| {
                before.is_lowercase() || before.is_ascii_digit() || after.is_some_and(|after| after.is_lowercase())
            });
        if begins || !c.is_alphanumeric() {
            words.push(String::new());
        }
        if let (true, Some(word)) = (c.is_alphanumeric(), words.last_mut()) {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(name: &str, file: Option<&str>) -> Option<(&'static str, Option<String>, Made, bool)> {
        let meaning = Meaning::of(name, file)?;
        let unit = meaning.unit.map(|unit| unit.map_or_else(|text| format!("?{text}"), |unit| unit.name.to_string()));
        Some((&known(meaning.channel).name, unit, meaning.made, meaning.is_sure))
    }

    #[test]
    fn names_as_people_write_them() {
        for (name, channel, unit) in [
            ("gyro_x", "gyro_x", ""),
            ("GyroX", "gyro_x", ""),
            ("GYR_Z", "gyro_z", ""),
            ("X_GYRO", "gyro_x", ""),
            ("Gyro X [deg/s]", "gyro_x", "deg/s"),
            ("gyro_y (°/s)", "gyro_y", "deg/s"),
            ("gyro_x_deg_s", "gyro_x", "deg/s"),
            ("GyroX_deg_per_s", "gyro_x", "deg/s"),
            ("gyro_x_dps", "gyro_x", "deg/s"),
            ("gyro_x[rpm]", "gyro_x", "rpm"),
            ("gyro_rad[2]", "gyro_z", "rad/s"),
            ("motionRotationRateX(rad/s)", "gyro_x", "rad/s"),
            ("field.angular_velocity.x", "gyro_x", ""),
            ("angular_velocity_z [rad/s]", "gyro_z", "rad/s"),
            ("linear_acceleration.y", "accel_y", ""),
            ("Acc_X(g)", "accel_x", "g"),
            ("acc_l_x[mg]", "accel_x", "mg"),
            ("accel_x (m/s^2)", "accel_x", "m/s^2"),
            ("accel_x [m/s²]", "accel_x", "m/s^2"),
            ("accel_x [cm/s^2]", "accel_x", "cm/s^2"),
            ("acc_z_ft_s2", "accel_z", "ft/s^2"),
            ("acc_z_m_s2", "accel_z", "m/s^2"),
            ("accelerometer_m_s2[2]", "accel_z", "m/s^2"),
            ("accelerometer_lsm6ds3_c.z", "accel_z", ""),
            ("Mag X (µT)", "mag_x", "uT"),
            ("magnY[mG]", "mag_y", "mgauss"),
            ("mag_z_gauss", "mag_z", "gauss"),
            ("Temp [°C]", "temperature", "degC"),
            ("temperature_K", "temperature", "K"),
            ("pressure (hPa)", "pressure", "hPa"),
            ("yaw_rad", "yaw", "rad"),
            ("Quat_W", "quat_w", ""),
            ("X (m/s^2)", "accel_x", "m/s^2"),
            ("y (rad/s)", "gyro_y", "rad/s"),
        ] {
            let found =
                said(name, None).map(|(channel, unit, _, is_sure)| (channel, unit.unwrap_or_default(), is_sure));
            assert_eq!(found, Some((channel, unit.to_owned(), true)), "{name}");
        }
    }

    #[test]
    fn letters_are_names_with_their_unit() {
        for (name, channel, unit) in [
            ("w_RS_S_x [rad s^-1]", "gyro_x", Some("rad/s")),
            ("a_RS_S_z [m s^-2]", "accel_z", Some("m/s^2")),
            ("A_X [g]", "accel_x", Some("g")),
            ("G_Y [mdps]", "gyro_y", Some("mdeg/s")),
            ("wz(deg/s)", "gyro_z", Some("deg/s")),
            ("ax", "accel_x", None),
            ("GyX", "gyro_x", None),
            ("AcZ", "accel_z", None),
            ("w.x", "gyro_x", None),
            ("AngularVelocity_1", "gyro_x", None),
            ("LinearAcceleration_3", "accel_z", None),
            ("Drehrate Y [°/s]", "gyro_y", Some("deg/s")),
            ("Beschleunigung z (m/s²)", "accel_z", Some("m/s^2")),
        ] {
            let found = said(name, None).map(|(channel, unit, _, is_sure)| (channel, unit, is_sure));
            assert_eq!(found, Some((channel, unit.map(str::to_owned), false)), "{name}");
        }
        // the bias of a gyroscope in ground truth
        let bias = said("b_w_RS_S_x [rad s^-1]", None).unwrap();
        assert_eq!((bias.1.as_deref(), bias.3), (Some("?rad s^-1"), false));
    }

    #[test]
    fn the_origin_of_numbers_belongs_to_the_column() {
        for (name, made) in [
            ("UncompGyroX", Made::Uncompensated),
            ("field.uncompaccel.x", Made::Uncompensated),
            ("CompGyroX", Made::Compensated),
            ("Linear Acceleration x (m/s^2)", Made::WithoutGravity),
            ("motionUserAccelerationX(G)", Made::WithoutGravity),
            ("GyroX", Made::Unsaid),
        ] {
            assert_eq!(said(name, None).map_or(Made::Unsaid, |(_, _, made, _)| made), made, "{name}");
        }
    }

    #[test]
    fn the_name_of_a_file_tells_the_sensor_of_bare_axes() {
        assert_eq!(said("x", Some("Gyroscope.csv")).map(|(channel, ..)| channel), Some("gyro_x"));
        assert_eq!(said("z", Some("2024 Accelerometer.csv")).map(|(channel, ..)| channel), Some("accel_z"));
        assert_eq!(said("z (m/s^2)", Some("Gyroscope.csv")), None, "they contradict each other");
        assert_eq!(said("x", Some("imu.csv")), None);
    }

    #[test]
    fn other_names_are_no_channel_and_an_unknown_unit_is_reported() {
        for name in [
            "",
            "x",
            "X (deg)",
            "z (rad)",
            "Heading z (deg)",
            "gyro",
            "gyro_w",
            "value",
            "data",
            "gyro_x_std",
            "temp_2",
            "yaw_rate",
            "gravity_x",
            "gyro_integral_dt",
            "angular_acceleration_x",
            "accelerometer_timestamp_relative",
            "orientation.x",
            "DeltaThetaX",
        ] {
            assert_eq!(said(name, None).filter(|(.., is_sure)| *is_sure), None, "{name}");
        }
        for (name, unit) in [
            ("gyro_x [furlong]", "?furlong"),
            ("accel_x (raw)", "?raw"),
            ("gyro_x [m/s^2]", "?m/s^2"),
            ("gyro_raw_x", "?raw"),
        ] {
            assert_eq!(said(name, None).and_then(|(_, unit, ..)| unit).as_deref(), Some(unit), "{name}");
        }
    }
}

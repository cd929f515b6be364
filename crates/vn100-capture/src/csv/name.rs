//! The meaning of a column's name: `gyro_x [deg/s]`, `UncompAccZ`, `acc_l_x[mg]`,
//! `field.angular_velocity.x`, `accelerometer_m_s2[2]`, `w_RS_S_x [rad s^-1]`, `X (m/s^2)`.

use std::ops::Range;

use vn100_protocol::Quantity::{
    self, Acceleration, Angle, AngularRate, MagneticField, Pressure, Quaternion, Temperature,
};

use super::{
    channels::{by_name, known, names, quantity_word},
    unit::Unit,
};

/// A sensor of three axes.
struct Sensor {
    /// Its name in our channels.
    name: &'static str,
    quantity: Quantity,
    /// Words for it, or two words in one.
    words: &'static str,
    /// Letters for it, valid only together with a unit of its quantity.
    letters: &'static str,
    /// The word for it in the name of a file.
    in_file: &'static str,
}

const SENSORS: [Sensor; 3] = [
    Sensor {
        name: "gyro",
        quantity: AngularRate,
        words: "gyro gyr gyros gyroscope angularvelocity angularrate angvel rotationrate rotrate",
        letters: "w g gy omega",
        in_file: "gyro",
    },
    Sensor {
        name: "accel",
        quantity: Acceleration,
        words: "accel acc accl acceleration accelerometer",
        letters: "a ac f t alpha",
        in_file: "accel",
    },
    Sensor {
        name: "mag",
        quantity: MagneticField,
        words: "mag magn magnetometer magneticfield magfield",
        letters: "m b h",
        in_file: "magnet",
    },
];

/// Words that turn the name of a sensor into another quantity.
const OTHER_QUANTITIES: &str = "std stddev sigma cov covariance var variance bias offset scale norm temp temperature time timestamp \
     stamp dt integral clipping status count accuracy flag delta gravity error rms mean max min setpoint ref target jerk world \
     earth ned enu global diff angle angles dangle theta dtheta dvel";
const OF_ROTATION: &str = "angular rotation rotational";

const UNCOMP: &str = "uncomp";
const UNCOMPENSATED: &str = "uncomp uncompensated";
const COMPENSATED: &str = "comp compensated";
const WITHOUT_GRAVITY: &str = "linear lin user free";

/// Words for numbers without a unit.
const RAW: &str = "raw lsb adc counts ticks volt volts bits digits";

/// A unit has no more words: `1e-3 degrees per second`, `milli m per s per s`.
const MOST_WORDS: usize = 6;

/// Prefixes of the name of a sensor that have no meaning.
const ABOVE: &str = "field imu sensor";

fn is_among(word: &str, list: &str) -> bool {
    list.split(' ').any(|known| known == word)
}

#[derive(Debug, Clone)]
pub(super) struct Meaning {
    /// The channel, as in [`known`].
    pub(super) channel: usize,
    /// The stated unit; an error for a unit that is not known, or is not one of the quantity.
    pub(super) unit: Option<Result<Unit, String>>,
    pub(super) made: Made,
    /// Whether a word or the unit of an axis names the sensor, rather than a single letter.
    pub(super) is_sure: bool,
    /// The common part of the names of one triple of axes, without the unit.
    pub(super) group: String,
}

/// How numbers of a sensor were made; the first is preferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Made {
    Uncompensated,
    Unsaid,
    Compensated,
    WithoutGravity,
}

impl Meaning {
    /// The meaning of the name of a column in the file `file`, whose name may tell the quantity of
    /// bare axes.
    pub(super) fn of(name: &str, file: Option<&str>) -> Option<Self> {
        let (bare, brackets) = without_brackets(name);
        let mut words = words(&bare);
        part_uncompensated(&mut words);
        let stated = brackets.iter().rfind(|content| axis_of(content).is_none() && !content.is_empty());
        let stated = stated.map(String::as_str);
        if let Some(meaning) = without_axes(&words, stated) {
            return Some(meaning);
        }
        let named = brackets.iter().find_map(|content| axis_of(content)).or_else(|| take_axis(&mut words));
        // a number after the name may be that of an axis, as MATLAB writes it, or of a sensor
        let mut number = || words.pop_if(|last| matches!(last.as_str(), "1" | "2" | "3"))?.parse().ok();
        let axis = named.or_else(|| number().map(|number: usize| number - 1))?;
        let by = |list: fn(&Sensor) -> &'static str, count: usize, after: &str| {
            words.windows(count).enumerate().find_map(|(at, run)| {
                let sensor = |word: &str| SENSORS.iter().find(|sensor| is_among(word, list(sensor)));
                // `mag_x_nT` has no `magn`
                let is_parted = count == 2 && sensor(&run[0]).is_some();
                let found = sensor(run.concat().trim_end_matches(|c| after.contains(c)));
                Some((found.filter(|_| !is_parted)?, at..at + count))
            })
        };
        let by_word = by(|sensor| sensor.words, 2, "").or_else(|| by(|sensor| sensor.words, 1, "0123456789"));
        let ((sensor, place), is_sure) = match by_word {
            Some(found) => (found, named.is_some()),
            None if words.is_empty() => ((of_bare_axis(stated, file)?, 0..0), true),
            None => (by(|sensor| sensor.letters, 1, "").or_else(|| Some((of_unit(stated?)?, 0..0)))?, false),
        };
        let has = |list: &str| words.iter().any(|word| is_among(word, list));
        if has(OTHER_QUANTITIES) || sensor.quantity == Acceleration && has(OF_ROTATION) {
            return None;
        }
        let (unit_words, unit) = match stated {
            Some(stated) => (0..0, Some(Unit::of(sensor.quantity, stated).ok_or_else(|| stated.to_owned()))),
            None => match unit_beside(sensor.quantity, &words, &place) {
                Some((run, unit)) => (run, Some(unit)),
                None => (0..0, has(RAW).then(|| Err("raw".into()))),
            },
        };
        let made = match () {
            () if has(UNCOMPENSATED) => Made::Uncompensated,
            () if has(COMPENSATED) => Made::Compensated,
            () if sensor.quantity == Acceleration && has(WITHOUT_GRAVITY) => Made::WithoutGravity,
            () => Made::Unsaid,
        };
        words.drain(unit_words);
        let channel = by_name(&format!("{}_{}", sensor.name, ["x", "y", "z"][axis]))?;
        Some(Self { channel, unit, made, is_sure, group: format!("{} {}", sensor.name, words.join(" ")) })
    }

    /// The quantity of the channel, as written in names of streams.
    pub(super) fn sensor(&self) -> &'static str {
        quantity_word(&known(self.channel).name)
    }
}

/// The channels that have no axes: yaw, temperature and the like, alone or with a unit.
fn without_axes(words: &[String], stated: Option<&str>) -> Option<Meaning> {
    let above = words.iter().take_while(|word| is_among(word, ABOVE)).count();
    let words = &words[above..];
    let (channel, rest) = (1..=words.len()).rev().find_map(|count| {
        let name = match words[..count].concat().as_str() {
            "temp" => "temperature".to_owned(),
            "pres" | "press" => "pressure".to_owned(),
            name => name.replace("quaternion", "quat"),
        };
        let channel = names().position(|known| known.replace('_', "") == name)?;
        let quantity = known(channel).quantity;
        let is_single = matches!(quantity, Angle | Quaternion | Temperature | Pressure);
        is_single.then(|| (channel, words[count..].concat()))
    })?;
    let quantity = known(channel).quantity;
    let unit = match stated.or(Some(rest.as_str()).filter(|rest| !rest.is_empty())) {
        None => None,
        Some(text) => match Unit::of(quantity, text) {
            None if stated.is_none() || !rest.is_empty() => return None,
            known => Some(known.ok_or_else(|| text.to_owned())),
        },
    };
    let group = quantity_word(&known(channel).name).to_owned();
    Some(Meaning { channel, unit, made: Made::Unsaid, is_sure: true, group })
}

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
        let sensor = word.strip_prefix(UNCOMP).map(|rest| rest.strip_suffix(['x', 'y', 'z']).unwrap_or(rest));
        sensor.is_some_and(|word| SENSORS.iter().any(|sensor| is_among(word, sensor.words)))
    });
    if let Some(place) = place {
        let sensor = words[place].split_off(UNCOMP.len());
        words.insert(place + 1, sensor);
    }
}

/// The axis that stands alone or in brackets.
fn axis_of(text: &str) -> Option<usize> {
    ["x0", "y1", "z2"].iter().position(|signs| text.len() == 1 && signs.contains(&text.to_lowercase()))
}

/// Removes the axis from the words and returns it: a word, or the last letter of the word for the sensor.
fn take_axis(words: &mut Vec<String>) -> Option<usize> {
    let is_letter = |word: &String| matches!(word.as_str(), "x" | "y" | "z");
    if let Some(place) = words.iter().rposition(is_letter) {
        return axis_of(&words.remove(place));
    }
    let is_sensor =
        |stem: &str| SENSORS.iter().any(|sensor| is_among(stem, sensor.words) || is_among(stem, sensor.letters));
    let place = words.iter().position(|word| word.strip_suffix(['x', 'y', 'z']).is_some_and(is_sensor))?;
    axis_of(&words[place].pop()?.to_string())
}

/// The sensor of columns named only `x`, `y` and `z`, from their unit or the name of the file.
fn of_bare_axis(stated: Option<&str>, file: Option<&str>) -> Option<&'static Sensor> {
    let file = file.unwrap_or_default().to_lowercase();
    let by_file = SENSORS.iter().find(|sensor| file.contains(sensor.in_file));
    match stated {
        Some(unit) => of_unit(unit).filter(|by_unit| by_file.is_none_or(|by_file| by_file.name == by_unit.name)),
        None => by_file,
    }
}

/// The sensor whose numbers have this unit.
fn of_unit(unit: &str) -> Option<&'static Sensor> {
    SENSORS.iter().find(|sensor| Unit::of(sensor.quantity, unit).is_some())
}

/// The most words beside those for the sensor at `place` that are a unit; an error with those that only
/// look like one. An angle beside a gyroscope is one per second, as in `gyro_rad[0]` of PX4.
fn unit_beside(
    quantity: Quantity,
    words: &[String],
    place: &Range<usize>,
) -> Option<(Range<usize>, Result<Unit, String>)> {
    let counts = (1..=words.len().min(MOST_WORDS)).rev();
    let runs = counts.flat_map(|count| (0..=words.len() - count).map(move |at| at..at + count));
    runs.filter(|run| run.end <= place.start || run.start >= place.end).find_map(|run| {
        let text = words[run.clone()].join(" ");
        let per_s = || Unit::of(quantity, &format!("{text} s")).filter(|_| quantity == AngularRate);
        let unit = Unit::of(quantity, &text).or_else(per_s);
        // the rate of the samples, as in `gyro_100_hz_x`
        let is_frequency = text == "hz" && words[..run.start].last().is_some_and(|word| word.parse::<u32>().is_ok());
        (unit.is_some() || Unit::is_like(&text) && !is_frequency).then(|| (run, unit.ok_or(text)))
    })
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
        // also the signs of a unit and of a number: `°`, `s^-2`, `0.01`, `1e-3`
        let is_of_number = before.is_some_and(|before| match c {
            '.' => before.is_ascii_digit() && after.is_some_and(char::is_ascii_digit),
            '-' => before == '^' || before == 'e' && at > 1 && characters[at - 2].is_ascii_digit(),
            _ => false,
        });
        let is_of_word = c.is_alphanumeric() || matches!(c, '°' | '^') || is_of_number;
        if begins || !is_of_word {
            words.push(String::new());
        }
        if let (true, Some(word)) = (is_of_word, words.last_mut()) {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::{super::unit::units, *};

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
            ("gyro_x_dps_2", "gyro_x", "deg/s"),
            ("gyro_x[rpm]", "gyro_x", "rpm"),
            ("gyro_rad[2]", "gyro_z", "rad/s"),
            ("gyro_x_rev_s", "gyro_x", "rev s"),
            ("gyro_x [0.01 dps]", "gyro_x", "0.01 dps"),
            ("GyroX in °/s", "gyro_x", "deg/s"),
            ("gyro_100_hz_x", "gyro_x", ""),
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
            ("acc_z_feet/s²", "accel_z", "ft/s^2"),
            ("acc_z_m_s2", "accel_z", "m/s^2"),
            ("acc_x_mms2", "accel_x", "mms2"),
            ("acc_x [in/s^2]", "accel_x", "in/s^2"),
            ("AccX_mGal", "accel_x", "m gal"),
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
            ("FreeAcc_X", Made::WithoutGravity),
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
            "gyro_dtheta_x [rad]",
            "GyroAngleX (deg)",
        ] {
            assert_eq!(said(name, None).filter(|(.., is_sure)| *is_sure), None, "{name}");
        }
        for (name, unit) in [
            ("gyro_x [furlong]", "?furlong"),
            ("accel_x (raw)", "?raw"),
            ("gyro_x [m/s^2]", "?m/s^2"),
            ("gyro_raw_x", "?raw"),
            ("gyro_x [rad]", "?rad"),
            ("gyro_x (deg)", "?deg"),
            ("gyro_x_turn_s", "?turn s"),
            ("gyro_x_grad/s", "?grad s"),
            ("gyro_x_rps", "?rps"),
            ("gyro_x_hz", "?hz"),
            ("gyro_x_d/s", "?d s"),
            ("gyro_x_deg2s", "?deg2s"),
            ("gyro_x_mV", "?m v"),
            ("gyro_x_m_s2", "?m s2"),
            ("acc_x_m_s", "?m s"),
            ("acc_x_kg", "?kg"),
        ] {
            assert_eq!(said(name, None).and_then(|(_, unit, ..)| unit).as_deref(), Some(unit), "{name}");
        }
    }

    #[test]
    fn a_name_of_any_length_is_read() {
        for repeated in ["milli", "h"] {
            assert!(Meaning::of(&format!("gyro_x_{}", repeated.repeat(60_000 / repeated.len())), None).is_some());
        }
    }

    #[test]
    fn a_unit_is_the_same_in_brackets_and_beside_the_name() {
        let others = ["", "_filtered", "_ins", "_rs", "_cg", "_uncalibrated"];
        let read = |name: &str| Meaning::of(name, None).unwrap().unit;
        for (sensor, unit) in SENSORS.iter().flat_map(|sensor| units(sensor.quantity).map(move |unit| (sensor, unit))) {
            let name = format!("imu0_{}_x", sensor.name);
            let places = |unit: &str| {
                let beside = others.map(|other| format!("{name}{other}_{unit}"));
                let more = [format!("{name} [{unit}]"), format!("{name} in {unit}"), format!("{unit} {name}")];
                [&beside[..], &more].concat()
            };
            for text in places(&unit.name) {
                let found = (read(&text), read(&text.to_lowercase()));
                assert_eq!(found, (Some(Ok(unit.clone())), Some(Ok(unit.clone()))), "{text}");
            }
            for (scale, factor) in
                [("milli ", 1e-3), ("centi-", 1e-2), ("0.01 ", 1e-2), ("10^-3 ", 1e-3), ("1e-3_", 1e-3)]
            {
                for text in places(&format!("{scale}{}", unit.name)) {
                    let found = read(&text).unwrap().unwrap();
                    assert!((found.scale / unit.scale / factor - 1.0).abs() < 1e-9, "{text}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_unit_of_parts_has_the_scale_of_its_parts() {
        let angles =
            [("deg", 1f64.to_radians()), ("°", 1f64.to_radians()), ("rad", 1.0), ("degrees", 1f64.to_radians())];
        let lengths = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("ft", 0.3048), ("feet", 0.3048), ("metres", 1.0)];
        let times = [("s", 1.0), ("sec", 1.0), ("second", 1.0)];
        let longer = [("h", 3600.0), ("hour", 3600.0)];
        let letters = [("", 1.0), ("m", 1e-3), ("u", 1e-6), ("µ", 1e-6), ("milli", 1e-3), ("1e-2 ", 1e-2)];
        let check = |channel: &str, unit: &str, scale: f64| {
            for name in [format!("{channel} [{unit}]"), format!("{channel}_{}", unit.replace([' ', '/'], "_"))] {
                let found = Meaning::of(&name, None).unwrap().unit.unwrap().unwrap();
                assert!((found.scale / scale - 1.0).abs() < 1e-9, "{name}: {found:?} is not {scale}");
            }
        };
        for ((letter, factor), over) in
            letters.iter().flat_map(|letter| ["/", " per ", " / "].map(|over| (letter, over)))
        {
            for ((angle, angle_rad), (time, time_s)) in
                angles.iter().flat_map(|angle| times.iter().chain(&longer).map(move |time| (angle, time)))
            {
                check("gyro_x", &format!("{letter}{angle}{over}{time}"), factor * angle_rad / time_s);
            }
            for (length, length_m) in lengths.iter().filter(|_| !["m", "u", "µ"].contains(letter)) {
                for squared in ["s2", "s^2", "s²", "s/s", "sec^2"] {
                    check("accel_x", &format!("{letter}{length}{over}{squared}"), factor * length_m);
                }
            }
        }
    }
}

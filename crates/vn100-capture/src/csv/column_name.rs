//! What people call a channel at the head of a column, with its unit: `gyro_x [deg/s]`, `AccX(g)`,
//! `field.angular_velocity.x`, `acc_z_m_s2`.

use vn100_protocol::Quantity;

use super::{
    column_map::{Unit, by_name, known, units},
    time_name::is_time_unit,
};

/// Names of a sensor, in lower case without anything between words; the first of each is ours.
const SENSORS: [(&str, &[&str]); 3] = [
    ("gyro", &["gyr", "gyro", "gyroscope", "angularvelocity", "angularrate"]),
    ("accel", &["acc", "accel", "acceleration", "accelerometer", "linearacceleration"]),
    ("mag", &["mag", "magn", "magnetometer", "magneticfield"]),
];

/// What may stand before the name of a sensor.
const ABOVE: [&str; 3] = ["field", "imu", "sensor"];

/// The place of the channel in the order of [`known`], and the unit where the name says one. `None`
/// for a name of no channel, and for one in a unit that is not known.
pub(super) fn channel_of(name: &str) -> Option<(usize, Option<&'static Unit>)> {
    let name = name.trim().to_lowercase();
    let Some(bracket) = name.find(['[', '(']) else {
        let unsaid = by_plain_name(&name).map(|channel| (channel, None));
        return unsaid.or_else(|| with_unit_behind(&name));
    };
    let inside = name[bracket + 1..].trim_end().strip_suffix([']', ')'])?;
    let channel = by_plain_name(&name[..bracket])?;
    unit_of(known(channel).quantity, inside).map(|unit| (channel, Some(unit)))
}

/// As in `gyro_x_deg_s`.
fn with_unit_behind(name: &str) -> Option<(usize, Option<&'static Unit>)> {
    let places = name.match_indices(['_', ' ']).map(|(at, _)| at);
    places.into_iter().find_map(|at| {
        let channel = by_plain_name(&name[..at])?;
        unit_of(known(channel).quantity, &name[at + 1..]).map(|unit| (channel, Some(unit)))
    })
}

/// The unit of this quantity that stands behind a name, in brackets or after a separator.
pub(super) fn unit_behind(name: &str, quantity: Quantity) -> Option<&'static Unit> {
    let name = name.to_lowercase();
    let mut behind = name.match_indices(['_', ' ', '[', '(']).map(|(at, _)| &name[at + 1..]);
    behind.find_map(|unit| unit_of(quantity, unit.trim_end_matches([']', ')', ' '])))
}

/// In lower case, without a unit.
fn by_plain_name(name: &str) -> Option<usize> {
    let name = name.trim();
    let is_of_sensor = |channel: &usize| known(*channel).quantity != Quantity::Value;
    // what a column of values holds, only the user knows
    if let Some(channel) = by_name(name).filter(is_of_sensor) {
        return Some(channel);
    }
    let words: Vec<&str> = name.split(['_', '.', ' ', '-', '/']).filter(|word| !word.is_empty()).collect();
    let above = words.iter().take_while(|word| ABOVE.contains(word)).count();
    let joined = words[above..].concat();
    if joined == "temp" {
        return by_name("temperature");
    }
    let axis = joined.chars().last().filter(|axis| matches!(axis, 'x' | 'y' | 'z'))?;
    let sensor = &joined[..joined.len() - 1];
    let (ours, _) = SENSORS.iter().find(|(_, names)| names.contains(&sensor))?;
    by_name(&format!("{ours}_{axis}"))
}

/// Whether people write a unit so, of a channel or of a time.
pub(super) fn is_unit(text: &str) -> bool {
    use Quantity::{Acceleration, Angle, AngularRate, MagneticField, Pressure, Temperature};
    let text = text.to_lowercase();
    let quantities = [Angle, MagneticField, Acceleration, AngularRate, Temperature, Pressure];
    is_time_unit(&text) || quantities.into_iter().any(|quantity| unit_of(quantity, &text).is_some())
}

/// The unit that people write so, in lower case.
fn unit_of(quantity: Quantity, text: &str) -> Option<&'static Unit> {
    let ascii = text.replace('°', "deg").replace(['µ', 'μ'], "u").replace('²', "2");
    let bare: String = ascii.chars().filter(|c| !matches!(c, ' ' | '^' | '·' | '*' | '_' | '.' | '/')).collect();
    let name = match (quantity, &*bare) {
        (Quantity::AngularRate, "rads" | "rads-1" | "radsec" | "radps" | "radianss") => "rad/s",
        (Quantity::AngularRate, "degs" | "degs-1" | "degsec" | "degps" | "dps" | "degreess") => "deg/s",
        (Quantity::AngularRate, "degh" | "deghr" | "dph") => "deg/h",
        (Quantity::AngularRate, "mdegs" | "mdps") => "mdeg/s",
        (Quantity::Acceleration, "ms2" | "ms-2" | "mss" | "mps2" | "msec2") => "m/s^2",
        (Quantity::Acceleration, "g" | "gs" | "g0") => "g",
        (Quantity::Acceleration, "mg") => "mg",
        (Quantity::MagneticField, "gauss" | "g" | "gs") => "gauss",
        (Quantity::MagneticField, "ut" | "microtesla") => "uT",
        (Quantity::MagneticField, "mt" | "millitesla") => "mT",
        (Quantity::MagneticField, "nt" | "nanotesla") => "nT",
        (Quantity::Angle, "deg" | "degrees") => "deg",
        (Quantity::Angle, "rad" | "radians") => "rad",
        (Quantity::Temperature, "degc" | "c" | "celsius") => "degC",
        (Quantity::Temperature, "k" | "kelvin") => "K",
        (Quantity::Pressure, "kpa") => "kPa",
        (Quantity::Pressure, "hpa" | "mbar") => "hPa",
        (Quantity::Pressure, "pa") => "Pa",
        _ => return None,
    };
    units(quantity).find(|unit| unit.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_as_people_write_them() {
        for (name, channel, unit) in [
            ("gyro_x", "gyro_x", None),
            ("GyroX", "gyro_x", None),
            ("gyr_z", "gyro_z", None),
            ("Gyro X [deg/s]", "gyro_x", Some("deg/s")),
            ("gyro_y (°/s)", "gyro_y", Some("deg/s")),
            ("gyro_x_deg_s", "gyro_x", Some("deg/s")),
            ("gyro_x_dps", "gyro_x", Some("deg/s")),
            ("field.angular_velocity.x", "gyro_x", None),
            ("angular_velocity_z [rad/s]", "gyro_z", Some("rad/s")),
            ("linear_acceleration.y", "accel_y", None),
            ("Acc_X(g)", "accel_x", Some("g")),
            ("AccZ [mg]", "accel_z", Some("mg")),
            ("accel_x (m/s^2)", "accel_x", Some("m/s^2")),
            ("accel_x [m/s²]", "accel_x", Some("m/s^2")),
            ("acc_z_m_s2", "accel_z", Some("m/s^2")),
            ("Mag X (µT)", "mag_x", Some("uT")),
            ("mag_z_gauss", "mag_z", Some("gauss")),
            ("Temp [°C]", "temperature", Some("degC")),
            ("temperature_K", "temperature", Some("K")),
            ("pressure (hPa)", "pressure", Some("hPa")),
            ("yaw_rad", "yaw", Some("rad")),
        ] {
            let found = channel_of(name).map(|(place, unit)| (&*known(place).name, unit.map(|unit| &*unit.name)));
            assert_eq!(found, Some((channel, unit)), "{name}");
        }
    }

    #[test]
    fn what_is_no_channel_or_in_no_known_unit_is_none() {
        for name in [
            "",
            "x",
            "gyro",
            "gyro_w",
            "value",
            "data",
            "gyro_x [furlong]",
            "accel_x (raw)",
            "gyro_x_std",
            "[deg/s]",
            "temp_2",
        ] {
            assert_eq!(channel_of(name).map(|(place, _)| place), None, "{name}");
        }
    }
}

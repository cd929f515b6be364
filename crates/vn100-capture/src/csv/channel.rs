//! The channels a CSV file can hold, the names and units they go by.

use std::{f64::consts::PI, sync::LazyLock};

use vn100_protocol::{Channel, MESSAGES, Quantity};

/// The channels of all messages of the sensor, in the order in which a layout holds them.
static KNOWN: LazyLock<Vec<&Channel>> = LazyLock::new(|| {
    let mut known: Vec<&Channel> = Vec::new();
    for channel in MESSAGES.iter().flat_map(|layout| &*layout.channels) {
        if known.iter().all(|other| other.name != channel.name) {
            known.push(channel);
        }
    }
    known.sort_by_key(|channel| channel.quantity);
    known
});

/// Standard acceleration of free fall in m/s² (BIPM, The International System of Units, 2019).
const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// A unit a column may be in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    pub(super) name: &'static str,
    pub(super) quantity: Quantity,
    /// How many of the channel's own unit make one of this.
    pub(super) scale: f64,
    /// Where the channel's own zero lies on this scale, in hundredths: 273.15 for kelvin, 0 for all
    /// others.
    pub(super) zero_hundredths: i64,
}

/// The names of all channels.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    KNOWN.iter().map(|channel| &*channel.name)
}

/// The channel at place `index` of the order in which a layout holds them.
pub(super) fn known(index: usize) -> &'static Channel {
    KNOWN[index]
}

/// The place of the channel with this very name.
pub(super) fn by_name(name: &str) -> Option<usize> {
    names().position(|known| known == name)
}

/// The place of the channel that scripts give this column name, in lower case.
pub(super) fn by_alias(name: &str) -> Option<usize> {
    let renamed = match name.split_once('_') {
        Some(("acc", axis)) => format!("accel_{axis}"),
        Some(("gyr", axis)) => format!("gyro_{axis}"),
        Some(("magn", axis)) => format!("mag_{axis}"),
        _ => name.to_owned(),
    };
    by_name(&renamed)
}

/// Whether only an inertial sensor has this channel.
pub(super) fn is_inertial(index: usize) -> bool {
    matches!(known(index).quantity, Quantity::Acceleration | Quantity::AngularRate)
}

/// The units of `quantity`, its channels' own unit first.
pub(super) fn units(quantity: Quantity) -> impl Iterator<Item = &'static Unit> {
    UNITS.iter().filter(move |unit| unit.quantity == quantity)
}

static UNITS: [Unit; 19] = [
    unit("rad/s", Quantity::AngularRate, 1.0),
    unit("deg/s", Quantity::AngularRate, PI / 180.0),
    unit("deg/h", Quantity::AngularRate, PI / 648_000.0),
    unit("mdeg/s", Quantity::AngularRate, PI / 180_000.0),
    unit("m/s^2", Quantity::Acceleration, 1.0),
    unit("g", Quantity::Acceleration, STANDARD_GRAVITY_M_S2),
    unit("mg", Quantity::Acceleration, STANDARD_GRAVITY_M_S2 / 1e3),
    unit("gauss", Quantity::MagneticField, 1.0),
    unit("uT", Quantity::MagneticField, 1e-2),
    unit("mT", Quantity::MagneticField, 10.0),
    unit("nT", Quantity::MagneticField, 1e-5),
    unit("deg", Quantity::Angle, 1.0),
    unit("rad", Quantity::Angle, 180.0 / PI),
    unit("1", Quantity::Quaternion, 1.0),
    unit("degC", Quantity::Temperature, 1.0),
    Unit { zero_hundredths: 27_315, ..unit("K", Quantity::Temperature, 1.0) },
    unit("kPa", Quantity::Pressure, 1.0),
    unit("hPa", Quantity::Pressure, 0.1),
    unit("Pa", Quantity::Pressure, 1e-3),
];

const fn unit(name: &'static str, quantity: Quantity, scale: f64) -> Unit {
    Unit { name, quantity, scale, zero_hundredths: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_has_its_own_unit_first() {
        for (index, channel) in KNOWN.iter().enumerate() {
            let own = units(channel.quantity).next().unwrap();
            assert_eq!((own.name, own.scale), (&*channel.unit, 1.0));
            assert_eq!(by_name(&channel.name), Some(index));
        }
    }

    #[test]
    fn a_layout_of_any_message_keeps_its_order() {
        for layout in MESSAGES {
            let places = layout.channels.iter().map(|channel| by_name(&channel.name));
            assert!(places.clone().all(|place| place.is_some()) && places.is_sorted(), "{}", layout.message);
        }
    }

    #[test]
    fn aliases_lead_to_channels() {
        for (alias, name) in [("acc_x", "accel_x"), ("gyr_z", "gyro_z"), ("magn_y", "mag_y"), ("gyro_x", "gyro_x")] {
            assert_eq!(by_alias(alias), by_name(name), "{alias}");
            assert!(by_alias(alias).is_some());
        }
        assert_eq!(by_alias("acc_w"), None);
        assert_eq!(by_alias("data"), None);
    }
}

//! The channels that a table or a message may hold, and their units as people write them.

use std::{borrow::Cow, f64::consts::PI, sync::LazyLock};

use vn100_protocol::{
    Channel, MESSAGES,
    Quantity::{self, Acceleration, Angle, AngularRate, MagneticField, Pressure, Quaternion, Temperature, Value},
};

/// The channels of all messages of the sensor and that of any series, in the order in which a
/// layout holds them.
static KNOWN: LazyLock<Vec<&Channel>> = LazyLock::new(|| {
    let mut known: Vec<&Channel> = Vec::new();
    for channel in MESSAGES.iter().flat_map(|layout| &*layout.channels) {
        if known.iter().all(|other| other.name != channel.name) {
            known.push(channel);
        }
    }
    known.push(&VALUE);
    known.sort_by_key(|channel| channel.quantity);
    known
});

/// Numbers of a series; the file determines the decimals and limits.
static VALUE: Channel = Channel {
    name: Cow::Borrowed("value"),
    quantity: Value,
    unit: Cow::Borrowed("1"),
    decimals: 0,
    scale: 1.0,
    zero_counts: 0,
    limit_counts: i32::MAX,
    refresh_hz: None,
    increment_step: None,
};

pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    KNOWN.iter().map(|channel| &*channel.name)
}

/// The channel at place `index` of the order that layouts use.
pub(crate) fn known(index: usize) -> &'static Channel {
    KNOWN[index]
}

/// The place of the channel with exactly this name.
pub(super) fn by_name(name: &str) -> Option<usize> {
    names().position(|known| known == name)
}

/// The quantity of a channel, as written in names of streams: `gyro` of `gyro_x`.
pub(crate) fn quantity_word(channel: &str) -> &str {
    channel.split('_').next().unwrap_or(channel)
}

/// The quantities that are named first.
const FIRST: [&str; 3] = ["gyro", "accel", "mag"];

/// The place of a stream of this name among others.
pub(super) fn rank(name: &str) -> usize {
    FIRST.iter().position(|first| name.starts_with(first)).unwrap_or(FIRST.len())
}

/// Standard acceleration of free fall in m/s² (BIPM, The International System of Units, 2019).
const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    pub(crate) name: Cow<'static, str>,
    pub(super) quantity: Quantity,
    /// The unit in units of the channel.
    pub(crate) scale: f64,
    /// The channel's own zero on this scale.
    pub(crate) zero: f64,
    /// The spellings in lower case, without signs between the letters.
    spellings: &'static str,
}

const fn unit(name: &'static str, quantity: Quantity, scale: f64, spellings: &'static str) -> Unit {
    Unit { name: Cow::Borrowed(name), quantity, scale, zero: 0.0, spellings }
}

static UNITS: [Unit; 26] = [
    unit("rad/s", AngularRate, 1.0, "rads radp radps"),
    unit("deg/s", AngularRate, PI / 180.0, "degs degp degps dps"),
    unit("deg/h", AngularRate, PI / 648_000.0, "degh deghr deghour dph"),
    unit("mdeg/s", AngularRate, PI / 180_000.0, "mdegs mdps"),
    unit("mrad/s", AngularRate, 1e-3, "mrads mradps"),
    unit("rpm", AngularRate, PI / 30.0, "rpm"),
    unit("m/s^2", Acceleration, 1.0, "ms2 mss mps2 mpss"),
    unit("g", Acceleration, STANDARD_GRAVITY_M_S2, "g gs g0 gn"),
    unit("mg", Acceleration, STANDARD_GRAVITY_M_S2 / 1e3, "mg"),
    unit("ug", Acceleration, STANDARD_GRAVITY_M_S2 / 1e6, "ug"),
    unit("cm/s^2", Acceleration, 1e-2, "cms2 cmss gal"),
    unit("ft/s^2", Acceleration, 0.3048, "fts2 ftss fps2"),
    unit("gauss", MagneticField, 1.0, "gauss g gs"),
    unit("mgauss", MagneticField, 1e-3, "mgauss mg mgs"),
    unit("T", MagneticField, 1e4, "t tesla"),
    unit("uT", MagneticField, 1e-2, "ut utesla"),
    unit("mT", MagneticField, 10.0, "mt mtesla"),
    unit("nT", MagneticField, 1e-5, "nt ntesla"),
    unit("deg", Angle, 1.0, "deg"),
    unit("rad", Angle, 180.0 / PI, "rad"),
    unit("1", Quaternion, 1.0, ""),
    unit("degC", Temperature, 1.0, "degc c celsius"),
    Unit { name: Cow::Borrowed("K"), quantity: Temperature, scale: 1.0, zero: 273.15, spellings: "k kelvin" },
    unit("kPa", Pressure, 1.0, "kpa"),
    unit("hPa", Pressure, 0.1, "hpa mbar"),
    unit("Pa", Pressure, 1e-3, "pa"),
];

impl Unit {
    /// The unit of numbers that are not converted.
    pub(crate) fn unconverted(name: String) -> Self {
        Self { name: name.into(), ..unit("", Value, 1.0, "") }
    }

    /// The channel at place `index`, in whole numbers of this unit.
    pub(crate) fn of_channel(&self, index: usize) -> Channel {
        let own = known(index);
        let unit = if own.quantity == Value { &self.name } else { &own.unit };
        Channel { unit: unit.clone(), scale: self.scale, ..own.clone() }
    }
}

/// The units of `quantity`, its channels' own unit first.
pub(crate) fn units(quantity: Quantity) -> impl Iterator<Item = &'static Unit> {
    UNITS.iter().filter(move |unit| unit.quantity == quantity)
}

/// The words of a unit in short, in lower case and without signs between the letters.
pub(super) fn in_short(text: &str) -> String {
    const SHORT: &str = "°=deg º=deg µ=u μ=u ²=2 degrees=deg degree=deg radians=rad second=s sec=s s1=s per= sqr=2 squared=2 \
         milli=m micro=u nano=n feet=ft";
    let bare = text.to_lowercase().replace(['_', '.', '/'], " ").replace(['^', '·', '*', '(', ')', '-'], "");
    let pairs = SHORT.split(' ').filter_map(|pair| pair.split_once('='));
    pairs.fold(bare, |bare, (long, short)| bare.replace(long, short))
}

/// The unit that people write in this way.
pub(super) fn unit_of(quantity: Quantity, text: &str) -> Option<&'static Unit> {
    let bare = in_short(text).replace(' ', "");
    units(quantity).find(|unit| unit.spellings.split_whitespace().any(|spelling| spelling == bare))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_has_its_own_unit_first() {
        for (index, channel) in KNOWN.iter().enumerate().filter(|(_, channel)| channel.quantity != Value) {
            let own = units(channel.quantity).next().unwrap();
            assert_eq!((&*own.name, own.scale), (&*channel.unit, 1.0));
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
}

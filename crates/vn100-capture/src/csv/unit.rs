//! Units as people write them: `deg/s`, `rad s^-1`, `0.01 dps`, `mm/s²`, `milli g`.

use std::{borrow::Cow, f64::consts::PI, ops::RangeInclusive};

use vn100_protocol::{
    Channel,
    Quantity::{self, Acceleration, Angle, AngularRate, MagneticField, Pressure, Quaternion, Temperature, Value},
};

use super::channels::known;

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
    /// The words for it in lower case, if it is not made of an angle or a length and a time.
    words: &'static str,
}

const fn unit(name: &'static str, quantity: Quantity, scale: f64, words: &'static str) -> Unit {
    Unit { name: Cow::Borrowed(name), quantity, scale, zero: 0.0, words }
}

/// The units that have a name of ours.
static UNITS: [Unit; 26] = [
    unit("rad/s", AngularRate, 1.0, ""),
    unit("deg/s", AngularRate, PI / 180.0, ""),
    unit("deg/h", AngularRate, PI / 648_000.0, ""),
    unit("mdeg/s", AngularRate, PI / 180_000.0, ""),
    unit("mrad/s", AngularRate, 1e-3, ""),
    unit("rpm", AngularRate, PI / 30.0, "rpm"),
    unit("m/s^2", Acceleration, 1.0, ""),
    unit("g", Acceleration, STANDARD_GRAVITY_M_S2, "g gs g0 gn"),
    unit("mg", Acceleration, STANDARD_GRAVITY_M_S2 / 1e3, ""),
    unit("ug", Acceleration, STANDARD_GRAVITY_M_S2 / 1e6, ""),
    unit("cm/s^2", Acceleration, 1e-2, "gal"),
    unit("ft/s^2", Acceleration, 0.3048, ""),
    unit("gauss", MagneticField, 1.0, "gauss g gs"),
    unit("mgauss", MagneticField, 1e-3, ""),
    unit("T", MagneticField, 1e4, "t tesla"),
    unit("uT", MagneticField, 1e-2, ""),
    unit("mT", MagneticField, 10.0, ""),
    unit("nT", MagneticField, 1e-5, ""),
    unit("deg", Angle, 1.0, ""),
    unit("rad", Angle, 180.0 / PI, ""),
    unit("1", Quaternion, 1.0, ""),
    unit("degC", Temperature, 1.0, "degc c celsius"),
    Unit { name: Cow::Borrowed("K"), quantity: Temperature, scale: 1.0, zero: 273.15, words: "k kelvin" },
    unit("kPa", Pressure, 1.0, "kpa"),
    unit("hPa", Pressure, 0.1, "hpa mbar"),
    unit("Pa", Pressure, 1e-3, "pa"),
];

const ANGLES_RAD: [(&str, f64); 5] =
    [("rad", 1.0), ("deg", PI / 180.0), ("rev", 2.0 * PI), ("arcmin", PI / 10_800.0), ("arcs", PI / 648_000.0)];
const LENGTHS_M: [(&str, f64); 6] =
    [("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("km", 1e3), ("ft", 0.3048), ("in", 0.0254)];
const TIMES_S: [(&str, f64); 5] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0), ("h", 3600.0)];
const LETTERS: [(char, f64); 4] = [('m', 1e-3), ('u', 1e-6), ('n', 1e-9), ('k', 1e3)];
const SCALES: [(&str, f64); 7] =
    [("milli", 1e-3), ("micro", 1e-6), ("nano", 1e-9), ("centi", 1e-2), ("deci", 0.1), ("kilo", 1e3), ("mega", 1e6)];

/// Units that are not known, or have several meanings, as the turns or radians of `rps`; and such angles:
/// `grad` is a gon or a German degree.
const NOT_KNOWN: &str = "rps rph dgps rpm hz gal ng kg v";
const ANGLES_NOT_KNOWN: &str = "turn cycle grad gon";

/// Factors beyond these are those of no sensor.
const FACTORS: RangeInclusive<f64> = 1e-12..=1e12;

impl Unit {
    /// The unit of numbers that are not converted.
    pub(crate) fn unconverted(name: String) -> Self {
        Self { name: name.into(), ..unit("", Value, 1.0, "") }
    }

    /// The unit that people write in this way: a number or a word for a factor, and a unit, which may have
    /// the letter of a scale.
    pub(super) fn of(quantity: Quantity, text: &str) -> Option<Self> {
        let (factor, rest) = without_factor(text.trim());
        let short = in_short(&rest);
        let (scale, zero) = match quantity {
            AngularRate => over_times(&short, 1).find_map(|(angle, time)| Some(scaled(angle, &ANGLES_RAD)? / time)),
            Acceleration => over_times(&short, 2).find_map(|(length, time)| Some(exactly(length, &LENGTHS_M)? / time)),
            Angle => scaled(&short, &ANGLES_RAD).map(f64::to_degrees),
            _ => None,
        }
        .map_or_else(|| of_word(quantity, &short), |scale| Some((scale, 0.0)))?;
        let (scale, zero) = (scale * factor, zero / factor);
        let is_same = |known: &&Self| known.zero == zero && (known.scale / scale - 1.0).abs() < 1e-9;
        let named = units(quantity).find(is_same).cloned();
        let other = || Self { name: text.trim().to_owned().into(), quantity, scale, zero, words: "" };
        FACTORS.contains(&scale).then(|| named.unwrap_or_else(other))
    }

    /// Whether people write a unit of a channel in this way.
    pub(super) fn is_one(text: &str) -> bool {
        let quantities = [Angle, MagneticField, Acceleration, AngularRate, Temperature, Pressure];
        quantities.into_iter().any(|quantity| Self::of(quantity, text).is_some())
    }

    /// Whether words look like a unit of motion, be it known or not: `deg`, `mm s`, `milli g`, `rps`.
    pub(super) fn is_like(text: &str) -> bool {
        let (factor, rest) = without_factor(text);
        let short = in_short(&rest);
        let is_among =
            |list: &str, text: &str| lettered(text).any(|(rest, _)| list.split(' ').any(|known| known == rest));
        let is_angle = |text: &str| scaled(text, &ANGLES_RAD).is_some() || is_among(ANGLES_NOT_KNOWN, text);
        let is_length = |text: &str| text == "d" || exactly(text, &LENGTHS_M).is_some();
        factor != 1.0 && Self::is_one(&rest)
            || is_angle(&short)
            || is_among(NOT_KNOWN, &short)
            // a number that stands alone may be that of a sensor
            || over_times(&short, 2).any(|(above, _)| is_length(above) || !short.ends_with(" 2") && is_angle(above))
            // one word of few letters, such as `ins`, is a name
            || over_times(&short, 1).any(|(above, _)| {
                is_angle(above.trim_end_matches('2')) || short.contains(' ') && is_length(above)
            })
    }

    /// The unit of the channel at place `index`, in whole numbers of this unit.
    pub(crate) fn of_channel(&self, index: usize) -> Channel {
        let own = known(index);
        let unit = if own.quantity == Value { &self.name } else { &own.unit };
        Channel { unit: unit.clone(), scale: self.scale, ..own.clone() }
    }
}

/// The units of `quantity` that have a name, its channels' own unit first.
pub(crate) fn units(quantity: Quantity) -> impl Iterator<Item = &'static Unit> {
    UNITS.iter().filter(move |unit| unit.quantity == quantity)
}

/// Separates a factor before a unit, as in `0.01 deg/s`, `10^-3 g`, `1e-3 T` or `milli g`; a whole
/// number may be that of a sensor and is none.
fn without_factor(text: &str) -> (f64, String) {
    let lower = text.to_lowercase();
    let word = SCALES.iter().find_map(|(word, scale)| Some((*scale, lower.strip_prefix(word)?)));
    let number = || {
        let end = lower.find(|c: char| !c.is_ascii_digit() && !".^-e".contains(c))?;
        let (number, rest) = lower.split_at(end);
        let power =
            number.split_once('^').and_then(|(base, power)| Some(base.parse::<f64>().ok()?.powf(power.parse().ok()?)));
        let is_factor = number.contains(['.', 'e']) && number.starts_with(|c: char| c.is_ascii_digit());
        Some((power.or_else(|| number.parse().ok().filter(|_| is_factor))?, rest))
    };
    let (factor, rest) = word.or_else(number).unwrap_or((1.0, &lower));
    (factor, rest.trim_start_matches([' ', '-', '_']).to_owned())
}

/// The words of a unit in short, in lower case, with spaces for other signs between them.
fn in_short(text: &str) -> String {
    const SHORT: &str = "°=deg º=deg µ=u μ=u ²=2 degrees=deg degree=deg radians=rad second=s sec=s s1=s per= sqr=2 squared=2 \
         meters=m metres=m meter=m metre=m feet=ft hours=h hour=h hr=h minute=min dps=degs dph=degh";
    let bare = text.to_lowercase().replace(['_', '.', '/'], " ").replace(['^', '·', '*', '(', ')', '-'], "");
    let pairs = SHORT.split(' ').filter_map(|pair| pair.split_once('='));
    pairs.fold(bare, |bare, (long, short)| bare.replace(long, short)).trim().to_owned()
}

/// What stands before a time to this power, each with the time in s to that power: `m` in `m s2`, `mps2`
/// and `m s s`.
fn over_times<'a>(short: &'a str, power: i32) -> impl Iterator<Item = (&'a str, f64)> {
    TIMES_S.iter().filter_map(move |(time, unit_s)| {
        let before = |text: &'a str| Some(text.trim_end().strip_suffix(time)?.trim_end_matches([' ', 'p']));
        let above = match power {
            1 => before(short),
            _ => short.strip_suffix('2').and_then(before).or_else(|| before(before(short)?)),
        };
        Some((above?, unit_s.powi(power)))
    })
}

/// The text, and what is left of it after the letter of a scale, each with its factor. A capital parts
/// words, as in `mGal`.
fn lettered(text: &str) -> impl Iterator<Item = (&str, f64)> {
    let after = |(letter, scale): &(char, f64)| Some((text.strip_prefix(*letter)?.trim_start(), *scale));
    std::iter::once((text, 1.0)).chain(LETTERS.iter().filter_map(after))
}

fn exactly(text: &str, table: &[(&str, f64)]) -> Option<f64> {
    table.iter().find(|(word, _)| *word == text).map(|(_, scale)| *scale)
}

fn scaled(text: &str, table: &[(&str, f64)]) -> Option<f64> {
    lettered(text).find_map(|(rest, factor)| Some(factor * exactly(rest, table)?))
}

/// The scale and the zero of a unit that has words of its own.
fn of_word(quantity: Quantity, short: &str) -> Option<(f64, f64)> {
    let short = short.replace(' ', "");
    let of = |(word, factor): (&str, f64)| {
        let unit = units(quantity).find(|unit| unit.words.split(' ').any(|known| known == word && !word.is_empty()))?;
        // `kg` is no acceleration
        let is_small = factor < 1.0 && !matches!(quantity, Temperature | Pressure);
        (factor == 1.0 || is_small).then_some((unit.scale * factor, unit.zero))
    };
    lettered(&short).find_map(of)
}

#[cfg(test)]
mod tests {
    use super::{super::channels::by_name, *};

    #[test]
    fn every_channel_has_its_own_unit_first() {
        for index in 0..by_name("value").unwrap() {
            let own = units(known(index).quantity).next().unwrap();
            assert_eq!((&*own.name, own.scale), (&*known(index).unit, 1.0));
        }
    }
}

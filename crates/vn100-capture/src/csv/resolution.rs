//! The conversion of the numbers of a column to counts, determined by its first rows: the printed
//! decimals if a count of 32 bits has room for them and for larger numbers, else a power of two.

use vn100_protocol::{Channel, Quantity};

use super::{number::Number, unit::Unit};

/// There is room for deviations from the median that are this many times as large as those in the
/// head.
const HEADROOM: f64 = 64.0;

/// The largest fraction of the rows of the head that may be single glitches.
const GLITCHES: f64 = 2e-3;

/// The counts of an angle continue beyond a turn: there is room for this many times the largest.
const TURNS: f64 = 8.0;

const MOST_DECIMALS: u32 = 18;

/// The decimals of a channel whose first numbers are all zero.
const UNSEEN_DECIMALS: u32 = 6;

/// A number with more digits than this is a float that was printed beyond its precision.
const FLOAT_DIGITS: u64 = 10_u64.pow(17);

const MOST_COUNTS: f64 = i32::MAX as f64;

/// The steps of the noise beside a large constant part.
const ANCHORED_STEPS: f64 = 1e6;

/// The largest digits that are counts as they are; those of larger numbers are rounded to a float.
const MOST_DIGITS: u64 = 1 << 52;

/// The conversion of a number to a count, which is 10^-`decimals` of the unit of the file, or a power
/// of two.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantizer {
    /// `None` for a power of two.
    decimals: Option<u8>,
    counts_per_unit: f64,
    /// Whether digits after the last one that is kept are rounded.
    pub(super) is_rounded: bool,
    /// The channel's own zero on the scale of the file.
    zero: f64,
    /// The counts of a large constant part, which are subtracted.
    zero_counts: i64,
    limit_counts: i32,
}

impl Quantizer {
    /// Counts of 2^-`bits` of the unit.
    pub(crate) fn binary(bits: i32, unit: &Unit) -> Self {
        let counts_per_unit = 2_f64.powi(bits);
        Self {
            decimals: None,
            counts_per_unit,
            is_rounded: true,
            zero: unit.zero,
            zero_counts: 0,
            limit_counts: i32::MAX,
        }
    }

    /// Decides from the numbers of the head, which are in this unit of the channel. Numbers
    /// `of_sensor` are in its own unit, and have at least its decimals; beyond its limit one is
    /// damaged, unless those of the head are.
    pub(super) fn new(numbers: &[Number], channel: &Channel, unit: &Unit, of_sensor: bool) -> Self {
        // the distance between two zeros must be a whole count
        let of_unit = if unit.zero == 0.0 { 0 } else { 2 };
        let least = if of_sensor { channel.decimals.into() } else { of_unit };
        let numbers: Vec<Number> = numbers.iter().map(|number| without_noise_digits(*number)).collect();
        let mut values: Vec<f64> = numbers.iter().map(Number::value).collect();
        // the largest magnitude except glitches
        let mut magnitudes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
        let usual = nth(&mut magnitudes, 1.0 - GLITCHES);
        let median = nth(&mut values, 0.5);
        let mut deviations: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
        let deviation = nth(&mut deviations, 1.0 - GLITCHES);
        let largest = channel.value(channel.limit_counts);
        let limit = Some(largest).filter(|limit| of_sensor && usual <= *limit);
        let room = (median.abs() + HEADROOM * deviation).max(2.0 * usual) + unit.zero;
        let within = limit.map_or(room, |limit| room.min(limit));
        // zeros are printed shorter by some scripts, and are no evidence against a last digit
        let most = |decimals: fn(&Number) -> u32| {
            let seen = numbers.iter().filter(|number| number.digits != 0).map(decimals).max();
            seen.unwrap_or(if of_sensor { 0 } else { UNSEEN_DECIMALS }).max(least)
        };
        let significant = most(Number::significant_decimals);
        let printed = [most(|number| number.decimals.max(0).unsigned_abs()), significant];
        let fit = |within: f64, whole: f64| {
            let fits = |decimals: &u32| {
                let counts_per_unit = 10_f64.powi(*decimals as i32);
                *decimals <= MOST_DECIMALS
                    && within * counts_per_unit <= MOST_COUNTS
                    && whole * counts_per_unit <= MOST_DIGITS as f64
            };
            printed.into_iter().find(fits)
        };
        // noise with this many steps still has room for a drift of many times its size
        let (alone, whole) = (deviation * MOST_COUNTS / ANCHORED_STEPS, median.abs());
        let is_anchored =
            channel.quantity == Quantity::Value && alone > 0.0 && alone < within && fit(within, 0.0).is_none();
        let (room, decimals) = if is_anchored { (alone, fit(alone, whole)) } else { (room, fit(within, 0.0)) };
        // a power of two has room for the range of the channel at least
        let range = least_range(channel.quantity, largest / unit.scale, alone);
        // beyond the digits of a float a constant part has no counts
        let finest = if is_anchored { MOST_DIGITS as f64 / whole } else { f64::INFINITY };
        let counts_per_unit = match decimals {
            Some(decimals) => 10_f64.powi(decimals as i32),
            None => {
                let counts_per_unit = (MOST_COUNTS / room.max(range)).min(finest);
                2_f64.powi((counts_per_unit.log2().floor() as i32).clamp(-900, 900))
            }
        };
        let zero_counts = if is_anchored { (median * counts_per_unit).round() as i64 } else { 0 };
        Self {
            decimals: decimals.map(|decimals| decimals as u8),
            counts_per_unit,
            is_rounded: decimals.is_none_or(|decimals| significant > decimals),
            zero: unit.zero,
            zero_counts,
            // a cast saturates
            limit_counts: limit.map_or(i32::MAX, |limit| (limit * counts_per_unit).round() as i32),
        }
    }

    /// The count; `None` for a number beyond the range of counts.
    #[inline]
    pub(super) fn count(&self, number: &Number) -> Option<i32> {
        let are_counts =
            self.zero == 0.0 && self.decimals.is_some_and(|decimals| number.decimals == i32::from(decimals));
        let count = match are_counts && number.digits <= MOST_DIGITS {
            true => number.signed_digits() - self.zero_counts,
            // exact as well for counts of 32 bits
            false => return self.count_of(number.value()),
        };
        let limit = i64::from(self.limit_counts);
        // the cast is of a number within the limit
        (-limit..=limit).contains(&count).then_some(count as i32)
    }

    /// The count of a float; `None` beyond the range of counts, and if it is not finite.
    #[inline]
    pub(crate) fn count_of(&self, value: f64) -> Option<i32> {
        let count = ((value - self.zero) * self.counts_per_unit).round_ties_even() - self.zero_counts as f64;
        let limit = f64::from(self.limit_counts);
        (-limit..=limit).contains(&count).then_some(count as i32)
    }

    /// Whether this number has digits that are rounded and that the numbers of the head did not have.
    #[inline]
    pub(super) fn rounds(&self, number: &Number) -> bool {
        !self.is_rounded && self.decimals.is_some_and(|decimals| number.decimals > decimals.into())
    }

    /// The channel in these counts; its scale is that of the file's unit.
    pub(crate) fn of_counts(&self, channel: Channel) -> Channel {
        let (decimals, scale) = match self.decimals {
            Some(decimals) => (decimals, channel.scale),
            None => (0, channel.scale / self.counts_per_unit),
        };
        Channel { decimals, scale, zero_counts: self.zero_counts, limit_counts: self.limit_counts, ..channel }
    }
}

/// The range that has counts in any case, of a channel with this largest value and this room for a drift.
fn least_range(quantity: Quantity, largest: f64, drift: f64) -> f64 {
    match quantity {
        Quantity::Value => drift,
        Quantity::Angle => TURNS * largest,
        _ => largest,
    }
}

/// The shortest decimal number that is the same float, if this one is a float that was printed
/// beyond its precision.
fn without_noise_digits(number: Number) -> Number {
    let shortest = (number.digits >= FLOAT_DIGITS).then(|| number.shortest_of_float()).flatten();
    shortest.unwrap_or(number)
}

/// The value below which this fraction of the values lies; 0 if there are none.
fn nth(values: &mut [f64], share: f64) -> f64 {
    let place = ((values.len() as f64 * share) as usize).min(values.len().saturating_sub(1));
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{
        super::{
            channels::{by_name, known},
            unit::units,
        },
        *,
    };

    /// The channel of any series, and that of a rate of the sensor.
    const ANY: &str = "value";
    const RATE: &str = "gyro_x";

    fn quantizer<T: ToString>(fields: impl IntoIterator<Item = T>, name: &str) -> Quantizer {
        let numbers = fields.into_iter().map(|field| Number::parse(field.to_string().as_bytes()).unwrap());
        let channel = known(by_name(name).unwrap());
        let unit = units(channel.quantity).next().cloned().unwrap_or_else(|| Unit::unconverted("1".into()));
        Quantizer::new(&numbers.collect::<Vec<_>>(), channel, &unit, name == RATE)
    }

    fn decimals(fields: &[&str], name: &str) -> Option<u8> {
        quantizer(fields, name).decimals
    }

    #[test]
    fn decimals_are_kept_as_printed() {
        assert_eq!(decimals(&["1.25", "-0.5", "0.25"], ANY), Some(2));
        assert_eq!(decimals(&["1.50", "-0.50"], ANY), Some(2));
        assert_eq!(decimals(&["3", "-4"], ANY), Some(0));
        assert_eq!(decimals(&["1e-05", "0.00012"], ANY), Some(5));
        // zeros are no evidence against a last digit
        assert_eq!(decimals(&["0.0", "0.0", "0.0", "0.125"], ANY), Some(3));
        assert_eq!(decimals(&["9.851000000000", "-9.8"], ANY), Some(3));
        // floats printed in full, of numbers with three decimals
        assert_eq!(decimals(&["-8.546899999999999409e+01", "7.497199999999999420e+01"], ANY), Some(3));
        assert_eq!((decimals(&["0.0", "0"], ANY), decimals(&[], ANY)), (Some(6), Some(6)));
    }

    #[test]
    fn a_series_of_floats_has_room_for_a_drift_of_a_thousand_times_its_noise() {
        for noise in [1e-12, 1e-3, 1e7] {
            let number = |row: i32| f64::from(row.wrapping_mul(7919) % 101 - 50) / 49.7 * noise;
            let found = quantizer((0..1000).map(|row| format!("{:.16e}", number(row))), ANY);
            assert_eq!(found.decimals, None);
            let drifted = found.count_of(1000.0 * noise).map(|count| f64::from(count) / found.counts_per_unit);
            assert!(drifted.is_some_and(|drifted| (drifted / noise - 1000.0).abs() < 1e-5), "{noise}: {drifted:?}");
        }
    }

    /// A constant part of any size, and digits beyond those of a float.
    #[test]
    fn noise_beside_a_large_constant_keeps_its_digits() {
        for (constant, decimals) in [(1e6, 9), (1e7, 9), (-1e7, 6), (3e9, 15), (1e12, 3)] {
            let number = |row: i32| {
                let value = constant + f64::from(row.wrapping_mul(7919) % 101 - 50) * 1e-4;
                Number::parse(format!("{value:.decimals$}").as_bytes()).unwrap()
            };
            let numbers: Vec<Number> = (0..1000).map(number).collect();
            let unit = Unit::unconverted("1".into());
            let found = Quantizer::new(&numbers, known(by_name(ANY).unwrap()), &unit, false);
            let channel = found.of_counts(known(by_name(ANY).unwrap()).clone());
            // a float of this size has this step
            let step = 2_f64.powi(constant.abs().log2() as i32 - 52);
            for number in numbers {
                let error = channel.value(found.count(&number).unwrap()) - number.value();
                assert!(error.abs() <= step.max(1e-6), "{constant} {decimals}: {error}");
            }
            // a later drift is two hundred times the noise
            let drifted = Number::parse(format!("{:.decimals$}", constant + 1.0).as_bytes()).unwrap();
            assert!(found.count(&drifted).is_some(), "{constant}");
        }
    }

    #[test]
    fn a_known_message_keeps_its_decimals() {
        assert_eq!(decimals(&[], RATE), Some(6));
        assert_eq!(decimals(&["0.5", "0.25"], RATE), Some(6));
        assert_eq!(decimals(&["-1.234000000000000095e-03"], RATE), Some(6));
        // degrees in a column of any name, because this limit applies to no such number
        let degrees = quantizer((0..100).map(|row| format!("{}.5", 100 + row)), RATE);
        assert!(degrees.count(&Number::parse(b"199.5").unwrap()).is_some());
        // damaged digits exceed the limit
        let damaged = quantizer((0..1000).map(|row| if row == 7 { "400.1" } else { "0.1" }), RATE);
        assert_eq!(damaged.count(&Number::parse(b"400.1").unwrap()), None);
    }

    #[test]
    fn glitches_of_the_head_are_lost_without_a_digit_of_the_others() {
        let noise = |row: i32| f64::from(row.wrapping_mul(7919) % 101) * 1.234_567_890_123e-3;
        let few = quantizer((0..1000).map(|row| if row == 500 { 3.4e38 } else { noise(row) }), ANY);
        let count = |value: f64| few.count(&Number::parse(value.to_string().as_bytes()).unwrap());
        assert_eq!(count(3.4e38), None);
        assert_eq!(few.decimals, None);
        assert!((f64::from(count(noise(7)).unwrap()) / few.counts_per_unit - noise(7)).abs() < 1e-4 * 0.1);
    }

    proptest! {
        /// Noise on any offset, as floats and with any decimals: rounding adds next to nothing to
        /// its deviation, and 64 times the noise has a count.
        #[test]
        fn values_after_a_head_have_room_and_resolution(
            offset in -1e3..1e3_f64, deviation_exponent in -5_i32..2, decimals in 2..17_usize, seed in 1..u64::MAX,
        ) {
            let deviation = 10_f64.powi(deviation_exponent);
            let mut state = seed;
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            let mut value = |scale: f64| format!("{:.decimals$}", offset + scale * (uniform() + uniform()));
            let head: Vec<String> = (0..1000).map(|_| value(deviation)).collect();
            let found = quantizer(&head, ANY);
            let per_count = found.counts_per_unit.recip();
            let printed = 10_f64.powi(-(decimals as i32));
            let needed = printed.max(deviation / 100.0).max(2e3 * 2_f64.powi(-29));
            prop_assert!(per_count <= needed, "{per_count} of {deviation}");
            for _ in 0..100 {
                let later = value(20.0 * deviation);
                prop_assert!(found.count(&Number::parse(later.as_bytes()).unwrap()).is_some(), "{later}");
            }
        }
    }
}

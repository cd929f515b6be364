//! The conversion of the numbers of a column to counts, determined by its first rows: the printed
//! decimals if a count of 32 bits has room for them and for larger numbers, else a power of two.

use vn100_protocol::{Channel, Quantity};

use super::{column_map::Unit, number::Number};

/// Number of rows that are examined in the head of a file.
pub(super) const HEAD_ROWS: usize = 1000;

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

/// The size of a count, in the unit of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CountScale {
    /// 10^-n of the unit.
    Decimal(u8),
    /// 2^-n of the unit.
    Binary(i32),
}

/// The conversion of a number to a count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Quantizer {
    pub(super) scale: CountScale,
    /// Whether digits after the last one that is kept are rounded.
    pub(super) is_rounded: bool,
    /// The channel's own zero on the scale of the file, and in counts.
    zero: f64,
    zero_counts: i64,
    counts_per_unit: f64,
    limit_counts: i32,
}

/// Properties of a column that are known before its numbers are read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    /// The least number of decimals.
    pub(super) decimals: u8,
    /// Beyond this magnitude a number of the sensor is damaged; `None` if that is not known.
    pub(super) limit: Option<f64>,
    /// A power of two has room for this magnitude at least, in the unit of the file.
    pub(super) range: f64,
    /// As in [`Unit`].
    pub(super) zero_hundredths: i64,
}

impl Prior {
    /// For a column in the unit of the sensor's own channel.
    pub(super) fn of_sensor(channel: &Channel) -> Self {
        let limit = Some(channel.value(channel.limit_counts));
        Self { decimals: channel.decimals, limit, range: range(channel), zero_hundredths: 0 }
    }

    /// For a column in this unit, of any sensor.
    pub(super) fn of_unit(unit: &Unit, channel: &Channel) -> Self {
        // the distance between two zeros must be a whole count
        let decimals = if unit.zero_hundredths == 0 { 0 } else { 2 };
        Self { decimals, limit: None, range: range(channel) / unit.scale, zero_hundredths: unit.zero_hundredths }
    }
}

/// The largest magnitude that a sensor measures in this channel; an angle may turn several times,
/// and the range of a series is unknown.
fn range(channel: &Channel) -> f64 {
    match channel.quantity {
        Quantity::Value => 0.0,
        Quantity::Angle => TURNS * channel.value(channel.limit_counts),
        _ => channel.value(channel.limit_counts),
    }
}

impl Quantizer {
    /// Decides from the numbers of the head.
    pub(super) fn new(numbers: &[Number], prior: Prior) -> Self {
        let head = Head::of(numbers);
        let limit = prior.limit.filter(|limit| head.usual <= 2.0 * limit);
        let scale = head.scale(prior, limit);
        let (counts_per_unit, is_rounded) = match scale {
            CountScale::Decimal(decimals) => (10_f64.powi(decimals.into()), head.significant > decimals.into()),
            CountScale::Binary(power) => (exp2(power), true),
        };
        Self {
            scale,
            is_rounded,
            zero: prior.zero_hundredths as f64 / 100.0,
            zero_counts: match scale {
                CountScale::Decimal(decimals) if prior.zero_hundredths != 0 => {
                    prior.zero_hundredths * 10_i64.pow(u32::from(decimals) - 2)
                }
                _ => 0,
            },
            counts_per_unit,
            // a cast saturates
            limit_counts: limit.map_or(i32::MAX, |limit| (limit * counts_per_unit).round() as i32),
        }
    }

    /// The count; `None` for a number beyond the range of counts.
    #[inline]
    pub(super) fn count(&self, number: &Number) -> Option<i32> {
        let count = match self.scale {
            CountScale::Decimal(decimals) => number.count(decimals)?.checked_sub(self.zero_counts)?,
            // a cast saturates, beyond every limit
            CountScale::Binary(_) => ((number.value() - self.zero) * self.counts_per_unit).round_ties_even() as i64,
        };
        let limit = i64::from(self.limit_counts);
        // the cast is of a number within the limit
        (-limit..=limit).contains(&count).then_some(count as i32)
    }

    /// Whether this number has digits that are rounded and that the numbers of the head did not have.
    #[inline]
    pub(super) fn rounds(&self, number: &Number) -> bool {
        match self.scale {
            CountScale::Decimal(decimals) if !self.is_rounded => number.decimals() > decimals.into(),
            CountScale::Decimal(_) | CountScale::Binary(_) => false,
        }
    }

    /// The channel in these counts; its scale is that of the file's unit.
    pub(super) fn of_counts(&self, channel: Channel) -> Channel {
        let (decimals, factor) = match self.scale {
            CountScale::Decimal(decimals) => (decimals, 1.0),
            CountScale::Binary(power) => (0, exp2(-power)),
        };
        Channel { decimals, scale: channel.scale * factor, limit_counts: self.limit_counts, ..channel }
    }
}

/// The properties of the first numbers of a column.
#[derive(Debug, Default)]
struct Head {
    /// The most decimals as printed, and without zeros at the end; each `None` if most numbers have
    /// fewer, so that later ones may have more.
    printed: Option<u32>,
    shortest: Option<u32>,
    significant: u32,
    /// The magnitude of the median, and the largest deviation from it except glitches.
    median: f64,
    deviation: f64,
    /// The largest magnitude except glitches.
    usual: f64,
}

impl Head {
    fn of(numbers: &[Number]) -> Self {
        let numbers: Vec<Number> = numbers.iter().map(Number::without_noise_digits).collect();
        let nonzero = || numbers.iter().filter(|number| number.value() != 0.0);
        let most = |decimals: fn(&Number) -> u32| {
            let most = nonzero().map(decimals).max()?;
            // zeros are printed shorter by some scripts, and are no evidence against a last digit
            let have = nonzero().filter(|number| decimals(number) == most).count();
            Some((most, 2 * have >= nonzero().count()))
        };
        let (printed, shortest) = (most(Number::decimals), most(Number::significant_decimals));
        let mut values: Vec<f64> = numbers.iter().map(Number::value).collect();
        let median = nth(&mut values, 0.5);
        let mut deviations: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
        let mut magnitudes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
        Self {
            printed: printed.and_then(|(most, is_usual)| is_usual.then_some(most)),
            shortest: shortest.and_then(|(most, is_usual)| is_usual.then_some(most)),
            significant: shortest.map_or(0, |(most, _)| most),
            median: median.abs(),
            deviation: nth(&mut deviations, 1.0 - GLITCHES),
            usual: nth(&mut magnitudes, 1.0 - GLITCHES),
        }
    }

    /// The decimals as printed if a count has room for larger numbers; else the smallest power of two
    /// with such room, also for the range of the sensor.
    fn scale(&self, prior: Prior, limit: Option<f64>) -> CountScale {
        let least = u32::from(prior.decimals);
        if limit.is_some() && self.printed.is_none_or(|printed| printed <= least) && self.significant <= least {
            return CountScale::Decimal(prior.decimals);
        }
        let zero = prior.zero_hundredths as f64 / 100.0;
        let room = (self.median + HEADROOM * self.deviation).max(2.0 * self.usual) + zero;
        for decimals in [self.printed, self.shortest].into_iter().flatten().map(|decimals| decimals.max(least)) {
            if decimals <= MOST_DECIMALS && room * 10_f64.powi(decimals as i32) <= MOST_COUNTS {
                return CountScale::Decimal(decimals as u8);
            }
        }
        if self.usual == 0.0 {
            return CountScale::Decimal(UNSEEN_DECIMALS.max(least) as u8);
        }
        let room = room.max(prior.range);
        CountScale::Binary(((MOST_COUNTS / room).log2().floor() as i32).clamp(-900, 900))
    }
}

impl Number {
    /// The shortest decimal number that is the same float, if this one is a float that was printed
    /// beyond its precision.
    fn without_noise_digits(&self) -> Self {
        let shortest = self.digits_beyond(FLOAT_DIGITS).then(|| self.shortest_of_float()).flatten();
        shortest.unwrap_or(*self)
    }
}

/// The value below which this fraction of the values lies; 0 if there are none.
fn nth(values: &mut [f64], share: f64) -> f64 {
    let place = (values.len() as f64 * share) as usize;
    let place = place.min(values.len().saturating_sub(1));
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f64::total_cmp).1 }
}

/// 2^`power`; exact if the result is not smaller than the smallest normal float.
fn exp2(power: i32) -> f64 {
    f64::from_bits(((power.clamp(-1022, 1023) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{CountScale::*, *};

    const ANY: Prior = Prior { decimals: 0, limit: None, range: 0.0, zero_hundredths: 0 };
    const RATE: Prior = Prior { decimals: 6, limit: Some(40.0), range: 40.0, ..ANY };

    fn quantizer<T: ToString>(fields: impl IntoIterator<Item = T>, prior: Prior) -> Quantizer {
        let numbers = fields.into_iter().map(|field| Number::parse(field.to_string().as_bytes()).unwrap());
        Quantizer::new(&numbers.collect::<Vec<_>>(), prior)
    }

    fn scale(fields: &[&str], prior: Prior) -> CountScale {
        quantizer(fields, prior).scale
    }

    #[test]
    fn decimals_are_kept_as_printed() {
        assert_eq!(scale(&["1.25", "-0.5", "0.25"], ANY), Decimal(2));
        assert_eq!(scale(&["1.50", "-0.50"], ANY), Decimal(2));
        assert_eq!(scale(&["3", "-4"], ANY), Decimal(0));
        assert_eq!(scale(&["1e-05", "0.00012"], ANY), Decimal(5));
        // zeros are no evidence against a last digit
        assert_eq!(scale(&["0.0", "0.0", "0.0", "0.125"], ANY), Decimal(3));
        assert_eq!(scale(&["9.851000000000", "-9.8"], ANY), Decimal(3));
        // floats printed in full, of numbers with three decimals
        assert_eq!(scale(&["-8.546899999999999409e+01", "7.497199999999999420e+01"], ANY), Decimal(3));
        assert_eq!((scale(&["0.0", "0"], ANY), scale(&[], ANY)), (Decimal(6), Decimal(6)));
    }

    #[test]
    fn a_known_message_keeps_its_decimals() {
        assert_eq!(scale(&[], RATE), Decimal(6));
        assert_eq!(scale(&["0.5", "0.25"], RATE), Decimal(6));
        assert_eq!(scale(&["-1.234000000000000095e-03"], RATE), Decimal(6));
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
        let Binary(power) = few.scale else { panic!("{few:?}") };
        assert!((f64::from(count(noise(7)).unwrap()) * exp2(-power) - noise(7)).abs() < 1e-4 * 0.1);
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
            let per_count = match found.scale {
                Decimal(decimals) => 10_f64.powi(-i32::from(decimals)),
                Binary(power) => exp2(-power),
            };
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

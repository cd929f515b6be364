//! How the numbers of a column become counts: decimals as printed where they fit 32 bits, else a
//! power of two.

use vn100_protocol::{Channel, Quantity};

use super::{column_map::Unit, number::Number};

/// Number of rows that are examined in the head of a file.
pub(super) const SCANNED_ROWS: usize = 1000;

/// Where only the head is known, there is room for values this many times as large as its largest
/// one.
const HEADROOM: f64 = 64.0;

/// An angle turns: there is room for this many times its largest value.
const TURNS: f64 = 8.0;

/// More decimals than this are never kept.
const MOST_DECIMALS: u32 = 18;

/// The fewest and the most decimals of a channel whose numbers are all zero.
const UNSEEN_DECIMALS: (u32, u32) = (6, 9);

/// A number with more digits than this is a float that was printed beyond its precision.
const FLOAT_DIGITS: u64 = 10_u64.pow(17);

/// The largest fraction of all numbers that may exceed what a count holds: single glitches.
const MOST_BEYOND: f64 = 1e-3;

/// A count is at most this fraction of the standard deviation of the differences, where the range
/// allows it: the error of half a count is then a hundredth of the deviation.
const COUNTS_IN_DEVIATION: f64 = 50.0;

/// The fraction of the largest differences that is excluded from their deviation.
const TRIMMED: f64 = 0.01;

/// The largest count.
const MOST_COUNTS: f64 = i32::MAX as f64;

/// The numbers of a column, in all rows or in the first ones.
#[derive(Debug, Clone, Default)]
pub(super) struct ColumnScan {
    numbers: u64,
    largest: f64,
    /// The most decimals of a number as printed, and without zeros at the end.
    printed: u32,
    significant: u32,
    /// How many numbers are not zero, and how many of them have the most decimals, with and without
    /// trailing zeros.
    nonzero: u64,
    have_printed: u64,
    have_significant: u64,
    magnitudes: Exponents,
    steps: Exponents,
    last: Option<f64>,
}

/// How many numbers have each binary exponent, without zeros.
#[derive(Debug, Clone, Default)]
struct Exponents {
    counts: Vec<u64>,
}

/// The exponents of a float of 64 bits.
const EXPONENTS: usize = 2048;

/// The size of a count, in the unit of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CountScale {
    /// 10^-n of the unit.
    Decimal(u8),
    /// 2^-n of the unit.
    Binary(i32),
}

/// How a number becomes a count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Quantizer {
    pub(super) scale: CountScale,
    /// Whether digits after the last one that is kept are rounded.
    pub(super) is_rounded: bool,
    zero_hundredths: i64,
    limit_counts: i32,
}

/// What is known of a channel beforehand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    /// The least number of decimals.
    pub(super) decimals: u8,
    /// The largest magnitude of a value of the sensor; `None` where that is not known.
    pub(super) limit: Option<f64>,
    /// As in [`Unit`](super::column_map::Unit).
    pub(super) zero_hundredths: i64,
    /// Whether the channel is an angle, whose counts continue beyond a turn.
    pub(super) turns: bool,
}

impl Prior {
    /// For a column in this unit, of any sensor.
    pub(super) fn of_unit(unit: &Unit) -> Self {
        Self {
            // the distance between two zeros must be a whole count
            decimals: if unit.zero_hundredths == 0 { 0 } else { 2 },
            limit: None,
            zero_hundredths: unit.zero_hundredths,
            turns: unit.quantity == Quantity::Angle,
        }
    }
}

/// How much of the file a [`ColumnScan`] is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scanned {
    Whole,
    Head,
}

impl Quantizer {
    /// The count; `None` for a number that no count holds.
    #[inline]
    pub(super) fn count(&self, number: &Number) -> Option<i32> {
        let count = match self.scale {
            CountScale::Decimal(decimals) => {
                let count = number.count(decimals)?;
                match self.zero_hundredths {
                    0 => count,
                    hundredths => count.checked_sub(hundredths * 10_i64.pow(u32::from(decimals) - 2))?,
                }
            }
            CountScale::Binary(power) => {
                let value = number.value() - self.zero_hundredths as f64 / 100.0;
                // a cast saturates, beyond every limit
                (value * exp2(power)).round_ties_even() as i64
            }
        };
        let limit = i64::from(self.limit_counts);
        // the cast is of a number within the limit
        (-limit..=limit).contains(&count).then_some(count as i32)
    }

    /// Whether a count holds this number with all the digits that it has more than the numbers
    /// before it.
    pub(super) fn holds(&self, number: &Number) -> bool {
        self.count(number).is_some() && !self.rounds(number)
    }

    /// Whether digits of this number are rounded that the numbers before it did not have.
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

impl ColumnScan {
    /// Whether the number is larger, or has more digits, than all numbers before it.
    #[inline]
    pub(super) fn add(&mut self, number: &Number) -> bool {
        let shortest = number.digits_beyond(FLOAT_DIGITS).then(|| number.shortest_of_float()).flatten();
        let number = shortest.as_ref().unwrap_or(number);
        let value = number.value();
        let magnitude = value.abs();
        let (largest, printed_most) = (self.largest, self.printed);
        self.numbers += 1;
        self.largest = self.largest.max(magnitude);
        self.magnitudes.add(magnitude);
        if let Some(last) = self.last.replace(value) {
            self.steps.add((value - last).abs());
        }
        let is_nonzero = u64::from(magnitude > 0.0);
        // zeros are printed shorter by some scripts, and are not counted here
        self.nonzero += is_nonzero;
        let printed = if shortest.is_some() { number.significant_decimals() } else { number.decimals() };
        if printed > self.printed {
            (self.printed, self.have_printed) = (printed, 0);
        }
        self.have_printed += is_nonzero * u64::from(printed == self.printed);
        // no more than those printed
        if printed >= self.significant {
            let significant = number.significant_decimals();
            if significant > self.significant {
                (self.significant, self.have_significant) = (significant, 0);
            }
            self.have_significant += is_nonzero * u64::from(significant == self.significant);
        }
        magnitude > largest || printed > printed_most
    }

    pub(super) fn quantizer(&self, prior: Prior, scanned: Scanned) -> Quantizer {
        let limit = prior.limit.filter(|limit| !self.are_many_beyond(*limit));
        let scale = self.scale(prior, limit, scanned);
        let per_unit = match scale {
            CountScale::Decimal(decimals) => 10_f64.powi(decimals.into()),
            CountScale::Binary(power) => exp2(power),
        };
        let is_rounded = match scale {
            CountScale::Decimal(decimals) => self.significant > u32::from(decimals),
            CountScale::Binary(_) => true,
        };
        Quantizer {
            scale,
            is_rounded,
            zero_hundredths: prior.zero_hundredths,
            // a cast saturates
            limit_counts: limit.map_or(i32::MAX, |limit| (limit * per_unit).round() as i32),
        }
    }

    /// The decimals as printed where the largest number fits 32 bits with them; else the power of
    /// two with which it just fits. Where only the head is known there is room for larger numbers
    /// and for more digits.
    fn scale(&self, prior: Prior, limit: Option<f64>, scanned: Scanned) -> CountScale {
        let prior_decimals = u32::from(prior.decimals);
        let zero = prior.zero_hundredths as f64 / 100.0;
        let turns = if prior.turns { TURNS } else { 1.0 };
        if limit.is_some() && self.printed <= prior_decimals {
            return CountScale::Decimal(prior.decimals);
        }
        let held = self.largest_held().min(limit.unwrap_or(f64::INFINITY)) + zero;
        let room = match (scanned, limit) {
            (Scanned::Whole, _) => turns * held,
            (Scanned::Head, Some(limit)) => turns * limit,
            (Scanned::Head, None) => HEADROOM * held,
        };
        let enough = |have: u64| scanned == Scanned::Whole || 2 * have >= self.nonzero;
        for (decimals, have) in [(self.printed, self.have_printed), (self.significant, self.have_significant)] {
            let decimals = decimals.max(prior_decimals);
            if self.nonzero > 0 && enough(have) && decimals <= MOST_DECIMALS && fits(room, decimals) {
                return CountScale::Decimal(decimals as u8);
            }
        }
        if self.nonzero == 0 {
            let (fewest, most) = UNSEEN_DECIMALS;
            let decimals = if scanned == Scanned::Whole { self.printed.clamp(fewest, most) } else { fewest };
            return CountScale::Decimal(decimals.max(prior_decimals) as u8);
        }
        CountScale::Binary(((MOST_COUNTS / room).log2().floor() as i32).clamp(-900, 900))
    }

    /// The largest number; a smaller one where single glitches would cost the resolution of all
    /// other numbers.
    fn largest_held(&self) -> f64 {
        let needed = MOST_COUNTS * self.steps.deviation() / COUNTS_IN_DEVIATION;
        if needed == 0.0 || self.largest <= needed {
            return self.largest;
        }
        let usual = self.magnitudes.all_but(MOST_BEYOND, self.numbers);
        if usual <= needed { self.magnitudes.up_to(needed) } else { self.largest }
    }

    fn are_many_beyond(&self, limit: f64) -> bool {
        self.largest > limit && self.magnitudes.all_but(MOST_BEYOND, self.numbers) > 2.0 * limit
    }
}

impl Exponents {
    #[inline]
    fn add(&mut self, magnitude: f64) {
        if self.counts.is_empty() {
            self.counts.resize(EXPONENTS, 0);
        }
        // the sign is 0
        self.counts[(magnitude.to_bits() >> 52) as usize % EXPONENTS] += 1;
    }

    /// The smallest power of two below which all but this fraction of `numbers` are.
    fn all_but(&self, share: f64, numbers: u64) -> f64 {
        let mut beyond = 0;
        for (exponent, count) in self.counts.iter().enumerate().rev() {
            beyond += count;
            if beyond as f64 > share * numbers as f64 {
                return exp2(exponent as i32 + 1 - 1023);
            }
        }
        0.0
    }

    /// The smallest power of two below which all numbers are that are certainly below `limit`.
    fn up_to(&self, limit: f64) -> f64 {
        let ends = self.counts.iter().zip(-1022_i32..).filter(|(count, _)| **count > 0).map(|(_, end)| exp2(end));
        ends.filter(|end| *end <= limit).fold(0.0, f64::max)
    }

    /// The root mean square without the largest numbers, each taken to be as small as its exponent
    /// allows.
    fn deviation(&self) -> f64 {
        let numbers: u64 = self.counts.iter().sum();
        let highest = self.all_but(TRIMMED, numbers);
        let below = |exponent: i32| exp2(exponent) < highest;
        let exponents = self.counts.iter().zip(-1023_i32..).filter(|(count, exponent)| **count > 0 && below(*exponent));
        let squares: f64 = exponents
            .filter(|(_, exponent)| *exponent > -1023)
            .map(|(count, exponent)| *count as f64 * exp2(exponent) * exp2(exponent))
            .sum();
        if numbers == 0 { 0.0 } else { (squares / numbers as f64).sqrt() }
    }
}

/// Whether `largest` with this many decimals is a count of 32 bits.
fn fits(largest: f64, decimals: u32) -> bool {
    largest * 10_f64.powi(decimals as i32) <= MOST_COUNTS
}

/// Exact where the result is not smaller than the smallest normal float.
fn exp2(power: i32) -> f64 {
    f64::from_bits(((power.clamp(-1022, 1023) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::{CountScale::*, Scanned::*, *};

    const ANY: Prior = Prior { decimals: 0, limit: None, zero_hundredths: 0, turns: false };
    const RATE: Prior = Prior { decimals: 6, limit: Some(40.0), ..ANY };

    fn scanned<T: ToString>(fields: impl IntoIterator<Item = T>) -> ColumnScan {
        let mut scan = ColumnScan::default();
        for field in fields {
            scan.add(&Number::parse(field.to_string().as_bytes()).unwrap());
        }
        scan
    }

    fn scale(fields: &[&str], prior: Prior, of: Scanned) -> CountScale {
        scanned(fields).quantizer(prior, of).scale
    }

    #[test]
    fn decimals_are_taken_as_they_stand() {
        for of in [Whole, Head] {
            assert_eq!(scale(&["1.25", "-0.5", "0.25"], ANY, of), Decimal(2));
            assert_eq!(scale(&["1.50", "-0.50"], ANY, of), Decimal(2));
            assert_eq!(scale(&["3", "-4"], ANY, of), Decimal(0));
            assert_eq!(scale(&["1e-05", "0.00012"], ANY, of), Decimal(5));
            // zeros are no evidence against a last digit
            assert_eq!(scale(&["0.0", "0.0", "0.0", "0.125"], ANY, of), Decimal(3));
            assert_eq!(scale(&["9.851000000000", "-9.8"], ANY, of), Decimal(3));
            // floats printed in full, of numbers with three decimals
            assert_eq!(scale(&["-8.546899999999999409e+01", "7.497199999999999420e+01"], ANY, of), Decimal(3));
        }
    }

    #[test]
    fn the_whole_file_needs_no_room_and_its_head_does() {
        // 20.5 with eight decimals fits, 28 does not
        assert_eq!(scale(&["20.50000001", "20.51000000"], ANY, Whole), Decimal(8));
        assert_eq!(scale(&["20.50000001", "28.00000001"], ANY, Whole), Binary(26));
        // 64 times as much
        assert_eq!(scale(&["20.50000001", "20.51000000"], ANY, Head), Binary(20));
        // a few longer numbers are all that is needed to know, or floats of which longer ones come
        let six_digits = ["0.123456", "0.0123456", "0.234567", "0.345678"];
        assert_eq!((scale(&six_digits, ANY, Whole), scale(&six_digits, ANY, Head)), (Decimal(7), Binary(26)));
    }

    #[test]
    fn an_angle_has_room_to_turn() {
        let angle = Prior { turns: true, ..ANY };
        assert_eq!(scale(&["179.999", "-179.999"], angle, Whole), Decimal(3));
        assert_eq!(scale(&["179.9999999", "-179.9999999"], angle, Whole), Binary(20));
    }

    #[test]
    fn a_known_message_keeps_its_decimals() {
        for of in [Whole, Head] {
            assert_eq!(scale(&[], RATE, of), Decimal(6));
            assert_eq!(scale(&["0.5", "0.25"], RATE, of), Decimal(6));
            assert_eq!(scale(&["-1.234000000000000095e-03"], RATE, of), Decimal(6));
        }
        assert_eq!((scale(&["0.12345678"], RATE, Whole), scale(&["0.12345678"], RATE, Head)), (Decimal(8), Binary(25)));
        // degrees, whatever the name says: the limit is that of no such number
        let degrees = scanned((0..100).map(|row| format!("{}.5", 100 + row)));
        assert_eq!(degrees.quantizer(RATE, Whole).count(&Number::parse(b"199.5").unwrap()), Some(199_500_000));
        // damaged digits are beyond it
        let damaged = scanned((0..2000).map(|row| if row == 7 { "400.1" } else { "0.1" }));
        assert_eq!(damaged.quantizer(RATE, Whole).count(&Number::parse(b"400.1").unwrap()), None);
    }

    #[test]
    fn nothing_but_zeros_leaves_room_for_decimals() {
        assert_eq!(scale(&["0.0", "0"], ANY, Whole), Decimal(6));
        assert_eq!(scale(&["0.00000000"], ANY, Whole), Decimal(8));
        assert_eq!(scale(&["0.00000000"], ANY, Head), Decimal(6));
        assert_eq!(scale(&[], ANY, Head), Decimal(6));
    }

    #[test]
    fn single_glitches_cost_themselves_and_not_the_digits_of_all_others() {
        let noise = |row: i32| f64::from(row.wrapping_mul(7919) % 101) * 1.234_567_890_123e-3;
        let numbers = |glitches: i32| (0..10_000).map(move |row| if row < glitches { 3.4e38 } else { noise(row) });
        let few = scanned(numbers(9)).quantizer(ANY, Whole);
        let count = |value: f64| few.count(&Number::parse(value.to_string().as_bytes()).unwrap());
        assert_eq!(count(3.4e38), None);
        let Binary(power) = few.scale else { panic!("{few:?}") };
        assert!((count(noise(7)).unwrap() as f64 * exp2(-power) - noise(7)).abs() < 0.125 * exp2(-31));
        // as many as these are what the column holds
        let many = scanned(numbers(11)).quantizer(ANY, Whole);
        assert!(many.count(&Number::parse(b"3.4e38").unwrap()).is_some());
    }
}

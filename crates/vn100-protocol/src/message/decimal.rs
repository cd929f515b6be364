//! A printed number as an exact count of its last digit.

use core::fmt;

use thiserror::Error;

/// A number as the sensor prints it, `sign digits . digits`, without the way through a float.
///
/// ```
/// use vn100_protocol::Decimal;
/// let rate = Decimal::parse(b"-00.000301")?;
/// assert_eq!((rate.count(), rate.decimals()), (-301, 6));
/// # Ok::<_, vn100_protocol::DecimalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Decimal {
    count: i32,
    negative_zero: bool,
    decimals: u8,
}

/// Why a field is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[non_exhaustive]
pub enum DecimalError {
    /// There is nothing in the field.
    #[error("the field is empty")]
    Empty,
    /// The first byte is neither `+` nor `-`.
    #[error("the sign is missing: a number begins with + or -, not with {:?}", char::from(*found))]
    NoSign {
        /// The first byte.
        found: u8,
    },
    /// No digit stands before the point.
    #[error("no digit stands before the point: at least one must")]
    NoWholeDigits,
    /// The digits are not followed by a point.
    #[error("the point is missing: a whole number has one too, with at least one decimal")]
    NoPoint,
    /// No digit stands behind the point.
    #[error("no digit stands behind the point: at least one must")]
    NoDecimals,
    /// A byte that no number has: an exponent, a space, a letter, a second point.
    #[error("{:?} has no place in a number: sign, digits, point, digits, nothing else", char::from(*found))]
    Unexpected {
        /// That byte.
        found: u8,
    },
    /// More digits than a 32-bit count holds, or more than 255 of them behind the point.
    #[error("the digits make a count beyond {} or stand more than 255 places behind the point", i32::MAX)]
    Overflow,
}

impl Decimal {
    /// Reads a whole field: a mandatory sign, at least one digit on either side of the point, any
    /// number of leading zeros.
    ///
    /// # Errors
    /// A [`DecimalError`] that names the first thing wrong with the field, reading from the left.
    pub fn parse(field: &[u8]) -> Result<Self, DecimalError> {
        let (&sign, digits) = field.split_first().ok_or(DecimalError::Empty)?;
        if !matches!(sign, b'+' | b'-') {
            return Err(DecimalError::NoSign { found: sign });
        }
        let (whole, rest) = split_digits(digits);
        let decimals = match rest {
            [b'.', ..] if whole.is_empty() => return Err(DecimalError::NoWholeDigits),
            [b'.', decimals @ ..] => decimals,
            [] => return Err(DecimalError::NoPoint),
            &[found, ..] => return Err(DecimalError::Unexpected { found }),
        };
        let (decimals, rest) = split_digits(decimals);
        match rest {
            [] if decimals.is_empty() => return Err(DecimalError::NoDecimals),
            [] => {}
            &[found, ..] => return Err(DecimalError::Unexpected { found }),
        }
        let magnitude = whole
            .iter()
            .chain(decimals)
            .try_fold(0_i32, |magnitude, digit| magnitude.checked_mul(10)?.checked_add(i32::from(digit - b'0')));
        let (Some(magnitude), Ok(decimals)) = (magnitude, u8::try_from(decimals.len())) else {
            return Err(DecimalError::Overflow);
        };
        let negative = sign == b'-';
        Ok(Self::from_count(if negative { -magnitude } else { magnitude }, negative, decimals))
    }

    /// The number `count` / 10^`decimals`; `negative_zero` is for a `count` of 0 alone.
    #[must_use]
    pub fn from_count(count: i32, negative_zero: bool, decimals: u8) -> Self {
        Self { count, negative_zero: negative_zero && count == 0, decimals }
    }

    /// The number in units of its last digit, exactly. What [`parse`](Self::parse) gives lies
    /// within ±[`i32::MAX`].
    #[inline]
    #[must_use]
    pub fn count(&self) -> i32 {
        self.count
    }

    /// Whether this is zero with a minus sign, which the sensor does print.
    #[inline]
    #[must_use]
    pub fn is_negative_zero(&self) -> bool {
        self.negative_zero
    }

    /// The number of digits behind the point.
    #[inline]
    #[must_use]
    pub fn decimals(&self) -> u8 {
        self.decimals
    }

    /// Writes the number with its own decimals and at least `whole_digits` digits before the point,
    /// filled with zeros; a larger number takes more.
    ///
    /// # Errors
    /// What `out` reports.
    pub fn write(&self, out: &mut impl fmt::Write, whole_digits: usize) -> fmt::Result {
        let sign = if self.count < 0 || self.negative_zero { '-' } else { '+' };
        let magnitude = self.count.unsigned_abs();
        // beyond ten decimals there is no whole part left, since a count has ten digits at most
        let (whole, fraction) = match 10_u32.checked_pow(self.decimals.into()) {
            Some(unit) => (magnitude / unit, magnitude % unit),
            None => (0, magnitude),
        };
        write!(out, "{sign}{whole:0whole_digits$}.{fraction:0decimals$}", decimals = usize::from(self.decimals))
    }
}

/// The digits at the head of `bytes`, and what stands behind them.
fn split_digits(bytes: &[u8]) -> (&[u8], &[u8]) {
    bytes.split_at(bytes.iter().take_while(|byte| byte.is_ascii_digit()).count())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(field: &str) -> Result<(i32, u8), DecimalError> {
        Decimal::parse(field.as_bytes()).map(|number| (number.count(), number.decimals()))
    }

    #[test]
    fn any_width_is_read() {
        assert_eq!(parsed("+1.5"), Ok((15, 1)));
        assert_eq!(parsed("-000085.469"), Ok((-85_469, 3)));
        assert_eq!(parsed("+2147483.647"), Ok((i32::MAX, 3)));
        assert_eq!(parsed("-2147483.647"), Ok((-i32::MAX, 3)));
    }

    #[test]
    fn what_a_float_parser_takes_is_refused_by_name() {
        use DecimalError::*;
        for (field, error) in [
            ("", Empty),
            ("nan", NoSign { found: b'n' }),
            ("inf", NoSign { found: b'i' }),
            ("1.5", NoSign { found: b'1' }),
            (" +1.5", NoSign { found: b' ' }),
            ("+nan", Unexpected { found: b'n' }),
            ("+1e3", Unexpected { found: b'e' }),
            ("+1.0e3", Unexpected { found: b'e' }),
            ("+1.5 ", Unexpected { found: b' ' }),
            ("+1 .5", Unexpected { found: b' ' }),
            ("+-1.5", Unexpected { found: b'-' }),
            ("+1.5.2", Unexpected { found: b'.' }),
            ("+1.5,", Unexpected { found: b',' }),
            ("+.5", NoWholeDigits),
            ("+.", NoWholeDigits),
            ("+5.", NoDecimals),
            ("+5", NoPoint),
            ("+", NoPoint),
            ("+2147483.648", Overflow),
            ("-2147483.648", Overflow),
            ("+99999999999999999999.0", Overflow),
        ] {
            assert_eq!(parsed(field), Err(error), "{field:?}");
        }
    }

    #[test]
    fn negative_zero_is_known() {
        let zero = Decimal::parse(b"-00.000").unwrap();
        assert_eq!((zero.count(), zero.is_negative_zero()), (0, true));
        assert!(!Decimal::parse(b"+00.000").unwrap().is_negative_zero());
        assert_eq!(Decimal::from_count(0, true, 3), zero);
    }

    #[test]
    fn widths_are_minimum_widths() {
        for (count, decimals, whole_digits, text) in [
            (-5, 3, 2, "-00.005"),
            (123_931, 3, 2, "+123.931"),
            (7, 12, 1, "+0.000000000007"),
            (i32::MIN, 9, 1, "-2.147483648"),
            (i32::MAX, 10, 1, "+0.2147483647"),
        ] {
            let mut out = String::new();
            Decimal::from_count(count, false, decimals).write(&mut out, whole_digits).unwrap();
            assert_eq!(out, text);
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(count in -i32::MAX..=i32::MAX, negative_zero: bool, decimals in 1_u8..14, whole in 1_usize..5) {
            let number = Decimal::from_count(count, negative_zero, decimals);
            let mut text = String::new();
            number.write(&mut text, whole).unwrap();
            prop_assert_eq!(Decimal::parse(text.as_bytes()), Ok(number));
        }

        #[test]
        fn the_standard_library_agrees(count in -i32::MAX..=i32::MAX, decimals in 1_u8..10) {
            let mut text = String::new();
            Decimal::from_count(count, false, decimals).write(&mut text, 1).unwrap();
            let divided = f64::from(count) / 10_f64.powi(decimals.into());
            prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), divided.to_bits());
        }

        #[test]
        fn a_number_is_what_the_standard_library_reads_and_more_strictly(text in "[-+0-9.e ]{0,12}") {
            let strict = text.len() > 1 && text.starts_with(['+', '-'])
                && text[1..].split_once('.').is_some_and(|(whole, decimals)| {
                    [whole, decimals].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()))
                });
            let count = text.replace('.', "").parse::<i64>().ok().filter(|count| strict && count.abs() <= i64::from(i32::MAX));
            prop_assert_eq!(parsed(&text).ok().map(|(count, _)| i64::from(count)), count);
        }
    }
}

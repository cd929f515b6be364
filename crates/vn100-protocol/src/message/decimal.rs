//! A printed number as an exact count of its last digit.

use thiserror::Error;

/// A number as the sensor prints it, `sign digits . digits`, without conversion to a float.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Decimal {
    /// The number in units of its last digit, within ±[`i32::MAX`].
    pub(super) count: i32,
    /// The number of digits after the point.
    pub(super) decimals: u8,
}

/// The reason why a field is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[non_exhaustive]
pub enum DecimalError {
    /// The field is empty.
    #[error("the field is empty")]
    Empty,
    /// The first byte is neither `+` nor `-`.
    #[error("the sign is missing: a number begins with + or -, not with {:?}", char::from(*found))]
    NoSign {
        /// The first byte.
        found: u8,
    },
    /// No digit precedes the point.
    #[error("there is no digit before the point, at least one is needed")]
    NoWholeDigits,
    /// The digits are not followed by a point.
    #[error("the point is missing: a number has at least one decimal")]
    NoPoint,
    /// No digit follows the point.
    #[error("there is no digit after the point, at least one is needed")]
    NoDecimals,
    /// A byte that cannot occur in a number: an exponent, a space, a letter, a second point.
    #[error("unexpected {:?} in a number: it consists of sign, digits, point and digits", char::from(*found))]
    Unexpected {
        /// That byte.
        found: u8,
    },
    /// More digits than a 32-bit count can hold, or more than 255 digits after the point.
    #[error("the number is beyond {} counts or has more than 255 decimals", i32::MAX)]
    Overflow,
}

impl Decimal {
    /// Reads a whole field: a mandatory sign, at least one digit on either side of the point, any
    /// number of leading zeros.
    ///
    /// # Errors
    /// A [`DecimalError`] for the first error in the field, from the left.
    pub(super) fn parse(field: &[u8]) -> Result<Self, DecimalError> {
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
        Ok(Self { count: if sign == b'-' { -magnitude } else { magnitude }, decimals })
    }
}

/// The digits at the head of `bytes`, and the bytes after them.
fn split_digits(bytes: &[u8]) -> (&[u8], &[u8]) {
    bytes.split_at(bytes.iter().take_while(|byte| byte.is_ascii_digit()).count())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(field: &str) -> Result<(i32, u8), DecimalError> {
        Decimal::parse(field.as_bytes()).map(|number| (number.count, number.decimals))
    }

    #[test]
    fn any_width_is_read() {
        assert_eq!(parsed("+1.5"), Ok((15, 1)));
        assert_eq!(parsed("-000085.469"), Ok((-85_469, 3)));
        assert_eq!(parsed("+2147483.647"), Ok((i32::MAX, 3)));
        assert_eq!(parsed("-2147483.647"), Ok((-i32::MAX, 3)));
    }

    #[test]
    fn texts_that_a_float_parser_accepts_are_rejected_with_the_reason() {
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

    proptest! {
        #[test]
        fn the_standard_library_agrees(count in -i32::MAX..=i32::MAX, decimals in 1_u8..10, width in 0_usize..16) {
            let value = f64::from(count) / 10_f64.powi(decimals.into());
            let text = format!("{value:+0width$.0$}", usize::from(decimals));
            prop_assert_eq!(parsed(&text), Ok((count, decimals)));
        }

        #[test]
        fn a_number_equals_that_of_the_standard_library_but_is_stricter(text in "[-+0-9.e ]{0,12}") {
            let strict = text.len() > 1 && text.starts_with(['+', '-'])
                && text[1..].split_once('.').is_some_and(|(whole, decimals)| {
                    [whole, decimals].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()))
                });
            let count = text.replace('.', "").parse::<i64>().ok().filter(|count| strict && count.abs() <= i64::from(i32::MAX));
            prop_assert_eq!(parsed(&text).ok().map(|(count, _)| i64::from(count)), count);
        }
    }
}

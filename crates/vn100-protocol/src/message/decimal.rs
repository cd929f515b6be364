//! A printed number as an exact count of its last digit.

/// A number as the sensor prints it, `sign digits . digits`, without conversion to a float.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Decimal {
    /// The number in units of its last digit, within ±[`i32::MAX`].
    pub(super) count: i32,
    /// The number of digits after the point.
    pub(super) decimals: u8,
}

impl Decimal {
    /// Reads a whole field: a mandatory sign, at least one digit on either side of the point, any
    /// number of leading zeros. `None` for any other text, and for a number that does not fit.
    pub(super) fn parse(field: &[u8]) -> Option<Self> {
        let (sign, digits) = field.split_first().filter(|(sign, _)| matches!(sign, b'+' | b'-'))?;
        let point = digits.iter().position(|byte| *byte == b'.')?;
        let (whole, decimals) = (&digits[..point], &digits[point + 1..]);
        if whole.is_empty() || decimals.is_empty() {
            return None;
        }
        let magnitude = whole.iter().chain(decimals).try_fold(0_i32, |magnitude, digit| {
            let digit = digit.is_ascii_digit().then(|| i32::from(digit - b'0'))?;
            magnitude.checked_mul(10)?.checked_add(digit)
        })?;
        let count = if *sign == b'-' { -magnitude } else { magnitude };
        Some(Self { count, decimals: decimals.len().try_into().ok()? })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(field: &str) -> Option<(i32, u8)> {
        Decimal::parse(field.as_bytes()).map(|number| (number.count, number.decimals))
    }

    #[test]
    fn any_width_is_read() {
        assert_eq!(parsed("+1.5"), Some((15, 1)));
        assert_eq!(parsed("-000085.469"), Some((-85_469, 3)));
        assert_eq!(parsed("+2147483.647"), Some((i32::MAX, 3)));
        assert_eq!(parsed("-2147483.647"), Some((-i32::MAX, 3)));
    }

    #[test]
    fn texts_that_a_float_parser_accepts_are_rejected() {
        for field in [
            "",
            "nan",
            "inf",
            "1.5",
            " +1.5",
            "+nan",
            "+1e3",
            "+1.0e3",
            "+1.5 ",
            "+1 .5",
            "+-1.5",
            "+1.5.2",
            "+1.5,",
            "+.5",
            "+.",
            "+5.",
            "+5",
            "+",
            "+2147483.648",
            "-2147483.648",
            "+99999999999999999999.0",
        ] {
            assert_eq!(parsed(field), None, "{field:?}");
        }
    }

    proptest! {
        #[test]
        fn the_standard_library_agrees(count in -i32::MAX..=i32::MAX, decimals in 1_u8..10, width in 0_usize..16) {
            let value = f64::from(count) / 10_f64.powi(decimals.into());
            let text = format!("{value:+0width$.0$}", usize::from(decimals));
            prop_assert_eq!(parsed(&text), Some((count, decimals)));
        }

        #[test]
        fn a_number_equals_that_of_the_standard_library_but_is_stricter(text in "[-+0-9.e ]{0,12}") {
            let strict = text.len() > 1 && text.starts_with(['+', '-'])
                && text[1..].split_once('.').is_some_and(|(whole, decimals)| {
                    [whole, decimals].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()))
                });
            let count = text.replace('.', "").parse::<i64>().ok().filter(|count| strict && count.abs() <= i64::from(i32::MAX));
            prop_assert_eq!(parsed(&text).map(|(count, _)| i64::from(count)), count);
        }
    }
}

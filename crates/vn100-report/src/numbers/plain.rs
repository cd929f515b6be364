//! Numbers for terminals, in ASCII except for the sign of a symmetric interval.

use std::time::Duration;

use super::in_threes;

/// Six digits, without trailing zeros: enough for rates and times.
pub fn short(value: f64) -> String {
    let decimals = if value > 0.0 { (5 - value.log10().floor() as i32).clamp(0, 9) as usize } else { 0 };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// `count` significant digits, with a power of ten below a hundredth and from a hundred thousand on:
/// `0.0353`, `12.5`, `3.53e-4`.
pub fn digits(value: f64, count: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let most = count.saturating_sub(1);
    // rounding may lead to the next power
    let rounded = format!("{value:.most$e}");
    let exponent = rounded.split_once('e').and_then(|(_, exponent)| exponent.parse().ok());
    match exponent {
        Some(exponent @ -2..=4) => format!("{value:.*}", (most as i32 - exponent).max(0) as usize),
        _ => rounded,
    }
}

/// At most `most` significant digits, without trailing zeros: `40`, `3.5e-3`.
pub fn digits_trimmed(value: f64, most: usize) -> String {
    let text = digits(value, most);
    let (number, exponent) = text.find('e').map_or((text.as_str(), ""), |place| text.split_at(place));
    let number = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    format!("{number}{exponent}")
}

/// A value with `decimals` decimals. If the text is wider than `width`, with fewer decimals as
/// long as three digits remain, else with a power of ten. What rounds to 0 has no minus.
pub fn fitted(value: f64, decimals: usize, width: usize) -> String {
    let keeps_digits = |places: usize| value == 0.0 || value.abs() * 10_f64.powi(places as i32) >= 100.0;
    let fixed = (0..=decimals).rev().filter(|places| *places == decimals || keeps_digits(*places));
    let fixed = fixed.map(|places| format!("{value:.places$}"));
    let is_zero = |text: &str| text.contains('0') && !text.bytes().any(|digit| matches!(digit, b'1'..=b'9'));
    let fixed = fixed.map(|text| if is_zero(&text) { text.replace('-', "") } else { text });
    let powers = (0..=5).rev().map(|places| format!("{value:.places$e}"));
    fixed.chain(powers).find(|text| text.len() <= width).unwrap_or_else(|| format!("{value:.0e}"))
}

/// The value with its sign and `decimals` decimals; `+0.0` where it rounds to 0.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:+.decimals$}");
    let is_zero = text.contains('0') && !text.bytes().any(|digit| matches!(digit, b'1'..=b'9'));
    if is_zero { text.replace('-', "+") } else { text }
}

/// An offset in ppm: `+12 ppm`; one that rounds to zero is `+0 ppm`.
pub fn ppm(value: f64) -> String {
    // the sum of a negative and a positive nought is positive
    format!("{:+} ppm", value.round() + 0.0)
}

/// A number and its noun: `1 gap`, `2 gaps`.
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A whole number in groups of three: `12 345`.
pub fn grouped(count: u64) -> String {
    in_threes(count, ' ')
}

/// An averaging time in seconds: `0.025`, `1.6`, `51.2`, `1638`.
pub fn tau(seconds: f64) -> String {
    let text = if seconds < 100.0 { format!("{seconds:.3}") } else { format!("{seconds:.1}") };
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A waiting time, in its two largest units: `45 s`, `2 min 10 s`, `3 h 5 min`.
pub fn time(seconds: f64) -> String {
    let whole = Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX).as_secs();
    let parts = parts(whole);
    let first = parts.iter().position(|(count, _)| *count > 0).unwrap_or_default();
    joined(&parts[first..parts.len().min(first + 2)], " ")
}

/// Whole seconds, rounded up, in all units, with `blank` between number and unit: `1 h 30 min`; for
/// an option `blank` is empty.
pub fn span(seconds: f64, blank: &str) -> String {
    joined(&parts(seconds.ceil().max(0.0) as u64), blank)
}

type SpanPart = (u64, &'static str);

fn parts(seconds: u64) -> [SpanPart; 4] {
    [(seconds / 86_400, "d"), (seconds / 3600 % 24, "h"), (seconds / 60 % 60, "min"), (seconds % 60, "s")]
}

fn joined(parts: &[SpanPart], blank: &str) -> String {
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, unit)| format!("{count}{blank}{unit}")).collect();
    if parts.is_empty() { format!("0{blank}s") } else { parts.join(blank) }
}

/// The time of a running clock: `0:00:05`.
pub fn clock(time: Duration) -> String {
    let s = time.as_secs();
    format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.035_312, "0.0353"),
            (-12.5, "-12.5"),
            (123.4, "123"),
            (99_999.0, "1.00e5"),
            (0.000_353_12, "3.53e-4"),
            (-123_456.0, "-1.23e5"),
        ] {
            assert_eq!(digits(value, 3), text);
        }
        for (value, text) in [(0.0, "0"), (0.012_345, "0.01235"), (9.99996, "10.00"), (123_450.0, "1.234e5")] {
            assert_eq!(digits(value, 4), text);
        }
        assert_eq!([grouped(0), grouped(999), grouped(1_234_567)], ["0", "999", "1 234 567"]);
        assert_eq!(
            [tau(0.025), tau(1.6), tau(51.2), tau(1638.4), tau(100.0)],
            ["0.025", "1.6", "51.2", "1638.4", "100"]
        );
        assert_eq!([0, 1, 2].map(|count| counted(count, "gap")), ["0 gaps", "1 gap", "2 gaps"]);
    }

    #[test]
    fn nothing_has_no_sign_of_its_own() {
        for (value, text) in
            [(-0.4, "+0 ppm"), (0.4, "+0 ppm"), (-0.6, "-1 ppm"), (12.4, "+12 ppm"), (-2500.0, "-2500 ppm")]
        {
            assert_eq!(ppm(value), text);
        }
    }

    #[test]
    fn nothing_is_not_below_0() {
        for (value, decimals, text) in [(-0.004, 1, "+0.0"), (0.0, 2, "+0.00"), (-0.06, 1, "-0.1"), (2.345, 2, "+2.35")]
        {
            assert_eq!(signed(value, decimals), text);
        }
        assert_eq!(crate::numbers::signed(-1.5, 1), "−1.5");
    }

    #[test]
    fn times_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.025, "0.025"),
            (1.0 / 3.0, "0.333333"),
            (60.0, "60"),
            (60.150_375_9, "60.1504"),
            (5e-6, "0.000005"),
            (1e7, "10000000"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn trailing_zeros_say_nothing() {
        let trimmed = [(40.0, 6), (10.0, 3), (0.04, 3), (0.0035, 3), (1.0 / 360.0, 3), (2e6, 3), (0.0, 3)];
        assert_eq!(trimmed.map(|(v, n)| digits_trimmed(v, n)), ["40", "10", "0.04", "3.5e-3", "2.78e-3", "2e6", "0"]);
    }

    #[test]
    fn times_have_two_parts_at_most() {
        for (seconds, text) in [
            (0.4, "0 s"),
            (59.9, "59 s"),
            (60.0, "1 min"),
            (130.0, "2 min 10 s"),
            (3.0 * 3600.0 + 59.0, "3 h"),
            (7800.0, "2 h 10 min"),
            (100_000.0, "1 d 3 h"),
            (f64::INFINITY, "213503982334601 d 7 h"),
        ] {
            assert_eq!(time(seconds), text);
        }
        assert_eq!(clock(Duration::from_secs(3_725)), "1:02:05");
    }

    #[test]
    fn spans_are_said_and_read_back() {
        for (seconds, said) in [
            (0.0, "0 s"),
            (59.2, "1 min"),
            (1800.0, "30 min"),
            (5400.0, "1 h 30 min"),
            (354_601.0, "4 d 2 h 30 min 1 s"),
        ] {
            assert_eq!(span(seconds, " "), said);
            let option = humantime::parse_duration(&span(seconds, ""));
            assert_eq!(option.map(|duration| duration.as_secs_f64()), Ok(seconds.ceil()), "{said}");
        }
    }

    #[test]
    fn a_number_never_is_wider_than_its_column_nor_without_digits() {
        for (value, decimals, width, text) in [
            (-9.8066, 4, 9, "-9.8066"),
            (0.0, 4, 9, "0.0000"),
            (0.0, 12, 9, "0.0000000"),
            (4.848e-5, 6, 9, "0.000048"),
            (4.8481e-5, 9, 9, "0.0000485"),
            (-4.8481e-6, 12, 14, "-0.00000484810"),
            (-4.8481e-6, 12, 9, "-4.848e-6"),
            (9.9996, 4, 5, "10.00"),
            (-1.5e12, 3, 9, "-1.500e12"),
            (-1.9e-6, 4, 7, "0.0000"),
            (-0.0, 3, 9, "0.000"),
        ] {
            assert_eq!(fitted(value, decimals, width), text);
        }
    }
}

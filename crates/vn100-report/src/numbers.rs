//! Numbers for people: here for pages and figures, with typographic signs; in [`plain`] for a
//! terminal.

pub mod plain;

/// The text for a number that is not known.
pub const NOTHING: &str = "–";

/// The value to `count` significant digits, with a power of ten below a hundredth and from a
/// hundred thousand on: `0.01235`, `1.263·10⁻⁴`; [`NOTHING`] for a value that is not finite.
pub fn digits(value: f64, count: usize) -> String {
    if value.is_finite() { with_powers(&plain::digits(value, count)).replace('-', "−") } else { NOTHING.into() }
}

/// The number with raised digits, as an exponent.
pub(crate) fn superscript(number: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    number.to_string().chars().map(raised).collect()
}

/// The text of a terminal with its powers of ten as on a page: `5.92e-4` as `5.92·10⁻⁴`.
pub fn with_powers(text: &str) -> String {
    let mut written = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('e') {
        written.push_str(before);
        let sign = usize::from(after.starts_with(['-', '+']));
        let digits = after[sign..].bytes().take_while(u8::is_ascii_digit).count();
        let power = after[..sign + digits].parse().ok().filter(|_| before.ends_with(|c: char| c.is_ascii_digit()));
        match power {
            Some(power) => written.extend(["·10", &superscript(power)]),
            None => written.push('e'),
        }
        rest = if power.is_some() { &after[sign + digits..] } else { after };
    }
    written + rest
}

/// The value with its sign and `decimals` decimals; `+0.0` where it rounds to 0.
pub fn signed(value: f64, decimals: usize) -> String {
    plain::signed(value, decimals).replace('-', "−")
}

/// A probability to two digits; below 10⁻⁹, which is too small to matter, as a bound.
pub fn p_value(p: f64) -> String {
    if p < 1e-9 { "< 10⁻⁹".into() } else { digits(p, 2) }
}

/// A value with its interval, all to the same digit: `1.263·10⁻⁴ (1.246 to 1.281)`.
pub fn with_interval(value: f64, lower: f64, upper: f64) -> String {
    let largest = value.abs().max(lower.abs()).max(upper.abs());
    if largest == 0.0 || !largest.is_finite() {
        return digits(value, 4);
    }
    // as many digits as the narrower half of the interval is worth, one more than that
    let half = (upper - value).min(value - lower).max(largest * 1e-6);
    let power = largest.log10().floor() as i32;
    let decimals = (power - half.log10().floor() as i32 + 1).clamp(1, 5);
    if (-2..=4).contains(&power) {
        let places = (decimals - power).max(0) as usize;
        return format!("{value:.places$} ({lower:.places$} to {upper:.places$})").replace('-', "−");
    }
    let (unit, places) = (10_f64.powi(power), decimals as usize);
    let [value, lower, upper] = [value, lower, upper].map(|value| value / unit);
    format!("{value:.places$} ({lower:.places$} to {upper:.places$})·10{}", superscript(power)).replace('-', "−")
}

/// A length of time, to three digits: `330.6 s`, `25 min`, `5.01 h`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        ..10.0 => format!("{} s", trimmed(seconds, 3)),
        ..600.0 => format!("{} s", trimmed(seconds, 1)),
        ..7200.0 => format!("{} min", trimmed(seconds / 60.0, 1)),
        ..172_800.0 => format!("{} h", trimmed(seconds / 3600.0, 2)),
        _ => format!("{} days", trimmed(seconds / 86_400.0, 2)),
    }
}

/// The value with at most so many decimals, without trailing zeros, and without a sign before 0.
pub fn trimmed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// A whole number in groups of three, with a narrow space between them that no line is broken at.
pub fn grouped(count: u64) -> String {
    in_threes(count, '\u{202f}')
}

fn in_threes(count: u64, between: char) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(between);
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten_of_a_terminal_are_written_as_on_a_page() {
        for (text, written) in [
            (
                "measured 5.922e-4 (5.912e-4 to 5.932e-4); the sheet",
                "measured 5.922·10⁻⁴ (5.912·10⁻⁴ to 5.932·10⁻⁴); the sheet",
            ),
            ("≤ 1.2e12", "≤ 1.2·10¹²"),
            ("1.65e+08", "1.65·10⁸"),
            ("2e, -e3 and e-4 stay", "2e, -e3 and e-4 stay"),
            ("", ""),
        ] {
            assert_eq!(with_powers(text), written);
        }
    }

    #[test]
    fn numbers_have_few_digits_and_no_rows_of_zeros() {
        for (value, text) in [
            (0.0, "0"),
            (1.263_4e-4, "1.263·10⁻⁴"),
            (0.012_345, "0.01235"),
            (9.99996, "10.00"),
            (-9.887_886, "−9.888"),
            (123_456.0, "1.235·10⁵"),
        ] {
            assert_eq!(digits(value, 4), text);
        }
        assert_eq!(with_interval(1.2634e-4, 1.2461e-4, 1.2812e-4), "1.263 (1.246 to 1.281)·10⁻⁴");
        assert_eq!(with_interval(0.4397, 0.4351, 0.4443), "0.4397 (0.4351 to 0.4443)");
        assert_eq!(with_interval(5.0, 1.0, 30.0), "5.0 (1.0 to 30.0)");
        assert_eq!(
            [(-0.04, 1), (-0.4, 0), (-0.06, 1), (0.0, 2)].map(|(value, decimals)| trimmed(value, decimals)),
            ["0", "0", "−0.1", "0"]
        );
        assert_eq!(
            [0.05, 59.96, 600.0, 18_000.0, 200_000.0].map(duration),
            ["0.05 s", "60 s", "10 min", "5 h", "2.31 days"]
        );
        assert_eq!([0, 999, 13_223, 1_234_567].map(grouped), ["0", "999", "13\u{202f}223", "1\u{202f}234\u{202f}567"]);
    }
}

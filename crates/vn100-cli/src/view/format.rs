//! Numbers and times as the view writes them: short, and always as wide as they say.

use std::time::Duration;

/// A number to so many digits, as short as that allows: `0.0353`, `12.5`, `3.53e-4`.
pub(crate) fn digits(value: f64, digits: i32) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        return "0".into();
    }
    if (0.01..1e5).contains(&magnitude) {
        let decimals = (digits - 1 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        let decimals = (digits - 1).max(0) as usize;
        format!("{value:.decimals$e}")
    }
}

/// A number to so many digits, without noughts at its end: `40`, `3.5e-3`.
pub(crate) fn digits_trimmed(value: f64, most: i32) -> String {
    let text = digits(value, most);
    let (number, exponent) = text.find('e').map_or((text.as_str(), ""), |place| text.split_at(place));
    let number = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    format!("{number}{exponent}")
}

/// How far the truth may lie above and below, as a part of the value: `±2.1 %`, or `+12 -9 %` where
/// that differs.
pub(crate) fn spread(value: f64, lower: f64, upper: f64) -> String {
    let (below, above) = (100.0 * (1.0 - lower / value), 100.0 * (upper / value - 1.0));
    let decimals = usize::from(above < 9.95);
    if (above - below).abs() < 0.15 * above {
        format!("±{:.decimals$} %", f64::midpoint(above, below))
    } else {
        format!("+{above:.decimals$} -{below:.decimals$} %")
    }
}

/// A time a person waits for: `45 s`, `2 min 10 s`, `3 h 5 min`, `2 d 4 h`.
pub(crate) fn time(seconds: f64) -> String {
    let whole = Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX).as_secs();
    let (large, small, large_unit, small_unit) = match whole {
        0..60 => return format!("{whole} s"),
        60..3600 => (whole / 60, whole % 60, "min", "s"),
        3600..86_400 => (whole / 3600, whole % 3600 / 60, "h", "min"),
        _ => (whole / 86_400, whole % 86_400 / 3600, "d", "h"),
    };
    if small == 0 { format!("{large} {large_unit}") } else { format!("{large} {large_unit} {small} {small_unit}") }
}

/// A running clock: `0:00:05`.
pub(crate) fn clock(time: Duration) -> String {
    let s = time.as_secs();
    format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
}

/// A whole number in groups of three: `12 345`.
pub(crate) fn grouped(number: u64) -> String {
    let text = number.to_string();
    let mut out = String::new();
    for (place, digit) in text.chars().enumerate() {
        if place > 0 && (text.len() - place).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

/// An averaging time: `0.025`, `1.6`, `51.2`, `1638`.
pub(crate) fn tau(seconds: f64) -> String {
    let text = if seconds < 100.0 { format!("{seconds:.3}") } else { format!("{seconds:.1}") };
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
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
            (99_999.0, "99999"),
            (0.000_353_12, "3.53e-4"),
            (-123_456.0, "-1.23e5"),
        ] {
            assert_eq!(digits(value, 3), text);
        }
        assert_eq!([grouped(0), grouped(999), grouped(1_234_567)], ["0", "999", "1 234 567"]);
        assert_eq!(
            [tau(0.025), tau(1.6), tau(51.2), tau(1638.4), tau(100.0)],
            ["0.025", "1.6", "51.2", "1638.4", "100"]
        );
    }

    #[test]
    fn spreads_are_one_number_where_that_is_enough() {
        let trimmed = [(40.0, 6), (10.0, 3), (0.04, 3), (0.0035, 3), (1.0 / 360.0, 3), (2e6, 3), (0.0, 3)];
        assert_eq!(trimmed.map(|(v, n)| digits_trimmed(v, n)), ["40", "10", "0.04", "3.5e-3", "2.78e-3", "2e6", "0"]);
        assert_eq!(spread(10.0, 9.8, 10.205), "±2.0 %");
        assert_eq!(spread(10.0, 5.0, 30.0), "+200 -50 %");
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
}

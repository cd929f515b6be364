//! Numbers as text.

/// To six digits, without zeros behind: what rates and times need.
#[must_use]
pub fn short(value: f64) -> String {
    let decimals = if value > 0.0 { (5 - value.log10().floor() as i32).clamp(0, 9) as usize } else { 0 };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// To four digits.
#[must_use]
pub fn four_digits(value: f64) -> String {
    let magnitude = value.abs();
    if (0.01..1e4).contains(&magnitude) {
        let decimals = (3 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// `+12 ppm`; what rounds to nothing is `+0 ppm`.
#[must_use]
pub fn ppm(value: f64) -> String {
    // the sum of a negative and a positive nought is positive
    format!("{:+} ppm", value.round() + 0.0)
}

/// `1 gap`, `2 gaps`.
#[must_use]
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_sign_of_its_own() {
        for (value, text) in
            [(-0.4, "+0 ppm"), (0.4, "+0 ppm"), (-0.6, "-1 ppm"), (12.4, "+12 ppm"), (-2500.0, "-2500 ppm")]
        {
            assert_eq!(ppm(value), text);
        }
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
}

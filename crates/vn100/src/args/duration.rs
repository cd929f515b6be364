//! Durations on the command line: seconds if no unit is given.

use std::time::Duration;

use vn100_analysis::Coast;

/// A duration such as `90`, `1.5`, `10min` or `5h`.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    if let Ok(seconds) = text.parse::<f64>() {
        return Duration::try_from_secs_f64(seconds).map_err(|_| format!("{text} s is not a duration"));
    }
    humantime::parse_duration(text).map_err(|error| format!("{error}; give a duration such as 90, 10min or 5h"))
}

pub(super) fn length(text: &str) -> Result<Duration, String> {
    match duration(text) {
        Ok(Duration::ZERO) => Err("0 s contains no sample; give a duration such as 10min".into()),
        length => length,
    }
}

/// `[REST+]T`: a coast of T after a rest, as long if no other is given.
pub(super) fn coast(text: &str) -> Result<Coast, String> {
    let (rest, coast) = text.split_once('+').unwrap_or((text, text));
    Ok(Coast { rest: length(rest)?, coast: length(coast)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_need_no_unit() {
        assert_eq!(duration("90"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1.5"), Ok(Duration::from_millis(1500)));
        assert_eq!(duration("10min"), Ok(Duration::from_secs(600)));
        assert_eq!(duration("1h 30min"), Ok(Duration::from_secs(5400)));
        assert_eq!(duration("0"), Ok(Duration::ZERO));
        for wrong in ["-1", "nan", "inf", "1e300", "5 apples", "", "-1s"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
        let after = |rest, coast| Coast { rest: Duration::from_secs(rest), coast: Duration::from_secs(coast) };
        assert_eq!(coast("5min"), Ok(after(300, 300)));
        assert_eq!(coast("10s+1h 1min"), Ok(after(10, 3660)));
        for wrong in ["", "+", "5+", "+5", "0", "1+0", "1+2+3"] {
            assert!(coast(wrong).is_err(), "{wrong}");
        }
        for wrong in ["0", "0s", "0.0", "1e-12"] {
            assert!(length(wrong).unwrap_err().contains("10min"), "{wrong}");
        }
    }
}

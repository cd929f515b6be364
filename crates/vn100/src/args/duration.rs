//! Durations on the command line: seconds if no unit is given.

use std::time::Duration;

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
        for wrong in ["0", "0s", "0.0", "1e-12"] {
            assert!(length(wrong).unwrap_err().contains("10min"), "{wrong}");
        }
    }
}

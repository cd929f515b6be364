//! The stamp of a row: in which unit it is written, and as exact nanoseconds.

use super::number::{LastDigit, Number};

/// The unit a stamp is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampUnit {
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
}

impl StampUnit {
    /// The units by the names they have in a column map.
    pub(super) const NAMES: [(&'static str, Self); 4] =
        [("s", Self::Seconds), ("ms", Self::Milliseconds), ("us", Self::Microseconds), ("ns", Self::Nanoseconds)];

    /// The unit by the size of a stamp: a time of the years 2001 to 2102 in one of the four units is in that unit; a whole number
    /// beyond 10^15 is nanoseconds; all else is seconds.
    pub(super) fn by_magnitude(stamp: &Number) -> Self {
        let magnitude = stamp.magnitude();
        let since_epoch = |unit_s: f64| (1e9..4.2e9).contains(&(magnitude * unit_s));
        if since_epoch(1e-3) {
            Self::Milliseconds
        } else if since_epoch(1e-6) {
            Self::Microseconds
        } else if magnitude >= 1e15 {
            Self::Nanoseconds
        } else {
            Self::Seconds
        }
    }

    /// `stamp` in nanoseconds, with digits behind them rounded away; `None` beyond 292 years.
    pub(super) fn nanoseconds(self, stamp: &Number) -> Option<i64> {
        let decimals = match self {
            Self::Seconds => 9,
            Self::Milliseconds => 6,
            Self::Microseconds => 3,
            Self::Nanoseconds => 0,
        };
        stamp.count(decimals, LastDigit::Rounded).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nanoseconds(text: &str) -> Option<i64> {
        let stamp = Number::parse(text.as_bytes()).unwrap();
        StampUnit::by_magnitude(&stamp).nanoseconds(&stamp)
    }

    #[test]
    fn the_unit_follows_from_the_size() {
        let epoch = Some(1_761_939_167_192_566_000);
        for text in [
            "1761939167.192566",
            "1761939167192.566",
            "1761939167192566",
            "1761939167192566000",
            "1.761939167192566e+09",
        ] {
            assert_eq!(nanoseconds(text), epoch, "{text}");
        }
        assert_eq!(nanoseconds("0.025"), Some(25_000_000));
        assert_eq!(nanoseconds("-3"), Some(-3_000_000_000));
        assert_eq!(nanoseconds("5000000000000000"), Some(5_000_000_000_000_000));
    }

    #[test]
    fn a_nanosecond_of_an_epoch_is_kept() {
        // a float of this size steps by 238 ns
        assert_eq!(nanoseconds("1761939167.192566001"), Some(1_761_939_167_192_566_001));
        assert_eq!(nanoseconds("0.0000000016"), Some(2));
        assert_eq!(nanoseconds("1e30"), None);
    }
}

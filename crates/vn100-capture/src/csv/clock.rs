//! Stamps that are no single number: dates and times of day, as `2023-03-06T02:25:02.45Z`,
//! `2023/03/06/02:25:02.45`, `06.03.2023 02:25:02,45`, `02:25:02.45` or `25:02.4`.

/// In which order a stamp has its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ClockForm {
    /// Year, month, day, time: ISO 8601, also with other separators.
    YearFirst,
    /// Day, month, year, time.
    DayFirst,
    /// Month, day, year, time.
    MonthFirst,
    /// The time of day alone, which begins anew at midnight.
    TimeOfDay,
    /// Minutes and seconds alone, as Excel shows a time of day; they may begin anew with the hour.
    MinutesSeconds,
}

const HOUR_NS: i64 = 3_600_000_000_000;
const DAY_NS: i64 = 24 * HOUR_NS;

impl ClockForm {
    /// Of two that fit, the first is taken.
    pub(super) const ALL: [Self; 5] =
        [Self::YearFirst, Self::DayFirst, Self::MonthFirst, Self::TimeOfDay, Self::MinutesSeconds];

    /// Its name in a column map.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::YearFirst => "iso",
            Self::DayFirst => "dmy",
            Self::MonthFirst => "mdy",
            Self::TimeOfDay => "clock",
            Self::MinutesSeconds => "mmss",
        }
    }

    /// Nanoseconds since 1970 in UTC, where the stamp has no zone in that of its clock; of a time
    /// of day since midnight. `None` for what is not of this form. Digits behind the ninth decimal
    /// are cut.
    pub(super) fn nanoseconds(self, stamp: &[u8]) -> Option<i64> {
        let mut text = Parts { rest: stamp.trim_ascii() };
        let days = match self {
            Self::MinutesSeconds => return text.minutes_seconds_ns(),
            Self::TimeOfDay => 0,
            Self::YearFirst => {
                let (year, separator) = (text.number(4, 4)?, text.separator()?);
                let month = text.number(1, 2)?;
                text.byte(separator)?;
                days(year, month, text.number(1, 2)?)?
            }
            Self::DayFirst | Self::MonthFirst => {
                let (first, separator) = (text.number(1, 2)?, text.separator()?);
                let second = text.number(1, 2)?;
                text.byte(separator)?;
                let year = text.number(4, 4)?;
                let (day, month) = if self == Self::DayFirst { (first, second) } else { (second, first) };
                days(year, month, day)?
            }
        };
        if self != Self::TimeOfDay {
            text.between_date_and_time()?;
        }
        let hour = text.number(1, 2).filter(|&hour| hour < 24)?;
        text.byte(b':')?;
        let minute = text.number(2, 2).filter(|&minute| minute < 60)?;
        text.byte(b':')?;
        // a leap second is the first of the next minute
        let second = text.number(2, 2).filter(|&second| second <= 60)?;
        let fraction_ns = text.fraction_ns()?;
        let hour = text.hour_of_day(hour)?;
        let zone_s = text.zone_s()?;
        let seconds = ((days * 24 + hour) * 60 + minute) * 60 + second - zone_s;
        text.rest.is_empty().then(|| seconds.checked_mul(1_000_000_000)?.checked_add(fraction_ns)).flatten()
    }

    /// `stamp_ns` behind `last_ns`, where a day or an hour has begun anew between them.
    pub(super) fn behind(self, last_ns: Option<i64>, stamp_ns: i64) -> i64 {
        let period_ns = match self {
            Self::TimeOfDay => DAY_NS,
            Self::MinutesSeconds => HOUR_NS,
            Self::YearFirst | Self::DayFirst | Self::MonthFirst => return stamp_ns,
        };
        let Some(last_ns) = last_ns else { return stamp_ns };
        let periods = (last_ns - stamp_ns + period_ns / 2).div_euclid(period_ns);
        stamp_ns + periods.max(0) * period_ns
    }
}

/// Whether it is a time of day.
pub(super) fn is_time(text: &[u8]) -> bool {
    ClockForm::TimeOfDay.nanoseconds(text).is_some()
}

/// Whether it is a date with a time of day, or a time of day alone.
pub(super) fn is_stamp(text: &[u8]) -> bool {
    ClockForm::ALL.iter().any(|form| form.nanoseconds(text).is_some())
}

struct Parts<'a> {
    rest: &'a [u8],
}

impl Parts<'_> {
    /// As many digits as there are, `least..=most` of them.
    fn number(&mut self, least: usize, most: usize) -> Option<i64> {
        let digits = self.rest.iter().take(most).take_while(|byte| byte.is_ascii_digit()).count();
        let (number, rest) = self.rest.split_at(digits);
        self.rest = rest;
        (digits >= least).then(|| number.iter().fold(0, |value, digit| 10 * value + i64::from(digit - b'0')))
    }

    fn byte(&mut self, expected: u8) -> Option<()> {
        self.rest = self.rest.strip_prefix(&[expected])?;
        Some(())
    }

    /// What separates the parts of a date.
    fn separator(&mut self) -> Option<u8> {
        let (&first, rest) = self.rest.split_first()?;
        self.rest = rest;
        matches!(first, b'-' | b'/' | b'.').then_some(first)
    }

    fn between_date_and_time(&mut self) -> Option<()> {
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest.trim_ascii_start();
        matches!(first, b'T' | b't' | b' ' | b'/' | b'_' | b'-' | b':').then_some(())
    }

    /// As `02:25.4`. Without a fraction it would be hours and minutes as likely.
    fn minutes_seconds_ns(&mut self) -> Option<i64> {
        let minutes = self.number(1, 6)?;
        self.byte(b':')?;
        let seconds = self.number(2, 2).filter(|&seconds| seconds < 60)?;
        let has_fraction = matches!(self.rest.first(), Some(b'.' | b','));
        let fraction_ns = self.fraction_ns()?;
        let is_whole = has_fraction && self.rest.is_empty();
        is_whole.then_some((minutes * 60 + seconds) * 1_000_000_000 + fraction_ns)
    }

    fn fraction_ns(&mut self) -> Option<i64> {
        let Some((b'.' | b',', rest)) = self.rest.split_first() else { return Some(0) };
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let (fraction, rest) = rest.split_at(digits);
        self.rest = rest;
        let nanoseconds =
            (0..9).fold(0, |value, place| 10 * value + fraction.get(place).map_or(0, |digit| i64::from(digit - b'0')));
        (digits > 0).then_some(nanoseconds)
    }

    /// The hour with the `AM` or `PM` behind it, where one stands there.
    fn hour_of_day(&mut self, hour: i64) -> Option<i64> {
        let trimmed = self.rest.trim_ascii_start();
        let (half, rest) = trimmed.split_at_checked(2).unwrap_or((b"", trimmed));
        let is_pm = half.eq_ignore_ascii_case(b"pm");
        if !is_pm && !half.eq_ignore_ascii_case(b"am") {
            return Some(hour);
        }
        self.rest = rest;
        (1..=12).contains(&hour).then_some(hour % 12 + if is_pm { 12 } else { 0 })
    }

    /// East of Greenwich; 0 without a zone.
    fn zone_s(&mut self) -> Option<i64> {
        let trimmed = self.rest.trim_ascii_start();
        match trimmed.split_first() {
            None => Some(0),
            Some((b'Z' | b'z', rest)) => {
                self.rest = rest;
                Some(0)
            }
            Some((sign @ (b'+' | b'-'), rest)) => {
                self.rest = rest;
                let hours = self.number(2, 2).filter(|&hours| hours < 24)?;
                self.rest = self.rest.strip_prefix(b":").unwrap_or(self.rest);
                let minutes = if self.rest.is_empty() { 0 } else { self.number(2, 2)? };
                let seconds = (hours * 60 + minutes) * 60;
                Some(if *sign == b'-' { -seconds } else { seconds })
            }
            Some(_) if trimmed == b"UTC" || trimmed == b"GMT" => {
                self.rest = b"";
                Some(0)
            }
            Some(_) => None,
        }
    }
}

/// Days since 1970-01-01 in the Gregorian calendar; `None` for a date that does not exist.
///
/// By years that begin in March, so that a leap day is the last of one: H. Hinnant, "chrono-
/// Compatible Low-Level Date Algorithms" (2013), `days_from_civil`.
fn days(year: i64, month: i64, day: i64) -> Option<i64> {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    if !(1..=length).contains(&day) {
        return None;
    }
    let march_year = year - i64::from(month <= 2);
    let (era, of_era) = (march_year.div_euclid(400), march_year.rem_euclid(400));
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + day_of_year - 719_468)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SECOND_NS: i64 = 1_000_000_000;

    #[test]
    fn one_moment_reads_the_same_in_every_form() {
        // date -u -d '2023-03-06 02:25:02' +%s
        let moment = 1_678_069_502 * SECOND_NS + 450_000_000;
        for (form, texts) in [
            (
                ClockForm::YearFirst,
                &[
                    "2023-03-06T02:25:02.45",
                    "2023-03-06T02:25:02.45Z",
                    "2023-03-06 02:25:02,45",
                    " 2023-03-06 02:25:02.450000000999 ",
                    "2023/03/06/02:25:02.45",
                    "2023/3/6 2:25:02.45",
                    "2023-03-06_02:25:02.45 UTC",
                    "2023-03-06T03:25:02.45+01:00",
                    "2023-03-05 20:55:02.45 -0530",
                    "2023.03.06 02:25:02.45",
                ][..],
            ),
            (ClockForm::DayFirst, &["06/03/2023 02:25:02.45", "6.3.2023 02:25:02,45", "06-03-2023T02:25:02.45"]),
            (
                ClockForm::MonthFirst,
                &[
                    "03/06/2023 02:25:02.45",
                    "3/6/2023  2:25:02.45",
                    "3/6/2023 2:25:02.45 AM",
                    "03/06/2023 02:25:02.45am",
                ],
            ),
        ] {
            for text in texts {
                assert_eq!(form.nanoseconds(text.as_bytes()), Some(moment), "{text}");
                assert_eq!(ClockForm::TimeOfDay.nanoseconds(text.as_bytes()), None, "{text}");
            }
        }
        let of_day = (2 * 60 + 25) * 60 * SECOND_NS + 2_450_000_000;
        assert_eq!(ClockForm::TimeOfDay.nanoseconds(b"02:25:02.45"), Some(of_day));
        let of_day = |text: &str| ClockForm::TimeOfDay.nanoseconds(text.as_bytes()).map(|ns| ns / SECOND_NS);
        let hours = ["12:00:00 AM", "12:30:00 pm", "1:00:00 PM", "11:59:59PM"].map(of_day);
        assert_eq!(hours, [0, 45_000, 46_800, 86_399].map(Some));
        // the leap day, and dates before the epoch
        assert_eq!(ClockForm::YearFirst.nanoseconds(b"2024-02-29 00:00:00"), Some(1_709_164_800 * SECOND_NS));
        assert_eq!(ClockForm::YearFirst.nanoseconds(b"1969-12-31 23:59:59"), Some(-SECOND_NS));
    }

    #[test]
    fn what_is_no_date_or_time_is_none() {
        for text in [
            "",
            "2023-02-29 00:00:00",
            "2023-13-01 00:00:00",
            "2023-03-06",
            "2023-03-06 25:00:00",
            "2023-03-06 02:25",
            "2023-03/06 02:25:02",
            "2023-03-06 02:25:02.",
            "2023-03-06 02:25:02 PDT",
            "2023-03-06 02:25:02+1",
            "12.5",
            "9999-99-99T99:99:99",
            "2023-03-06 02:25:02.45x",
            "3/16/2023 13:25:02 PM",
            "3/16/2023 0:25:02 AM",
        ] {
            assert!(ClockForm::ALL.iter().all(|form| form.nanoseconds(text.as_bytes()).is_none()), "{text}");
        }
    }

    #[test]
    fn minutes_and_seconds_continue_behind_the_hour() {
        let read = |text: &str| ClockForm::MinutesSeconds.nanoseconds(text.as_bytes());
        let late = read("59:59.9").unwrap();
        assert_eq!(late, 3_599_900_000_000);
        let early = ClockForm::MinutesSeconds.behind(Some(late), read("00:00.1").unwrap());
        assert_eq!(early - late, 200_000_000);
        // a duration continues
        assert_eq!(ClockForm::MinutesSeconds.behind(Some(late), read("60:00.1").unwrap()) - late, 200_000_000);
        for text in ["00:60.0", "12:30", "12:30:15.5", "0:5.0", "00:00.", "00:00.0x"] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn a_time_of_day_continues_behind_midnight() {
        let read = |text: &str| ClockForm::TimeOfDay.nanoseconds(text.as_bytes()).unwrap();
        let late = read("23:59:59.99");
        let early = ClockForm::TimeOfDay.behind(Some(late), read("00:00:00.01"));
        assert_eq!(early - late, 20_000_000);
        // and behind a second one; a small step back is one
        assert_eq!(
            ClockForm::TimeOfDay.behind(Some(early + DAY_NS - 20_000_000), read("00:00:00.02")),
            early + DAY_NS + 10_000_000
        );
        assert_eq!(ClockForm::TimeOfDay.behind(Some(early), read("23:59:59.995")), late + 5_000_000);
        assert_eq!(ClockForm::YearFirst.behind(Some(late), 5), 5);
    }

    proptest! {
        #[test]
        fn any_moment_is_read_back(second in -62_000_000_000_i64..250_000_000_000, nanosecond in 0..SECOND_NS) {
            // printed by the calendar of another: days counted one by one would be too slow
            let (day, of_day) = (second.div_euclid(86_400), second.rem_euclid(86_400));
            let (year, month, day) = civil(day);
            let (h, m, s) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
            let text = format!("{year:04}-{month:02}-{day:02}T{h:02}:{m:02}:{s:02}.{nanosecond:09}Z");
            let expected = second.checked_mul(SECOND_NS).and_then(|ns| ns.checked_add(nanosecond));
            prop_assert_eq!(ClockForm::YearFirst.nanoseconds(text.as_bytes()), expected, "{}", text);
        }

        #[test]
        fn any_bytes_are_a_stamp_or_none(bytes in any::<Vec<u8>>()) {
            for form in ClockForm::ALL {
                let _ = form.nanoseconds(&bytes);
            }
        }
    }

    /// The date of a day since 1970, by searching the year.
    fn civil(day: i64) -> (i64, i64, i64) {
        let is_leap = |year: i64| year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        // the days before a year, by the count of leap years
        let before = |year: i64| {
            let leaps = |year: i64| year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
            365 * (year - 1970) + leaps(year - 1) - leaps(1969)
        };
        let mut year = 1970 + day.div_euclid(366);
        while before(year + 1) <= day {
            year += 1;
        }
        while before(year) > day {
            year -= 1;
        }
        let mut rest = day - before(year);
        for (month, length) in (1..).zip([31, 28 + i64::from(is_leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]) {
            if rest < length {
                return (year, month, rest + 1);
            }
            rest -= length;
        }
        panic!("a year has twelve months")
    }
}

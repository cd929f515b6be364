//! Stamps that are not a single number: dates and times of day, as `2023-03-06T02:25:02.45Z`,
//! `2023/03/06/02:25:02.45`, `06-Mar-2023 02:25:02,45`, `02:25:02.45` or `25:02.4`.

use std::borrow::Cow;

use jiff::{
    civil::{Date, DateTime, Time},
    tz::Offset,
};

/// The order of the parts of a stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DateForm {
    /// Year, month, day, time: ISO 8601, also with other separators.
    YearFirst,
    /// Day, month, year, time; the month may be a word, as MATLAB writes it.
    DayFirst,
    /// Month, day, year, time.
    MonthFirst,
    /// The time of day alone, which restarts at midnight.
    TimeOfDay,
    /// Minutes and seconds alone, as Excel shows a time of day; they may restart with the hour.
    MinutesSeconds,
}

const SECOND_NS: i64 = 1_000_000_000;
const HOUR_NS: i64 = 3600 * SECOND_NS;
const DAY_NS: i64 = 24 * HOUR_NS;

impl DateForm {
    /// If several fit, the first is taken.
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

    /// Nanoseconds since 1970 in UTC, in the local time of its clock if the stamp names no zone;
    /// for a time of day, nanoseconds since midnight. `None` for a text that is not of this form.
    pub(super) fn nanoseconds(self, stamp: &[u8]) -> Option<i64> {
        let stamp = str::from_utf8(stamp).ok()?.trim();
        // a date without a time of day has no colon, and a number has none
        let first_colon = stamp.find(':')?;
        let stamp = if stamp.contains(',') { Cow::from(stamp.replace(',', ".")) } else { stamp.into() };
        match self {
            Self::MinutesSeconds => minutes_seconds_ns(&stamp),
            Self::TimeOfDay => {
                let (time, offset_s) = time_and_offset(&stamp)?;
                Some(DateTime::from_parts(Date::constant(1970, 1, 1), time).to_utc_ns()? - offset_s * SECOND_NS)
            }
            _ => {
                // hours follow one character after the date, which may be a colon as well
                let hour = stamp[..first_colon].rfind(|c: char| !c.is_ascii_digit());
                let is_date = |text: &str| text.bytes().filter(|&byte| matches!(byte, b'-' | b'/' | b'.')).count() == 2;
                let boundary = hour.filter(|&hour| is_date(stamp[..hour].trim_end())).unwrap_or(first_colon);
                let date = self.date(stamp[..boundary].trim_end())?;
                let (time, offset_s) = time_and_offset(stamp[boundary..].get(1..)?)?;
                let is_separator = matches!(stamp.as_bytes()[boundary], b'T' | b't' | b' ' | b'/' | b'_' | b'-' | b':');
                DateTime::from_parts(date, time).to_utc_ns()?.checked_sub(offset_s * SECOND_NS).filter(|_| is_separator)
            }
        }
    }

    /// The form of all these texts, if they are dates or times of day.
    ///
    /// # Errors
    /// If the day or the month may come first.
    pub(super) fn of_all(texts: &[&[u8]]) -> Result<Option<Self>, ()> {
        let fits = |form: &Self| !texts.is_empty() && texts.iter().all(|text| form.nanoseconds(text).is_some());
        match Self::ALL.into_iter().filter(fits).collect::<Vec<_>>()[..] {
            [Self::DayFirst, Self::MonthFirst] => Err(()),
            [form, ..] => Ok(Some(form)),
            [] => Ok(None),
        }
    }

    fn date(self, text: &str) -> Option<Date> {
        let separator = text.chars().find(|c| matches!(c, '-' | '/' | '.'))?;
        let mut parts = text.split(separator);
        let [first, second, third] = [parts.next()?, parts.next()?, parts.next()?];
        let month = match (self, second.len()) {
            (_, 3) if second.bytes().all(|byte| byte.is_ascii_alphabetic()) => "%b",
            (_, 1 | 2) => "%m",
            _ => return None,
        };
        let is_year = |part: &str| part.len() == 4 && part.bytes().all(|byte| byte.is_ascii_digit());
        let (format, year) = match (self, month) {
            (Self::YearFirst, _) => (format!("%Y{separator}{month}{separator}%d"), first),
            (Self::DayFirst, _) => (format!("%d{separator}{month}{separator}%Y"), third),
            (Self::MonthFirst, "%m") => (format!("%m{separator}%d{separator}%Y"), third),
            _ => return None,
        };
        Date::strptime(format, text).ok().filter(|_| is_year(year))
    }

    /// `stamp_ns` after `last_ns`, if a new day or hour has begun between them.
    pub(super) fn after(self, last_ns: Option<i64>, stamp_ns: i64) -> i64 {
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

/// Whether the text is a time of day.
pub(super) fn is_time(text: &[u8]) -> bool {
    DateForm::TimeOfDay.nanoseconds(text).is_some()
}

/// Whether the text is a date with a time of day, or a time of day alone.
pub(super) fn is_stamp(text: &[u8]) -> bool {
    DateForm::ALL.iter().any(|form| form.nanoseconds(text).is_some())
}

/// A time of day, and the seconds by which its zone is east of Greenwich; 0 without a zone.
fn time_and_offset(text: &str) -> Option<(Time, i64)> {
    let text = text.trim_start();
    let digits_end = text.find(|c: char| !c.is_ascii_digit() && c != ':' && c != '.').unwrap_or(text.len());
    let (clock, rest) = text.split_at(digits_end);
    let rest = rest.trim();
    let (half, zone) = match rest.get(..2) {
        Some(half) if half.eq_ignore_ascii_case("am") || half.eq_ignore_ascii_case("pm") => (half, rest[2..].trim()),
        _ => ("", rest),
    };
    let mut parts = clock.splitn(4, ':');
    let [hour, minute, second] = [parts.next()?, parts.next()?, parts.next()?];
    // milliseconds after a third colon
    let thousandths = parts.next();
    if hour.is_empty() || minute.len() != 2 || second.get(2..).is_some_and(|rest| !rest.is_empty() && rest.len() < 2) {
        return None;
    }
    // digits beyond nanoseconds are cut
    let second = &second[..second.len().min("00.000000000".len())];
    let point = thousandths.map_or(String::new(), |digits| format!(".{digits}"));
    let (format, half) = if half.is_empty() { ("%H:%M:%S%.f", "") } else { ("%I:%M:%S%.f %p", half) };
    let clock = format!("{hour}:{minute}:{second}{point} {half}");
    let time = Time::strptime(format, clock.trim_end()).ok().filter(|_| hour.len() <= 2)?;
    let offset_s = match zone {
        "" | "Z" | "z" | "UTC" | "GMT" => 0,
        zone if zone.starts_with(['+', '-']) => i64::from(offset(zone)?.seconds()),
        _ => return None,
    };
    Some((time, offset_s))
}

/// The offset of `+01:00`, `+0100` or `+01`.
fn offset(zone: &str) -> Option<Offset> {
    let digits: String = zone.chars().filter(|c| *c != ':').collect();
    let digits = if digits.len() == 3 { digits + "00" } else { digits };
    jiff::fmt::strtime::parse("%z", digits).ok()?.offset()
}

/// The time of a text such as `02:25.4`. Without a fraction it could equally be hours and minutes.
fn minutes_seconds_ns(text: &str) -> Option<i64> {
    let (minutes, seconds) = text.split_once(':')?;
    let are_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let (whole, fraction) = seconds.split_once('.')?;
    if !are_digits(minutes) || minutes.len() > 6 || !are_digits(whole) || whole.len() != 2 || !are_digits(fraction) {
        return None;
    }
    let nanoseconds: i64 = format!("{fraction:0<9}").get(..9)?.parse().ok()?;
    let seconds = whole.parse::<i64>().ok().filter(|seconds| *seconds < 60)?;
    Some((minutes.parse::<i64>().ok()? * 60 + seconds) * SECOND_NS + nanoseconds)
}

/// A moment as nanoseconds since 1970, read as UTC.
trait ToUtcNanoseconds {
    /// `None` beyond 292 years.
    fn to_utc_ns(self) -> Option<i64>;
}

impl ToUtcNanoseconds for DateTime {
    fn to_utc_ns(self) -> Option<i64> {
        Offset::UTC.to_timestamp(self).ok()?.as_nanosecond().try_into().ok()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn one_moment_reads_the_same_in_every_form() {
        // date -u -d '2023-03-06 02:25:02' +%s
        let moment = 1_678_069_502 * SECOND_NS + 450_000_000;
        for (form, texts) in [
            (
                DateForm::YearFirst,
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
            (DateForm::DayFirst, &["06/03/2023 02:25:02.45", "6.3.2023 02:25:02,45", "06-03-2023T02:25:02.45"]),
            (
                DateForm::MonthFirst,
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
                assert_eq!(DateForm::TimeOfDay.nanoseconds(text.as_bytes()), None, "{text}");
            }
        }
        let of_day = (2 * 60 + 25) * 60 * SECOND_NS + 2_450_000_000;
        assert_eq!(DateForm::TimeOfDay.nanoseconds(b"02:25:02.45"), Some(of_day));
        let of_day = |text: &str| DateForm::TimeOfDay.nanoseconds(text.as_bytes()).map(|ns| ns / SECOND_NS);
        let hours = ["12:00:00 AM", "12:30:00 pm", "1:00:00 PM", "11:59:59PM"].map(of_day);
        assert_eq!(hours, [0, 45_000, 46_800, 86_399].map(Some));
        // the leap day, and dates before the epoch
        assert_eq!(DateForm::YearFirst.nanoseconds(b"2024-02-29 00:00:00"), Some(1_709_164_800 * SECOND_NS));
        assert_eq!(DateForm::YearFirst.nanoseconds(b"1969-12-31 23:59:59"), Some(-SECOND_NS));
    }

    #[test]
    fn other_texts_are_no_date_or_time() {
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
            assert!(DateForm::ALL.iter().all(|form| form.nanoseconds(text.as_bytes()).is_none()), "{text}");
        }
    }

    #[test]
    fn minutes_and_seconds_continue_after_the_hour() {
        let read = |text: &str| DateForm::MinutesSeconds.nanoseconds(text.as_bytes());
        let late = read("59:59.9").unwrap();
        assert_eq!(late, 3_599_900_000_000);
        let early = DateForm::MinutesSeconds.after(Some(late), read("00:00.1").unwrap());
        assert_eq!(early - late, 200_000_000);
        // a duration continues
        assert_eq!(DateForm::MinutesSeconds.after(Some(late), read("60:00.1").unwrap()) - late, 200_000_000);
        for text in ["00:60.0", "12:30", "12:30:15.5", "0:5.0", "00:00.", "00:00.0x"] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn a_time_of_day_continues_behind_midnight() {
        let read = |text: &str| DateForm::TimeOfDay.nanoseconds(text.as_bytes()).unwrap();
        let late = read("23:59:59.99");
        let early = DateForm::TimeOfDay.after(Some(late), read("00:00:00.01"));
        assert_eq!(early - late, 20_000_000);
        // a second midnight is recognised as well; a small step back is not midnight
        assert_eq!(
            DateForm::TimeOfDay.after(Some(early + DAY_NS - 20_000_000), read("00:00:00.02")),
            early + DAY_NS + 10_000_000
        );
        assert_eq!(DateForm::TimeOfDay.after(Some(early), read("23:59:59.995")), late + 5_000_000);
        assert_eq!(DateForm::YearFirst.after(Some(late), 5), 5);
    }

    proptest! {
        #[test]
        fn any_moment_is_read_back(second in -62_000_000_000_i64..250_000_000_000, nanosecond in 0..SECOND_NS) {
            // the text comes from an independent calendar; days counted one by one would be too slow
            let (day, of_day) = (second.div_euclid(86_400), second.rem_euclid(86_400));
            let (year, month, day) = civil(day);
            let (h, m, s) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
            let text = format!("{year:04}-{month:02}-{day:02}T{h:02}:{m:02}:{s:02}.{nanosecond:09}Z");
            let expected = second.checked_mul(SECOND_NS).and_then(|ns| ns.checked_add(nanosecond));
            prop_assert_eq!(DateForm::YearFirst.nanoseconds(text.as_bytes()), expected, "{}", text);
        }

        #[test]
        fn any_bytes_are_a_stamp_or_none(bytes in any::<Vec<u8>>()) {
            for form in DateForm::ALL {
                let _ = form.nanoseconds(&bytes);
            }
        }
    }

    /// The date of a day since 1970, by searching the year.
    fn civil(day: i64) -> (i64, i64, i64) {
        let is_leap = |year: i64| year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        // the days before a year, from the count of leap years
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

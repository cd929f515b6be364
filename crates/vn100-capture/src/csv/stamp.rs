//! The stamp of a row: its form, and its value in exact nanoseconds. A stamp is a number in a unit, a
//! date as `2023-03-06T02:25:02.45Z`, `2023/03/06/02:25:02.45` or `06-Mar-2023 02:25:02,45`, or a time of day
//! as `02:25:02.45`, `02:25:02:450`, `022502.45` or `25:02.4`.

use std::ops::{Range, RangeInclusive};

use jiff::{
    civil::{Date, Time},
    tz::Offset,
};

use super::number::Number;

/// Times of the years 2001 to 2102 in seconds since 1970.
const SINCE_EPOCH_S: Range<f64> = 1e9..4.2e9;

/// The same years in days since 1900, as spreadsheets count them, and since the year 0, as MATLAB does.
const DAYS_OF_THIS_CENTURY: [Range<f64>; 2] = [36_892.0..73_800.0, 730_852.0..767_800.0];

/// 1970-01-01 in days since the year 0. In nanoseconds such days are beyond 64 bits, and their zero is
/// moved to 1970.
const MATLAB_DAYS_OF_1970: u64 = 719_529;

/// One stamp in so many may be damaged without being taken for another form.
const STAMPS_A_DAMAGED_ONE: usize = 20;

/// An inertial sensor sends 1 to 1000 lines a second; the limits allow a tenth more for the clock.
const SHORTEST_STEP_S: f64 = 0.9e-3;
const LONGEST_STEP_S: f64 = 1.1;

/// Some sensors send ten times as many lines, which is believed of decimals and of known ticks.
const LIKELY_STEPS_S: RangeInclusive<f64> = SHORTEST_STEP_S / 10.0..=LONGEST_STEP_S;

/// In a unit that the file states: chips sample at up to 32 kHz, and loggers as rarely as once a minute.
const STATED_STEPS_S: RangeInclusive<f64> = SHORTEST_STEP_S / 32.0..=LONGEST_STEP_S * 60.0;

/// The most rows of one read: an adapter delays bytes by up to 16 ms, at 1000 Hz.
const MOST_ROWS_TOGETHER: usize = 16;

/// The units: the name in a column map, the length in nanoseconds, and the words for it in names.
const UNITS: [(&str, i64, &str); 8] = [
    ("s", 1_000_000_000, "s sec secs second seconds"),
    ("ms", 1_000_000, "ms msec msecs millis millisec milliseconds"),
    ("us", 1000, "us µs usec usecs micros microsec microseconds"),
    ("ns", 1, "ns nsec nsecs nanos nanosec nanosecs nanoseconds"),
    // the ticks of a sensor of Xsens
    ("100us", 100_000, ""),
    // days, as spreadsheets and MATLAB count them
    ("d", 86_400_000_000_000, "day days"),
    ("min", 60_000_000_000, "min mins minute minutes"),
    ("h", 3_600_000_000_000, "h hr hrs hour hours"),
];

/// The units that the size of a stamp, or the step from row to row, may show.
pub(super) const USUAL_NS: [i64; 4] = [UNITS[0].1, UNITS[1].1, UNITS[2].1, UNITS[3].1];
pub(super) const TICK_NS: i64 = UNITS[4].1;
const SECOND_NS: i64 = UNITS[0].1;
const DAY_NS: i64 = UNITS[5].1;

/// The unit of time of a word in lower case, in nanoseconds.
pub(super) fn time_unit(word: &str) -> Option<i64> {
    let is_one = |words: &str| words.split(' ').any(|known| known == word && !word.is_empty());
    UNITS.iter().find(|(_, _, words)| is_one(words)).map(|(_, unit_ns, _)| *unit_ns)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampForm {
    /// A number in a unit of this many nanoseconds.
    Unit(i64),
    /// Year, month, day, time: ISO 8601, also with other separators.
    YearFirst,
    /// Day, month, year, time; the month may be a word, as MATLAB writes it.
    DayFirst,
    MonthFirst,
    /// The time of day alone, which restarts at midnight.
    TimeOfDay,
    /// Minutes and seconds alone, as Excel shows a time of day; they restart with the hour.
    MinutesSeconds,
}

impl StampForm {
    /// If several fit, the first is taken.
    const OF_TEXT: [Self; 5] =
        [Self::YearFirst, Self::DayFirst, Self::MonthFirst, Self::TimeOfDay, Self::MinutesSeconds];

    pub(super) fn all() -> impl Iterator<Item = Self> {
        UNITS.iter().map(|(_, unit_ns, _)| Self::Unit(*unit_ns)).chain(Self::OF_TEXT)
    }

    /// Its name in a column map.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Unit(unit_ns) => UNITS.iter().find(|unit| unit.1 == unit_ns).map_or("", |unit| unit.0),
            Self::YearFirst => "iso",
            Self::DayFirst => "dmy",
            Self::MonthFirst => "mdy",
            Self::TimeOfDay => "clock",
            Self::MinutesSeconds => "mmss",
        }
    }

    pub(super) fn by_name(name: &str) -> Option<Self> {
        Self::all().find(|form| form.name() == name)
    }

    /// `stamp` in nanoseconds: for a date since 1970 in UTC, or in the local time of its clock if it names
    /// no zone; for a time of day since midnight. `None` for a text of another form.
    pub(super) fn nanoseconds(self, stamp: &[u8]) -> Option<i64> {
        let Self::Unit(unit_ns) = self else { return self.text_ns(str::from_utf8(stamp).ok()?) };
        match Number::parse(stamp) {
            Some(number) if unit_ns == DAY_NS => {
                number.times(DAY_NS).or_else(|| number.minus(MATLAB_DAYS_OF_1970)?.times(DAY_NS))
            }
            Some(number) => number.times(unit_ns),
            None => with_unit(stamp).and_then(|(number, unit_ns)| number.times(unit_ns)),
        }
    }

    fn text_ns(self, text: &str) -> Option<i64> {
        let mut text = text.trim().replace(',', ".");
        if self == Self::MinutesSeconds {
            // without a fraction it could equally be hours and minutes
            let is_so = text.split_once(':').is_some_and(|(_, seconds)| seconds.find('.') == Some(2));
            let are_digits = text.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b':' | b'.'));
            text = (is_so && are_digits).then(|| format!("00:{text}"))?;
        }
        if self == Self::TimeOfDay {
            text = with_colons(&text).unwrap_or(text);
        }
        // a date without a time of day has no colon, and a number has none
        let hour = text[..text.find(':')?].trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (date, clock) = text.split_at(hour);
        let date = date.trim_end_matches([' ', 'T', 't', '_', '-', '/', ':']).replace(['/', '.'], "-");
        let of = |format: &str| Date::strptime(format, &date).ok();
        let date = match self {
            Self::YearFirst => of("%Y-%m-%d").or_else(|| of("%Y-%b-%d")),
            Self::DayFirst => of("%d-%m-%Y").or_else(|| of("%d-%b-%Y")),
            Self::MonthFirst => of("%m-%d-%Y"),
            _ => date.is_empty().then_some(Date::constant(1970, 1, 1)),
        };
        let (time, offset_s) = time_and_offset(clock)?;
        let moment = Offset::UTC.to_timestamp(date?.to_datetime(time)).ok()?;
        i64::try_from(moment.as_nanosecond() - i128::from(offset_s) * i128::from(SECOND_NS)).ok()
    }

    /// The form of these texts, if they are dates or times of day; a few may be damaged.
    ///
    /// # Errors
    /// If the day or the month may come first.
    pub(super) fn of_texts(texts: &[&[u8]]) -> Result<Option<Self>, ()> {
        let is_of = |form: Self, text: &[u8]| text.contains(&b':') && form.nanoseconds(text).is_some();
        let fitting = |form: Self| texts.iter().filter(|text| is_of(form, text)).count();
        let counts = Self::OF_TEXT.map(|form| (form, fitting(form)));
        let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
        if most == 0 || (texts.len() - most) * STAMPS_A_DAMAGED_ONE > texts.len() {
            return Ok(None);
        }
        match counts.into_iter().filter(|(_, count)| *count == most).map(|(form, _)| form).collect::<Vec<_>>()[..] {
            [Self::DayFirst, Self::MonthFirst] => Err(()),
            ref forms => Ok(forms.first().copied()),
        }
    }

    /// `stamp_ns` after `last_ns`, if a new day or hour has begun between them.
    #[inline]
    pub(super) fn after(self, last_ns: Option<i64>, stamp_ns: i64) -> i64 {
        let period_ns = match self {
            Self::TimeOfDay => DAY_NS,
            Self::MinutesSeconds => DAY_NS / 24,
            _ => return stamp_ns,
        };
        let Some(last_ns) = last_ns else { return stamp_ns };
        let periods = (last_ns - stamp_ns + period_ns / 2).div_euclid(period_ns);
        stamp_ns + periods.max(0) * period_ns
    }
}

/// Whether the text is a date with a time of day, or a time of day alone.
pub(super) fn is_stamp(text: &[u8]) -> bool {
    text.contains(&b':') && StampForm::OF_TEXT.iter().any(|form| form.nanoseconds(text).is_some())
}

/// Whether numbers are times of day without colons: a second after one minute the next begins, and
/// none lies between.
pub(super) fn are_of_day(numbers: &[&[u8]]) -> bool {
    let minute_ns = 60 * SECOND_NS;
    let times = numbers.iter().map(|number| StampForm::TimeOfDay.nanoseconds(number));
    let turns = |pair: &[i64]| pair[0] / minute_ns < pair[1] / minute_ns && pair[1] - pair[0] <= SECOND_NS;
    times.collect::<Option<Vec<i64>>>().is_some_and(|times| times.windows(2).any(turns))
}

/// A time of day as `022502.45`, with colons; a number may have lost the zeros at its head.
fn with_colons(text: &str) -> Option<String> {
    let (digits, part) = text.split_at(text.find('.').unwrap_or(text.len()));
    let are_digits = (1..=6).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_digit());
    let digits = are_digits.then(|| format!("{digits:0>6}"))?;
    Some(format!("{}:{}:{}{part}", &digits[..2], &digits[2..4], &digits[4..]))
}

/// A time of day, and the seconds by which its zone is east of Greenwich; 0 without a zone.
fn time_and_offset(text: &str) -> Option<(Time, i64)> {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != ':' && c != '.').unwrap_or(text.len());
    let (clock, rest) = (&text[..end], text[end..].trim());
    // milliseconds after a third colon
    let third = clock.match_indices(':').nth(2).map_or(clock.len(), |(at, _)| at);
    let clock = clock[..third].to_owned() + &clock[third..].replace(':', ".");
    let half = rest.get(..2).filter(|half| half.eq_ignore_ascii_case("am") || half.eq_ignore_ascii_case("pm"));
    let time = match half {
        Some(half) => Time::strptime("%I:%M:%S%.f %p", format!("{clock} {half}")),
        None => Time::strptime("%H:%M:%S%.f", clock),
    };
    let zone = rest[half.map_or(0, str::len)..].trim();
    let offset_s = match zone {
        "" | "Z" | "z" | "UTC" | "GMT" => 0,
        _ if zone.starts_with(['+', '-']) => {
            let digits = zone.replace(':', "") + if zone.len() == 3 { "00" } else { "" };
            jiff::fmt::strtime::parse("%z", digits).ok()?.offset()?.seconds().into()
        }
        _ => return None,
    };
    Some((time.ok()?, offset_s))
}

/// A stamp with its unit after it, as in `0.01 sec`.
#[cold]
pub(super) fn with_unit(stamp: &[u8]) -> Option<(Number, i64)> {
    let (number, length) = Number::parse_prefix(stamp)?;
    let unit = str::from_utf8(&stamp[length..]).ok()?.trim().to_lowercase();
    Some((number, time_unit(&unit)?))
}

/// The time of the sensor in nanoseconds since it started.
pub(super) fn device_ns(cell: &[u8]) -> Option<u64> {
    Number::parse(cell)?.times(1)?.try_into().ok()
}

/// The unit of a date. Otherwise seconds, if there are decimals and the step from row to row is
/// 0.1 ms to 1 s; otherwise the unit in which the step is 1 ms to 1 s.
///
/// # Errors
/// The reason why the unit is ambiguous, in words.
pub(super) fn unit_of(stamps: &[Number]) -> Result<i64, String> {
    if let Some(unit_ns) = unit_of_date(stamps) {
        return Ok(unit_ns);
    }
    let have_decimals = stamps.iter().any(|stamp| stamp.decimals > 0);
    let are_seconds = have_decimals && may_be_in(stamps, SECOND_NS, &LIKELY_STEPS_S);
    let Some(step) = step(stamps, MOST_ROWS_TOGETHER).filter(|_| !are_seconds) else { return Ok(SECOND_NS) };
    let fits = |unit_ns: &i64| (SHORTEST_STEP_S..=LONGEST_STEP_S).contains(&seconds(step, *unit_ns));
    let may_be = match USUAL_NS.into_iter().filter(fits).collect::<Vec<_>>()[..] {
        [unit_ns] => return Ok(unit_ns),
        [] => "is not between 1 ms and 1 s in any unit".into(),
        ref units => {
            let names = units.iter().map(|unit_ns| StampForm::Unit(*unit_ns).name());
            format!("may be {}", names.collect::<Vec<_>>().join(" or "))
        }
    };
    Err(format!("they step by {} from row to row, which {may_be}", step as f32))
}

/// The unit that a name states.
///
/// # Errors
/// The reason why the stamps are not in this unit, in words.
pub(super) fn stated_unit(stamps: &[Number], unit_ns: i64) -> Result<i64, String> {
    let name = |unit_ns: i64| StampForm::Unit(unit_ns).name();
    let (stated, likely) = (name(unit_ns), may_be_in(stamps, unit_ns, &LIKELY_STEPS_S));
    match unit_of_date(stamps).filter(|other_ns| !likely && *other_ns != unit_ns) {
        Some(other_ns) => {
            Err(format!("the name states {stated}, but in {} they are dates of this century", name(other_ns)))
        }
        None if may_be_in(stamps, unit_ns, &STATED_STEPS_S) => Ok(unit_ns),
        None => {
            // a difference of decimals has fewer digits than a float of 64 bits shows
            let step = step(stamps, MOST_ROWS_TOGETHER).unwrap_or_default() as f32;
            let (shortest_us, longest_s) = (STATED_STEPS_S.start() * 1e6, STATED_STEPS_S.end());
            Err(format!(
                "a step of {step} {stated}, as the name states, is not between {shortest_us:.0} us and {longest_s:.0} s"
            ))
        }
    }
}

/// Whether the step from row to row is one of these in this unit. A clock that stands excludes none.
pub(super) fn may_be_in(stamps: &[Number], unit_ns: i64, steps_s: &RangeInclusive<f64>) -> bool {
    let step_s = |most_rows| step(stamps, most_rows).map_or(0.0, |step| seconds(step, unit_ns));
    // a read may have more rows than usual, which are together
    step_s(MOST_ROWS_TOGETHER) <= *steps_s.end() && !(f64::MIN_POSITIVE..*steps_s.start()).contains(&step_s(usize::MAX))
}

/// The unit in which the stamps are times of the years 2001 to 2102 and do not step by more than 1 s:
/// seconds or a decimal part of them, or days if the step in seconds would be less than 0.02 ms.
fn unit_of_date(stamps: &[Number]) -> Option<i64> {
    let step = step(stamps, MOST_ROWS_TOGETHER);
    let middle = median(stamps.iter().map(Number::value).collect()).unwrap_or_default();
    let is_short = |unit_ns: i64| step.is_none_or(|step| seconds(step, unit_ns) <= LONGEST_STEP_S);
    let is_epoch = |unit_ns: &i64| SINCE_EPOCH_S.contains(&seconds(middle, *unit_ns)) && is_short(*unit_ns);
    let are_days = DAYS_OF_THIS_CENTURY.iter().any(|days| days.contains(&middle))
        && step.is_some_and(|step| step > 0.0 && step < SHORTEST_STEP_S / 50.0);
    USUAL_NS.into_iter().find(is_epoch).or(are_days.then_some(DAY_NS))
}

fn seconds(length: f64, unit_ns: i64) -> f64 {
    length * (unit_ns as f64 / 1e9)
}

/// The median step from row to row; `None` for a single row.
fn step(stamps: &[Number], most_rows: usize) -> Option<f64> {
    // rows of one read have uneven steps, which average out over several rows
    let lag = (stamps.len() / 2).clamp(1, most_rows);
    let later = stamps.iter().skip(lag);
    median(later.zip(stamps).map(|(later, stamp)| (later.value() - stamp.value()) / lag as f64).collect())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit of stamps, by its name.
    fn unit<T: ToString>(stamps: impl IntoIterator<Item = T>) -> Result<&'static str, String> {
        let numbers = stamps.into_iter().map(|stamp| Number::parse(stamp.to_string().as_bytes()).unwrap());
        unit_of(&numbers.collect::<Vec<_>>()).map(|unit_ns| StampForm::Unit(unit_ns).name())
    }

    #[test]
    fn days_of_matlab_are_days_of_1970() {
        let since_1970 = |text: &str| StampForm::Unit(DAY_NS).nanoseconds(text.as_bytes());
        assert_eq!(since_1970("719529.5"), Some(DAY_NS / 2));
        assert_eq!(since_1970("737520.0000000001"), Some(17_991 * DAY_NS + 8640));
        assert_eq!(since_1970("45000.5"), Some(45_000 * DAY_NS + DAY_NS / 2), "of a spreadsheet");
        assert_eq!(since_1970("999999999"), None);
    }

    #[test]
    fn a_stated_unit_is_taken_unless_the_stamps_contradict_it() {
        let stated = |start: f64, step: f64, unit_ns: i64| {
            let stamps = (0..50).map(|row| format!("{:.6}", start + f64::from(row) * step));
            let numbers: Vec<Number> = stamps.map(|stamp| Number::parse(stamp.as_bytes()).unwrap()).collect();
            stated_unit(&numbers, unit_ns)
        };
        let [second_ns, milli_ns, micro_ns, _] = USUAL_NS;
        // of a slow logger, a fast sensor, a clock that stands, and a clock since 20 days
        for (start, step, unit_ns) in [
            (0.0, 10.0, second_ns),
            (0.0, 60_000.0, milli_ns),
            (0.0, 5e6, micro_ns),
            (1e4, 0.05, milli_ns),
            (7.0, 0.0, milli_ns),
            (1.7e9, 25.0, milli_ns),
        ] {
            assert_eq!(stated(start, step, unit_ns), Ok(unit_ns), "{start} {step} {unit_ns}");
        }
        for (start, step, unit_ns, reason) in [
            (1e4, 0.025, milli_ns, "a step of 0.025 ms, as the name states, is not between 28 us and 66 s"),
            (0.0, 25_000.0, second_ns, "a step of 25000 s, as the name states, is not between 28 us and 66 s"),
            (1.7e12, 25.0, second_ns, "the name states s, but in ms they are dates of this century"),
            (1.7e9, 0.05, milli_ns, "the name states ms, but in s they are dates of this century"),
        ] {
            assert_eq!(stated(start, step, unit_ns).unwrap_err(), reason);
        }
    }

    #[test]
    fn a_damaged_text_among_forty_changes_no_form() {
        let mut texts = vec![b"05-Apr-2019 11:00:00.010".as_slice(); 39];
        for damaged in [b"05-Apx-2019 11:00:00.010".as_slice(), b"", b"17"] {
            texts.push(damaged);
            assert_eq!(StampForm::of_texts(&texts), Ok(Some(StampForm::DayFirst)));
            texts.pop();
        }
        assert_eq!(StampForm::of_texts(&[b"none"]), Ok(None));
    }

    #[test]
    fn the_unit_of_an_epoch_follows_from_its_size() {
        for (text, expected) in [
            ("1761939167.192566", "s"),
            ("1761939167192.566", "ms"),
            ("1761939167192566", "us"),
            ("1761939167192566000", "ns"),
            ("1.761939167192566e+09", "s"),
            ("0.025", "s"),
        ] {
            assert_eq!(unit([text]), Ok(expected), "{text}");
        }
        // a float of this size steps by 238 ns
        let exact = StampForm::Unit(SECOND_NS).nanoseconds(b"1761939167.192566001");
        assert_eq!(exact, Some(1_761_939_167_192_566_001));
    }

    #[test]
    fn the_unit_since_a_start_follows_from_the_step() {
        for (name, unit_ns) in [("ms", 1_000_000_i64), ("us", 1000), ("ns", 1)] {
            for step_ms in [5, 25, 800] {
                // since boot, half an hour and a month ago: these include sizes of an epoch in a larger unit
                for start_s in [0, 1, 1800, 2_600_000] {
                    let stamp = |row: i64| (start_s * SECOND_NS + row * step_ms * 1_000_000) / unit_ns;
                    assert_eq!(unit((0..100).map(stamp)), Ok(name), "{step_ms} after {start_s} s");
                }
            }
        }
        assert_eq!(unit((0..50).map(|row| format!("{:.3}", 25.013 * f64::from(row)))), Ok("ms"));
        // hours at 10 Hz, and a read of 400 rows in seconds, 20 us apart
        assert!(unit((0..500).map(|row| format!("{:.9}", 0.1 / 3600.0 * f64::from(row)))).is_err());
        let read = |row: i32| f64::from(row / 400) * 4.0 + f64::from(row % 400) * 20e-6;
        assert_eq!(unit((0..1000).map(|row| format!("{:.6}", read(row)))), Ok("s"));
        // a latency timer of 16 ms at 200 Hz, in microseconds: three rows at once, 100 us apart
        assert_eq!(unit((0..300_i64).map(|row| 15_000 * (row / 3) + 100 * (row % 3))), Ok("us"));
        // a first stamp of zero among those of an epoch
        assert_eq!(unit((0..300_i64).map(|row| if row == 0 { 0 } else { 1_761_939_167_192 + 25 * row })), Ok("ms"));
    }

    #[test]
    fn a_step_of_two_units_or_none_is_unsure() {
        for (step, end) in
            [(1_i64, "s or ms"), (1_000, "ms or us"), (1_000_000, "us or ns"), (0, "any unit"), (-25, "any unit")]
        {
            assert!(unit((0..50).map(|row| step * row)).unwrap_err().ends_with(end), "{step}");
        }
    }

    #[test]
    fn one_moment_reads_the_same_in_every_form() {
        // date -u -d '2023-03-06 02:25:02' +%s
        let moment = Some(1_678_069_502 * SECOND_NS + 450_000_000);
        for (form, texts) in [
            (
                StampForm::YearFirst,
                &[
                    "2023-03-06T02:25:02.45",
                    "2023-03-06T02:25:02.45Z",
                    "2023-03-06 02:25:02,45",
                    "2023/03/06/02:25:02.45",
                    "2023/3/6 2:25:02.45",
                    "2023-03-06_02:25:02.45 UTC",
                    "2023-03-06T03:25:02.45+01:00",
                    "2023-03-05 20:55:02.45 -0530",
                    "2023.03.06 02:25:02.45",
                ][..],
            ),
            (StampForm::DayFirst, &["06/03/2023 02:25:02.45", "6.3.2023 02:25:02,45", "06-Mar-2023T02:25:02.45"]),
            (StampForm::MonthFirst, &["03/06/2023 02:25:02.45", "3/6/2023  2:25:02.45 AM"]),
        ] {
            for text in texts {
                assert_eq!(form.nanoseconds(text.as_bytes()), moment, "{text}");
                assert_eq!(StampForm::TimeOfDay.nanoseconds(text.as_bytes()), None, "{text}");
            }
        }
        let of_day = |text: &str| StampForm::TimeOfDay.nanoseconds(text.as_bytes()).map(|ns| ns / SECOND_NS);
        let hours = ["02:25:02", "12:00:00 AM", "12:30:00 pm", "11:59:59PM", "22502.9"].map(of_day);
        assert_eq!(hours, [8702, 0, 45_000, 86_399, 8702].map(Some));
        assert!(!is_stamp(b"22502.9"), "it may be a number");
    }

    #[test]
    fn other_texts_are_no_date_or_time() {
        for text in [
            "",
            "2023-02-29 00:00:00",
            "2023-03-06",
            "2023-03-06 25:00:00",
            "2023-03-06 02:25",
            "2023-03-06 02:25:02.",
            "2023-03-06 02:25:02 PDT",
            "2023-03-06 02:25:02+1",
            "23-03-06 02:25:02",
            "-12.5",
            "12:30",
            "0:5.0",
            "9999-99-99T99:99:99",
            "2023-03-06 02:25:02.45x",
            "3/16/2023 13:25:02 PM",
        ] {
            assert!(StampForm::OF_TEXT.iter().all(|form| form.nanoseconds(text.as_bytes()).is_none()), "{text}");
        }
    }

    #[test]
    fn a_time_of_day_continues_after_midnight_and_minutes_after_the_hour() {
        for (form, late, early) in
            [(StampForm::TimeOfDay, "23:59:59.9", "00:00:00.1"), (StampForm::MinutesSeconds, "59:59.9", "00:00.1")]
        {
            let [late, early] = [late, early].map(|text| form.nanoseconds(text.as_bytes()).unwrap());
            let after = form.after(Some(late), early);
            assert_eq!(after - late, 200_000_000);
            // a small step back is none
            assert_eq!(form.after(Some(after), late), late);
        }
        assert_eq!(StampForm::YearFirst.after(Some(9), 5), 5);
    }
}

//! The stamp of a row: its form, and its value in exact nanoseconds.

use std::ops::Range;

use super::{date::DateForm, number::Number};

/// Times of the years 2001 to 2102 in seconds since 1970.
const SINCE_EPOCH_S: Range<f64> = 1e9..4.2e9;

/// The same years in days since 1900, as spreadsheets count them, and since the year 0, as MATLAB does.
const DAYS_OF_THIS_CENTURY: [Range<f64>; 2] = [36_892.0..73_800.0, 730_852.0..767_800.0];

/// An inertial sensor sends 1 to 1000 lines a second; the limits allow a tenth more for the clock.
const SHORTEST_STEP_S: f64 = 0.9e-3;
const LONGEST_STEP_S: f64 = 1.1;

/// The most rows of one read: an adapter delays bytes by up to 16 ms, at 1000 Hz.
const MOST_ROWS_TOGETHER: usize = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StampUnit {
    /// Its name in a column map.
    pub(super) name: &'static str,
    pub(super) nanoseconds: i64,
}

impl StampUnit {
    /// The units that the size of a stamp, or the step from row to row, may show.
    pub(super) const USUAL: [Self; 4] =
        [Self::new("s", 1_000_000_000), Self::new("ms", 1_000_000), Self::new("us", 1000), Self::new("ns", 1)];
    const SECONDS: Self = Self::USUAL[0];
    pub(super) const NANOSECONDS: Self = Self::USUAL[3];
    /// The ticks of a sensor of Xsens.
    pub(super) const TICKS: Self = Self::new("100us", 100_000);
    /// Days, as spreadsheets and MATLAB count them.
    const DAYS: Self = Self::new("d", 86_400_000_000_000);

    const fn new(name: &'static str, nanoseconds: i64) -> Self {
        Self { name, nanoseconds }
    }

    pub(super) fn all() -> impl Iterator<Item = Self> {
        Self::USUAL.into_iter().chain([Self::TICKS, Self::DAYS])
    }

    /// The length of the unit in seconds.
    pub(super) fn seconds(self) -> f64 {
        self.nanoseconds as f64 / 1e9
    }
}

/// The words for the units in a name.
const UNIT_WORDS: [(&str, &[&str]); 4] = [
    ("s", &["s", "sec", "secs", "second", "seconds"]),
    ("ms", &["ms", "msec", "msecs", "millis", "millisec", "milliseconds"]),
    ("us", &["us", "µs", "usec", "usecs", "micros", "microsec", "microseconds"]),
    ("ns", &["ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecs", "nanoseconds"]),
];

/// The unit of time of a word in lower case.
pub(super) fn time_unit(word: &str) -> Option<StampUnit> {
    let (name, _) = UNIT_WORDS.iter().find(|(_, words)| words.contains(&word))?;
    StampUnit::USUAL.into_iter().find(|unit| unit.name == *name)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampForm {
    /// A number in this unit.
    Unit(StampUnit),
    /// A date or a time of day.
    Date(DateForm),
}

impl StampForm {
    pub(super) fn all() -> impl Iterator<Item = Self> {
        StampUnit::all().map(Self::Unit).chain(DateForm::ALL.map(Self::Date))
    }

    /// Its name in a column map.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Unit(unit) => unit.name,
            Self::Date(form) => form.name(),
        }
    }

    pub(super) fn by_name(name: &str) -> Option<Self> {
        Self::all().find(|form| form.name() == name)
    }

    /// `stamp` in nanoseconds; for a date, since 1970.
    pub(super) fn nanoseconds(self, stamp: &[u8]) -> Option<i64> {
        match self {
            Self::Unit(unit) => match Number::parse(stamp) {
                Some(number) => number.times(unit.nanoseconds),
                None => with_unit(stamp).and_then(|(number, unit)| number.times(unit.nanoseconds)),
            },
            Self::Date(form) => form.nanoseconds(stamp),
        }
    }
}

/// A stamp with its unit after it, as in `0.01 sec`.
#[cold]
pub(super) fn with_unit(stamp: &[u8]) -> Option<(Number, StampUnit)> {
    let (number, length) = Number::parse_prefix(stamp)?;
    let unit = str::from_utf8(&stamp[length..]).ok()?.trim().to_lowercase();
    Some((number, time_unit(&unit)?))
}

/// The time of the sensor in nanoseconds since it started.
pub(super) fn device_ns(cell: &[u8]) -> Option<u64> {
    Number::parse(cell)?.times(1)?.try_into().ok()
}

/// The properties of the stamps of the first rows.
#[derive(Debug, Default)]
pub(super) struct StampScan {
    stamps: Vec<f64>,
    /// Whether one of the stamps has decimals.
    decimals: bool,
}

impl StampScan {
    pub(super) fn add(&mut self, stamp: &Number) {
        self.stamps.push(stamp.value());
        self.decimals |= stamp.decimals > 0;
    }

    pub(super) fn is_empty(&self) -> bool {
        self.stamps.is_empty()
    }

    /// The unit in which the stamps are times of the years 2001 to 2102: seconds or a decimal part of
    /// them, or days if the step in seconds would be less than 0.02 ms. Otherwise seconds, if there
    /// are decimals; otherwise the unit in which the step from row to row is 1 ms to 1 s. A unit with
    /// a longer step is excluded.
    ///
    /// # Errors
    /// The reason why the unit is ambiguous, in words.
    pub(super) fn unit(&self) -> Result<StampUnit, String> {
        let step = self.step();
        let is_short = |unit: &StampUnit| step.is_none_or(|step| step * unit.seconds() <= LONGEST_STEP_S);
        let middle = median(self.stamps.clone()).unwrap_or_default();
        let is_epoch = |unit: &StampUnit| SINCE_EPOCH_S.contains(&(middle * unit.seconds()));
        if let Some(unit) = StampUnit::USUAL.into_iter().find(|unit| is_epoch(unit) && is_short(unit)) {
            return Ok(unit);
        }
        let are_days = DAYS_OF_THIS_CENTURY.iter().any(|days| days.contains(&middle));
        if are_days && step.is_some_and(|step| step > 0.0 && step < SHORTEST_STEP_S / 50.0) {
            return Ok(StampUnit::DAYS);
        }
        let Some(step) = step.filter(|_| !self.decimals || !is_short(&StampUnit::SECONDS)) else {
            return Ok(StampUnit::SECONDS);
        };
        let fits = |unit: &StampUnit| (SHORTEST_STEP_S..=LONGEST_STEP_S).contains(&(step * unit.seconds()));
        let fitting: Vec<_> = StampUnit::USUAL.into_iter().filter(fits).collect();
        let may_be = match &fitting[..] {
            [unit] => return Ok(*unit),
            [] => "is not between 1 ms and 1 s in any unit".into(),
            units => format!("may be {}", units.iter().map(|unit| unit.name).collect::<Vec<_>>().join(" or ")),
        };
        Err(format!("they step by {step} from row to row, which {may_be}"))
    }

    /// Whether the step from row to row fits an inertial sensor in this unit.
    pub(super) fn may_be(&self, unit: StampUnit) -> bool {
        self.step().is_none_or(|step| (SHORTEST_STEP_S / 10.0..=LONGEST_STEP_S).contains(&(step * unit.seconds())))
    }

    /// The median step from row to row; `None` for a single row.
    fn step(&self) -> Option<f64> {
        // rows of one read have uneven steps, which average out over several rows
        let lag = (self.stamps.len() / 2).clamp(1, MOST_ROWS_TOGETHER);
        let later = self.stamps.iter().skip(lag);
        median(later.zip(&self.stamps).map(|(later, stamp)| (later - stamp) / lag as f64).collect())
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan<T: ToString>(stamps: impl IntoIterator<Item = T>) -> StampScan {
        let mut scan = StampScan::default();
        stamps.into_iter().for_each(|stamp| scan.add(&Number::parse(stamp.to_string().as_bytes()).unwrap()));
        scan
    }

    fn nanoseconds(text: &str) -> Option<i64> {
        Number::parse(text.as_bytes()).unwrap().times(scan([text]).unit().unwrap().nanoseconds)
    }

    #[test]
    fn the_unit_of_an_epoch_follows_from_its_size() {
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
    }

    #[test]
    fn the_unit_since_a_start_follows_from_the_step() {
        let [_, milliseconds, microseconds, nanoseconds] = StampUnit::USUAL;
        for (unit, steps) in [
            (milliseconds, [5, 25, 800].as_slice()),
            (microseconds, &[5_000, 25_000, 800_000]),
            (nanoseconds, &[5_000_000, 25_000_000, 1_000_000_000]),
        ] {
            for &step in steps {
                // since boot, half an hour and a month ago: these include sizes of an epoch in a larger unit
                for start_s in [0, 1, 1800, 2_600_000] {
                    let start = (f64::from(start_s) / unit.seconds()).round() as i64;
                    let stamps = (0..100).map(|row| start + step * row);
                    assert_eq!(scan(stamps).unit(), Ok(unit), "{step} after {start_s} s");
                }
            }
        }
    }

    #[test]
    fn decimals_are_seconds_unless_the_step_is_too_long() {
        assert_eq!(scan((0..50).map(|row| format!("{:.3}", 0.025 * f64::from(row)))).unit(), Ok(StampUnit::SECONDS));
        assert_eq!(scan((0..50).map(|row| format!("{row}.0"))).unit(), Ok(StampUnit::SECONDS));
        let milliseconds = scan((0..50).map(|row| format!("{:.3}", 25.013 * f64::from(row))));
        assert_eq!(milliseconds.unit(), Ok(StampUnit::USUAL[1]));
        let printed_as_float = scan((0..50).map(|row| format!("{:.18e}", 25e6 * f64::from(row))));
        assert_eq!(printed_as_float.unit(), Ok(StampUnit::USUAL[3]));
    }

    #[test]
    fn a_step_of_two_units_or_none_is_unsure() {
        for (step, units) in [
            (1_i64, ["s", "ms"].as_slice()),
            (1_000, &["ms", "us"]),
            (1_000_000, &["us", "ns"]),
            (2_000_000_000, &[]),
            (100_000, &["us"]),
            (0, &[]),
            (-25, &[]),
        ] {
            let unit = scan((0..50).map(|row| step * row)).unit();
            match units {
                [_] => assert!(unit.is_ok()),
                [] => assert!(unit.unwrap_err().ends_with("in any unit")),
                units => assert!(unit.unwrap_err().ends_with(&units.join(" or "))),
            }
        }
    }

    #[test]
    fn rows_that_come_together_and_a_clock_set_once_do_not_mislead() {
        // a latency timer of 16 ms at 200 Hz, in microseconds: three rows at once, 100 us apart
        let bunched = (0..300_i64).map(|row| 15_000 * (row / 3) + 100 * (row % 3));
        assert_eq!(scan(bunched).unit(), Ok(StampUnit::USUAL[2]));
        let set = (0..300_i64).map(|row| 25 * row + if row < 150 { 0 } else { 3_600_000 });
        assert_eq!(scan(set).unit(), Ok(StampUnit::USUAL[1]));
        // a first stamp of zero among those of an epoch
        let late = (0..300_i64).map(|row| if row == 0 { 0 } else { 1_761_939_167_192 + 25 * row });
        assert_eq!(scan(late).unit(), Ok(StampUnit::USUAL[1]));
    }

    #[test]
    fn a_nanosecond_of_an_epoch_is_kept() {
        // a float of this size steps by 238 ns
        assert_eq!(nanoseconds("1761939167.192566001"), Some(1_761_939_167_192_566_001));
        assert_eq!(nanoseconds("0.0000000016"), Some(2));
        assert_eq!(nanoseconds("1e30"), None);
    }
}

//! Which columns hold the stamps of the rows, and in which form: by their names and what stands in
//! them.

use super::{
    ColumnUse, CsvError,
    clock::ClockForm,
    column_map::{MappedStamp, STAMP},
    header::Header,
    number::Number,
    shown,
    stamp::{StampForm, StampScan, StampUnit},
};

/// Names that stand for nothing else.
const STAMPS: [&str; 6] = ["t", "time", "timestamp", "bag_t", "rosbagtimestamp", "%time"];

/// The words of the name of the sensor's own time, as tables of samples have it.
const DEVICE_TIME: [&str; 2] = ["device", "time"];

/// How the last words of other names of times end.
const TIME_ENDINGS: [&str; 4] = ["time", "stamp", "stamps", "zeit"];

/// Words for times, alone or among others.
const TIME_WORDS: [&str; 8] = ["t", "utc", "epoch", "elapsed", "clock", "temps", "tiempo", "tempo"];

/// The words for the units in a name.
const UNIT_WORDS: [(&str, &[&str]); 4] = [
    ("s", &["s", "sec", "secs", "second", "seconds"]),
    ("ms", &["ms", "msec", "msecs", "millis", "millisec", "milliseconds"]),
    ("us", &["us", "µs", "usec", "usecs", "micros", "microsec", "microseconds"]),
    ("ns", &["ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecs", "nanoseconds"]),
];

/// In fewer rows, stamps of whole seconds may be but two.
const FEWEST_ROWS_OF_COARSE: usize = 500;

/// Most rows of a logger with its own stamps may repeat the stamp before.
const REPEATED_SHARE: f64 = 0.2;

/// The columns of the stamps, in the order in which they are added.
#[derive(Debug, Clone)]
pub(super) struct StampColumns {
    pub(super) columns: Vec<(usize, ColumnUse)>,
    /// What a row that repeats a stamp came behind it; `None` where rows share stamps as a rule.
    pub(super) repeated_step_ns: Option<i64>,
}

/// The names of the columns, and what stands in the first rows.
pub(super) struct StampSearch<'a> {
    pub(super) header: &'a Header,
    pub(super) rows: &'a [Vec<Vec<u8>>],
    /// Columns that hold something else.
    pub(super) taken: Vec<usize>,
}

impl StampSearch<'_> {
    /// The columns that the user named.
    pub(super) fn mapped(&self, map: &MappedStamp) -> Result<StampColumns, CsvError> {
        let place = self.header.mapped_place(STAMP, &map.column)?;
        let mut columns = vec![(place, ColumnUse::Stamp(map.form))];
        if let Some((column, unit)) = &map.part {
            columns.push((self.header.mapped_place(STAMP, column)?, ColumnUse::StampPart(*unit)));
        }
        if !self.rows.is_empty() && self.cells(place).all(|cell| map.form.nanoseconds(cell).is_none()) {
            return Err(self.no_stamps(place));
        }
        if map.part.is_none() && self.is_coarse(place) {
            return Err(CsvError::CoarseStamps { column: self.header.names[place].clone(), rows: self.rows.len() });
        }
        Ok(self.completed(columns))
    }

    /// The columns by what they are called, else by what stands in them.
    ///
    /// # Errors
    /// Where a column that can only be one of stamps is not understood.
    pub(super) fn found(&self) -> Result<Option<StampColumns>, CsvError> {
        if let Some(columns) = self.device_time() {
            return Ok(Some(columns));
        }
        match self.free().find(|&place| self.name(place).is_stamp() && !self.is_coarse(place)) {
            Some(place) => self.form(place).map(|form| Some(self.completed(vec![(place, ColumnUse::Stamp(form))]))),
            None => Ok(self.likely()),
        }
    }

    /// As [`found`](Self::found), where any column may hold something else: only columns that
    /// ascend from row to row.
    pub(super) fn likely(&self) -> Option<StampColumns> {
        if let Some(columns) = self.device_time() {
            return Some(columns);
        }
        let by_name = || {
            let named = self.free().filter(|&place| self.name(place).is_time());
            { named }.find_map(|place| Some((place, self.form(place).ok().filter(|_| self.ascends(place))?)))
        };
        let exactly = self.free().filter(|&place| self.name(place).is_stamp() && self.ascends(place));
        let exactly = { exactly }.find_map(|place| Some((place, self.form(place).ok()?)));
        let single = |(place, form)| vec![(place, ColumnUse::Stamp(form))];
        let by_content = || self.free().find_map(|place| Some((place, StampForm::Clock(self.clock(place).ok()??))));
        let columns = exactly.map(single).or_else(|| self.pair()).or_else(|| by_name().map(single));
        columns.or_else(|| by_content().map(single)).map(|columns| self.completed(columns))
    }

    /// The time at which the sensor measured each row, which is better than any of its arrival.
    fn device_time(&self) -> Option<StampColumns> {
        let is_device_time = |place: &usize| self.name(*place).words == DEVICE_TIME && self.ascends(*place);
        let place = self.free().find(is_device_time)?;
        Some(self.completed(vec![(place, ColumnUse::Stamp(self.form(place).ok()?))]))
    }

    /// Whatever its name, the first that can be nothing but times.
    pub(super) fn unnamed(&self) -> Option<StampColumns> {
        let (place, form) =
            self.free().find_map(|place| Some((place, self.form(place).ok().filter(|_| self.ascends(place))?)))?;
        Some(self.completed(vec![(place, ColumnUse::Stamp(form))]))
    }

    /// Seconds in one column, and what is added to them in another of the same name but for that.
    fn pair(&self) -> Option<Vec<(usize, ColumnUse)>> {
        let [seconds_unit, rest @ ..] = StampUnit::ALL;
        let all_numbers = |place: usize| self.cells(place).all(|cell| Number::parse(cell).is_some());
        let in_unit = |unit: StampUnit| {
            self.free().filter(move |&place| self.name(place).unit == Some(unit) && all_numbers(place))
        };
        in_unit(seconds_unit).find_map(|seconds| {
            let base = self.name(seconds).words;
            // whole seconds, or the other column is a time of its own
            let is_whole = self.cells(seconds).filter_map(Number::parse).all(|number| number.decimals() == 0);
            rest.into_iter().filter(|_| is_whole).find_map(|unit| {
                let part = in_unit(unit).find(|&place| self.name(place).words == base)?;
                let limit = 1.0 / unit.seconds();
                let is_part =
                    self.cells(part).filter_map(Number::parse).all(|part| (0.0..limit).contains(&part.value()));
                let form = ColumnUse::Stamp(StampForm::Unit(seconds_unit));
                is_part.then(|| vec![(seconds, form), (part, ColumnUse::StampPart(unit))])
            })
        })
    }

    /// In which form the stamps of a column are.
    fn form(&self, place: usize) -> Result<StampForm, CsvError> {
        let mut scan = StampScan::default();
        self.cells(place).filter_map(Number::parse).for_each(|stamp| scan.add(&stamp));
        if scan.is_empty() {
            return match self.clock(place)? {
                Some(form) => Ok(StampForm::Clock(form)),
                None if self.rows.is_empty() => Ok(StampForm::Unit(StampUnit::ALL[0])),
                None => Err(self.no_stamps(place)),
            };
        }
        let named = self.name(place).unit.filter(|&unit| scan.may_be(unit));
        let unit = named.map_or_else(|| scan.unit(), Ok).map_err(|unsure| CsvError::StampUnit {
            column: self.header.names[place].clone(),
            argument: self.header.argument(place),
            step: unsure.step,
            units: unsure.units,
        })?;
        Ok(StampForm::Unit(unit))
    }

    /// Dates, or times of day; `None` where no cell is one.
    fn clock(&self, place: usize) -> Result<Option<ClockForm>, CsvError> {
        let fits = |form: &ClockForm| {
            let mut cells = self.cells(place).filter(|cell| !cell.is_empty()).peekable();
            cells.peek().is_some() && cells.all(|cell| form.nanoseconds(cell).is_some())
        };
        let fitting: Vec<ClockForm> = ClockForm::ALL.into_iter().filter(fits).collect();
        match fitting[..] {
            [ClockForm::DayFirst, ClockForm::MonthFirst] => Err(CsvError::DateOrder {
                column: self.header.names[place].clone(),
                argument: self.header.argument(place),
            }),
            [form, ..] => Ok(Some(form)),
            [] => Ok(None),
        }
    }

    /// Whether so many rows share each stamp that these show no rate, as of an epoch in a float of
    /// 32 bits.
    fn is_coarse(&self, place: usize) -> bool {
        let stamps: Vec<&[u8]> = self.cells(place).collect();
        let changes = stamps.windows(2).filter(|pair| pair[0] != pair[1]).count();
        stamps.len() >= FEWEST_ROWS_OF_COARSE && changes <= 1
    }

    /// Whether the stamps of a column ascend from row to row, but for a few.
    fn ascends(&self, place: usize) -> bool {
        let Ok(form) = self.form(place) else { return false };
        let stamps: Vec<i64> = self.cells(place).filter_map(|cell| form.nanoseconds(cell)).collect();
        let backwards = stamps.windows(2).filter(|pair| pair[1] < pair[0]).count();
        stamps.last() > stamps.first() && 20 * backwards <= stamps.len() && !self.is_coarse(place)
    }

    fn no_stamps(&self, place: usize) -> CsvError {
        let first = self.cells(place).next().unwrap_or_default();
        CsvError::Stamps { column: self.header.names[place].clone(), text: shown(first) }
    }

    fn completed(&self, columns: Vec<(usize, ColumnUse)>) -> StampColumns {
        let stamps: Vec<i64> = self.rows.iter().filter_map(|row| stamp_ns(&columns, row)).collect();
        let mut steps: Vec<i64> = stamps.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
        let repeated = steps.iter().filter(|&&step| step == 0).count();
        let are_few = (repeated as f64) < REPEATED_SHARE * steps.len() as f64;
        steps.retain(|&step| step > 0);
        steps.sort_unstable();
        let repeated_step_ns = steps.get(steps.len() / 2).copied().filter(|_| are_few);
        StampColumns { columns, repeated_step_ns }
    }

    fn free(&self) -> impl Iterator<Item = usize> {
        (0..self.header.names.len()).filter(|place| !self.taken.contains(place))
    }

    fn cells(&self, place: usize) -> impl Iterator<Item = &[u8]> {
        self.rows.iter().filter_map(move |row| row.get(place).map(Vec::as_slice))
    }

    fn name(&self, place: usize) -> TimeName {
        TimeName::of(&self.header.described(place))
    }
}

impl StampColumns {
    /// The form of dates and times of day.
    pub(super) fn clock(&self) -> Option<ClockForm> {
        self.columns.iter().find_map(|&(_, column)| match column {
            ColumnUse::Stamp(StampForm::Clock(form)) => Some(form),
            _ => None,
        })
    }

    /// As a column map names them.
    pub(super) fn named(&self, header: &Header) -> String {
        let column = |&(place, column): &(usize, ColumnUse)| {
            let form = match column {
                ColumnUse::Stamp(form) => form.name(),
                ColumnUse::StampPart(unit) => unit.name,
                ColumnUse::Ignored | ColumnUse::Channel(_) | ColumnUse::OtherStream | ColumnUse::Sentence => "",
            };
            format!("{}:{form}", header.argument(place))
        };
        self.columns.iter().map(column).collect::<Vec<_>>().join("+")
    }
}

/// The stamp of a row cut into fields.
fn stamp_ns(columns: &[(usize, ColumnUse)], row: &[Vec<u8>]) -> Option<i64> {
    columns.iter().try_fold(0_i64, |sum, &(place, column)| {
        let cell = row.get(place)?;
        let part = match column {
            ColumnUse::Stamp(form) => form.nanoseconds(cell)?,
            ColumnUse::StampPart(unit) => StampForm::Unit(unit).nanoseconds(cell)?,
            ColumnUse::Ignored | ColumnUse::Channel(_) | ColumnUse::OtherStream | ColumnUse::Sentence => 0,
        };
        sum.checked_add(part)
    })
}

/// Whether it is a word for a unit of times, in lower case.
pub(super) fn is_time_unit(word: &str) -> bool {
    UNIT_WORDS.iter().any(|(_, words)| words.contains(&word))
}

/// Whether a column of this name may hold times.
pub(super) fn is_time_name(name: &str) -> bool {
    let name = TimeName::of(name);
    name.is_stamp() || name.is_time() || name.words.iter().any(|word| TIME_WORDS.contains(&word.as_str()))
}

/// A name cut into words, with that of a unit at its end apart.
struct TimeName {
    whole: String,
    words: Vec<String>,
    unit: Option<StampUnit>,
}

impl TimeName {
    fn of(name: &str) -> Self {
        let whole = name.to_lowercase();
        let mut words: Vec<String> =
            whole.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect();
        let unit = words.last().and_then(|last| {
            let (name, _) = UNIT_WORDS.iter().find(|(_, unit_words)| unit_words.contains(&last.as_str()))?;
            StampUnit::ALL.into_iter().find(|unit| unit.name == *name)
        });
        if unit.is_some() {
            words.pop();
        }
        Self { whole, words, unit }
    }

    fn is_stamp(&self) -> bool {
        STAMPS.contains(&self.whole.as_str()) || STAMPS.contains(&self.words.join("_").as_str())
    }

    /// Whether it may be one of a time: its last word is, or nothing but a unit.
    fn is_time(&self) -> bool {
        match self.words.last() {
            Some(word) => {
                TIME_ENDINGS.iter().any(|ending| word.ends_with(ending)) || TIME_WORDS.contains(&word.as_str())
            }
            None => self.unit.is_some(),
        }
    }
}

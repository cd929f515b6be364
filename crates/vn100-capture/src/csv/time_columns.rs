//! The search for the columns of the stamps and their form, by the names of the columns and by
//! their content.

use std::ops::RangeInclusive;

use super::{
    ColumnUse, HeadRows, OpenHint, Unusable,
    column_map::{ColumnMap, STAMP},
    date_order,
    header::Header,
    name::words,
    number::Number,
    numbers_at, shown,
    stamp::{
        StampForm, TICK_NS, USUAL_NS, are_of_day, device_ns, may_be_in, stated_unit, time_unit, unit_of, with_unit,
    },
};

/// Names that always mean times.
const STAMPS: [&str; 6] = ["t", "time", "timestamp", "bag_t", "rosbagtimestamp", "%time"];

/// Endings of a word in other names of times.
const TIME_ENDINGS: [&str; 4] = ["time", "stamp", "stamps", "zeit"];

/// The last word in other names of times.
const TIME_WORDS: [&str; 8] = ["t", "utc", "epoch", "elapsed", "clock", "temps", "tiempo", "tempo"];

/// The last words in names of the time at which the sensor measured.
const DEVICE_TIMES: [&str; 4] = ["device time", "time startup", "sample time fine", "sampletimefine"];

/// The columns of times in a table that this program wrote; the first one exists only if the source
/// had arrival times.
const WRITTEN_ARRIVAL: &str = "time [ns]";
const WRITTEN_DEVICE_TIME: &str = "device time [ns]";

/// The steps of a sensor that counts ticks of 100 us: longer ones are those of 10 to 1000 Hz in microseconds.
const TICKED_STEPS_S: RangeInclusive<f64> = 0.9e-4..=0.099;

/// With fewer rows, stamps of whole seconds may have only two values.
const FEWEST_ROWS_OF_COARSE: usize = 500;

/// The columns that hold the stamps of the rows, in the order in which they are added.
pub(super) type StampColumns = Vec<(usize, ColumnUse)>;

/// A name cut into words, without the unit at its end.
struct TimeName {
    whole: String,
    words: Vec<String>,
    /// In nanoseconds.
    unit_ns: Option<i64>,
}

impl TimeName {
    fn of(name: &str) -> Self {
        let (whole, mut words) = (name.to_lowercase(), words(name));
        let unit_ns = words.last().and_then(|last| time_unit(last));
        words.truncate(words.len() - usize::from(unit_ns.is_some()));
        Self { whole, words, unit_ns }
    }

    fn is_device_time(&self) -> bool {
        DEVICE_TIMES.iter().any(|time| self.words.join(" ").ends_with(time))
    }

    /// Whether the name means the time in the header of a message.
    fn is_of_header(&self) -> bool {
        ["header", "stamp"].iter().all(|word| self.words.iter().any(|other| other == word))
    }

    fn is_stamp(&self) -> bool {
        STAMPS.contains(&&*self.whole) || STAMPS.contains(&&*self.words.join("_"))
    }

    /// Whether the name may mean a time: one of its words means times, or it is only a unit. One of minutes
    /// or hours is a part of a date.
    fn is_time(&self) -> bool {
        let Some(word) = self.words.last() else { return self.unit_ns.is_some_and(|unit_ns| unit_ns <= USUAL_NS[0]) };
        let ends = |word: &String| TIME_ENDINGS.iter().any(|ending| word.ends_with(ending));
        TIME_WORDS.contains(&&**word) || self.words.iter().any(ends)
    }
}

/// The names of the columns, and the content of the first rows.
pub(super) struct TimeSearch<'a> {
    pub(super) header: &'a Header,
    pub(super) rows: &'a HeadRows,
    /// Columns with another content.
    pub(super) taken: Vec<usize>,
}

impl TimeSearch<'_> {
    /// The columns that the user named; `None` if the map names none.
    pub(super) fn mapped(&self, map: &ColumnMap) -> Result<Option<StampColumns>, Unusable> {
        let mapped = |(column, form): &(String, _)| Ok((self.header.mapped_place(STAMP, column)?, *form));
        let columns = map.stamp.iter().map(mapped).collect::<Result<Vec<(usize, StampForm)>, Unusable>>()?;
        let Some(&(place, form)) = columns.first() else { return Ok(None) };
        if !self.rows.is_empty() && self.cells(place).all(|cell| form.nanoseconds(cell).is_none()) {
            return Err(self.no_stamps(place));
        }
        if columns.len() == 1 && self.is_coarse(place) {
            let (column, rows) = (&self.header.names[place], self.rows.len());
            return Err(Unusable::certain(format!(
                "the time stamps in column {column:?} are too coarse to show a sample rate: they change once at most in {rows} rows"
            )));
        }
        Ok(Some(columns.into_iter().map(|(place, form)| (place, ColumnUse::Stamp(form))).collect()))
    }

    /// The columns found by their names, else by their content.
    ///
    /// # Errors
    /// [`Unusable`] if a column that can only hold stamps is not understood.
    pub(super) fn found(&self) -> Result<Option<StampColumns>, Unusable> {
        let named = || self.free().find(|&place| self.name(place).is_stamp() && !self.is_coarse(place));
        match self.of_measurement() {
            None => match named() {
                Some(place) => self.form(place).map(|form| Some(vec![(place, ColumnUse::Stamp(form))])),
                None => {
                    self.likely().map_or_else(|| self.ambiguous_date().map_or(Ok(None), Err), |found| Ok(Some(found)))
                }
            },
            columns => Ok(columns),
        }
    }

    /// The error of the first column of dates whose day or month may come first.
    fn ambiguous_date(&self) -> Option<Unusable> {
        self.free().filter(|&place| !self.is_coarse(place)).find_map(|place| self.date(place).err())
    }

    /// Like [`found`](Self::found), but any column may have another content: only columns that
    /// ascend from row to row.
    pub(super) fn likely(&self) -> Option<StampColumns> {
        let dates = |place| Some(vec![(place, ColumnUse::Stamp(self.date(place).ok()??))]);
        self.of_measurement()
            .or_else(|| self.ascending(TimeName::is_stamp))
            .or_else(|| self.pair(|_| true))
            .or_else(|| self.ascending(TimeName::is_time))
            .or_else(|| self.free().find_map(dates))
    }

    /// The first column of any name that can only hold times.
    pub(super) fn unnamed(&self) -> Option<StampColumns> {
        self.ascending(|_| true)
    }

    /// The time at which the sensor measured each row, or that in the header of a message: both are
    /// preferred to the time of recording. Of this, whole seconds are preferred together with their part.
    fn of_measurement(&self) -> Option<StampColumns> {
        self.written_device_time()
            .or_else(|| self.ascending(TimeName::is_device_time))
            .or_else(|| self.ascending(|name| name.is_of_header() && name.unit_ns.is_none()))
            .or_else(|| self.pair(TimeName::is_of_header))
            .or_else(|| self.pair(TimeName::is_stamp))
    }

    /// The first column whose name fits and whose stamps ascend from row to row, with few
    /// exceptions.
    fn ascending(&self, is_named: impl Fn(&TimeName) -> bool) -> Option<StampColumns> {
        let named = self.free().filter(|&place| is_named(&self.name(place)));
        { named }.find_map(|place| {
            let form = self.form(place).ok()?;
            let stamps: Vec<i64> = self.cells(place).filter_map(|cell| form.nanoseconds(cell)).collect();
            let backwards = stamps.windows(2).filter(|pair| pair[1] < pair[0]).count();
            // one stamp that is none, even the last, does not decide
            let (early, late) = stamps.split_at(stamps.len() / 2);
            let is_later = median(early).is_some_and(|early| median(late) > Some(early));
            let ascends = is_later && 20 * backwards <= stamps.len() && !self.is_coarse(place);
            ascends.then(|| vec![(place, ColumnUse::Stamp(form))])
        })
    }

    /// The columns of times in a table of samples that this program wrote: the time of the sensor,
    /// which starts from zero after a restart.
    fn written_device_time(&self) -> Option<StampColumns> {
        let place_of = |name: &str| self.free().find(|&place| self.header.names[place] == name);
        let place = place_of(WRITTEN_DEVICE_TIME)?;
        let times = self.cells(place).map(device_ns).collect::<Option<Vec<u64>>>()?;
        let forward = times.windows(2).filter(|pair| pair[1] > pair[0]).count();
        let arrival = place_of(WRITTEN_ARRIVAL).map(|place| (place, ColumnUse::Stamp(StampForm::Unit(1))));
        (2 * forward >= times.len()).then(|| arrival.into_iter().chain([(place, ColumnUse::DeviceTime)]).collect())
    }

    /// Whole seconds in one column, and the part to be added in another, whose name differs only in
    /// the unit.
    fn pair(&self, is_named: impl Fn(&TimeName) -> bool) -> Option<StampColumns> {
        let [second_ns, parts @ ..] = USUAL_NS;
        let has = |place: usize, unit_ns: i64, is: &dyn Fn(Number) -> bool| {
            self.name(place).unit_ns == Some(unit_ns)
                && self.cells(place).all(|cell| Number::parse(cell).is_some_and(is))
        };
        let seconds = self.free().filter(|&place| has(place, second_ns, &|number| number.decimals <= 0));
        { seconds.filter(|&place| is_named(&self.name(place))) }.find_map(|seconds| {
            let words = self.name(seconds).words;
            let is_part = |place: usize, unit_ns: i64| {
                let limit = (second_ns / unit_ns) as f64;
                has(place, unit_ns, &|number| (0.0..limit).contains(&number.value())) && self.name(place).words == words
            };
            let part = |unit_ns: i64| Some((self.free().find(|&place| is_part(place, unit_ns))?, unit_ns));
            let uses = [(seconds, second_ns), parts.into_iter().find_map(part)?];
            Some(uses.map(|(place, unit_ns)| (place, ColumnUse::Stamp(StampForm::Unit(unit_ns)))).to_vec())
        })
    }

    fn form(&self, place: usize) -> Result<StampForm, Unusable> {
        let stamps: Vec<Number> = numbers_at(self.rows, place).collect();
        let cells: Vec<&[u8]> = self.cells(place).filter(|cell| !cell.is_empty()).collect();
        // a number among dates is a damaged date
        if stamps.is_empty() || 2 * stamps.len() < cells.len() {
            if let Some((_, unit_ns)) = self.cells(place).find_map(with_unit) {
                return Ok(StampForm::Unit(unit_ns));
            }
            return match self.date(place)? {
                Some(form) => Ok(form),
                None if self.rows.is_empty() => Ok(StampForm::Unit(USUAL_NS[0])),
                None => Err(self.no_stamps(place)),
            };
        }
        if are_of_day(&cells) {
            return Ok(StampForm::TimeOfDay);
        }
        let name = self.name(place);
        let are_fine = name.is_device_time() && name.whole.contains("fine");
        let unit_ns = match name.unit_ns {
            Some(unit_ns) => stated_unit(&stamps, unit_ns),
            // some sensors of Xsens count microseconds, at 1000 Hz at most
            None if are_fine && may_be_in(&stamps, TICK_NS, &TICKED_STEPS_S) => Ok(TICK_NS),
            None => unit_of(&stamps),
        };
        let unit_ns = unit_ns.map_err(|ambiguous| {
            let column = &self.header.names[place];
            let reason = format!("the unit of the time stamps in column {column:?} is ambiguous: {ambiguous}");
            let [_, milli_ns, ..] = USUAL_NS;
            let likely_ns = unit_of(&stamps).ok().or(name.unit_ns).unwrap_or(milli_ns);
            let likely = StampForm::Unit(likely_ns).name();
            let hint = OpenHint::StampUnit(format!("t={}:{likely}", self.header.argument(place)));
            Unusable::certain(reason).with_hint(hint)
        })?;
        Ok(StampForm::Unit(unit_ns))
    }

    /// Dates, or times of day; `None` if no cell is one of these.
    fn date(&self, place: usize) -> Result<Option<StampForm>, Unusable> {
        let cells: Vec<&[u8]> = self.cells(place).filter(|cell| !cell.is_empty()).collect();
        let order = || date_order(&self.header.names[place], &self.header.argument(place));
        StampForm::of_texts(&cells).map_err(|()| order())
    }

    /// Whether too many rows share each stamp for finding a rate, such as an epoch in a float of 32
    /// bits.
    fn is_coarse(&self, place: usize) -> bool {
        let stamps: Vec<&[u8]> = self.cells(place).collect();
        let changes = stamps.windows(2).filter(|pair| pair[0] != pair[1]).count();
        stamps.len() >= FEWEST_ROWS_OF_COARSE && changes <= 1
    }

    fn no_stamps(&self, place: usize) -> Unusable {
        let (column, first) = (&self.header.names[place], shown(self.cells(place).next().unwrap_or_default()));
        Unusable::certain(format!(
            "the time stamps in column {column:?} are neither numbers nor dates nor times of day, the first is {first:?}: name \
             another column"
        ))
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

/// The columns as written in a column map; a device time is preferred to the arrival times in the
/// same table.
pub(super) fn argument(columns: &StampColumns, header: &Header) -> String {
    let device_time = columns.iter().find(|(_, column)| *column == ColumnUse::DeviceTime);
    let columns = device_time.map_or(&columns[..], std::slice::from_ref);
    let column = |&(place, column): &(usize, ColumnUse)| {
        let form = if let ColumnUse::Stamp(form) = column { form } else { StampForm::Unit(1) };
        format!("{}:{}", header.argument(place), form.name())
    };
    columns.iter().map(column).collect::<Vec<_>>().join("+")
}

fn median(stamps: &[i64]) -> Option<i64> {
    let mut sorted = stamps.to_vec();
    sorted.sort_unstable();
    sorted.get(sorted.len() / 2).copied()
}

//! The search for the columns of the stamps and their form, by the names of the columns and by
//! their content.

use super::{
    ColumnUse, CsvError, HeadRows,
    column_map::{ColumnMap, STAMP},
    date::DateForm,
    header::Header,
    number::Number,
    shown,
    stamp::{StampForm, StampScan, StampUnit, device_ns, with_unit},
    time_name::TimeName,
};

/// The columns of times in a table that this program wrote; the first one exists only if the source
/// had arrival times.
const WRITTEN_ARRIVAL: &str = "time [ns]";
const WRITTEN_DEVICE_TIME: &str = "device time [ns]";

/// With fewer rows, stamps of whole seconds may have only two values.
const FEWEST_ROWS_OF_COARSE: usize = 500;

/// The columns that hold the stamps of the rows, in the order in which they are added.
#[derive(Debug, Clone)]
pub(super) struct StampColumns {
    pub(super) columns: Vec<(usize, ColumnUse)>,
}

/// The names of the columns, and the content of the first rows.
pub(super) struct StampSearch<'a> {
    pub(super) header: &'a Header,
    pub(super) rows: &'a HeadRows,
    /// Columns with another content.
    pub(super) taken: Vec<usize>,
    pub(super) has_sentences: bool,
}

impl StampSearch<'_> {
    /// The columns that the user named; `None` if the map names none.
    pub(super) fn mapped(&self, map: &ColumnMap) -> Result<Option<StampColumns>, CsvError> {
        let mapped = |(column, form): &(_, _)| Ok((self.header.mapped_place(STAMP, column)?, *form));
        let columns = map.stamp.iter().map(mapped).collect::<Result<Vec<(usize, StampForm)>, CsvError>>()?;
        let Some(&(place, form)) = columns.first() else { return Ok(None) };
        if !self.rows.is_empty() && self.cells(place).all(|cell| form.nanoseconds(cell).is_none()) {
            return Err(self.no_stamps(place));
        }
        if columns.len() == 1 && self.is_coarse(place) {
            return Err(CsvError::CoarseStamps { column: self.header.names[place].clone(), rows: self.rows.len() });
        }
        let columns = columns.into_iter().map(|(place, form)| (place, ColumnUse::Stamp(form)));
        Ok(Some(StampColumns { columns: columns.collect() }))
    }

    /// The columns found by their names, else by their content.
    ///
    /// # Errors
    /// [`CsvError`] if a column that can only hold stamps is not understood.
    pub(super) fn found(&self) -> Result<Option<StampColumns>, CsvError> {
        if let Some(columns) = self.device_time().or_else(|| self.header_stamp()) {
            return Ok(Some(columns));
        }
        match self.free().find(|&place| self.name(place).is_stamp() && !self.is_coarse(place)) {
            Some(place) => self.form(place).map(|form| Some(StampColumns::of(place, form))),
            None => Ok(self.likely()),
        }
    }

    /// Like [`found`](Self::found), but any column may have another content: only columns that
    /// ascend from row to row.
    pub(super) fn likely(&self) -> Option<StampColumns> {
        if let Some(columns) = self.device_time().or_else(|| self.header_stamp()) {
            return Some(columns);
        }
        let by_name = || {
            let named = self.free().filter(|&place| self.name(place).is_time());
            { named }.find_map(|place| Some((place, self.form(place).ok().filter(|_| self.ascends(place))?)))
        };
        let exactly = self.free().filter(|&place| self.name(place).is_stamp() && self.ascends(place));
        let exactly = { exactly }.find_map(|place| Some((place, self.form(place).ok()?)));
        let single = |(place, form)| vec![(place, ColumnUse::Stamp(form))];
        let by_content = || self.free().find_map(|place| Some((place, StampForm::Date(self.date(place).ok()??))));
        let columns = exactly.map(single).or_else(|| self.pair()).or_else(|| by_name().map(single));
        columns.or_else(|| by_content().map(single)).map(|columns| StampColumns { columns })
    }

    /// The time at which the sensor measured each row, preferred to any arrival time.
    fn device_time(&self) -> Option<StampColumns> {
        if let Some(columns) = self.written_device_time() {
            return Some(StampColumns { columns });
        }
        let is_device_time = |place: &usize| self.name(*place).is_device_time() && self.ascends(*place);
        let place = self.free().find(is_device_time)?;
        Some(StampColumns::of(place, self.form(place).ok()?))
    }

    /// The time in the header of a message, preferred to the time of its recording.
    fn header_stamp(&self) -> Option<StampColumns> {
        let is_of_header = |place: &usize| self.name(*place).is_of_header();
        let single =
            self.free().find(|place| is_of_header(place) && self.name(*place).unit.is_none() && self.ascends(*place));
        let single = single.and_then(|place| Some(vec![(place, ColumnUse::Stamp(self.form(place).ok()?))]));
        let pair = || self.pair().filter(|columns| columns.iter().all(|(place, _)| is_of_header(place)));
        Some(StampColumns { columns: single.or_else(pair)? })
    }

    /// The columns of times in a table of samples that this program wrote.
    fn written_device_time(&self) -> Option<Vec<(usize, ColumnUse)>> {
        let place_of = |name: &str| self.free().find(|&place| self.header.names[place] == name);
        let place = place_of(WRITTEN_DEVICE_TIME).filter(|&place| !self.has_sentences && self.counts_up(place))?;
        let form = StampForm::Unit(StampUnit::NANOSECONDS);
        let are_stamps = |place: &usize| self.cells(*place).all(|cell| form.nanoseconds(cell).is_some());
        let arrival = place_of(WRITTEN_ARRIVAL).filter(are_stamps).map(|place| (place, ColumnUse::Stamp(form)));
        Some(arrival.into_iter().chain([(place, ColumnUse::DeviceTime)]).collect())
    }

    /// Whether a column counts nanoseconds up from row to row, and starts from zero after a restart.
    fn counts_up(&self, place: usize) -> bool {
        let times: Option<Vec<u64>> = self.cells(place).map(device_ns).collect();
        let Some(times) = times else { return false };
        let forward = times.windows(2).filter(|pair| pair[1] > pair[0]).count();
        2 * forward >= times.len()
    }

    /// The first column of any name that can only hold times.
    pub(super) fn unnamed(&self) -> Option<StampColumns> {
        let (place, form) =
            self.free().find_map(|place| Some((place, self.form(place).ok().filter(|_| self.ascends(place))?)))?;
        Some(StampColumns::of(place, form))
    }

    /// Seconds in one column, and the nanoseconds to be added in another, whose name differs only
    /// in the unit.
    fn pair(&self) -> Option<Vec<(usize, ColumnUse)>> {
        let [seconds_unit, rest @ ..] = StampUnit::USUAL;
        let all_numbers = |place: usize| self.cells(place).all(|cell| Number::parse(cell).is_some());
        let in_unit = |unit: StampUnit| {
            self.free().filter(move |&place| self.name(place).unit == Some(unit) && all_numbers(place))
        };
        in_unit(seconds_unit).find_map(|seconds| {
            let base = self.name(seconds).words;
            // the seconds are whole, or the other column is a time of its own
            let is_whole = self.cells(seconds).filter_map(Number::parse).all(|number| number.decimals() == 0);
            rest.into_iter().filter(|_| is_whole).find_map(|unit| {
                let part = in_unit(unit).find(|&place| self.name(place).words == base)?;
                let limit = 1.0 / unit.seconds();
                let is_part =
                    self.cells(part).filter_map(Number::parse).all(|part| (0.0..limit).contains(&part.value()));
                let form = ColumnUse::Stamp(StampForm::Unit(seconds_unit));
                is_part.then(|| vec![(seconds, form), (part, ColumnUse::Stamp(StampForm::Unit(unit)))])
            })
        })
    }

    /// The form of the stamps of a column.
    fn form(&self, place: usize) -> Result<StampForm, CsvError> {
        let mut scan = StampScan::default();
        self.cells(place).filter_map(Number::parse).for_each(|stamp| scan.add(&stamp));
        if scan.is_empty() {
            if let Some((_, unit)) = self.cells(place).find_map(with_unit) {
                return Ok(StampForm::Unit(unit));
            }
            return match self.date(place)? {
                Some(form) => Ok(StampForm::Date(form)),
                None if self.rows.is_empty() => Ok(StampForm::Unit(StampUnit::USUAL[0])),
                None => Err(self.no_stamps(place)),
            };
        }
        let named = self.name(place).unit().filter(|&unit| scan.may_be(unit));
        let unit = named.map_or_else(|| scan.unit(), Ok).map_err(|unsure| CsvError::StampUnit {
            column: self.header.names[place].clone(),
            argument: self.header.argument(place),
            step: unsure.step,
            units: unsure.units,
        })?;
        Ok(StampForm::Unit(unit))
    }

    /// Dates, or times of day; `None` if no cell is one of these.
    fn date(&self, place: usize) -> Result<Option<DateForm>, CsvError> {
        let fits = |form: &DateForm| {
            let mut cells = self.cells(place).filter(|cell| !cell.is_empty()).peekable();
            cells.peek().is_some() && cells.all(|cell| form.nanoseconds(cell).is_some())
        };
        let fitting: Vec<DateForm> = DateForm::ALL.into_iter().filter(fits).collect();
        match fitting[..] {
            [DateForm::DayFirst, DateForm::MonthFirst] => Err(CsvError::DateOrder {
                column: self.header.names[place].clone(),
                argument: self.header.argument(place),
            }),
            [form, ..] => Ok(Some(form)),
            [] => Ok(None),
        }
    }

    /// Whether too many rows share each stamp for finding a rate, such as an epoch in a float of 32
    /// bits.
    fn is_coarse(&self, place: usize) -> bool {
        let stamps: Vec<&[u8]> = self.cells(place).collect();
        let changes = stamps.windows(2).filter(|pair| pair[0] != pair[1]).count();
        stamps.len() >= FEWEST_ROWS_OF_COARSE && changes <= 1
    }

    /// Whether the stamps of a column ascend from row to row, with few exceptions.
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
    fn of(place: usize, form: StampForm) -> Self {
        Self { columns: vec![(place, ColumnUse::Stamp(form))] }
    }

    /// The form of dates and times of day.
    pub(super) fn date(&self) -> Option<DateForm> {
        self.columns.iter().find_map(|&(_, column)| match column {
            ColumnUse::Stamp(StampForm::Date(form)) => Some(form),
            _ => None,
        })
    }

    /// The columns as written in a column map.
    pub(super) fn named(&self, header: &Header) -> String {
        // a device time is preferred to the arrival times in the same table
        let device_time = self.columns.iter().find(|(_, column)| *column == ColumnUse::DeviceTime);
        let columns = device_time.map_or(&self.columns[..], std::slice::from_ref);
        let column = |&(place, column): &(usize, ColumnUse)| {
            let form = match column {
                ColumnUse::Stamp(form) => form.name(),
                ColumnUse::DeviceTime => StampUnit::NANOSECONDS.name,
                _ => "",
            };
            format!("{}:{form}", header.argument(place))
        };
        columns.iter().map(column).collect::<Vec<_>>().join("+")
    }
}

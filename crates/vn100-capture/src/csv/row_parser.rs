//! The rows of a CSV file, read one after the other as its plan says.

use std::mem;

use memchr::memchr;
use vn100_protocol::stream::{CsvReport, RejectedRow};

use super::{
    ColumnUse, CsvPlan, Kind,
    fields::FieldCutter,
    lines::{Completeness, CsvLine, is_comment_or_blank},
    name::Meaning,
    number::Number,
    row_counts::{Absence, RowCounts},
    shown, stamp,
    stamped_sentences::stamp_and_sentence,
};

/// Reads the rows of a CSV file one after the other. Either `counts` or `sentence` is used, by the
/// [`Kind`] of the plan.
pub(super) struct RowParser {
    pub(super) plan: CsvPlan,
    fields: FieldCutter,
    /// The counts of the last valid row, in the order of the layout; 0 for a channel that it lacks.
    pub(super) counts: Vec<i32>,
    /// The channels that the last valid row lacks, in order.
    pub(super) absent: Vec<(usize, Absence)>,
    /// The numbers of a row.
    cells: Vec<Option<Number>>,
    /// The sum of the parts of its stamp so far.
    part_of_stamp: Option<i64>,
    /// Whether the last row has a number in a column of another stream.
    holds_others: bool,
    /// Whether the last row has numbers of other streams only.
    is_of_others: bool,
    /// The sentence of the last valid row, with CR LF.
    pub(super) sentence: Vec<u8>,
    /// The stamp of the last valid row, in nanoseconds since the first; negative where a clock was
    /// set back.
    pub(super) stamp_ns: Option<i64>,
    /// The time of the sensor in the last valid row.
    pub(super) device_ns: Option<u64>,
    first_stamp_ns: Option<i64>,
    /// The stamp as written.
    last_stamp_ns: Option<i64>,
    /// The line in which a table with other columns begins.
    pub(super) other_table: Option<u64>,
    /// Whether the last row ended inside quotes: the next line may be the rest of it.
    quote_open: bool,
    /// The counts of the lines by their kind.
    pub(super) counted: RowCounts,
}

impl RowParser {
    pub(super) fn new(plan: CsvPlan) -> Self {
        let channels = plan.quantizers.len();
        Self {
            fields: FieldCutter::new(plan.dialect.separator, plan.line_end),
            counts: vec![0; channels],
            absent: Vec::new(),
            cells: vec![None; channels],
            part_of_stamp: None,
            holds_others: false,
            is_of_others: false,
            sentence: Vec::new(),
            stamp_ns: None,
            device_ns: None,
            first_stamp_ns: None,
            last_stamp_ns: None,
            other_table: None,
            quote_open: false,
            counted: RowCounts::new(&plan),
            plan,
        }
    }

    /// What has become of the lines so far.
    pub(super) fn report(&self) -> CsvReport {
        CsvReport { first_stamp_ns: self.first_stamp_ns, ..self.counted.report(&self.plan) }
    }

    /// The numbers of a line, if it is a valid row.
    pub(super) fn numbers(&mut self, line: &CsvLine<'_>) -> Option<&[Option<Number>]> {
        let text = self.plan.dialect.tidy(line.text);
        let line = &CsvLine { text: &text, ..*line };
        let is_row = match line.completeness {
            Completeness::Overlong => false,
            Completeness::Unended => self.ends_whole(line.text),
            Completeness::Whole => true,
        };
        let is_good = is_row
            && line.number > self.plan.lines_above
            && !is_comment_or_blank(line.text)
            && self.cells(line.text).is_ok();
        is_good.then_some(&self.cells)
    }

    /// Reads a line; `None` where it is no row, or a row of another stream.
    #[inline]
    pub(super) fn push(&mut self, line: &CsvLine<'_>) -> Option<Result<(), RejectedRow>> {
        let text = self.plan.dialect.tidy(line.text);
        let line = &CsvLine { text: &text, ..*line };
        self.counted.report.lines += 1;
        if line.completeness != Completeness::Overlong && self.is_skipped(line) {
            self.counted.skip(line);
            return None;
        }
        let row = match line.completeness {
            Completeness::Overlong => Err(RejectedRow::Length),
            Completeness::Unended if !self.ends_whole(line.text) => Err(RejectedRow::Truncated),
            Completeness::Unended | Completeness::Whole => self.row(line),
        };
        if mem::take(&mut self.is_of_others) {
            self.counted.leave_to_others(line);
            return None;
        }
        if row.is_err() && self.is_header(line) {
            self.counted.skip(line);
            return None;
        }
        match row {
            Ok(()) => self.counted.accept(line, &self.absent),
            Err(reason) => self.counted.reject(reason, line),
        }
        Some(row)
    }

    #[inline]
    fn is_skipped(&mut self, line: &CsvLine<'_>) -> bool {
        if line.number <= self.plan.lines_above || is_comment_or_blank(line.text) {
            return true;
        }
        // a script that saved a sentence together with its CR LF
        mem::take(&mut self.quote_open) && line.text.trim_ascii_start().starts_with(b"\"")
    }

    /// Whether a row without a line end is complete, as far as that can be known.
    #[cold]
    fn ends_whole(&mut self, row: &[u8]) -> bool {
        let Some(last_field) = self.plan.last_field else {
            return true;
        };
        let fields = self.fields.cut(row);
        fields.len() == self.plan.columns.len() && last_field.is_whole(fields.last())
    }

    #[inline]
    fn row(&mut self, line: &CsvLine<'_>) -> Result<(), RejectedRow> {
        self.stamp_ns = match self.plan.kind {
            Kind::Values(_) => self.values(line)?,
            Kind::Sentences => self.sentence(line.text)?,
        };
        Ok(())
    }

    /// Reads the counts of a row and returns its stamp. A value that is absent has no effect on the
    /// other channels.
    #[inline]
    fn values(&mut self, line: &CsvLine<'_>) -> Result<Option<i64>, RejectedRow> {
        let stamp = self.cells(line.text)?;
        let Self { plan, counts, absent, counted, cells, .. } = self;
        for (slot, (cell, quantizer)) in cells.iter().zip(&plan.quantizers).enumerate() {
            let count = cell.as_ref().and_then(|number| quantizer.count(number));
            counts[slot] = count.unwrap_or_default();
            match (cell, count) {
                (Some(number), Some(_)) => counted.late_rounded[slot] |= quantizer.rounds(number),
                (Some(_), None) => absent.push((slot, Absence::OutOfRange)),
                // why is in the list already
                (None, _) => {}
            }
        }
        if absent.len() >= cells.len() {
            self.is_of_others = self.holds_others && cells.iter().all(Option::is_none);
            return Err(RejectedRow::Number);
        }
        absent.sort_unstable_by_key(|(slot, _)| *slot);
        stamp.map(|stamp_ns| self.since_first(stamp_ns)).transpose()
    }

    /// Reads the numbers of a row and returns its stamp.
    #[inline]
    fn cells(&mut self, line: &[u8]) -> Result<Option<i64>, RejectedRow> {
        self.absent.clear();
        self.holds_others = false;
        self.part_of_stamp = None;
        // without quotes the fields are read in place
        if memchr(b'"', line).is_some() { self.quoted_cells(line) } else { self.plain_cells(line) }?;
        Ok(self.part_of_stamp)
    }

    #[inline]
    fn plain_cells(&mut self, line: &[u8]) -> Result<(), RejectedRow> {
        let separator = self.plan.dialect.separator;
        let (mut at, mut place, mut outcome) = (0, 0, Ok(()));
        loop {
            let Some(&column) = self.plan.columns.get(place) else { return Err(RejectedRow::Fields) };
            let quick = match column {
                ColumnUse::Channel(slot) => Number::parse_prefix(&line[at..])
                    .filter(|(_, length)| line.get(at + length).is_none_or(|byte| *byte == separator))
                    .map(|(number, length)| {
                        self.cells[slot] = Some(number);
                        at + length
                    }),
                _ => None,
            };
            let end = quick.unwrap_or_else(|| {
                let end = memchr(separator, &line[at..]).map_or(line.len(), |length| at + length);
                outcome = outcome.and(self.cell(column, line[at..end].trim_ascii()));
                end
            });
            place += 1;
            if end == line.len() {
                break;
            }
            at = end + 1;
        }
        if place == self.plan.columns.len() { outcome } else { Err(RejectedRow::Fields) }
    }

    #[cold]
    fn quoted_cells(&mut self, line: &[u8]) -> Result<(), RejectedRow> {
        let mut fields = mem::replace(&mut self.fields, FieldCutter::of_head(self.plan.dialect.separator));
        let cut = fields.cut(line);
        let outcome = match cut.len() == self.plan.columns.len() {
            true => cut.iter().enumerate().try_for_each(|(place, field)| self.cell(self.plan.columns[place], field)),
            false => Err(RejectedRow::Fields),
        };
        self.fields = fields;
        outcome
    }

    /// Reads a field without spaces or quotes around it.
    fn cell(&mut self, column: ColumnUse, field: &[u8]) -> Result<(), RejectedRow> {
        match column {
            ColumnUse::Channel(slot) => {
                self.cells[slot] = Number::parse(field);
                if self.cells[slot].is_none() {
                    self.absent.push((slot, absence(field).ok_or(RejectedRow::Number)?));
                }
            }
            ColumnUse::Stamp(form) => self.part_of_stamp = Some(added(self.part_of_stamp, form.nanoseconds(field))?),
            ColumnUse::DeviceTime => self.device_ns = Some(stamp::device_ns(field).ok_or(RejectedRow::Stamp)?),
            ColumnUse::OtherStream => self.holds_others |= Number::parse(field).is_some(),
            ColumnUse::Ignored | ColumnUse::Sentence => {}
        }
        Ok(())
    }

    /// Reads the sentence of a row and returns its stamp.
    fn sentence(&mut self, line: &[u8]) -> Result<Option<i64>, RejectedRow> {
        if self.plan.dialect.has_stamped_sentences {
            return self.stamped_sentence(line);
        }
        let Self { plan, fields, sentence, .. } = self;
        let last = plan.columns.len() - 1;
        let is_unquoted =
            |tail: &&[u8]| plan.columns[last] == ColumnUse::Sentence && !tail.trim_ascii_start().starts_with(b"\"");
        // without quotes the separators in a sentence do not separate columns
        let tail = fields.cut_first(line, last).1.filter(is_unquoted);
        let fields = fields.cut_first(line, if tail.is_some() { last } else { usize::MAX }).0;
        self.quote_open = fields.quote_open;
        sentence.clear();
        let mut stamp = Ok(None);
        for (field, &column) in fields.iter().chain(tail.map(<[u8]>::trim_ascii)).zip(&plan.columns) {
            let form = match column {
                ColumnUse::Stamp(form) => form,
                ColumnUse::Sentence => {
                    sentence.extend_from_slice(field);
                    continue;
                }
                ColumnUse::Ignored | ColumnUse::DeviceTime | ColumnUse::Channel(_) | ColumnUse::OtherStream => continue,
            };
            stamp = stamp.and_then(|sum| added(sum, form.nanoseconds(field)).map(Some));
        }
        let width = fields.len() + usize::from(tail.is_some());
        // after an open quote the row continues in the next line
        let is_whole = width == plan.columns.len() || self.quote_open && width < plan.columns.len();
        if sentence.is_empty() || !is_whole || stamp == Ok(None) && plan.times.is_some() {
            return Err(RejectedRow::Fields);
        }
        sentence.extend_from_slice(b"\r\n");
        stamp?.map(|stamp_ns| self.since_first(stamp_ns)).transpose()
    }

    /// Reads a row that is a stamp and a sentence.
    fn stamped_sentence(&mut self, line: &[u8]) -> Result<Option<i64>, RejectedRow> {
        let (stamp, sentence) = stamp_and_sentence(line).ok_or(RejectedRow::Fields)?;
        self.sentence.clear();
        self.sentence.extend_from_slice(sentence);
        self.sentence.extend_from_slice(b"\r\n");
        match self.plan.columns.first() {
            Some(ColumnUse::Stamp(form)) => {
                let stamp_ns = form.nanoseconds(stamp).ok_or(RejectedRow::Stamp)?;
                self.since_first(stamp_ns).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Whether a line that is no row names the columns once more, as a logger does that was started
    /// again: the columns of the next rows are then in its order. A line that names other columns
    /// ends the table.
    #[cold]
    fn is_header(&mut self, line: &CsvLine<'_>) -> bool {
        let names: Vec<String> = self.fields.cut(line.text).iter().map(shown).collect();
        let is_number = |name: &String| Number::parse(name.as_bytes()).is_some();
        if self.plan.names.is_empty() || names.len() < 2 || names.iter().any(is_number) {
            return false;
        }
        let mut free: Vec<(&String, ColumnUse)> =
            self.plan.names.iter().zip(self.plan.columns.iter().copied()).collect();
        let place = |name: &String| {
            let at = free.iter().position(|(other, _)| *other == name)?;
            Some(free.remove(at).1)
        };
        let named = names.iter().take(self.plan.names.len()).map(place).collect::<Option<Vec<_>>>();
        match named.filter(|named| named.len() == self.plan.names.len()) {
            Some(mut columns) => {
                columns.resize(self.plan.columns.len(), ColumnUse::Ignored);
                (self.plan.columns, self.plan.names) = (columns, names);
                true
            }
            None => {
                let is_known = |name: &&String| Meaning::of(name, None).is_some_and(|meaning| meaning.is_sure);
                if names.iter().filter(is_known).count() >= 2 {
                    self.other_table = Some(line.number);
                }
                false
            }
        }
    }

    /// The time since the first good row.
    #[inline]
    fn since_first(&mut self, stamp_ns: i64) -> Result<i64, RejectedRow> {
        let stamp_ns = match self.plan.date {
            Some(form) => form.after(self.last_stamp_ns, stamp_ns),
            None => stamp_ns,
        };
        let repeats = self.last_stamp_ns.replace(stamp_ns) == Some(stamp_ns);
        let behind_ns = self.plan.repeated_step_ns.filter(|_| repeats).unwrap_or_default();
        let first_ns = *self.first_stamp_ns.get_or_insert(stamp_ns);
        stamp_ns.checked_sub(first_ns).and_then(|ns| ns.checked_add(behind_ns)).ok_or(RejectedRow::Stamp)
    }
}

/// A part of a stamp added to those before it.
#[inline]
fn added(sum: Option<i64>, part_ns: Option<i64>) -> Result<i64, RejectedRow> {
    part_ns.and_then(|part_ns| sum.unwrap_or_default().checked_add(part_ns)).ok_or(RejectedRow::Stamp)
}

/// Why there is no number in `field`; `None` for one that is damaged.
#[cold]
fn absence(field: &[u8]) -> Option<Absence> {
    let word = field.strip_prefix(b"-").or(field.strip_prefix(b"+")).unwrap_or(field);
    let says_none = |text: &[u8]| NO_NUMBERS.iter().any(|none| text.eq_ignore_ascii_case(none.as_bytes()));
    match field {
        b"" => Some(Absence::Empty),
        _ if says_none(field) || says_none(word) => Some(Absence::NotANumber),
        _ => None,
    }
}

/// What scripts write for no number, in lower case.
const NO_NUMBERS: [&str; 18] = [
    "nan", "inf", "infinity", "null", "none", "na", "n/a", "-", "--", // spreadsheets, pandas, C of Windows
    "#n/a", "#num!", "#value!", "#div/0!", "<na>", "nan(ind)", "1.#ind", "1.#qnan", "1.#inf",
];

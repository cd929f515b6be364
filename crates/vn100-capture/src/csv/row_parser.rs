//! The rows of a CSV file, read in sequence according to its plan.

use vn100_protocol::stream::{CsvReport, RejectedRow};

use super::{
    ColumnUse, CsvPlan,
    fields::fields,
    lines::{Completeness, CsvLine, is_comment_or_blank},
    name::Meaning,
    number::Number,
    row_counts::{Absence, RowCounts},
    sentence_rows::SentenceRow,
    shown,
    stamp::device_ns,
};

/// Texts that scripts write in place of a missing number, in lower case.
const NO_NUMBERS: [&str; 18] = [
    "nan", "inf", "infinity", "null", "none", "na", "n/a", "-", "--", // spreadsheets, pandas, C of Windows
    "#n/a", "#num!", "#value!", "#div/0!", "<na>", "nan(ind)", "1.#ind", "1.#qnan", "1.#inf",
];

/// Reads the rows of a CSV file in sequence. The plan determines whether `counts` or `sentence` is
/// used.
pub(super) struct RowParser {
    pub(super) plan: CsvPlan,
    /// The counts of the last valid row, in the order of the layout; 0 for a missing channel.
    pub(super) counts: Vec<i32>,
    /// The channels that the last row lacks, in order.
    pub(super) absent: Vec<(usize, Absence)>,
    /// The sensor's time in the last row.
    pub(super) device_ns: Option<u64>,
    /// The sentence of the last valid row, with CR LF.
    pub(super) sentence: Vec<u8>,
    /// The stamp of the last valid row, in nanoseconds since the first; negative if a clock was set
    /// back.
    pub(super) stamp_ns: Option<i64>,
    first_stamp_ns: Option<i64>,
    /// The stamp as written.
    last_stamp_ns: Option<i64>,
    /// The line in which a table with other columns begins.
    pub(super) other_table: Option<u64>,
    /// The counts of the lines by their kind.
    pub(super) counted: RowCounts,
}

impl RowParser {
    pub(super) fn new(plan: CsvPlan) -> Self {
        Self {
            counts: vec![0; plan.quantizers.len()],
            absent: Vec::new(),
            device_ns: None,
            sentence: Vec::new(),
            stamp_ns: None,
            first_stamp_ns: None,
            last_stamp_ns: None,
            other_table: None,
            counted: RowCounts::new(&plan),
            plan,
        }
    }

    /// The counts of the lines so far.
    pub(super) fn report(&self) -> CsvReport {
        CsvReport { first_stamp_ns: self.first_stamp_ns, ..self.counted.report() }
    }

    /// Reads a line; `None` if it is no row, or a row of another stream.
    #[inline]
    pub(super) fn push(&mut self, line: &CsvLine<'_>) -> Option<Result<(), RejectedRow>> {
        let text = &*self.plan.dialect.tidy(line.text);
        self.counted.report.lines += 1;
        if line.completeness != Completeness::Overlong && self.is_skipped(line.number, text) {
            self.counted.skip(line);
            return None;
        }
        let row = match line.completeness {
            Completeness::Overlong => Err(RejectedRow::Length),
            Completeness::Unended if !self.ends_whole(text) => Err(RejectedRow::Truncated),
            _ if self.plan.layout.is_some() => self.values(text),
            _ => self.sentence(text).map(|()| true),
        };
        match row {
            Ok(true) => self.counted.accept(line, &self.absent),
            Ok(false) => {
                self.counted.leave_to_others(line);
                return None;
            }
            Err(_) if self.is_header(line.number, text) => {
                self.counted.skip(line);
                return None;
            }
            Err(reason) => self.counted.reject(reason, line),
        }
        Some(row.map(|_| ()))
    }

    #[inline]
    fn is_skipped(&self, number: u64, text: &[u8]) -> bool {
        // a script saved a sentence together with its CR LF: this is the rest of the row
        let is_rest = || text.trim_ascii_start().starts_with(b"\"") && SentenceRow::of(text).is_none();
        number <= self.plan.lines_above || is_comment_or_blank(text) || self.plan.layout.is_none() && is_rest()
    }

    /// Whether a row without a line end is complete, as far as it can be determined.
    #[cold]
    fn ends_whole(&mut self, row: &[u8]) -> bool {
        let Some(last_field) = self.plan.last_field else { return true };
        let separator = self.plan.dialect.separator;
        let cells = match self.plan.layout {
            Some(_) => fields(row, separator).collect(),
            None => SentenceRow::of(row).map_or(Vec::new(), |row| row.cells(separator).0),
        };
        cells.len() == self.plan.columns.len() && cells.last().is_some_and(|last| last_field.is_whole(last))
    }

    /// Reads the counts and the stamp of a row; `false` if it has values of another stream only. A
    /// value that is absent has no effect on the other channels.
    #[inline]
    fn values(&mut self, line: &[u8]) -> Result<bool, RejectedRow> {
        self.absent.clear();
        let mut cells = fields(line, self.plan.dialect.separator);
        let (mut place, mut stamp_ns, mut holds_others, mut outcome) = (0, None, false, Ok(()));
        while cells.has_next() {
            let Some(&column) = self.plan.columns.get(place) else { return Err(RejectedRow::Fields) };
            place += 1;
            if let ColumnUse::Channel(slot) = column
                && let Some(number) = cells.next_number()
            {
                self.take_number(slot, &number);
                continue;
            }
            let cell = cells.next().unwrap_or_default();
            outcome = outcome.and(match column {
                ColumnUse::Channel(slot) => self.take_cell(slot, &cell),
                ColumnUse::Stamp(form) => added(stamp_ns, form.nanoseconds(&cell)).map(|sum| stamp_ns = Some(sum)),
                ColumnUse::DeviceTime => {
                    self.device_ns = device_ns(&cell);
                    self.device_ns.map(drop).ok_or(RejectedRow::Stamp)
                }
                ColumnUse::OtherStream => {
                    holds_others |= Number::parse(&cell).is_some();
                    Ok(())
                }
                ColumnUse::Ignored | ColumnUse::Sentence => Ok(()),
            });
        }
        if place < self.plan.columns.len() {
            return Err(RejectedRow::Fields);
        }
        outcome?;
        if self.absent.len() >= self.counts.len() {
            let are_elsewhere = holds_others && self.absent.iter().all(|(_, absence)| *absence != Absence::OutOfRange);
            return if are_elsewhere { Ok(false) } else { Err(RejectedRow::Number) };
        }
        self.absent.sort_unstable_by_key(|(slot, _)| *slot);
        self.stamp_ns = stamp_ns.map(|stamp_ns| self.since_first(stamp_ns)).transpose()?;
        Ok(true)
    }

    #[inline]
    fn take_number(&mut self, slot: usize, number: &Number) {
        let quantizer = &mut self.plan.quantizers[slot];
        let count = quantizer.count(number);
        self.counts[slot] = count.unwrap_or_default();
        if count.is_none() {
            self.absent.push((slot, Absence::OutOfRange));
        } else if quantizer.rounds(number) {
            quantizer.is_rounded = true;
            let channel = self.plan.layout.as_ref().map(|layout| layout.channels[slot].name.to_string());
            self.counted.report.rounded.extend(channel);
        }
    }

    /// Reads a field that is no bare number.
    fn take_cell(&mut self, slot: usize, cell: &[u8]) -> Result<(), RejectedRow> {
        if let Some(number) = Number::parse(cell) {
            self.take_number(slot, &number);
            return Ok(());
        }
        let word = cell.strip_prefix(b"-").or(cell.strip_prefix(b"+")).unwrap_or(cell);
        let says_none = |text: &[u8]| NO_NUMBERS.iter().any(|none| text.eq_ignore_ascii_case(none.as_bytes()));
        let absence = match cell {
            b"" => Absence::Empty,
            _ if says_none(cell) || says_none(word) => Absence::NotANumber,
            _ => return Err(RejectedRow::Number),
        };
        self.counts[slot] = 0;
        self.absent.push((slot, absence));
        Ok(())
    }

    /// Reads the sentence and the stamp of a row.
    fn sentence(&mut self, line: &[u8]) -> Result<(), RejectedRow> {
        let row = SentenceRow::of(line).ok_or(RejectedRow::Fields)?;
        self.sentence.clear();
        self.sentence.extend_from_slice(row.sentence);
        self.sentence.extend_from_slice(b"\r\n");
        let mut stamp_ns = None;
        let cells = match self.plan.has_prefix_stamps {
            true => vec![row.prefix().into()],
            false => row.cells(self.plan.dialect.separator).0,
        };
        if cells.len() > self.plan.columns.len() {
            return Err(RejectedRow::Fields);
        }
        for (place, column) in self.plan.columns.iter().enumerate() {
            if let ColumnUse::Stamp(form) = column {
                let cell = cells.get(place).ok_or(RejectedRow::Fields)?;
                stamp_ns = Some(added(stamp_ns, form.nanoseconds(cell))?);
            }
        }
        self.stamp_ns = stamp_ns.map(|stamp_ns| self.since_first(stamp_ns)).transpose()?;
        Ok(())
    }

    /// Whether a line that is no row names the columns again, as after a restart of a logger; the
    /// columns of the next rows are then in its order. A line that names other columns ends the
    /// table.
    #[cold]
    fn is_header(&mut self, number: u64, text: &[u8]) -> bool {
        let names: Vec<String> = fields(text, self.plan.dialect.separator).map(|field| shown(&field)).collect();
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
        if let Some(mut columns) = named.filter(|named| named.len() == self.plan.names.len()) {
            columns.resize(self.plan.columns.len(), ColumnUse::Ignored);
            (self.plan.columns, self.plan.names) = (columns, names);
            return true;
        }
        let is_known = |name: &&String| Meaning::of(name, None).is_some_and(|meaning| meaning.is_sure);
        if names.iter().filter(is_known).count() >= 2 {
            self.other_table = Some(number);
        }
        false
    }

    /// The time since the first good row.
    #[inline]
    fn since_first(&mut self, stamp_ns: i64) -> Result<i64, RejectedRow> {
        let stamp_ns = match self.plan.date {
            Some(form) => form.after(self.last_stamp_ns, stamp_ns),
            None => stamp_ns,
        };
        self.last_stamp_ns = Some(stamp_ns);
        let first_ns = *self.first_stamp_ns.get_or_insert(stamp_ns);
        stamp_ns.checked_sub(first_ns).ok_or(RejectedRow::Stamp)
    }
}

/// The sum of the parts of a stamp so far and the next part.
#[inline]
fn added(sum: Option<i64>, part_ns: Option<i64>) -> Result<i64, RejectedRow> {
    part_ns.and_then(|part_ns| sum.unwrap_or_default().checked_add(part_ns)).ok_or(RejectedRow::Stamp)
}

//! The rows of a CSV file, read in sequence according to its plan.

use std::mem;

use vn100_protocol::stream::{CsvReport, RejectedRow};

use super::{
    ColumnUse, CsvPlan, Kind,
    cells::{Cells, added},
    fields::FieldCutter,
    lines::{Completeness, CsvLine, is_comment_or_blank},
    name::Meaning,
    number::Number,
    row_counts::{Absence, RowCounts},
    shown,
    stamped_sentences::stamp_and_sentence,
};

/// Reads the rows of a CSV file in sequence. The [`Kind`] of the plan determines whether `counts`
/// or `sentence` is used.
pub(super) struct RowParser {
    pub(super) plan: CsvPlan,
    fields: FieldCutter,
    /// The counts of the last valid row, in the order of the layout; 0 for a missing channel.
    pub(super) counts: Vec<i32>,
    /// The numbers of the last row, with the missing channels, in order.
    pub(super) cells: Cells,
    /// Whether the last row has numbers of other streams only.
    is_of_others: bool,
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
            cells: Cells::new(channels),
            is_of_others: false,
            sentence: Vec::new(),
            stamp_ns: None,
            first_stamp_ns: None,
            last_stamp_ns: None,
            other_table: None,
            quote_open: false,
            counted: RowCounts::new(&plan),
            plan,
        }
    }

    /// The counts of the lines so far.
    pub(super) fn report(&self) -> CsvReport {
        CsvReport { first_stamp_ns: self.first_stamp_ns, ..self.counted.report(&self.plan) }
    }

    /// Reads a line; `None` if it is no row, or a row of another stream.
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
            Ok(()) => self.counted.accept(line, &self.cells.absent),
            Err(reason) => self.counted.reject(reason, line),
        }
        Some(row)
    }

    #[inline]
    fn is_skipped(&mut self, line: &CsvLine<'_>) -> bool {
        if line.number <= self.plan.lines_above || is_comment_or_blank(line.text) {
            return true;
        }
        // a script saved a sentence together with its CR LF
        mem::take(&mut self.quote_open) && line.text.trim_ascii_start().starts_with(b"\"")
    }

    /// Whether a row without a line end is complete, as far as it can be determined.
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
        let Self { plan, fields, counts, counted, cells, .. } = self;
        let stamp = cells.read(line.text, plan, fields)?;
        let Cells { numbers, absent, holds_others, .. } = cells;
        for (slot, (number, quantizer)) in numbers.iter().zip(&plan.quantizers).enumerate() {
            let count = number.as_ref().and_then(|number| quantizer.count(number));
            counts[slot] = count.unwrap_or_default();
            match (number, count) {
                (Some(number), Some(_)) => counted.late_rounded[slot] |= quantizer.rounds(number),
                (Some(_), None) => absent.push((slot, Absence::OutOfRange)),
                // the reason is in the list already
                (None, _) => {}
            }
        }
        if absent.len() >= numbers.len() {
            self.is_of_others = *holds_others && numbers.iter().all(Option::is_none);
            return Err(RejectedRow::Number);
        }
        absent.sort_unstable_by_key(|(slot, _)| *slot);
        stamp.map(|stamp_ns| self.since_first(stamp_ns)).transpose()
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

    /// Whether a line that is no row names the columns again, as after a restart of a logger; the
    /// columns of the next rows are then in its order. A line that names other columns ends the
    /// table.
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
        self.last_stamp_ns = Some(stamp_ns);
        let first_ns = *self.first_stamp_ns.get_or_insert(stamp_ns);
        stamp_ns.checked_sub(first_ns).ok_or(RejectedRow::Stamp)
    }
}

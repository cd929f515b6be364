//! The rows of a CSV file as batches of samples, some hundred at a time. Each line is counted as a row, a
//! rejected row, a row of another stream, or no row.

use std::{
    io::{self, Read},
    mem,
    sync::Arc,
};

use vn100_protocol::{
    Tally,
    stream::{Batch, CsvReport, FileReport, ReadOptions, RejectedRow, RejectedRowCounts, RejectedRows, SampleReader},
};

use super::{
    ColumnUse, CsvPlan,
    fields::fields,
    lines::{Completeness, CsvLine, Lines, is_comment_or_blank},
    name::Meaning,
    number::Number,
    sentence_rows::SentenceRow,
    shown,
    stamp::{StampForm, device_ns},
};
use crate::{
    read_samples::{Event, FileReader},
    rows_of_samples::{Absence, NumberRows, RowSamples},
};

/// Rows in one batch, accepted or rejected.
const MOST_ROWS: usize = 512;

/// Texts that scripts write in place of a missing number, in lower case.
const NO_NUMBERS: [&str; 18] = [
    "nan", "inf", "infinity", "null", "none", "na", "n/a", "-", "--", // spreadsheets, pandas, C of Windows
    "#n/a", "#num!", "#value!", "#div/0!", "<na>", "nan(ind)", "1.#ind", "1.#qnan", "1.#inf",
];

/// Reads the samples of a CSV file, some hundred rows at a time.
pub(crate) struct CsvReader<R> {
    lines: Lines<R>,
    rows: Rows,
}

/// The rows that were read, according to the plan.
struct Rows {
    plan: CsvPlan,
    samples: RowSamples,
    clock: RowClock,
    line_by_line: bool,
    /// The line in which a table with other columns begins.
    other_table: Option<u64>,
    report: CsvReport,
    /// The bytes of all lines, line ends included, and the rejected rows.
    tally: Tally,
    rejected: RejectedRowCounts,
}

/// The stamps of the rows, as written.
struct RowClock {
    /// Their form, if there are any.
    form: Option<StampForm>,
    first_ns: Option<i64>,
    last_ns: Option<i64>,
}

impl RowClock {
    /// The time since the first good row; negative if a clock was set back.
    #[inline]
    fn since_first(&mut self, stamp_ns: i64) -> Result<i64, RejectedRow> {
        let stamp_ns = self.form.map_or(stamp_ns, |form| form.after(self.last_ns, stamp_ns));
        self.last_ns = Some(stamp_ns);
        let first_ns = *self.first_ns.get_or_insert(stamp_ns);
        stamp_ns.checked_sub(first_ns).ok_or(RejectedRow::Stamp)
    }
}

/// A row that is not rejected.
#[derive(PartialEq, Eq)]
enum Row {
    Sample,
    OfOtherStream,
}

impl<R: Read> CsvReader<R> {
    /// Reads `reader` from the first byte of the file on.
    pub(crate) fn new(mut plan: CsvPlan, reader: R, options: ReadOptions) -> Self {
        let form = |column: &ColumnUse| if let ColumnUse::Stamp(form) = column { Some(*form) } else { None };
        let rows = Rows {
            clock: RowClock { form: plan.columns.iter().find_map(form), first_ns: None, last_ns: None },
            samples: match &plan.layout {
                Some(layout) => RowSamples::Numbers(NumberRows::new(Arc::clone(layout))),
                None => RowSamples::Sentences(SampleReader::new(options)),
            },
            line_by_line: options.line_by_line,
            other_table: None,
            report: mem::take(&mut plan.report),
            tally: Tally::default(),
            rejected: RejectedRowCounts::default(),
            plan,
        };
        Self { lines: Lines::new(reader, rows.plan.line_end), rows }
    }
}

impl<R: Read + Send + 'static> FileReader for CsvReader<R> {
    /// Up to 512 rows; fewer if the next rows would require waiting.
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let Self { lines, rows } = self;
        let mut batches = Vec::new();
        let mut row_count = 0;
        while row_count == 0 {
            if let Some(line) = rows.other_table {
                let text =
                    format!("line {line} begins a table with other columns: it and the lines after it are not read");
                return Err(io::Error::other(text));
            }
            while row_count < MOST_ROWS
                && rows.other_table.is_none()
                && let Some(line) = lines.next_buffered()
            {
                let Some(is_sample) = rows.take(&line) else { continue };
                row_count += 1;
                if is_sample && rows.line_by_line {
                    batches.extend(rows.take_batches());
                }
            }
            if row_count == 0 && !lines.fill()? {
                return Ok(None);
            }
        }
        batches.extend(rows.take_batches());
        Ok(Some(batches.into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        let batches = self.rows.samples.finish();
        (self.rows.complete(batches), Some(self.rows.report()))
    }
}

impl Rows {
    /// Reads a line: whether it is a sample or is rejected; `None` if it is no row, or a row of another
    /// stream.
    #[inline]
    fn take(&mut self, line: &CsvLine<'_>) -> Option<bool> {
        let text = &*self.plan.dialect.tidy(line.text);
        self.report.lines += 1;
        let row = match line.completeness {
            Completeness::Overlong => Err(RejectedRow::Length),
            _ if self.is_skipped(line.number, text) => {
                // scripts that append to a table put a # before the names of the columns again
                if let Some(names) =
                    text.trim_ascii_start().strip_prefix(b"#").filter(|_| line.number > self.plan.lines_above)
                {
                    self.is_header(line.number, names);
                    // a note that mentions two columns begins no table
                    if fields(names, self.plan.dialect.separator).count() != self.plan.names.len() {
                        self.other_table = None;
                    }
                }
                return self.skip(line);
            }
            Completeness::Unended if !self.ends_whole(text) => Err(RejectedRow::Truncated),
            _ if self.holds_sentences() => self.take_sentence(text),
            _ => self.take_numbers(line.number, text),
        };
        match row {
            Ok(Row::Sample) => {
                self.report.rows += 1;
                self.tally.valid_sentence_bytes += line.bytes;
            }
            Ok(Row::OfOtherStream) => {
                *self.report.other_stream_rows.get_or_insert_default() += 1;
                self.tally.skipped_bytes += line.bytes;
                return None;
            }
            Err(_) if self.is_header(line.number, text) => return self.skip(line),
            Err(reason) => self.reject(reason, line),
        }
        Some(row.is_ok())
    }

    #[inline]
    fn is_skipped(&self, number: u64, text: &[u8]) -> bool {
        // a script saved a sentence together with its CR LF: this is the rest of the row
        let is_rest = || text.trim_ascii_start().starts_with(b"\"") && SentenceRow::of(text).is_none();
        number <= self.plan.lines_above || is_comment_or_blank(text) || self.holds_sentences() && is_rest()
    }

    const fn holds_sentences(&self) -> bool {
        matches!(self.samples, RowSamples::Sentences(_))
    }

    fn skip(&mut self, line: &CsvLine<'_>) -> Option<bool> {
        self.report.skipped_lines += 1;
        self.tally.skipped_bytes += line.bytes;
        None
    }

    #[cold]
    fn reject(&mut self, reason: RejectedRow, line: &CsvLine<'_>) {
        self.rejected.count(reason);
        self.tally.rejected_sentence_bytes += line.bytes;
        let tally = &mut self.tally.rejected;
        *match reason {
            RejectedRow::Length => &mut tally.too_long,
            RejectedRow::Truncated => &mut tally.truncated,
            RejectedRow::Fields | RejectedRow::Number | RejectedRow::Stamp => &mut tally.grammar,
        } += 1;
        let rejected = &mut self.report.rejected;
        let at = rejected.binary_search_by_key(&reason, |rows| rows.reason).unwrap_or_else(|at| {
            let first = RejectedRows { reason, count: 0, first_line: line.number, first_text: shown(line.text) };
            rejected.insert(at, first);
            at
        });
        rejected[at].count += 1;
        self.samples.mark_rejected_row();
    }

    /// Whether a row without a line end is complete, as far as it can be determined; of the fields of a
    /// sentence its checksum tells.
    #[cold]
    fn ends_whole(&self, row: &[u8]) -> bool {
        let cells = || fields(row, self.plan.dialect.separator).collect::<Vec<_>>();
        match self.holds_sentences() {
            true => SentenceRow::of(row).is_none_or(|row| row.is_last()),
            false => self.plan.row_end.is_none_or(|end| end.is_whole(&cells())),
        }
    }

    /// Reads the counts and the stamp of a row. A value that is absent has no effect on the other
    /// channels.
    #[inline]
    fn take_numbers(&mut self, number: u64, line: &[u8]) -> Result<Row, RejectedRow> {
        let RowSamples::Numbers(rows) = &mut self.samples else { return Err(RejectedRow::Fields) };
        rows.begin();
        let mut cells = fields(line, self.plan.dialect.separator);
        let (mut place, mut stamp_ns, mut time_ns, mut holds_others, mut outcome) = (0, None, None, false, Ok(()));
        while cells.rest.is_some() {
            let column = self.plan.columns.get(place).copied();
            place += 1;
            if let Some(ColumnUse::Channel(slot)) = column
                && let Some(number) = cells.next_number()
            {
                rows.set(slot, self.plan.count(slot, &number, &mut self.report));
                continue;
            }
            let cell = cells.next().unwrap_or_default();
            outcome = outcome.and(match column {
                Some(ColumnUse::Channel(slot)) => {
                    let count = match Number::parse(&cell) {
                        Some(number) => Ok(self.plan.count(slot, &number, &mut self.report)),
                        None => no_number(&cell).map(Err),
                    };
                    count.map(|count| rows.set(slot, count))
                }
                Some(ColumnUse::Stamp(form)) => {
                    added(stamp_ns, form.nanoseconds(&cell)).map(|sum| stamp_ns = Some(sum))
                }
                Some(ColumnUse::DeviceTime) => {
                    time_ns = device_ns(&cell);
                    time_ns.map(drop).ok_or(RejectedRow::Stamp)
                }
                Some(ColumnUse::OtherStream) => {
                    holds_others |= Number::parse(&cell).is_some();
                    Ok(())
                }
                Some(ColumnUse::Ignored | ColumnUse::Sentence) => Ok(()),
                None if cell.is_empty() => Ok(()),
                None => return Err(RejectedRow::Fields),
            });
        }
        if place < self.plan.fewest_fields {
            return Err(RejectedRow::Fields);
        }
        outcome?;
        if rows.is_blank() {
            let are_elsewhere = holds_others && rows.absent.iter().all(|(_, absence)| *absence != Absence::OutOfRange);
            return if are_elsewhere { Ok(Row::OfOtherStream) } else { Err(RejectedRow::Number) };
        }
        let stamp_ns = stamp_ns.map(|stamp_ns| self.clock.since_first(stamp_ns)).transpose()?;
        rows.push(stamp_ns, time_ns, number);
        Ok(Row::Sample)
    }

    /// Gives the sentence of a row to the decoder, with its stamp.
    fn take_sentence(&mut self, line: &[u8]) -> Result<Row, RejectedRow> {
        let row = SentenceRow::of(line).ok_or(RejectedRow::Fields)?;
        let cells = match self.plan.has_prefix_stamps {
            true => vec![row.prefix().into()],
            false => row.cells(self.plan.dialect.separator).0,
        };
        if cells.len() > self.plan.columns.len() {
            return Err(RejectedRow::Fields);
        }
        let mut stamp_ns = None;
        for (place, column) in self.plan.columns.iter().enumerate() {
            if let ColumnUse::Stamp(form) = column {
                let cell = cells.get(place).ok_or(RejectedRow::Fields)?;
                stamp_ns = Some(added(stamp_ns, form.nanoseconds(cell))?);
            }
        }
        let stamp_ns = stamp_ns.map(|stamp_ns| self.clock.since_first(stamp_ns)).transpose()?;
        if let RowSamples::Sentences(reader) = &mut self.samples {
            reader.push(&[row.sentence, b"\r\n"].concat(), stamp_ns);
        }
        Ok(Row::Sample)
    }

    /// Whether a line that is no row names the columns again, as after a restart of a logger; the
    /// columns of the next rows are then in its order. A line that names other columns ends the
    /// table.
    #[cold]
    fn is_header(&mut self, number: u64, text: &[u8]) -> bool {
        let plan = &mut self.plan;
        let names: Vec<String> = fields(text, plan.dialect.separator).map(|field| shown(&field)).collect();
        let is_number = |name: &String| Number::parse(name.as_bytes()).is_some();
        if plan.names.is_empty() || names.len() < 2 || names.iter().any(is_number) {
            return false;
        }
        let mut free: Vec<(&String, ColumnUse)> = plan.names.iter().zip(plan.columns.iter().copied()).collect();
        let place = |name: &String| {
            let at = free.iter().position(|(other, _)| *other == name)?;
            Some(free.remove(at).1)
        };
        let named = names.iter().take(plan.names.len()).map(place).collect::<Option<Vec<_>>>();
        if let Some(mut columns) = named.filter(|named| named.len() == plan.names.len()) {
            columns.resize(plan.columns.len(), ColumnUse::Ignored);
            (plan.columns, plan.names) = (columns, names);
            return true;
        }
        let is_known = |name: &&String| Meaning::of(name, None).is_some_and(|meaning| meaning.is_sure);
        if names.iter().filter(is_known).count() >= 2 {
            self.other_table = Some(number);
        }
        false
    }

    fn report(&self) -> FileReport {
        let (first_stamp_ns, absent) = (self.clock.first_ns, self.samples.absent());
        FileReport::Csv(CsvReport { first_stamp_ns, absent, ..self.report.clone() })
    }

    fn take_batches(&mut self) -> Vec<Batch> {
        let batches = self.samples.take_batches();
        self.complete(batches)
    }

    /// Adds the counts of everything that is no sample to the batches. The bytes of a row are all bytes
    /// of its line, including stamp, other columns and line end, even if its sentence is damaged.
    fn complete(&self, mut batches: Vec<Batch>) -> Vec<Batch> {
        let file = &self.tally;
        for batch in &mut batches {
            batch.report = self.line_by_line.then(|| self.report().into());
            let link = &mut batch.link;
            let tally = &mut link.tally;
            if !self.holds_sentences() {
                // a row of numbers carries no checksum
                (tally.samples, tally.unchecked_sentences) = (self.report.rows, self.report.rows);
            }
            tally.valid_sentence_bytes += file.valid_sentence_bytes.saturating_sub(tally.bytes());
            tally.rejected_sentence_bytes += file.rejected_sentence_bytes;
            tally.skipped_bytes += file.skipped_bytes;
            tally.rejected.too_long += file.rejected.too_long;
            tally.rejected.truncated += file.rejected.truncated;
            tally.rejected.grammar += file.rejected.grammar;
            link.rejected_rows = Some(self.rejected);
        }
        batches
    }
}

impl CsvPlan {
    /// The count of a number of the channel in this place of the layout.
    #[inline]
    fn count(&mut self, channel: usize, number: &Number, report: &mut CsvReport) -> Result<i32, Absence> {
        let quantizer = &mut self.quantizers[channel];
        let count = quantizer.count(number);
        if count.is_some() && quantizer.rounds(number) {
            quantizer.is_rounded = true;
            report.rounded.extend(self.layout.as_ref().map(|layout| layout.channels[channel].name.to_string()));
        }
        count.ok_or(Absence::OutOfRange)
    }
}

/// Why a field that is no number has none.
fn no_number(cell: &[u8]) -> Result<Absence, RejectedRow> {
    let word = cell.strip_prefix(b"-").or(cell.strip_prefix(b"+")).unwrap_or(cell);
    let says_none = |text: &[u8]| NO_NUMBERS.iter().any(|none| text.eq_ignore_ascii_case(none.as_bytes()));
    match cell {
        b"" => Ok(Absence::Empty),
        _ if says_none(cell) || says_none(word) => Ok(Absence::NotANumber),
        _ => Err(RejectedRow::Number),
    }
}

/// The sum of the parts of a stamp so far and the next part.
#[inline]
fn added(sum: Option<i64>, part_ns: Option<i64>) -> Result<i64, RejectedRow> {
    part_ns.and_then(|part_ns| sum.unwrap_or_default().checked_add(part_ns)).ok_or(RejectedRow::Stamp)
}

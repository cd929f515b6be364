//! The rows of a CSV file, read as its plan says, and batches of samples made of them.

use std::{
    io::{self, Read},
    mem,
    sync::Arc,
};

use vn100_protocol::{
    Layout, Tally,
    stream::{
        AbsentCell, AbsentValues, Arrival, Batch, CsvReport, FileReport, Mark, MarkKind, ReadOptions, RejectedRow,
        RejectedRowCounts, RejectedRows, SampleReader,
    },
};

use super::{
    ColumnUse, CsvPlan, Kind,
    lines::{
        Completeness, CsvLine, Fields, Lines, field_end, has_open_quote, is_comment_or_blank, opening_quote, unquoted,
    },
    number::Number,
    resolution::{ColumnScan, Scanned},
    shown,
    stamp::StampForm,
};
use crate::read_samples::{Event, FileReader};

/// Rows in one batch, accepted or rejected.
const MOST_ROWS: usize = 512;

/// Reads the samples of a CSV file, some hundred rows at a time.
pub(crate) struct CsvReader<R> {
    /// Until all rows have shown what the columns print.
    first_pass: Option<FirstPass<R>>,
    lines: Lines<R>,
    parser: RowParser,
    line_by_line: bool,
    content: Content,
}

/// The file from its beginning, and what its columns have printed so far.
struct FirstPass<R> {
    lines: Lines<R>,
    scans: Vec<ColumnScan>,
}

/// What rows become.
#[expect(clippy::large_enum_variant, reason = "there is one for each file")]
enum Content {
    /// Numbers, already counts.
    Values { layout: Arc<Layout>, open: Batch },
    /// Sentences, to be decoded.
    Sentences(SampleReader),
}

impl<R: Read> CsvReader<R> {
    /// Reads `reader` from the first byte of the file on. Where `again` reads the same, it is read
    /// first: what a count is worth depends on all rows.
    pub(crate) fn new(plan: CsvPlan, reader: R, again: Option<R>, options: ReadOptions) -> Self {
        let content = match plan.layout() {
            Some(layout) => Content::Values { layout: Arc::new(layout), open: Batch::default() },
            None => Content::Sentences(SampleReader::new(options)),
        };
        let scans = vec![ColumnScan::default(); plan.priors.len()];
        let again = again.filter(|_| plan.layout().is_some());
        Self {
            first_pass: again.map(|again| FirstPass { lines: Lines::new(again, plan.line_end), scans }),
            lines: Lines::new(reader, plan.line_end),
            parser: RowParser::new(plan),
            line_by_line: options.line_by_line,
            content,
        }
    }

    /// Reads on in the first pass, and ends it where the file does, or cannot be read: then so does
    /// the second one.
    fn scan(&mut self) {
        let Some(FirstPass { lines, scans }) = &mut self.first_pass else { return };
        if lines.fill().unwrap_or(false) {
            while let Some(line) = lines.next_buffered() {
                self.parser.scan(&line, scans);
            }
            return;
        }
        self.parser.plan.quantize(scans, Scanned::Whole);
        if let (Content::Values { layout, .. }, Some(quantized)) = (&mut self.content, self.parser.plan.layout()) {
            *layout = Arc::new(quantized);
        }
        self.first_pass = None;
    }
}

impl<R: Read + Send + 'static> FileReader for CsvReader<R> {
    /// Up to 512 rows, fewer where more would have to be waited for.
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        if self.first_pass.is_some() {
            self.scan();
            return Ok(Some(Vec::new()));
        }
        let Self { lines, parser, line_by_line, content, .. } = self;
        let mut batches = Vec::new();
        let mut row_count = 0;
        while row_count == 0 {
            while row_count < MOST_ROWS
                && let Some(line) = lines.next_buffered()
            {
                let Some(row) = parser.push(&line) else { continue };
                row_count += 1;
                match row {
                    Ok(()) => content.push(parser),
                    Err(_) => content.mark_rejected(),
                }
                if row.is_ok() && *line_by_line {
                    batches.extend(content.take_batches(parser));
                }
            }
            if row_count == 0 && !lines.fill()? {
                return Ok(None);
            }
        }
        batches.extend(content.take_batches(parser));
        Ok(Some(batches.into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        let batches = match &mut self.content {
            Content::Sentences(samples) => self.parser.complete(samples.finish()),
            values => values.take_batches(&self.parser),
        };
        (batches, Some(FileReport::Csv(self.parser.report())))
    }
}

impl Content {
    fn push(&mut self, row: &RowParser) {
        match self {
            Self::Values { layout, open } => {
                let from_row = open.counts.len() / layout.channels.len();
                open.arrivals.extend(row.stamp_ns.map(|at_ns| Arrival { from_row, at_ns }));
                open.counts.extend_from_slice(&row.counts);
                let cell = |&(channel, _): &(usize, Absence)| AbsentCell { row: from_row, channel };
                open.absent.extend(row.absent.iter().map(cell));
            }
            Self::Sentences(samples) => samples.push(&row.sentence, row.stamp_ns),
        }
    }

    fn mark_rejected(&mut self) {
        match self {
            Self::Values { layout, open } => {
                let before_row = open.counts.len() / layout.channels.len();
                open.marks.push(Mark { before_row, kind: MarkKind::Rejected });
            }
            Self::Sentences(samples) => samples.mark_rejected_row(),
        }
    }

    fn take_batches(&mut self, parser: &RowParser) -> Vec<Batch> {
        parser.complete(match self {
            Self::Values { layout, open } => {
                let mut batch = mem::take(open);
                batch.layout = Some(Arc::clone(layout));
                batch.link.tally.samples = parser.report.rows;
                // a row of numbers carries no checksum
                batch.link.tally.unchecked_sentences = parser.report.rows;
                vec![batch]
            }
            Self::Sentences(samples) => samples.take_batches(),
        })
    }
}

/// Reads the rows of a CSV file one after the other. Of `counts` and `sentence` one is in use, by
/// the [`Kind`] of the plan.
pub(super) struct RowParser {
    pub(super) plan: CsvPlan,
    /// Of the last good row, in the order of the layout; 0 for what it lacks.
    pub(super) counts: Vec<i32>,
    /// The channels that the last good row lacks, in order.
    pub(super) absent: Vec<(usize, Absence)>,
    /// How often each channel was absent.
    absences: Vec<AbsentValues>,
    /// The channels of which digits were rounded away that the head of the file does not have.
    late_rounded: Vec<bool>,
    /// The numbers of a row.
    cells: Vec<Option<Number>>,
    /// The last row has a number in a column of another stream.
    holds_others: bool,
    /// The last row has no number but such.
    is_of_others: bool,
    /// Of the last good row, with CR LF.
    pub(super) sentence: Vec<u8>,
    /// Of the last good row, in nanoseconds since the first; negative where a clock was set back.
    pub(super) stamp_ns: Option<i64>,
    first_stamp_ns: Option<i64>,
    /// As written.
    last_stamp_ns: Option<i64>,
    /// The last row ended inside quotes: the next line may be what is left of it.
    quote_open: bool,
    pub(super) report: CsvReport,
    /// The bytes of all lines, line ends included, and the rejected rows.
    pub(super) tally: Tally,
    rejected: RejectedRowCounts,
}

impl RowParser {
    pub(super) fn new(plan: CsvPlan) -> Self {
        let ignored_columns = plan.ignored_columns.clone();
        let channels = plan.priors.len();
        Self {
            counts: vec![0; channels],
            absent: Vec::new(),
            absences: vec![AbsentValues::default(); channels],
            late_rounded: vec![false; channels],
            cells: vec![None; channels],
            holds_others: false,
            is_of_others: false,
            sentence: Vec::new(),
            stamp_ns: None,
            first_stamp_ns: None,
            last_stamp_ns: None,
            quote_open: false,
            report: CsvReport {
                ignored_columns,
                times: plan.times.clone(),
                other_stream_rows: plan.columns.contains(&ColumnUse::OtherStream).then_some(0),
                ..CsvReport::default()
            },
            tally: Tally::default(),
            rejected: RejectedRowCounts::default(),
            plan,
        }
    }

    /// What has become of the lines so far.
    pub(super) fn report(&self) -> CsvReport {
        let Some(layout) = self.plan.layout() else { return self.report.clone() };
        let mut rounded = self.plan.rounded();
        let late = layout.channels.iter().zip(&self.late_rounded).filter(|(_, late)| **late);
        rounded.extend(late.map(|(channel, _)| channel.name.to_string()));
        let absences = layout.channels.iter().zip(&self.absences).filter(|(_, absences)| absences.total() > 0);
        let absent =
            absences.map(|(channel, absences)| AbsentValues { channel: channel.name.to_string(), ..absences.clone() });
        CsvReport { rounded, absent: absent.collect(), ..self.report.clone() }
    }

    /// Adds the numbers of a line to what is known of their columns.
    pub(super) fn scan(&mut self, line: &CsvLine<'_>, scans: &mut [ColumnScan]) {
        for (scan, number) in scans.iter_mut().zip(self.numbers(line).into_iter().flatten()) {
            if let Some(number) = number {
                scan.add(number);
            }
        }
    }

    /// The numbers of a line, where it is a good row.
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

    /// Reads a line; `None` where it is no row, or one of another stream.
    #[inline]
    pub(super) fn push(&mut self, line: &CsvLine<'_>) -> Option<Result<(), RejectedRow>> {
        let text = self.plan.dialect.tidy(line.text);
        let line = &CsvLine { text: &text, ..*line };
        self.report.lines += 1;
        if line.completeness != Completeness::Overlong && self.is_skipped(line) {
            self.report.skipped_lines += 1;
            self.tally.skipped_bytes += line.bytes;
            return None;
        }
        let row = match line.completeness {
            Completeness::Overlong => Err(RejectedRow::Length),
            Completeness::Unended if !self.ends_whole(line.text) => Err(RejectedRow::Truncated),
            Completeness::Unended | Completeness::Whole => self.row(line.text),
        };
        if mem::take(&mut self.is_of_others) {
            *self.report.other_stream_rows.get_or_insert_default() += 1;
            self.tally.skipped_bytes += line.bytes;
            return None;
        }
        match row {
            Ok(()) => {
                self.report.rows += 1;
                self.tally.valid_sentence_bytes += line.bytes;
                if !self.absent.is_empty() {
                    self.count_absent(line.number);
                }
            }
            Err(reason) => {
                self.count_rejected(reason, line);
            }
        }
        Some(row)
    }

    #[cold]
    fn count_absent(&mut self, line: u64) {
        for &(channel, absence) in &self.absent {
            let absences = &mut self.absences[channel];
            if absences.total() == 0 {
                absences.first_line = line;
            }
            *match absence {
                Absence::Empty => &mut absences.empty,
                Absence::NotANumber => &mut absences.not_a_number,
                Absence::OutOfRange => &mut absences.out_of_range,
            } += 1;
        }
    }

    #[cold]
    fn count_rejected(&mut self, reason: RejectedRow, line: &CsvLine<'_>) {
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
    }

    #[inline]
    fn is_skipped(&mut self, line: &CsvLine<'_>) -> bool {
        if line.number <= self.plan.lines_above || is_comment_or_blank(line.text) {
            return true;
        }
        // a script that saved a sentence together with its CR LF
        mem::take(&mut self.quote_open) && line.text.trim_ascii_start().starts_with(b"\"")
    }

    /// Adds to batches what the file holds beside their samples. All bytes of a row are those of
    /// its line: stamp, other columns and line end too, even where its sentence is damaged.
    fn complete(&self, mut batches: Vec<Batch>) -> Vec<Batch> {
        let file = &self.tally;
        for link in batches.iter_mut().map(|batch| &mut batch.link) {
            let tally = &mut link.tally;
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

    /// Whether a row without a line end is whole, as far as that can be known.
    #[cold]
    fn ends_whole(&self, row: &[u8]) -> bool {
        let Some(last_field) = self.plan.last_field else {
            return true;
        };
        let (count, last) = Fields::new(row, self.plan.dialect.separator).count_and_last();
        count == self.plan.columns.len() && last_field.is_whole(last)
    }

    #[inline]
    fn row(&mut self, line: &[u8]) -> Result<(), RejectedRow> {
        self.stamp_ns = match self.plan.kind {
            Kind::Values(_) => self.values(line).map_err(|reason| self.wrong_fields(line).unwrap_or(reason))?,
            Kind::Sentences => self.sentence(line)?,
        };
        Ok(())
    }

    /// Reads the counts of a row and returns its stamp. What a channel lacks costs no other one.
    #[inline]
    fn values(&mut self, line: &[u8]) -> Result<Option<i64>, RejectedRow> {
        let stamp = self.cells(line)?;
        let Self { plan, counts, absent, late_rounded, cells, .. } = self;
        for (slot, (cell, quantizer)) in cells.iter().zip(&plan.quantizers).enumerate() {
            let count = cell.as_ref().and_then(|number| quantizer.count(number));
            counts[slot] = count.unwrap_or_default();
            match (cell, count) {
                (Some(number), Some(_)) => late_rounded[slot] |= quantizer.rounds(number),
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
        let Self { plan, absent, cells, holds_others, .. } = self;
        absent.clear();
        *holds_others = false;
        let mut stamp = None;
        let mut rest = line;
        for (place, &column) in plan.columns.iter().enumerate() {
            if place > 0 {
                rest = rest.get(1..).ok_or(RejectedRow::Fields)?;
            }
            rest = match column {
                ColumnUse::Channel(slot) => match leading_number(rest, plan.dialect.separator) {
                    Some((number, rest)) => {
                        cells[slot] = Some(number);
                        rest
                    }
                    None => {
                        let (absence, rest) =
                            leading_absence(rest, plan.dialect.separator).ok_or(RejectedRow::Number)?;
                        cells[slot] = None;
                        absent.push((slot, absence));
                        rest
                    }
                },
                ColumnUse::Stamp(StampForm::Unit(unit)) | ColumnUse::StampPart(unit) => {
                    let (number, rest) = leading_number(rest, plan.dialect.separator).ok_or(RejectedRow::Stamp)?;
                    stamp = Some(added(stamp, unit.nanoseconds(&number))?);
                    rest
                }
                ColumnUse::Stamp(form @ StampForm::Clock(_)) => {
                    let end = field_end(rest, plan.dialect.separator);
                    stamp = Some(added(stamp, form.nanoseconds(unquoted(&rest[..end])))?);
                    &rest[end..]
                }
                ColumnUse::OtherStream => {
                    let number = leading_number(rest, plan.dialect.separator);
                    *holds_others |= number.is_some();
                    number.map_or_else(|| &rest[field_end(rest, plan.dialect.separator)..], |(_, rest)| rest)
                }
                ColumnUse::Ignored | ColumnUse::Sentence => &rest[field_end(rest, plan.dialect.separator)..],
            };
        }
        if rest.is_empty() { Ok(stamp) } else { Err(RejectedRow::Fields) }
    }

    /// Reads the sentence of a row and returns its stamp.
    fn sentence(&mut self, line: &[u8]) -> Result<Option<i64>, RejectedRow> {
        let mut stamp_fields = Vec::new();
        let mut sentence = None;
        let last = self.plan.columns.len() - 1;
        let mut rest = Some(line);
        for (place, &column) in self.plan.columns.iter().enumerate() {
            // behind an open quote the row continues in the next line
            let Some(begun) = rest.filter(|_| !self.quote_open) else {
                break;
            };
            let unquoted_tail = place == last && column == ColumnUse::Sentence && opening_quote(begun).is_none();
            let end = if unquoted_tail { begun.len() } else { field_end(begun, self.plan.dialect.separator) };
            let field = &begun[..end];
            rest = begun.get(end + 1..);
            self.quote_open = has_open_quote(field);
            match column {
                ColumnUse::Sentence => sentence = Some(unquoted(field)),
                ColumnUse::Stamp(form) => stamp_fields.push((unquoted(field), form)),
                ColumnUse::StampPart(unit) => stamp_fields.push((unquoted(field), StampForm::Unit(unit))),
                ColumnUse::Ignored | ColumnUse::Channel(_) | ColumnUse::OtherStream => {}
            }
        }
        let sentence = sentence.filter(|sentence| !sentence.is_empty() && rest.is_none()).ok_or(RejectedRow::Fields)?;
        if stamp_fields.is_empty() && self.plan.times.is_some() {
            return Err(RejectedRow::Fields);
        }
        let sum = |sum, &(field, form): &(&[u8], StampForm)| added(sum, form.nanoseconds(field)).map(Some);
        let stamp = stamp_fields.iter().try_fold(None, sum)?;
        let stamp_ns = stamp.map(|stamp_ns| self.since_first(stamp_ns)).transpose()?;
        self.sentence.clear();
        self.sentence.extend_from_slice(sentence);
        self.sentence.extend_from_slice(b"\r\n");
        Ok(stamp_ns)
    }

    /// The time since the first good row.
    #[inline]
    fn since_first(&mut self, stamp_ns: i64) -> Result<i64, RejectedRow> {
        let stamp_ns = match self.plan.clock {
            Some(form) => form.behind(self.last_stamp_ns, stamp_ns),
            None => stamp_ns,
        };
        let repeats = self.last_stamp_ns.replace(stamp_ns) == Some(stamp_ns);
        let behind_ns = self.plan.repeated_step_ns.filter(|_| repeats).unwrap_or_default();
        let first_ns = *self.first_stamp_ns.get_or_insert(stamp_ns);
        stamp_ns.checked_sub(first_ns).and_then(|ns| ns.checked_add(behind_ns)).ok_or(RejectedRow::Stamp)
    }

    /// A row with too many or too few fields is that before all else.
    #[cold]
    fn wrong_fields(&self, line: &[u8]) -> Option<RejectedRow> {
        let fields = Fields::new(line, self.plan.dialect.separator).count();
        (fields != self.plan.columns.len()).then_some(RejectedRow::Fields)
    }
}

/// A part of a stamp added to those before it.
#[inline]
fn added(sum: Option<i64>, part_ns: Option<i64>) -> Result<i64, RejectedRow> {
    part_ns.and_then(|part_ns| sum.unwrap_or_default().checked_add(part_ns)).ok_or(RejectedRow::Stamp)
}

/// The number in the field at the head of `rest`, and what follows the field.
#[inline]
fn leading_number(rest: &[u8], separator: u8) -> Option<(Number, &[u8])> {
    if let Some((number, length)) = Number::parse_prefix(rest)
        && rest.get(length).is_none_or(|&byte| byte == separator)
    {
        return Some((number, &rest[length..]));
    }
    // spaces or quotes
    let end = field_end(rest, separator);
    let number = Number::parse(unquoted(&rest[..end]))?;
    Some((number, &rest[end..]))
}

/// Why a row lacks a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Absence {
    Empty,
    NotANumber,
    OutOfRange,
}

/// What scripts write for no number, in lower case.
const NO_NUMBERS: [&str; 9] = ["nan", "inf", "infinity", "null", "none", "na", "n/a", "-", "--"];

/// Why there is no number in the field at the head of `rest`, and what follows the field; `None`
/// for a field that is damaged.
#[cold]
fn leading_absence(rest: &[u8], separator: u8) -> Option<(Absence, &[u8])> {
    let end = field_end(rest, separator);
    let field = unquoted(&rest[..end]);
    let word = field.strip_prefix(b"-").or(field.strip_prefix(b"+")).unwrap_or(field);
    let says_none = |text: &[u8]| NO_NUMBERS.iter().any(|none| text.eq_ignore_ascii_case(none.as_bytes()));
    match field {
        b"" => Some((Absence::Empty, &rest[end..])),
        _ if says_none(field) || says_none(word) => Some((Absence::NotANumber, &rest[end..])),
        _ => None,
    }
}

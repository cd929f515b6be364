//! The rows of a CSV file, some hundred at a time.

use std::io::{self, Read};

use vn100_protocol::stream::RejectedRow;

use super::{
    fields::{Fields, field_end, has_open_quote, is_comment_or_blank, opening_quote, unquoted},
    lines::{Line, Lines, State},
    number::{Misfit, Number},
    plan::{Column, Kind, Plan, Scale},
    shown,
    stamp::StampUnit,
};
use crate::event::{CsvReport, RejectedRows};

/// Rows handed over at once, accepted or rejected.
const MOST_ROWS: usize = 512;

/// Reads a CSV file as its plan says.
pub(crate) struct CsvReader<R> {
    lines: Lines<R>,
    parser: Parser,
}

/// Rows of a CSV file. Of `counts` and `sentences` one is in use, by the [`Kind`] of the plan.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Rows {
    /// Row after row, each with the channels in the order of the layout, in units of their last
    /// decimals.
    pub(crate) counts: Vec<i32>,
    /// The sentences one behind the other, each with CR LF.
    pub(crate) sentences: Vec<u8>,
    /// Where each sentence ends.
    pub(crate) sentence_ends: Vec<usize>,
    /// The stamp of each row, in nanoseconds since that of the first row of the file; negative
    /// where a clock was set back. Empty when the rows have no stamps.
    pub(crate) stamps_ns: Vec<i64>,
    /// The rejected rows, each with the number of good rows before it.
    pub(crate) rejected: Vec<(usize, RejectedRow)>,
    /// For each good row, the bytes of the file from its beginning to the end of the row.
    pub(crate) bytes: Vec<LineBytes>,
    /// The number of good rows.
    pub(crate) count: usize,
}

impl<R: Read> CsvReader<R> {
    /// Reads `reader` from the first byte of the file on.
    pub(crate) fn new(plan: Plan, reader: R) -> Self {
        Self {
            lines: Lines::new(reader, plan.line_end),
            parser: Parser {
                report: CsvReport {
                    ignored_columns: plan.ignored_columns.clone(),
                    rounded: plan.rounded.clone(),
                    ..CsvReport::default()
                },
                plan,
                first_stamp_ns: None,
                quote_open: false,
                bytes: LineBytes::default(),
            },
        }
    }

    /// Replaces `rows` by the next ones: up to 512, fewer where more would have to be waited for.
    /// `false` at the end of the file, with no rows.
    ///
    /// # Errors
    /// That of the reader; nothing is lost by it.
    pub(crate) fn next_rows(&mut self, rows: &mut Rows) -> io::Result<bool> {
        rows.clear();
        loop {
            while rows.count + rows.rejected.len() < MOST_ROWS {
                let Some(line) = self.lines.next_buffered() else {
                    break;
                };
                self.parser.line(&line, rows);
            }
            if rows.count + rows.rejected.len() > 0 {
                return Ok(true);
            }
            if !self.lines.fill()? {
                return Ok(false);
            }
        }
    }

    /// What became of the lines so far.
    pub(crate) fn report(&self) -> &CsvReport {
        &self.parser.report
    }

    /// The bytes of the lines so far.
    pub(crate) fn bytes(&self) -> LineBytes {
        self.parser.bytes
    }
}

impl Rows {
    /// The sentence of a row, with CR LF.
    pub(crate) fn sentence(&self, row: usize) -> &[u8] {
        let begin = row.checked_sub(1).map_or(0, |before| self.sentence_ends[before]);
        &self.sentences[begin..self.sentence_ends[row]]
    }

    fn clear(&mut self) {
        self.counts.clear();
        self.sentences.clear();
        self.sentence_ends.clear();
        self.stamps_ns.clear();
        self.rejected.clear();
        self.bytes.clear();
        self.count = 0;
    }
}

/// Bytes of the lines, line ends included.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct LineBytes {
    pub(crate) rows: u64,
    pub(crate) rejected: u64,
    pub(crate) skipped: u64,
}

struct Parser {
    plan: Plan,
    first_stamp_ns: Option<i64>,
    /// The last row ended inside quotes: the next line may be what is left of it.
    quote_open: bool,
    report: CsvReport,
    bytes: LineBytes,
}

impl Parser {
    #[inline]
    fn line(&mut self, line: &Line<'_>, rows: &mut Rows) {
        self.report.lines += 1;
        if line.state != State::Overlong && self.is_skipped(line) {
            self.report.skipped_lines += 1;
            self.bytes.skipped += line.bytes;
            return;
        }
        let row = match line.state {
            State::Overlong => Err(RejectedRow::Length),
            State::Unended if !self.ends_whole(line.text) => Err(RejectedRow::Truncated),
            State::Unended | State::Whole => self.row(line.text, rows),
        };
        match row {
            Ok(()) => {
                self.report.rows += 1;
                self.bytes.rows += line.bytes;
                rows.count += 1;
                rows.bytes.push(self.bytes);
            }
            Err(kind) => {
                self.bytes.rejected += line.bytes;
                rows.rejected.push((rows.count, kind));
                self.count_rejected(kind, line);
            }
        }
    }

    #[cold]
    fn count_rejected(&mut self, reason: RejectedRow, line: &Line<'_>) {
        let rejected = &mut self.report.rejected;
        let at = rejected.binary_search_by_key(&reason, |rows| rows.reason).unwrap_or_else(|at| {
            let first = RejectedRows { reason, count: 0, first_line: line.number, first_text: shown(line.text) };
            rejected.insert(at, first);
            at
        });
        rejected[at].count += 1;
    }

    #[inline]
    fn is_skipped(&mut self, line: &Line<'_>) -> bool {
        if line.number <= self.plan.lines_above || is_comment_or_blank(line.text) {
            return true;
        }
        // a script that saved a sentence together with its CR LF
        std::mem::take(&mut self.quote_open) && line.text.trim_ascii_start().starts_with(b"\"")
    }

    /// Whether a row without a line end is whole, as far as that can be known.
    #[cold]
    fn ends_whole(&self, row: &[u8]) -> bool {
        let Some(last_field) = self.plan.last_field else {
            return true;
        };
        let (count, last) = Fields::new(row, self.plan.separator).fold((0, &b""[..]), |(n, _), field| (n + 1, field));
        count == self.plan.columns.len() && last_field.is_whole(last)
    }

    /// Takes a row, or nothing of it.
    #[inline]
    fn row(&mut self, line: &[u8], rows: &mut Rows) -> Result<(), RejectedRow> {
        let stamp_ns = match self.plan.kind {
            Kind::Values(_) => {
                let begin = rows.counts.len();
                rows.counts.resize(begin + self.plan.scales.len(), 0);
                let row = self.values(line, &mut rows.counts[begin..]);
                if row.is_err() {
                    rows.counts.truncate(begin);
                }
                row.map_err(|kind| self.wrong_fields(line).unwrap_or(kind))?
            }
            Kind::Sentences => {
                let (stamp_ns, sentence) = self.sentence(line)?;
                rows.sentences.extend_from_slice(sentence);
                rows.sentences.extend_from_slice(b"\r\n");
                rows.sentence_ends.push(rows.sentences.len());
                stamp_ns
            }
        };
        rows.stamps_ns.extend(stamp_ns);
        Ok(())
    }

    /// Reads the counts of a row into `counts` and returns its stamp.
    #[inline]
    fn values(&mut self, line: &[u8], counts: &mut [i32]) -> Result<Option<i64>, RejectedRow> {
        let plan = &self.plan;
        let mut stamp = None;
        let mut rest = line;
        for (place, &column) in plan.columns.iter().enumerate() {
            if place > 0 {
                rest = rest.get(1..).ok_or(RejectedRow::Fields)?;
            }
            rest = match column {
                Column::Channel(slot) => {
                    let (number, rest) = leading_number(rest, plan.separator).ok_or(RejectedRow::Number)?;
                    counts[slot] = plan.scales[slot].count(&number)?;
                    rest
                }
                Column::Stamp(unit) => {
                    let (number, rest) = leading_number(rest, plan.separator).ok_or(RejectedRow::Stamp)?;
                    stamp = Some((number, unit));
                    rest
                }
                Column::Ignored | Column::Sentence => &rest[field_end(rest, plan.separator)..],
            };
        }
        if !rest.is_empty() {
            return Err(RejectedRow::Fields);
        }
        stamp.map(|(stamp, unit)| self.since_first(&stamp, unit)).transpose()
    }

    /// The stamp and the sentence of a row.
    fn sentence<'a>(&mut self, line: &'a [u8]) -> Result<(Option<i64>, &'a [u8]), RejectedRow> {
        let mut stamp = None;
        let mut sentence = None;
        let last = self.plan.columns.len() - 1;
        let mut rest = Some(line);
        for (place, &column) in self.plan.columns.iter().enumerate() {
            // behind an open quote the row continues in the next line
            let Some(begun) = rest.filter(|_| !self.quote_open) else {
                break;
            };
            let unquoted_tail = place == last && column == Column::Sentence && opening_quote(begun).is_none();
            let end = if unquoted_tail { begun.len() } else { field_end(begun, self.plan.separator) };
            let field = &begun[..end];
            rest = begun.get(end + 1..);
            self.quote_open = has_open_quote(field);
            match column {
                Column::Sentence => sentence = Some(unquoted(field)),
                Column::Stamp(unit) => stamp = Some((unquoted(field), unit)),
                Column::Ignored | Column::Channel(_) => {}
            }
        }
        let sentence = sentence.filter(|sentence| !sentence.is_empty() && rest.is_none()).ok_or(RejectedRow::Fields)?;
        let (stamp, unit) = stamp.ok_or(RejectedRow::Fields)?;
        let stamp = Number::parse(stamp).ok_or(RejectedRow::Stamp)?;
        Ok((Some(self.since_first(&stamp, unit)?), sentence))
    }

    /// The time since the first good row.
    #[inline]
    fn since_first(&mut self, stamp: &Number, unit: StampUnit) -> Result<i64, RejectedRow> {
        let stamp_ns = unit.nanoseconds(stamp).ok_or(RejectedRow::Stamp)?;
        let first_ns = *self.first_stamp_ns.get_or_insert(stamp_ns);
        stamp_ns.checked_sub(first_ns).ok_or(RejectedRow::Stamp)
    }

    /// A row with too many or too few fields is that before all else.
    #[cold]
    fn wrong_fields(&self, line: &[u8]) -> Option<RejectedRow> {
        let fields = Fields::new(line, self.plan.separator).count();
        (fields != self.plan.columns.len()).then_some(RejectedRow::Fields)
    }
}

impl Scale {
    #[inline]
    fn count(&self, number: &Number) -> Result<i32, RejectedRow> {
        let count = number
            .count(self.resolution.decimals, self.resolution.last_digit)
            .map_err(|misfit| match misfit {
                Misfit::Decimals => RejectedRow::Decimals,
                Misfit::Range => RejectedRow::Range,
            })?
            .saturating_sub(self.zero_counts);
        if count.unsigned_abs() > u64::from(self.limit_counts.unsigned_abs()) {
            return Err(RejectedRow::Range);
        }
        i32::try_from(count).map_err(|_| RejectedRow::Range)
    }
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

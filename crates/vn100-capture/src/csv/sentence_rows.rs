//! Rows that hold a whole sentence, beside stamps in other columns, or after a stamp that a terminal
//! program wrote: `1.5,"$VNYMR,...*63"`, `[2024-02-06 18:14:11.000] $VNYMR,...`.

use std::borrow::Cow;

use memchr::{memchr, memchr2, memmem};
use vn100_protocol::stream::CsvReport;

use super::{
    ColumnUse, CsvPlan, HEAD_ROWS, HeadRow, Said, Unusable,
    column_map::RAW,
    date_order,
    dialect::{Dialect, separator},
    fields::fields,
    header::Header,
    lines::is_comment_or_blank,
    number::Number,
    shown,
    stamp::{StampForm, unit_of},
    time_columns::{TimeSearch, argument},
};

/// With fewer rows, any text may stand before a sentence.
const FEWEST: usize = 3;

/// A row cut at its first sentence. The separators in a sentence do not separate columns.
pub(super) struct SentenceRow<'a> {
    before: &'a [u8],
    pub(super) sentence: &'a [u8],
    after: &'a [u8],
}

impl<'a> SentenceRow<'a> {
    /// `None` for a row without a sentence.
    pub(super) fn of(line: &'a [u8]) -> Option<Self> {
        let (before, rest) = line.split_at(memmem::find(line, b"$VN")?);
        let mut end = checked_part(rest).len();
        if end == rest.len() {
            end = memchr2(b'"', b'\'', rest).unwrap_or(end);
        }
        Some(Self { before, sentence: rest[..end].trim_ascii_end(), after: &rest[end..] })
    }

    /// The fields, the sentence among them, without empty ones at the end; and its place.
    pub(super) fn cells(&self, separator: u8) -> (Vec<Cow<'a, [u8]>>, usize) {
        let mut cells: Vec<_> = fields(self.before, separator).collect();
        // the last field before the sentence is what stands in front of it: a quote, or b'
        let place = cells.len() - 1;
        cells[place] = self.sentence.into();
        let after = memchr(separator, self.after).map(|end| fields(&self.after[end + 1..], separator));
        cells.extend(after.into_iter().flatten());
        let used = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        cells.truncate(used.max(place + 1));
        (cells, place)
    }

    /// Whether no field follows the sentence.
    pub(super) fn is_last(&self) -> bool {
        !self.after.iter().any(u8::is_ascii_alphanumeric)
    }

    /// The text before the sentence, without signs around it.
    pub(super) fn prefix(&self) -> &'a [u8] {
        let begin = self.before.iter().position(u8::is_ascii_alphanumeric).unwrap_or(self.before.len());
        let end = self.before.iter().rposition(u8::is_ascii_alphanumeric).map_or(begin, |last| last + 1);
        &self.before[begin..end]
    }
}

/// The sentence up to its checksum of two or four digits, without a quote or an escaped line end
/// after it. The whole sentence if it has no checksum.
pub(crate) fn checked_part(sentence: &[u8]) -> &[u8] {
    let Some(star) = memchr(b'*', sentence) else { return sentence };
    let digits = sentence[star + 1..].iter().take(4).take_while(|byte| byte.is_ascii_hexdigit()).count();
    match digits {
        4 => &sentence[..star + 5],
        2 | 3 => &sentence[..star + 3],
        _ => sentence,
    }
}

/// The plan of a table or log of sentences; `None` without stamps, because the file can then be read
/// as text just as well. The user may have named the columns.
pub(super) fn detect(lines: &[&[u8]], said: Said<'_>) -> Result<Option<CsvPlan>, Unusable> {
    let is_row = |line: &&[u8]| !is_comment_or_blank(line) && SentenceRow::of(line).is_some();
    let Some(first) = lines.iter().position(is_row) else { return Ok(None) };
    let rows = lines[first..].iter().filter(|line| !is_comment_or_blank(line));
    let rows: Vec<SentenceRow<'_>> = rows.filter_map(|line| SentenceRow::of(line)).take(HEAD_ROWS).collect();
    let raw = said.map.and_then(|map| map.sentence.as_deref());
    let above = lines[..first].iter().rposition(|line| !line.trim_ascii().is_empty());
    let named = above.and_then(|above| header(lines[above], &rows[0], raw.is_some()));
    let has_names = named.is_some();
    if !has_names
        && raw.is_none()
        && let Some(form) = prefix_form(&rows, said)?
    {
        let columns = vec![ColumnUse::Stamp(form), ColumnUse::Sentence];
        let report = CsvReport { times: Some(format!("1:{}", form.name())), ..CsvReport::default() };
        return Ok(Some(CsvPlan { has_prefix_stamps: true, columns, report, ..CsvPlan::default() }));
    }
    let (header, separator) = named.unwrap_or_else(|| {
        let separator = separator(&[rows[0].before, rows[0].after].concat());
        (Header::of_names(rows[0].cells(separator).0.iter().map(|cell| shown(cell)).collect()), separator)
    });
    if let Some(raw) = raw {
        header.mapped_place(RAW, raw)?;
    }
    let place = rows[0].cells(separator).1;
    let owned = |row: &SentenceRow<'_>| row.cells(separator).0.into_iter().map(Cow::into_owned).collect();
    let cells: Vec<HeadRow> = rows.iter().map(owned).collect();
    let search = TimeSearch { header: &header, rows: &cells, taken: vec![place] };
    // named by the user, found by name, or any column that can only be times
    let stamp = match said.map.map_or(Ok(None), |map| search.mapped(map))? {
        None if has_names => search.found()?.or_else(|| search.unnamed()),
        None => search.unnamed(),
        stamp => stamp,
    };
    if stamp.is_none() && raw.is_none() {
        return Ok(None);
    }
    let mut columns = vec![ColumnUse::Ignored; header.names.len()];
    columns[place] = ColumnUse::Sentence;
    let times = stamp.as_ref().map(|stamp| argument(stamp, &header));
    for (place, column) in stamp.into_iter().flatten() {
        columns[place] = column;
    }
    let unused = header
        .names
        .iter()
        .zip(&columns)
        .filter(|(name, column)| has_names && **column == ColumnUse::Ignored && !name.is_empty());
    let report =
        CsvReport { times, ignored_columns: unused.map(|(name, _)| name.clone()).collect(), ..CsvReport::default() };
    Ok(Some(CsvPlan {
        report,
        lines_above: above.filter(|_| has_names).map_or(0, |above| above as u64 + 1),
        names: if has_names { header.names.clone() } else { Vec::new() },
        dialect: Dialect { separator, ..Dialect::default() },
        columns,
        ..CsvPlan::default()
    }))
}

/// The line above the first row, and its separator, if it names the columns of the row. Beside a
/// sentence without other fields only a column that the user names shows it.
fn header(line: &[u8], row: &SentenceRow<'_>, is_named: bool) -> Option<(Header, u8)> {
    let names = line.trim_ascii_start();
    let names = names.strip_prefix(b"#").unwrap_or(names);
    let separator = separator(names);
    let header = Header::read(names, separator);
    let (cells, place) = row.cells(separator);
    ((cells.len() > 1 || is_named) && header.names.len() > place).then_some((header, separator))
}

/// The form of the stamps before the sentences, if these are all of one form: dates, or numbers that
/// ascend and have a certain unit. The user may have named the form of column 1.
fn prefix_form(rows: &[SentenceRow<'_>], said: Said<'_>) -> Result<Option<StampForm>, Unusable> {
    let prefixes: Vec<&[u8]> = rows.iter().map(SentenceRow::prefix).collect();
    if prefixes.len() < FEWEST {
        return Ok(None);
    }
    if let Some(&(_, form)) = said.map.and_then(|map| map.stamp.first()) {
        return Ok(Some(form).filter(|form| prefixes.iter().all(|stamp| form.nanoseconds(stamp).is_some())));
    }
    if let Some(form) = StampForm::of_texts(&prefixes).map_err(|()| date_order("1", "1"))? {
        return Ok(Some(form));
    }
    let Some(numbers) = prefixes.iter().map(|stamp| Number::parse(stamp)).collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    let ascends = numbers.windows(2).all(|pair| pair[1].value() >= pair[0].value());
    let is_certain = ascends && numbers.iter().any(|number| number.decimals > 0);
    Ok(unit_of(&numbers).ok().filter(|_| is_certain).map(StampForm::Unit))
}

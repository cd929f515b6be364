//! Rows that hold a whole sentence, beside stamps in other columns, or after a stamp that a terminal
//! program wrote: `1.5,"$VNYMR,...*63"`, `[2024-02-06 18:14:11.000] $VNYMR,...`.

use std::borrow::Cow;

use memchr::{memchr, memchr2, memmem};

use super::{
    ColumnUse, CsvError, CsvPlan, HeadRows, Said,
    column_map::RAW,
    date::DateForm,
    dialect::{Dialect, separator},
    fields::{LastField, fields},
    header::Header,
    lines::is_comment_or_blank,
    number::Number,
    resolution::HEAD_ROWS,
    shown,
    stamp::{StampForm, StampScan},
    time_columns::{StampColumns, TimeSearch, argument, date_of},
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
pub(super) fn detect(lines: &[&[u8]], line_end: u8, said: Said<'_>) -> Result<Option<CsvPlan>, CsvError> {
    let is_row = |line: &&[u8]| !is_comment_or_blank(line) && SentenceRow::of(line).is_some();
    let Some(first) = lines.iter().position(is_row) else { return Ok(None) };
    let rows = lines[first..].iter().filter(|line| !is_comment_or_blank(line));
    let rows: Vec<SentenceRow<'_>> = rows.filter_map(|line| SentenceRow::of(line)).take(HEAD_ROWS).collect();
    let raw = said.map.and_then(|map| map.sentence.as_ref());
    let above = lines[..first].iter().rposition(|line| !line.trim_ascii().is_empty());
    let header = above.and_then(|above| header(lines[above], &rows[0], raw.is_some()));
    if header.is_none()
        && raw.is_none()
        && let Some(form) = prefix_form(&rows, said)?
    {
        let columns = vec![ColumnUse::Stamp(form), ColumnUse::Sentence];
        let plan =
            CsvPlan { has_prefix_stamps: true, times: Some(format!("1:{}", form.name())), ..plan(columns, line_end) };
        return Ok(Some(CsvPlan { date: if let StampForm::Date(date) = form { Some(date) } else { None }, ..plan }));
    }
    let has_names = header.is_some();
    let (header, separator) = header.unwrap_or_else(|| {
        let separator = separator(&[rows[0].before, rows[0].after].concat());
        let names = rows[0].cells(separator).0.iter().map(|cell| shown(cell)).collect();
        (Header::of_names(names), separator)
    });
    let place = rows[0].cells(separator).1;
    let cells: Vec<Vec<Vec<u8>>> =
        rows.iter().map(|row| row.cells(separator).0.into_iter().map(Cow::into_owned).collect()).collect();
    if let Some(raw) = raw {
        header.mapped_place(RAW, raw)?;
    }
    let stamp = stamps(&header, &cells, place, has_names, said)?;
    if stamp.is_none() && raw.is_none() {
        return Ok(None);
    }
    let mut columns = vec![ColumnUse::Ignored; header.names.len()];
    columns[place] = ColumnUse::Sentence;
    for &(place, column) in stamp.iter().flatten() {
        columns[place] = column;
    }
    let unused =
        header.names.iter().zip(&columns).filter(|(name, column)| **column == ColumnUse::Ignored && !name.is_empty());
    let is_last = place + 1 == header.names.len();
    let ended = cells.len() - usize::from(lines.last().is_some_and(|last| !last.is_empty()));
    let whole = cells[..ended].iter().filter(|cells| !is_last && cells.len() == header.names.len());
    Ok(Some(CsvPlan {
        last_field: whole.filter_map(|cells| Some(LastField::of(cells.last()?))).reduce(LastField::common),
        ignored_columns: if has_names { unused.map(|(name, _)| name.clone()).collect() } else { Vec::new() },
        dialect: Dialect::plain(separator),
        times: stamp.as_ref().map(|stamp| argument(stamp, &header)),
        date: stamp.as_ref().and_then(date_of),
        lines_above: above.filter(|_| has_names).map_or(0, |above| above as u64 + 1),
        names: if has_names { header.names } else { Vec::new() },
        ..plan(columns, line_end)
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

/// A plan for sentences in these columns.
fn plan(columns: Vec<ColumnUse>, line_end: u8) -> CsvPlan {
    CsvPlan {
        layout: None,
        names: Vec::new(),
        ignored_columns: Vec::new(),
        left_out: Vec::new(),
        line_end,
        dialect: Dialect::plain(b','),
        columns,
        quantizers: Vec::new(),
        last_field: None,
        has_prefix_stamps: false,
        times: None,
        date: None,
        lines_above: 0,
        streams: Vec::new(),
    }
}

/// The columns of the stamps: named by the user, found by name, or any column that can only be times.
fn stamps(
    header: &Header,
    rows: &HeadRows,
    place: usize,
    has_names: bool,
    said: Said<'_>,
) -> Result<Option<StampColumns>, CsvError> {
    let search = TimeSearch { header, rows, taken: vec![place] };
    match said.map.map_or(Ok(None), |map| search.mapped(map))? {
        Some(stamp) => Ok(Some(stamp)),
        None if has_names => Ok(search.found()?.or_else(|| search.unnamed())),
        None => Ok(search.unnamed()),
    }
}

/// The form of the stamps before the sentences, if these are all of one form: dates, or numbers that
/// ascend and have a certain unit. The user may have named the form of column 1.
fn prefix_form(rows: &[SentenceRow<'_>], said: Said<'_>) -> Result<Option<StampForm>, CsvError> {
    let prefixes: Vec<&[u8]> = rows.iter().map(SentenceRow::prefix).collect();
    if prefixes.len() < FEWEST {
        return Ok(None);
    }
    if let Some(&(_, form)) = said.map.and_then(|map| map.stamp.first()) {
        return Ok(Some(form).filter(|form| prefixes.iter().all(|stamp| form.nanoseconds(stamp).is_some())));
    }
    if let Some(form) = DateForm::of_all(&prefixes).map_err(|()| CsvError::date_order("1", "1"))? {
        return Ok(Some(StampForm::Date(form)));
    }
    let Some(numbers) = prefixes.iter().map(|stamp| Number::parse(stamp)).collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    let mut scan = StampScan::default();
    numbers.iter().for_each(|number| scan.add(number));
    let ascends = numbers.windows(2).all(|pair| pair[1].value() >= pair[0].value());
    let is_certain = ascends && numbers.iter().any(|number| number.decimals > 0);
    Ok(scan.unit().ok().filter(|_| is_certain).map(StampForm::Unit))
}

//! The separator of the fields of a row, and its decimal sign.

use std::borrow::Cow;

use super::{
    date,
    fields::fields,
    number::{Number, are_thousands},
    shown,
};

/// The notation of the rows of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    /// The separator of two fields; a space stands for any number of spaces and tabs.
    pub(super) separator: u8,
    /// Whether decimals follow a comma: `0,5` is a half.
    decimal_comma: bool,
    /// Whether a space also separates a date from its time of day.
    has_dates: bool,
    /// Whether each cell begins with its name, as in `ax:0.03,ay:-0.11`.
    has_named_cells: bool,
}

/// Characters that are always separators.
const SEPARATORS: [u8; 4] = *b"\t;|,";

impl Dialect {
    /// The dialect of `rows`, which follow a line of `names` or begin with it.
    pub(super) fn of(names: &[u8], rows: &[&[u8]]) -> Self {
        // a tab that separates the names also separates the numbers
        let has_tabs = |row: &[u8]| names.contains(&b'\t') && row.contains(&b'\t');
        if !rows.is_empty() && rows.iter().all(|row| is_spaced(row) && !has_tabs(row)) {
            let decimal_comma = rows.iter().any(|row| row.contains(&b','));
            let has_dates = rows.iter().any(|row| words(row).any(is_date));
            return Self { decimal_comma, has_dates, ..Self::plain(b' ') };
        }
        let mut named = b",\t; ".map(|separator| Self { has_named_cells: true, ..Self::plain(separator) }).into_iter();
        let cells = |dialect: &Self| dialect.names_of_cells(names);
        let fits = |dialect: &Self, row: &[u8]| dialect.names_of_cells(row) == cells(dialect);
        if let Some(dialect) =
            named.find(|dialect| cells(dialect).is_some() && rows.iter().all(|row| fits(dialect, row)))
        {
            return dialect;
        }
        let separator = separator(names);
        Self { decimal_comma: separator != b',' && has_decimal_commas(rows, separator), ..Self::plain(separator) }
    }

    pub(super) const fn plain(separator: u8) -> Self {
        Self { separator, decimal_comma: false, has_dates: false, has_named_cells: false }
    }

    /// The names of the cells of a row, if each of several cells begins with one.
    pub(super) fn names_of_cells(self, row: &[u8]) -> Option<Vec<String>> {
        let cells = row.split(|byte| *byte == self.separator).filter(|cell| !cell.trim_ascii().is_empty());
        let named = cells.map(|cell| named_cell(cell).filter(|(_, number)| Number::parse(number).is_some()));
        let names = named.map(|cell| Some(shown(cell?.0))).collect::<Option<Vec<_>>>()?;
        (self.has_named_cells && names.len() > 1).then_some(names)
    }

    /// The names of the columns above rows of this dialect, and their separator; the names may
    /// stand in the first row.
    pub(super) fn header<'a>(self, names: &'a [u8]) -> (Cow<'a, [u8]>, u8) {
        let is_spaced = self.separator == b' ' && !names.iter().any(|byte| SEPARATORS.contains(byte));
        let separator = if is_spaced { b' ' } else { separator(names) };
        let is_row = separator != b',' && fields(names, separator).any(|field| is_with_comma(&field));
        (if is_spaced || is_row { self.tidy(names) } else { names.into() }, separator)
    }

    /// The line with single separators and decimal points.
    #[inline]
    pub(super) fn tidy<'a>(self, line: &'a [u8]) -> Cow<'a, [u8]> {
        let is_plain = !self.decimal_comma && self.separator != b' ' && !self.has_named_cells;
        if is_plain { line.into() } else { self.rewritten(line).into() }
    }

    fn rewritten(self, line: &[u8]) -> Vec<u8> {
        let mut tidy = Vec::with_capacity(line.len());
        if self.has_named_cells {
            let cells = line.split(|byte| *byte == self.separator).filter(|cell| !cell.trim_ascii().is_empty());
            let numbers: Vec<&[u8]> = cells.map(|cell| named_cell(cell).map_or(cell, |(_, number)| number)).collect();
            return numbers.join(&self.separator);
        }
        if self.separator == b' ' {
            let mut words = words(line).peekable();
            while let Some(word) = words.next() {
                tidy.extend_from_slice(word);
                if self.has_dates && (is_date(word) || word.eq_ignore_ascii_case(b"date")) {
                    let time = words.next_if(|time| date::is_time(time) || time.eq_ignore_ascii_case(b"time"));
                    tidy.extend(time.iter().flat_map(|time| [b"_", *time].concat()));
                    tidy.extend(words.next_if(|zone| time.is_some() && is_zone(zone)).into_iter().flatten());
                }
                tidy.push(b' ');
            }
            tidy.pop();
        } else {
            tidy.extend_from_slice(line);
        }
        if self.decimal_comma { with_points(&tidy) } else { tidy }
    }
}

/// The name and the number of a cell such as `ax:0.03`.
fn named_cell(cell: &[u8]) -> Option<(&[u8], &[u8])> {
    let colon = cell.iter().position(|byte| *byte == b':')?;
    let (name, number) = (cell[..colon].trim_ascii(), cell[colon + 1..].trim_ascii());
    name.first().is_some_and(u8::is_ascii_alphabetic).then_some((name, number))
}

/// Replaces decimal commas by points, and removes the points between thousands: `101.325,5`.
fn with_points(line: &[u8]) -> Vec<u8> {
    let mut written: Vec<u8> = Vec::with_capacity(line.len());
    for &byte in line {
        if byte == b',' {
            let digits = written.iter().rev().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
            let number = written.split_off(written.len() - digits);
            let has_thousands = are_thousands(&number, b'.');
            written.extend(number.into_iter().filter(|byte| !has_thousands || *byte != b'.'));
        }
        written.push(if byte == b',' { b'.' } else { byte });
    }
    written
}

/// Whether decimals follow a comma in the rows, and never a point.
fn has_decimal_commas(rows: &[&[u8]], separator: u8) -> bool {
    let mut all = rows.iter().flat_map(|row| fields(row, separator));
    let is_with_point = |field: &[u8]| field.contains(&b'.') && Number::parse(field).is_some();
    rows.iter().flat_map(|row| fields(row, separator)).any(|field| is_with_comma(&field))
        && !all.any(|field| is_with_point(&field))
}

/// The most frequent of `,` `;` `|` and tab in the line; a comma only if commas are not decimal
/// signs.
pub(super) fn separator(line: &[u8]) -> u8 {
    let are_decimals = |separator: &u8| {
        *separator != b',' && line.contains(separator) && fields(line, *separator).all(|field| is_with_comma(&field))
    };
    let occurrences = |separator: u8| line.iter().filter(|&&byte| byte == separator).count();
    // the last of several separators with equal counts
    let most = || SEPARATORS.into_iter().max_by_key(|&byte| occurrences(byte));
    SEPARATORS.into_iter().find(are_decimals).or_else(most).unwrap_or(b',')
}

/// Whether the line is several numbers, or stamps among them, separated by spaces.
fn is_spaced(line: &[u8]) -> bool {
    let is_number =
        |word: &[u8]| Number::parse(word).is_some() || is_with_comma(word) || word.eq_ignore_ascii_case(b"nan");
    let is_stamp = |word: &[u8]| is_date(word) || is_zone(word) || date::is_stamp(word);
    !line.contains(&b';')
        && !line.contains(&b'|')
        && line.contains(&b' ')
        && words(line).count() > 1
        && words(line).any(is_number)
        && words(line).all(|word| is_number(word) || is_stamp(word))
}

/// The text between spaces or tabs, without the quotes around a stamp of two words.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| matches!(byte, b' ' | b'\t' | b'"')).filter(|word| !word.is_empty())
}

/// Whether the text is a date, without a time of day.
fn is_date(word: &[u8]) -> bool {
    // a number has no second such sign between digits
    let is_sign = |byte: &&u8| matches!(byte, b'-' | b'/' | b'.');
    word.iter().filter(is_sign).count() == 2 && date::is_stamp(&[word, b" 00:00:00"].concat())
}

/// Whether the text is a time zone and no number.
fn is_zone(word: &[u8]) -> bool {
    let is_offset = matches!(word, [b'+' | b'-', _, _, b':', ..]);
    (is_offset || word.first().is_some_and(u8::is_ascii_alphabetic)) && date::is_time(&[b"00:00:00", word].concat())
}

/// Whether the text is a number with a decimal comma.
fn is_with_comma(field: &[u8]) -> bool {
    let decimals = field.iter().position(|&byte| byte == b',').map(|at| &field[at + 1..]);
    decimals.is_some_and(|decimals| decimals.first().is_some_and(u8::is_ascii_digit))
        && Number::parse(&with_points(field)).is_some()
}

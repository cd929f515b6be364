//! The separator of the fields of a row, and its decimal sign.

use std::borrow::Cow;

use super::{
    fields::fields,
    number::{Number, are_thousands},
    shown,
    stamp::is_stamp,
};

/// The notation of the rows of a file.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Dialect {
    /// The separator of two fields; a space stands for any number of spaces and tabs.
    pub(super) separator: u8,
    /// Whether decimals follow a comma: `0,5` is a half.
    pub(super) decimal_comma: bool,
    /// Whether each cell begins with its name, as in `ax:0.03,ay:-0.11`.
    pub(super) has_named_cells: bool,
}

/// Characters that are always separators.
const SEPARATORS: [u8; 4] = *b"\t;|,";

impl Dialect {
    /// The dialect of `rows`, which follow a line of `names` or begin with it.
    pub(super) fn of(names: &[u8], rows: &[&[u8]]) -> Self {
        // a tab that separates the names also separates the numbers
        let has_tabs = |row: &[u8]| names.contains(&b'\t') && row.contains(&b'\t');
        if !rows.is_empty() && rows.iter().all(|row| is_spaced(row) && !has_tabs(row)) {
            return Self {
                separator: b' ',
                decimal_comma: rows.iter().any(|row| row.contains(&b',')),
                ..Self::default()
            };
        }
        let named = b",\t; ".map(|separator| Self { separator, decimal_comma: false, has_named_cells: true });
        let fits = |dialect: &Self| {
            let names = dialect.names_of_cells(names);
            names.is_some() && rows.iter().all(|row| dialect.names_of_cells(row) == names)
        };
        if let Some(dialect) = named.into_iter().find(fits) {
            return dialect;
        }
        let separator = separator(names);
        let all = || rows.iter().flat_map(|row| fields(row, separator));
        let is_with_point = |field: Cow<'_, [u8]>| field.contains(&b'.') && Number::parse(&field).is_some();
        let decimal_comma = separator != b',' && all().any(|field| is_with_comma(&field)) && !all().any(is_with_point);
        Self { separator, decimal_comma, has_named_cells: false }
    }

    /// The names of the cells of a row, if each of several cells begins with one.
    pub(super) fn names_of_cells(self, row: &[u8]) -> Option<Vec<String>> {
        let named = self.cells(row).map(|cell| named_cell(cell).filter(|(_, number)| Number::parse(number).is_some()));
        let names = named.map(|cell| Some(shown(cell?.0))).collect::<Option<Vec<_>>>()?;
        (self.has_named_cells && names.len() > 1).then_some(names)
    }

    /// The parts of a row of named cells.
    fn cells(self, row: &[u8]) -> impl Iterator<Item = &[u8]> {
        row.split(move |byte| *byte == self.separator).filter(|cell| !cell.trim_ascii().is_empty())
    }

    /// The names of the columns above rows of this dialect, and their separator; the names may
    /// stand in the first row.
    pub(super) fn header(self, names: &[u8]) -> (Cow<'_, [u8]>, u8) {
        let is_spaced = self.separator == b' ' && !names.iter().any(|byte| SEPARATORS.contains(byte));
        let separator = if is_spaced { b' ' } else { separator(names) };
        let is_row = separator != b',' && fields(names, separator).any(|field| is_with_comma(&field));
        (if is_spaced || is_row { self.tidy(names) } else { names.into() }, separator)
    }

    /// The line with single separators and decimal points.
    #[inline]
    pub(super) fn tidy(self, line: &[u8]) -> Cow<'_, [u8]> {
        let is_plain = !self.decimal_comma && self.separator != b' ' && !self.has_named_cells;
        if is_plain { line.into() } else { self.rewritten(line).into() }
    }

    fn rewritten(self, line: &[u8]) -> Vec<u8> {
        if self.has_named_cells {
            let numbers = self.cells(line).map(|cell| named_cell(cell).map_or(cell, |(_, number)| number));
            return numbers.collect::<Vec<_>>().join(&self.separator);
        }
        let mut tidy = line.to_vec();
        if self.separator == b' ' {
            tidy.clear();
            let mut words = words(line).peekable();
            while let Some(word) = words.next() {
                tidy.extend_from_slice(word);
                // a date and its time of day are one field
                let is_time = |time: &&[u8]| match is_date(word) {
                    true => time.contains(&b':'),
                    false => word.eq_ignore_ascii_case(b"date") && time.eq_ignore_ascii_case(b"time"),
                };
                tidy.push(if words.peek().is_some_and(is_time) { b'_' } else { b' ' });
            }
            tidy.pop();
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

/// The most frequent of `,` `;` `|` and tab in the line; a comma only if commas are not decimal
/// signs.
pub(super) fn separator(line: &[u8]) -> u8 {
    let are_decimals = |separator: &u8| {
        *separator != b',' && line.contains(separator) && fields(line, *separator).all(|field| is_with_comma(&field))
    };
    let occurrences = |separator: &u8| line.iter().filter(|byte| *byte == separator).count();
    let certain = SEPARATORS.into_iter().find(are_decimals);
    certain.or_else(|| SEPARATORS.into_iter().max_by_key(occurrences)).unwrap_or(b',')
}

/// Whether the line is several numbers, or stamps among them, separated by spaces.
fn is_spaced(line: &[u8]) -> bool {
    let is_number =
        |word: &[u8]| Number::parse(word).is_some() || is_with_comma(word) || word.eq_ignore_ascii_case(b"nan");
    line.contains(&b' ')
        && !line.iter().any(|byte| matches!(byte, b';' | b'|'))
        && words(line).count() > 1
        && words(line).any(is_number)
        && words(line).all(|word| is_number(word) || is_date(word) || is_stamp(word))
}

/// The text between spaces or tabs, without the quotes around a stamp of two words.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| matches!(byte, b' ' | b'\t' | b'"')).filter(|word| !word.is_empty())
}

/// Whether the text is a date, without a time of day.
fn is_date(word: &[u8]) -> bool {
    let is_sign = |byte: &u8| matches!(byte, b'-' | b'/' | b'.');
    word.first().is_some_and(u8::is_ascii_digit)
        && word.iter().filter(|byte| is_sign(byte)).count() == 2
        && word.iter().all(|byte| byte.is_ascii_digit() || is_sign(byte))
}

/// Whether the text is a number with a decimal comma.
fn is_with_comma(field: &[u8]) -> bool {
    let decimals = field.iter().position(|&byte| byte == b',').map(|at| &field[at + 1..]);
    decimals.is_some_and(|decimals| decimals.first().is_some_and(u8::is_ascii_digit))
        && Number::parse(&with_points(field)).is_some()
}

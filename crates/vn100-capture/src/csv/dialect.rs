//! The separator of the fields of a row, and its decimal sign.

use std::borrow::Cow;

use memchr::memmem;

use super::{
    date,
    fields::FieldCutter,
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
    /// Whether a row is a stamp and a sentence, with any separator.
    pub(super) has_stamped_sentences: bool,
}

/// Rows that show that cells begin with their names.
const NAMED_ROWS: usize = 50;

/// Characters that are always separators.
const SEPARATORS: [u8; 4] = [b'\t', b';', b'|', b','];

impl Dialect {
    /// The dialect of `rows`, which follow a line of `names` or begin with it.
    pub(super) fn of<'a>(names: &[u8], rows: impl Iterator<Item = &'a [u8]> + Clone) -> Self {
        let mut shown = rows.clone().peekable();
        // a tab that separates the names also separates the numbers
        let has_tabs = |row: &[u8]| names.contains(&b'\t') && row.contains(&b'\t');
        if shown.peek().is_some() && shown.all(|row| is_spaced(row) && !has_tabs(row)) {
            let decimal_comma = rows.clone().any(|row| row.contains(&b','));
            let has_dates = rows.clone().any(|row| words(row).any(is_date));
            return Self { decimal_comma, has_dates, ..Self::plain(b' ') };
        }
        let named = [b',', b'\t', b';', b' ']
            .into_iter()
            .map(|separator| Self { has_named_cells: true, ..Self::plain(separator) });
        let cells = |dialect: &Self| dialect.names_of_cells(names);
        if let Some(dialect) = { named }.find(|dialect| {
            cells(dialect).is_some()
                && rows.clone().take(NAMED_ROWS).all(|row| dialect.names_of_cells(row) == cells(dialect))
        }) {
            return dialect;
        }
        let separator = separator(names);
        let has_sentence = || rows.clone().any(|row| memmem::find(row, b"$VN").is_some());
        let decimal_comma = separator != b',' && has_decimal_commas(rows.clone(), separator) && !has_sentence();
        Self { decimal_comma, ..Self::plain(separator) }
    }

    const fn plain(separator: u8) -> Self {
        Self { separator, decimal_comma: false, has_dates: false, has_named_cells: false, has_stamped_sentences: false }
    }

    /// The dialect of rows that are a stamp and a sentence.
    pub(super) const fn stamped_sentences() -> Self {
        Self { has_stamped_sentences: true, ..Self::plain(b',') }
    }

    /// The names of the cells of a row, if each of several cells begins with one.
    pub(super) fn names_of_cells(self, row: &[u8]) -> Option<Vec<String>> {
        let name = |cell: &[u8]| {
            let (name, number) = named_cell(cell)?;
            Number::parse(number)?;
            Some(shown(name))
        };
        let is_cell = |cell: &&[u8]| !cell.trim_ascii().is_empty();
        let cells = row.split(|byte| *byte == self.separator).filter(is_cell);
        let names: Vec<String> = cells.map(name).collect::<Option<_>>()?;
        (self.has_named_cells && names.len() > 1).then_some(names)
    }

    /// The names of the columns above rows of this dialect, and their separator; the names may
    /// stand in the first row.
    pub(super) fn header<'a>(self, names: &'a [u8]) -> (Cow<'a, [u8]>, u8) {
        let is_spaced = self.separator == b' ' && !names.iter().any(|byte| SEPARATORS.contains(byte));
        let separator = if is_spaced { b' ' } else { separator(names) };
        let is_row = separator != b',' && FieldCutter::of_head(separator).cut(names).iter().any(is_with_comma);
        (if is_spaced || is_row { self.tidy(names) } else { names.into() }, separator)
    }

    /// Whether a line needs no conversion.
    #[inline]
    pub(super) const fn is_plain(self) -> bool {
        !self.decimal_comma && self.separator != b' ' && !self.has_named_cells
    }

    /// The line with single separators and decimal points.
    pub(super) fn tidy<'a>(self, line: &'a [u8]) -> Cow<'a, [u8]> {
        if self.is_plain() {
            return line.into();
        }
        let mut tidy = Vec::with_capacity(line.len());
        if self.has_named_cells {
            let cells = line.split(|byte| *byte == self.separator).filter(|cell| !cell.trim_ascii().is_empty());
            for cell in cells {
                tidy.extend_from_slice(named_cell(cell).map_or(cell, |(_, number)| number));
                tidy.push(self.separator);
            }
            tidy.pop();
            return tidy.into();
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
        if self.decimal_comma { with_points(&tidy).into() } else { tidy.into() }
    }
}

/// The name and the number of a cell such as `ax:0.03`.
fn named_cell(cell: &[u8]) -> Option<(&[u8], &[u8])> {
    let colon = cell.iter().position(|byte| *byte == b':')?;
    let (name, number) = (cell[..colon].trim_ascii(), cell[colon + 1..].trim_ascii());
    let is_name = name.first().is_some_and(u8::is_ascii_alphabetic);
    is_name.then_some((name, number))
}

/// Replaces decimal commas by points, and removes the points between thousands: `101.325,5`.
fn with_points(line: &[u8]) -> Vec<u8> {
    let mut written: Vec<u8> = Vec::with_capacity(line.len());
    for &byte in line {
        if byte == b',' {
            let digits = written.iter().rev().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
            let begin = written.len() - digits;
            if are_thousands(&written[begin..], b'.') {
                let bare: Vec<u8> = written.split_off(begin).into_iter().filter(|byte| *byte != b'.').collect();
                written.extend(bare);
            }
        }
        written.push(if byte == b',' { b'.' } else { byte });
    }
    written
}

/// Whether decimals follow a comma in the rows, and never a point.
fn has_decimal_commas<'a>(rows: impl Iterator<Item = &'a [u8]>, separator: u8) -> bool {
    let mut reader = FieldCutter::of_head(separator);
    let (mut commas, mut points) = (false, false);
    for row in rows {
        for field in reader.cut(row).iter() {
            commas |= is_with_comma(field);
            points |= field.contains(&b'.') && Number::parse(field).is_some();
        }
    }
    commas && !points
}

/// The most frequent of `,` `;` `|` and tab in the line; a comma only if commas are not decimal
/// signs.
fn separator(line: &[u8]) -> u8 {
    let are_decimals = |separator: &u8| {
        line.contains(separator) && FieldCutter::of_head(*separator).cut(line).iter().all(is_with_comma)
    };
    let occurrences = |separator: u8| line.iter().filter(|&&byte| byte == separator).count();
    let [tab, semicolon, bar, _] = SEPARATORS;
    // the last of several separators with equal counts
    let most = || SEPARATORS.into_iter().max_by_key(|&byte| occurrences(byte));
    [tab, semicolon, bar].into_iter().find(are_decimals).or_else(most).unwrap_or(b',')
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
    match field.iter().position(|&byte| byte == b',') {
        Some(at) if field[at + 1..].first().is_some_and(u8::is_ascii_digit) => {
            Number::parse(&with_points(field)).is_some()
        }
        _ => false,
    }
}

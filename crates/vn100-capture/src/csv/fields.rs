//! Cuts a line of a table into its fields. Quotes, doubled or not closed, have the same meaning as
//! for other programs.

use std::borrow::Cow;

use memchr::memchr;

use super::{HeadRow, number::Number};

/// The fields of a line, at least one, without the spaces and quotes around them.
pub(super) const fn fields(line: &[u8], separator: u8) -> Fields<'_> {
    Fields { rest: Some(line), separator }
}

pub(super) struct Fields<'a> {
    /// `None` after the last field.
    pub(super) rest: Option<&'a [u8]>,
    separator: u8,
}

impl<'a> Iterator for Fields<'a> {
    type Item = Cow<'a, [u8]>;

    #[inline]
    fn next(&mut self) -> Option<Cow<'a, [u8]>> {
        let line = self.rest?;
        let spaces = line.iter().take_while(|byte| **byte == b' ').count();
        match line.get(spaces) {
            Some(b'"') => Some(self.quoted(&line[spaces + 1..]).trim_ascii().to_vec().into()),
            _ => Some(self.take(line).trim_ascii().into()),
        }
    }
}

impl<'a> Fields<'a> {
    /// The next field, if it is a number without spaces or quotes around it.
    #[inline]
    pub(super) fn next_number(&mut self) -> Option<Number> {
        let line = self.rest?;
        let (number, length) = Number::parse_prefix(line)?;
        self.rest = match line.get(length) {
            None => None,
            Some(byte) if *byte == self.separator => Some(&line[length + 1..]),
            Some(_) => return None,
        };
        Some(number)
    }

    /// The bytes up to the next separator.
    #[inline]
    fn take(&mut self, line: &'a [u8]) -> &'a [u8] {
        let end = memchr(self.separator, line);
        self.rest = end.map(|end| &line[end + 1..]);
        &line[..end.unwrap_or(line.len())]
    }

    /// The text after an opening quote; what follows its closing quote belongs to it as well.
    fn quoted(&mut self, mut line: &'a [u8]) -> Vec<u8> {
        let mut text = Vec::new();
        while let Some(quote) = memchr(b'"', line) {
            text.extend_from_slice(&line[..quote]);
            line = &line[quote + 1..];
            if line.first() != Some(&b'"') {
                text.extend_from_slice(self.take(line));
                return text;
            }
            text.push(b'"');
            line = &line[1..];
        }
        text.extend_from_slice(line);
        self.rest = None;
        text
    }
}

/// The form of the ends of all rows. It tells whether a last row without a line end is complete or
/// truncated: many writers omit the last line end.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowEnd {
    /// The fewest fields of a row.
    fields: usize,
    /// The decimals of the last fields, if these are the same in all rows.
    decimals: Option<Decimals>,
    /// The length of the longest last field.
    longest: usize,
}

/// Number of digits between the point and an exponent, at least one, and whether there is an
/// exponent. A number without any has `None`, as a truncated integer looks complete.
type Decimals = (usize, bool);

impl RowEnd {
    /// The common form of these rows; `None` if there are none.
    pub(super) fn of_all(rows: impl Iterator<Item = HeadRow>) -> Option<Self> {
        let last = |row: &HeadRow| row.last().cloned().unwrap_or_default();
        let ends =
            rows.map(|row| Self { fields: row.len(), decimals: decimals(&last(&row)), longest: last(&row).len() });
        ends.reduce(|common, end| Self {
            fields: common.fields.min(end.fields),
            decimals: common.decimals.filter(|_| common.decimals == end.decimals),
            longest: common.longest.max(end.longest),
        })
    }

    /// Whether a row has as many fields as all others, and its last one as many decimals, or the length
    /// of the longest.
    pub(super) fn is_whole(self, row: &[Cow<'_, [u8]>]) -> bool {
        let Some(last) = row.last().filter(|_| row.len() >= self.fields) else { return false };
        self.decimals.is_some() && decimals(last) == self.decimals || last.len() >= self.longest
    }
}

fn decimals(field: &[u8]) -> Option<Decimals> {
    let exponent = field.iter().position(|byte| matches!(byte, b'e' | b'E'));
    let mantissa = &field[..exponent.unwrap_or(field.len())];
    let point = memchr(b'.', mantissa).filter(|_| Number::parse(field).is_some())?;
    Some((mantissa.len() - point - 1, exponent.is_some())).filter(|(decimals, _)| *decimals > 0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cut(line: &str, separator: u8) -> Vec<String> {
        fields(line.as_bytes(), separator).map(|field| str::from_utf8(&field).unwrap().into()).collect()
    }

    #[test]
    fn quotes_hold_separators() {
        assert_eq!(cut("a, b ,,c", b','), ["a", "b", "", "c"]);
        assert_eq!(cut("1,\"$A,b*63\",2", b','), ["1", "$A,b*63", "2"]);
        assert_eq!(cut("1; \"x;y\" ;2", b';'), ["1", "x;y", "2"]);
        assert_eq!(cut("  \"x,y\"  ", b','), ["x,y"]);
        assert_eq!(cut("\"say \"\"a,b\"\"\",2", b','), ["say \"a,b\"", "2"]);
        assert_eq!(cut("\t1\t", b'\t'), ["", "1", ""]);
        assert_eq!(cut("\"a\", ", b','), ["a", ""]);
        assert_eq!(cut("", b','), [""]);
        assert_eq!(cut(" ", b','), [""]);
    }

    /// The rows are as `csv.writer` of Python 3 writes random fields, with and without need of quotes.
    #[test]
    fn rows_that_python_wrote_are_read() {
        let rows: &[(u8, &str, &[&str])] = &[
            (b';', "\"*63a1\";\"1;$VNa\"", &["*63a1", "1;$VNa"]),
            (b',', "\"\"", &[""]),
            (b';', "\"1\"", &["1"]),
            (b';', "\"1-*63*63\"", &["1-*63*63"]),
            (b',', "\"\"\"a-a\",\"'.,\"\"\",,,\", '*63\"", &["\"a-a", "'.,\"", "", "", ", '*63"]),
            (
                b',',
                "*63-;1,é1$VNa,\"-\"\"\"\"*63\",\";\"\"\"\"\",\"\\\"\"\"\";,\"",
                &["*63-;1", "é1$VNa", "-\"\"*63", ";\"\"", "\\\"\";,"],
            ),
            (b',', "\"\",\", \"\"\"\"\\\"", &["", ", \"\"\\"]),
            (b'\t', "\"$VN1\"\t\"\"\t\"\"\".\t;\"\t\"\\\"", &["$VN1", "", "\".\t;", "\\"]),
            (b';', "\"1\t $VN\"", &["1\t $VN"]),
            (b';', "\"\"\"\"\"$VN\t\"\"\"\"\";\"\";\"\"", &["\"\"$VN\t\"\"", "", ""]),
            (b';', "\"\"", &[""]),
            (b'\t', "\"$VN*63'\"\"\"\",\"\t\"\"\"\\*63;a\"\t;.$VN", &["$VN*63'\"\",", "\"\\*63;a", ";.$VN"]),
            (b';', "\"\"", &[""]),
            (b',', "\"\"\"\\'\",\"1.\"\"\"\"\"", &["\"\\'", "1.\"\""]),
            (b'\t', "'\t' ,\t\"\"\";*63\\\"\"\"", &["'", "' ,", "\";*63\\\""]),
            (b',', ".", &["."]),
            (b'\t', "\"\"\t\"'$VN.\"", &["", "'$VN."]),
            (b';', "\"\"\"\"", &["\""]),
            (
                b';',
                "\";.é'\";\"$VN*63*63é\";\"\";\"\\'\";\"\"\"\"\"\"\"\"",
                &[";.é'", "$VN*63*63é", "", "\\'", "\"\"\""],
            ),
            (b',', "\"\"\"a-1-\",.1;,a1a$VN,", &["\"a-1-", ".1;", "a1a$VN", ""]),
            (b';', "\"\";\"\";\"$VN\";\".*63,\";\"$VN;\"", &["", "", "$VN", ".*63,", "$VN;"]),
            (b',', "\"\"\"\"\"\"\"\"\"\"\"\"\"\"", &["\"\"\"\"\"\""]),
            (b',', "\"\",\";é,\"\"\"\"'\"", &["", ";é,\"\"'"]),
            (b',', ",,.é,\\a,*63'", &["", "", ".é", "\\a", "*63'"]),
        ];
        for (separator, line, expected) in rows {
            assert_eq!(cut(line, *separator), *expected, "{line}");
        }
    }

    #[test]
    fn an_open_quote_ends_with_its_line() {
        assert_eq!(cut("1,\"$A,b*63", b','), ["1", "$A,b*63"]);
        assert_eq!(cut("\"", b','), [""]);
    }

    proptest! {
        #[test]
        fn a_written_row_is_read_again(
            row in proptest::collection::vec(("[a1,;\"\t $*.\u{e9}-]{0,8}", any::<bool>(), " {0,2}", " {0,2}"), 1..40),
            separator in prop::sample::select(vec![b',', b';', b'\t']),
        ) {
            let written: Vec<_> = row.iter().map(|(field, quoted, before, behind)| {
                let needs_quotes = field.contains(['"', char::from(separator)]);
                match *quoted || needs_quotes {
                    true => format!("{before}\"{}\"{behind}", field.replace('"', "\"\"")),
                    false => format!("{before}{field}{behind}"),
                }
            }).collect();
            let line = written.join(&char::from(separator).to_string());
            let expected: Vec<_> = row.iter().map(|(field, ..)| field.trim_ascii()).collect();
            prop_assert_eq!(cut(&line, separator), &*expected, "{}", line);
        }
    }

    #[test]
    fn decimals_are_the_digits_after_the_point_of_a_number() {
        for (field, expected) in [
            ("-12.50", Some((2, false))),
            ("1.5e-3", Some((1, true))),
            ("0.125", Some((3, false))),
            ("5.", None),
            ("5", None),
            ("x.5", None),
        ] {
            assert_eq!(decimals(field.as_bytes()), expected, "{field}");
        }
    }
}

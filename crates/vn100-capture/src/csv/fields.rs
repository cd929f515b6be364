//! Cuts a line of a CSV file into its fields, by csv-core and with reused buffers. Quotes, doubled or
//! not closed, have the same meaning as for other programs.

use csv_core::{ReadRecordResult, Reader, ReaderBuilder, Terminator};
use memchr::memchr;

use super::number::Number;

/// Cuts lines into their fields.
pub(super) struct FieldCutter {
    reader: Reader,
    /// A line end that no line contains.
    line_end: u8,
    /// The fields of the present line, one after the other, and the end of each.
    text: Vec<u8>,
    ends: Vec<usize>,
}

struct FirstFields {
    count: usize,
    /// The place of the next field in the line; `None` after the last field.
    next: Option<usize>,
    quote_open: bool,
}

impl FieldCutter {
    /// Cuts lines that do not contain `line_end` and whose fields are separated by `separator`.
    pub(super) fn new(separator: u8, line_end: u8) -> Self {
        let reader = ReaderBuilder::new().delimiter(separator).terminator(Terminator::Any(line_end)).build();
        Self { reader, line_end, text: Vec::new(), ends: Vec::new() }
    }

    /// Cuts lines of the head of a file, which contain no line feed for any kind of line end.
    pub(super) fn of_head(separator: u8) -> Self {
        Self::new(separator, b'\n')
    }

    /// All fields of a line, at least one.
    #[inline]
    pub(super) fn cut(&mut self, line: &[u8]) -> Fields<'_> {
        let FirstFields { count, quote_open, .. } = self.read(line, usize::MAX);
        Fields { text: &self.text, ends: &self.ends[..count], quote_open }
    }

    /// At most `count` first fields of a line, and the rest of the line after their separator.
    pub(super) fn cut_first<'a>(&mut self, line: &'a [u8], count: usize) -> (Fields<'_>, Option<&'a [u8]>) {
        let FirstFields { count, next, quote_open } = self.read(line, count);
        let fields = Fields { text: &self.text, ends: &self.ends[..count], quote_open };
        (fields, next.map(|next| &line[next..]))
    }

    fn read(&mut self, line: &[u8], most: usize) -> FirstFields {
        let Self { reader, line_end, text, ends } = self;
        reader.reset();
        // room for a line end inside quotes
        if text.len() < line.len() + 2 {
            text.resize(line.len() + 2, 0);
        }
        // csv-core does not recognise a quote after spaces, so spaces are skipped here, field by
        // field
        let step = if memchr(b'"', line).is_some() { 1 } else { usize::MAX };
        let (mut at, mut length, mut count, mut quote_open) = (0, 0, 0_usize, false);
        while count < most {
            if step == 1 {
                at += line[at..].iter().take_while(|&&byte| byte == b' ').count();
            }
            if count == ends.len() {
                ends.resize(16.max(2 * count), 0);
            }
            let end = ends.len().min(most).min(count.saturating_add(step));
            let rest = match (&line[at..], quote_open) {
                ([], false) => std::slice::from_ref(&*line_end),
                (rest, _) => rest,
            };
            let is_line_end = at == line.len();
            let (result, read, written, ended) = reader.read_record(rest, &mut text[length..], &mut ends[count..end]);
            length += written;
            count += ended;
            match result {
                ReadRecordResult::Record => return FirstFields { count, next: None, quote_open },
                // an empty line is no record for csv-core; here it has one empty field
                _ if is_line_end && written == 0 => {
                    ends[0] = 0;
                    return FirstFields { count: 1, next: None, quote_open };
                }
                // a quoted field continues after the line end
                _ if is_line_end => quote_open = true,
                _ => at += read,
            }
        }
        FirstFields { count, next: Some(at), quote_open }
    }
}

/// The fields of a line, without the spaces and quotes around them.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    text: &'a [u8],
    ends: &'a [usize],
    /// Whether the last field begins with a quote that is not closed.
    pub(super) quote_open: bool,
}

impl<'a> Fields<'a> {
    pub(super) const fn len(self) -> usize {
        self.ends.len()
    }

    #[inline]
    pub(super) fn iter(self) -> impl Iterator<Item = &'a [u8]> {
        let mut begin = 0;
        self.ends.iter().map(move |&end| self.text[std::mem::replace(&mut begin, end)..end].trim_ascii())
    }

    pub(super) fn last(self) -> &'a [u8] {
        self.iter().last().unwrap_or_default()
    }
}

/// The common printed form of the last fields of all rows. It tells whether a last row without a
/// line end is complete or truncated: many writers omit the last line end.
#[derive(Debug, Clone, Copy)]
pub(super) struct LastField {
    /// Number of digits between the point and an exponent, at least one, and whether there is an
    /// exponent: a truncated integer looks complete.
    decimals: Option<(usize, bool)>,
    /// The length, and whether it is the same in all rows.
    length: usize,
    is_constant: bool,
}

impl LastField {
    pub(super) fn of(field: &[u8]) -> Self {
        let is_exponent = |byte: &u8| matches!(byte, b'e' | b'E');
        let exponent = field.iter().position(is_exponent);
        let mantissa = &field[..exponent.unwrap_or(field.len())];
        let point = mantissa.iter().position(|byte| *byte == b'.').filter(|_| Number::parse(field).is_some());
        let decimals = point.map(|point| (mantissa.len() - point - 1, exponent.is_some()));
        Self { decimals: decimals.filter(|(decimals, _)| *decimals > 0), length: field.len(), is_constant: true }
    }

    pub(super) fn common(self, other: Self) -> Self {
        Self {
            decimals: self.decimals.filter(|_| self.decimals == other.decimals),
            length: self.length.min(other.length),
            is_constant: self.is_constant && other.is_constant && self.length == other.length,
        }
    }

    /// Whether `field` has the decimals or the length that all other fields have in common. A
    /// decimal number among numbers of varying length must be no shorter than any of them: a cut
    /// could then remove less than its last digit.
    pub(super) fn is_whole(self, field: &[u8]) -> bool {
        let own = Self::of(field);
        match self.decimals {
            Some(decimals) => own.decimals == Some(decimals),
            None if self.is_constant => own.length == self.length,
            None => own.decimals.is_some() && own.length >= self.length,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn fields(line: &str, separator: u8) -> Vec<String> {
        let mut reader = FieldCutter::of_head(separator);
        let fields = reader.cut(line.as_bytes());
        fields.iter().map(|field| str::from_utf8(field).unwrap().into()).collect()
    }

    #[test]
    fn quotes_hold_separators() {
        assert_eq!(fields("a, b ,,c", b','), ["a", "b", "", "c"]);
        assert_eq!(fields("1,\"$A,b*63\",2", b','), ["1", "$A,b*63", "2"]);
        assert_eq!(fields("1; \"x;y\" ;2", b';'), ["1", "x;y", "2"]);
        assert_eq!(fields("  \"x,y\"  ", b','), ["x,y"]);
        assert_eq!(fields("\"say \"\"a,b\"\"\",2", b','), ["say \"a,b\"", "2"]);
        assert_eq!(fields("\t1\t", b'\t'), ["", "1", ""]);
        assert_eq!(fields("\"a\", ", b','), ["a", ""]);
        assert_eq!(fields("", b','), [""]);
        assert_eq!(fields(" ", b','), [""]);
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
            assert_eq!(fields(line, *separator), *expected, "{line}");
        }
    }

    #[test]
    fn an_open_quote_ends_with_its_line() {
        assert_eq!(fields("1,\"$A,b*63", b','), ["1", "$A,b*63"]);
        assert_eq!(fields("\"", b','), [""]);
        let mut reader = FieldCutter::new(b',', b'\r');
        let open = [("1,\"$A", true), ("\"", true), (" \"$A\" ", false), ("\"\"", false), ("a\"", false), ("", false)];
        for (line, open) in open {
            assert_eq!(reader.cut(line.as_bytes()).quote_open, open, "{line:?}");
        }
    }

    #[test]
    fn the_text_after_the_first_fields_is_unchanged() {
        let mut reader = FieldCutter::of_head(b',');
        for (line, count, first, rest) in [
            ("1,$A,b*63", 1, &["1"][..], Some("$A,b*63")),
            ("$A,b*63", 0, &[], Some("$A,b*63")),
            (" \"1,2\" ,3,\"4", 2, &["1,2", "3"], Some("\"4")),
            ("1,", 1, &["1"], Some("")),
            ("1", 1, &["1"], None),
            ("1", 2, &["1"], None),
            ("", 1, &[""], None),
        ] {
            let (fields, found) = reader.cut_first(line.as_bytes(), count);
            let fields: Vec<_> = fields.iter().map(|field| str::from_utf8(field).unwrap()).collect();
            assert_eq!((&*fields, found), (first, rest.map(str::as_bytes)), "{line:?}");
        }
    }

    #[test]
    fn a_field_is_whole_with_the_decimals_or_the_width_of_all_others() {
        for (others, field, whole) in [
            (&["+00.000301", "-00.000391"][..], "+00.000724", true),
            (&["+00.000301", "-00.000391"], "+00.00072", false),
            (&["0.301", "-12.391"], "7.724", true),
            (&["0.301", "-12.391"], "7.72", false),
            (&["1234", "1235"], "1236", true),
            (&["1234", "1235"], "123", false),
            (&["9", "10"], "11", false),
            (&["0.5", "0.25"], "0.125", true),
            (&["-0.5", "0.25"], "0.1", false),
            (&["-3.220814489E-2", "7.7036E-1"], "7.7", false),
            (&["-3.220814489E-2", "7.703784658E-10"], "7.625183395E-1", true),
            (&["-3.220814489E-2", "7.703784658E-10"], "7.62518", false),
            (&["12:00:01", "12:00:02"], "12:00:03", true),
            (&["12:00:01", "12:00:02"], "12:00", false),
            (&["", ""], "", true),
        ] {
            let others_forms = others.iter().map(|other| LastField::of(other.as_bytes()));
            let last = others_forms.reduce(LastField::common).unwrap();
            assert_eq!(last.is_whole(field.as_bytes()), whole, "{field} after {others:?}");
        }
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
            prop_assert_eq!(fields(&line, separator), &*expected, "{}", line);
            let mut reader = FieldCutter::of_head(separator);
            // the buffers hold another line before
            reader.cut(b"\"");
            prop_assert!(!reader.cut(line.as_bytes()).quote_open);
        }

        #[test]
        fn any_bytes_are_cut_within_the_line(
            line in proptest::collection::vec(prop::sample::select(b"a,\" \xef\xbb\xbf".to_vec()), 0..60),
            most in 0_usize..9,
        ) {
            let mut reader = FieldCutter::of_head(b',');
            let all: Vec<_> = reader.cut(&line).iter().map(<[u8]>::to_vec).collect();
            prop_assert!(!all.is_empty() && all.iter().map(Vec::len).sum::<usize>() <= line.len());
            let (first, rest) = reader.cut_first(&line, most);
            prop_assert!(first.iter().eq(all.iter().take(most)));
            prop_assert_eq!(rest.is_some(), all.len() > most || most == 0);
        }
    }
}

//! A line cut into its fields. A record is a line: a line break inside quotes ends it, so that one
//! lost quote damages one line only.

use memchr::{memchr, memchr_iter};

/// The fields of a line, without the spaces and quotes around them.
pub(super) struct Fields<'a> {
    /// `None` behind the last field.
    rest: Option<&'a [u8]>,
    separator: u8,
}

impl<'a> Fields<'a> {
    pub(super) fn new(line: &'a [u8], separator: u8) -> Self {
        Self { rest: Some(line), separator }
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let end = field_end(rest, self.separator);
        self.rest = rest.get(end + 1..);
        Some(unquoted(&rest[..end]))
    }
}

/// The length of the field at the head of `rest`. A quoted field may hold separators.
#[inline]
pub(super) fn field_end(rest: &[u8], separator: u8) -> usize {
    if let Some(quote) = opening_quote(rest) {
        return memchr_iter(b'"', &rest[quote + 1..])
            .map(|at| quote + 1 + at)
            .find_map(|closing| {
                let behind = closing + 1;
                let spaces = rest[behind..].iter().take_while(|&&b| b == b' ').count();
                let end = behind + spaces;
                (end == rest.len() || rest[end] == separator).then_some(end)
            })
            .unwrap_or(rest.len());
    }
    memchr(separator, rest).unwrap_or(rest.len())
}

/// Where the quote that the field at the head of `rest` begins with stands.
pub(super) fn opening_quote(rest: &[u8]) -> Option<usize> {
    let at = rest.iter().position(|&b| b != b' ')?;
    (rest[at] == b'"').then_some(at)
}

/// Whether `field` begins with a quote that is not closed.
pub(super) fn has_open_quote(field: &[u8]) -> bool {
    match field.trim_ascii().strip_prefix(b"\"") {
        Some(behind) => !behind.ends_with(b"\""),
        None => false,
    }
}

/// `field` without the spaces around it, and without its quotes; a quote that is not closed is one
/// too.
pub(super) fn unquoted(field: &[u8]) -> &[u8] {
    let field = field.trim_ascii();
    match field.strip_prefix(b"\"") {
        Some(inner) => inner.strip_suffix(b"\"").unwrap_or(inner).trim_ascii(),
        None => field,
    }
}

/// Whether `line` is no row: nothing but spaces, or a `#` and what follows it.
#[inline]
pub(super) fn is_comment_or_blank(line: &[u8]) -> bool {
    let first = line.iter().find(|byte| !byte.is_ascii_whitespace());
    matches!(first, None | Some(b'#'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(line: &str, separator: u8) -> Vec<&str> {
        Fields::new(line.as_bytes(), separator).map(|field| std::str::from_utf8(field).unwrap()).collect()
    }

    #[test]
    fn quotes_hold_separators() {
        assert_eq!(fields("a, b ,,c", b','), ["a", "b", "", "c"]);
        assert_eq!(fields("1,\"$A,b*63\",2", b','), ["1", "$A,b*63", "2"]);
        assert_eq!(fields("1; \"x;y\" ;2", b';'), ["1", "x;y", "2"]);
        assert_eq!(fields("\"say \"\"a,b\"\"\",2", b','), ["say \"\"a,b\"\"", "2"]);
        assert_eq!(fields("\t1\t", b'\t'), ["", "1", ""]);
        assert_eq!(fields("", b','), [""]);
    }

    #[test]
    fn an_open_quote_ends_with_its_line() {
        assert_eq!(fields("1,\"$A,b*63", b','), ["1", "$A,b*63"]);
        assert_eq!(fields("\"", b','), [""]);
        for (field, open) in [("\"$A", true), ("\"", true), (" \"$A\" ", false), ("\"\"", false), ("a\"", false)] {
            assert_eq!(has_open_quote(field.as_bytes()), open, "{field:?}");
        }
    }
}

//! TOML that users write: what is wrong in the text, and where, in one line.

use std::fmt;

use serde::de::DeserializeOwned;
use thiserror::Error;

/// Why a text is no TOML, or does not have the expected form.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub struct TomlError {
    /// Line and column of the error, both from 1; `None` if they are not known.
    pub place: Option<(usize, usize)>,
    /// The error, in one line.
    pub message: String,
}

impl fmt::Display for TomlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, message } = self;
        match place {
            Some((line, column)) => write!(f, "line {line}, column {column}: {message}"),
            None => f.write_str(message),
        }
    }
}

/// Reads a TOML text that a user wrote.
///
/// # Errors
/// [`TomlError`] when the text is no TOML, or does not have the form of `T`.
pub fn parse_toml<T: DeserializeOwned>(text: &str) -> Result<T, TomlError> {
    toml::from_str(text).map_err(|error: toml::de::Error| TomlError {
        place: error.span().map(|span| (line(text, span.start), column(text, span.start))),
        message: error.message().replace('\n', ", "),
    })
}

/// Of this byte, from 1.
pub(crate) fn line(text: &str, byte: usize) -> usize {
    text.bytes().take(byte).filter(|byte| *byte == b'\n').count() + 1
}

fn column(text: &str, byte: usize) -> usize {
    let before = text.get(..byte).unwrap_or(text);
    before.chars().rev().take_while(|character| *character != '\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistake_has_its_line_and_column_and_one_line() {
        for (text, place) in [
            ("place = \"bench\"\nnöte 3\n", "line 2, column 6: "),
            ("place", "line 1, column 6: "),
            ("a = 1\r\nb = \"x\r\n", "line 2, column 8: "),
            ("a = 1\na = 2", "line 2, column 1: "),
        ] {
            let error = parse_toml::<toml::Table>(text).unwrap_err().to_string();
            assert!(error.starts_with(place), "{error}");
            assert!(error.len() > place.len() && !error.contains(char::is_control), "{error:?}");
        }
    }
}

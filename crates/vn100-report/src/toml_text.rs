//! TOML that users write: what is wrong in the text, and where, in one line.

use serde::de::DeserializeOwned;
use thiserror::Error;

/// Why a text is no TOML, or does not have the expected form.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct TomlError(String);

/// Reads a TOML text that a user wrote.
///
/// # Errors
/// [`TomlError`] when the text is no TOML, or does not have the form of `T`.
pub fn parse_toml<T: DeserializeOwned>(text: &str) -> Result<T, TomlError> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let message = error.message().replace('\n', ", ");
        let at = |byte| format!("line {}, column {}: {message}", line(text, byte), column(text, byte));
        TomlError(error.span().map_or_else(|| message.clone(), |span| at(span.start)))
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

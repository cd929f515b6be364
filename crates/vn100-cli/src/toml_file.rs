//! TOML that users write: what is wrong with it, and where, in one line.

use anyhow::{Result, anyhow};
use serde::de::DeserializeOwned;

/// # Errors
/// When it is no TOML, or not of this form; with line and column.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let message = error.message().replace('\n', ", ");
        match error.span() {
            Some(span) => anyhow!("line {}, column {}: {message}", line(text, span.start), column(text, span.start)),
            None => anyhow!(message),
        }
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
            let error = parse::<toml::Table>(text).unwrap_err().to_string();
            assert!(error.starts_with(place), "{error}");
            assert!(error.len() > place.len() && !error.contains(char::is_control), "{error:?}");
        }
    }
}

//! The conditions of a measurement, as the user writes them down to be kept with its data.

use std::{collections::BTreeMap, fs, path::Path};

use anyhow::{Context, Result, bail};
use toml::Value;
use vn100_pipeline::is_reserved;
use vn100_report::parse_toml;

/// The conditions in the user's file; none without one.
pub(crate) fn read(file: Option<&Path>) -> Result<BTreeMap<String, String>> {
    let Some(file) = file else { return Ok(BTreeMap::new()) };
    let text = fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    parse(&text).with_context(|| format!("{}", file.display()))
}

fn parse(text: &str) -> Result<BTreeMap<String, String>> {
    let table: toml::Table = parse_toml(text)?;
    let entry = |(name, value): (String, Value)| {
        let text = match value {
            Value::String(text) => text,
            Value::Integer(number) => number.to_string(),
            Value::Float(number) => number.to_string(),
            Value::Boolean(yes) => yes.to_string(),
            Value::Datetime(time) => time.to_string(),
            Value::Array(_) | Value::Table(_) => {
                bail!("{name} should be a text or a number, as in {name} = \"bench 3\"")
            }
        };
        if is_reserved(&name) {
            bail!("{name} is a name of the program's own");
        }
        Ok((name, text))
    };
    table.into_iter().map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_names_and_values() {
        let parsed = parse("place = \"bench 3\"\ntemperature = 21.5\naxis_up = \"-z\"\n").unwrap();
        assert_eq!(parsed["temperature"], "21.5");
        for wrong in ["place", "[place]\nname = 1", "place = [1, 2]", "\"measured.duration\" = \"1h\""] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}

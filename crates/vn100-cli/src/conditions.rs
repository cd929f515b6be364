//! The conditions of a measurement, kept with its data: what the user writes down, and what was asked of it.

use std::{collections::BTreeMap, fs, path::Path, time::Duration};

use anyhow::{Context, Result, bail};
use toml::Value;

/// Under this name a recording keeps the data time that its measurement was to last. A replay of it ends there too, and so equals it:
/// a line more may have come by the time the measurement was over.
const MEASURED_DURATION: &str = "measured.duration";

/// What goes into a recording: the conditions in the user's file, and the duration asked for.
pub(crate) fn read(file: Option<&Path>, duration: Option<Duration>) -> Result<BTreeMap<String, String>> {
    let mut all = match file {
        Some(file) => {
            let text = fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
            parse(&text).with_context(|| format!("{}", file.display()))?
        }
        None => BTreeMap::new(),
    };
    let duration = duration.map(|duration| humantime::format_duration(duration).to_string());
    all.extend(duration.map(|duration| (MEASURED_DURATION.to_owned(), duration)));
    Ok(all)
}

/// The user's conditions among what a recording keeps; `None` where there are none.
pub(crate) fn conditions(metadata: &BTreeMap<String, String>) -> Option<BTreeMap<String, String>> {
    let users: BTreeMap<_, _> =
        metadata.iter().filter(|(name, _)| *name != MEASURED_DURATION).map(|(n, v)| (n.clone(), v.clone())).collect();
    (!users.is_empty()).then_some(users)
}

/// The data time that the measurement behind a recording was to last.
pub(crate) fn measured_duration(metadata: &BTreeMap<String, String>) -> Option<Duration> {
    humantime::parse_duration(metadata.get(MEASURED_DURATION)?).ok()
}

fn parse(text: &str) -> Result<BTreeMap<String, String>> {
    let table: toml::Table = toml::from_str(text)?;
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
        if name == MEASURED_DURATION {
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
        assert_eq!(conditions(&parsed), Some(parsed));
        for wrong in ["place", "[place]\nname = 1", "place = [1, 2]", "\"measured.duration\" = \"1h\""] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_duration_comes_back_and_is_no_condition() {
        let duration = Duration::from_millis(90_500);
        let all = read(None, Some(duration)).unwrap();
        assert_eq!(measured_duration(&all), Some(duration));
        assert_eq!(conditions(&all), None);
    }
}

//! The conditions of a measurement, kept with its data: what the user writes down, and what was
//! asked of it.

use std::{collections::BTreeMap, fs, path::Path, time::Duration};

use anyhow::{Context, Result, bail};
use toml::Value;
use vn100_analysis::{Goal, Settings};
use vn100_report::parse_toml;

/// Under this name a recording keeps the data time that its measurement was to last. A replay of it
/// ends there too, and so equals it: a line more may have come by the time the measurement was
/// over.
const MEASURED_DURATION: &str = "measured.duration";

/// Likewise what was to be known when the measurement ended, each goal between semicolons.
const MEASURED_UNTIL: &str = "measured.until";

/// What goes into a recording: the conditions in the user's file, and when the measurement was to
/// end.
pub(crate) fn read(file: Option<&Path>, settings: &Settings) -> Result<BTreeMap<String, String>> {
    let mut all = match file {
        Some(file) => {
            let text = fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
            parse(&text).with_context(|| format!("{}", file.display()))?
        }
        None => BTreeMap::new(),
    };
    let duration = settings.duration.map(|duration| humantime::format_duration(duration).to_string());
    all.extend(duration.map(|duration| (MEASURED_DURATION.to_owned(), duration)));
    if !settings.until.is_empty() {
        let goals: Vec<_> = settings.until.iter().map(Goal::to_string).collect();
        all.insert(MEASURED_UNTIL.to_owned(), goals.join("; "));
    }
    Ok(all)
}

/// The user's conditions among what a recording keeps; `None` where there are none.
pub(crate) fn conditions(metadata: &BTreeMap<String, String>) -> Option<BTreeMap<String, String>> {
    let users: BTreeMap<_, _> =
        metadata.iter().filter(|(name, _)| !is_ours(name)).map(|(n, v)| (n.clone(), v.clone())).collect();
    (!users.is_empty()).then_some(users)
}

/// The data time that the measurement behind a recording was to last.
pub(crate) fn measured_duration(metadata: &BTreeMap<String, String>) -> Option<Duration> {
    humantime::parse_duration(metadata.get(MEASURED_DURATION)?).ok()
}

/// What was to be known when the measurement behind a recording ended.
pub(crate) fn measured_until(metadata: &BTreeMap<String, String>) -> Vec<Goal> {
    let goals = metadata.get(MEASURED_UNTIL).map_or("", String::as_str);
    goals.split(';').filter_map(|goal| goal.parse().ok()).collect()
}

fn is_ours(name: &str) -> bool {
    [MEASURED_DURATION, MEASURED_UNTIL].contains(&name)
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
        if is_ours(&name) {
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
    fn when_it_was_to_end_comes_back_and_is_no_condition() {
        let duration = Some(Duration::from_millis(90_500));
        let until = ["gyro N ±5%", "accel_z K ±12.5 %"].map(|goal| goal.parse().unwrap()).to_vec();
        let settings = Settings { duration, until, ..Settings::default() };
        let all = read(None, &settings).unwrap();
        assert_eq!(measured_duration(&all), duration);
        assert_eq!(measured_until(&all), settings.until);
        assert_eq!(conditions(&all), None);
    }
}

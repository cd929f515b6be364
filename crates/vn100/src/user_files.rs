//! What users write as TOML: the conditions of a measurement, kept with its data, and the data
//! sheet of a sensor.

use std::{collections::BTreeMap, fs, io::Read, path::Path};

use anyhow::{Context, Result, bail};
use toml::Value;
use vn100_analysis::{Datasheet, recorded_settings::is_reserved};
use vn100_report::{DATASHEETS, Evaluation, built_in_datasheet, parse_datasheet, parse_toml};

use crate::{args::MeasureArgs, exit::report};

/// A text that a user has written; what is longer than a megabyte is something else.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    const MOST_BYTES: u64 = 1 << 20;
    let mut text = String::new();
    fs::File::open(path)?.take(MOST_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_BYTES {
        bail!("it is longer than 1 MiB");
    }
    Ok(text)
}

pub(crate) fn read_conditions(file: Option<&Path>) -> Result<BTreeMap<String, String>> {
    let Some(file) = file else { return Ok(BTreeMap::new()) };
    let text = read_text(file).with_context(|| format!("cannot read {}", file.display()))?;
    parse_conditions(&text).with_context(|| format!("{}", file.display()))
}

fn parse_conditions(text: &str) -> Result<BTreeMap<String, String>> {
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
            bail!("{name} is a reserved name");
        }
        Ok((name, text))
    };
    table.into_iter().map(entry).collect()
}

/// A built-in one by its name, or a user's.
pub(crate) fn open_datasheet(path: &Path) -> Result<Datasheet> {
    if let Some(sheet) = path.to_str().and_then(built_in_datasheet) {
        return Ok(sheet?);
    }
    if path.extension().is_none() && !path.exists() {
        let names: Vec<&str> = DATASHEETS.iter().map(|(name, _)| *name).collect();
        bail!("{} is neither a file nor a built-in data sheet, which are {}", path.display(), names.join(", "));
    }
    let text = read_text(path).with_context(|| format!("cannot read the data sheet {}", path.display()))?;
    parse_datasheet(&text).with_context(|| format!("the data sheet {}", path.display()))
}

/// What completes every result, as asked for.
pub(crate) fn evaluation(args: &MeasureArgs) -> Result<Evaluation> {
    let datasheet = args.datasheet.as_deref().map(open_datasheet).transpose()?;
    let evaluation =
        Evaluation::new(datasheet, args.fail_on.clone(), args.typical_is_limit).context("the built-in data sheet")?;
    for (figure, sheet) in evaluation.not_deciding() {
        report(&format!(
            "--fail-on \"{figure}\" needs a limit, but {sheet} gives only a typical figure; --typical-is-limit treats it as a limit"
        ));
    }
    Ok(evaluation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_names_and_values() {
        let parsed = parse_conditions("place = \"bench 3\"\ntemperature = 21.5\naxis_up = \"-z\"\n").unwrap();
        assert_eq!(parsed["temperature"], "21.5");
        for wrong in ["place", "[place]\nname = 1", "place = [1, 2]", "\"measured.duration\" = \"1h\""] {
            assert!(parse_conditions(wrong).is_err(), "{wrong}");
        }
    }
}

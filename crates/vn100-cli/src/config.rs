//! The user's settings, kept in a file: how the live view looks, and the port that is meant when
//! none is named. No document, report or exit code depends on them.

use std::{
    env,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use serde::Deserialize;
use vn100_report::parse_toml;

use crate::{exit::report, user_files::read_text};
use vn100_view::{FirstUnits, ThemeChoice};

/// What the file holds; every key may be missing.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Config {
    theme: Option<String>,
    units: Option<String>,
    port: Option<String>,
}

impl Config {
    /// From the file named on the command line.
    pub(crate) fn named(path: PathBuf) -> Result<Self, String> {
        Self::of_file(&path)
    }

    fn of_file(path: &Path) -> Result<Self, String> {
        let read = || -> Result<Self> { Self::parse(&read_text(path).context("cannot be read")?) };
        read().map_err(|error| format!("{error:#}"))
    }

    /// From the file of the user, if there is one. No exit code depends on it: a mistake in it is
    /// reported.
    pub(crate) fn of_user() -> Self {
        let path = user_file(|name| env::var_os(name).map(PathBuf::from)).filter(|path| path.exists());
        path.map_or_else(Self::default, |path| {
            Self::of_file(&path).unwrap_or_else(|error| {
                report(&format!("the settings in {} are not used: {error}", path.display()));
                Self::default()
            })
        })
    }

    fn parse(text: &str) -> Result<Self> {
        let config: Self = parse_toml(text)?;
        // refused here, where their file is named
        config.theme()?;
        config.units()?;
        Ok(config)
    }

    pub(crate) fn theme(&self) -> Result<Option<ThemeChoice>> {
        one_of("theme", self.theme.as_deref())
    }

    pub(crate) fn units(&self) -> Result<Option<FirstUnits>> {
        one_of("units", self.units.as_deref())
    }

    /// The source that is meant when none is named.
    pub(crate) fn port(&self) -> Option<&str> {
        self.port.as_deref()
    }
}

fn one_of<T: ValueEnum>(key: &str, value: Option<&str>) -> Result<Option<T>> {
    let Some(value) = value else { return Ok(None) };
    let known = || T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    match T::from_str(value, false) {
        Ok(value) => Ok(Some(value)),
        Err(_) => {
            let names: Vec<String> = known().map(|value| format!("\"{}\"", value.get_name())).collect();
            bail!("{key} = {value:?} should be one of {}", names.join(", "))
        }
    }
}

/// `vn100/vn100.toml` in the folder of settings.
fn user_file(variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    let folder = variable("XDG_CONFIG_HOME").filter(|path| path.is_absolute());
    let folder = folder.or_else(|| Some(variable("HOME")?.join(".config")))?;
    Some(folder.join("vn100").join("vn100.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_keys_are_known_and_others_named_with_their_line() {
        let config = Config::parse("theme = \"16\"\nunits = \"si\"\nport = \"/dev/imu\"\n").unwrap();
        assert_eq!(config.theme().unwrap(), Some(ThemeChoice::Sixteen));
        assert_eq!(config.units().unwrap(), Some(FirstUnits::Si));
        assert_eq!(config.port(), Some("/dev/imu"));
        assert_eq!(Config::parse("").unwrap(), Config::default());
        for (text, parts) in [
            ("theme = \"dark\"\ncolour = 3\n", &["line 2", "colour", "theme", "units", "port"][..]),
            ("theme = \"pink\"", &["theme", "pink", "\"auto\", \"dark\", \"light\", \"16\""]),
            ("port = 3", &["line 1", "string"]),
        ] {
            let error = format!("{:#}", Config::parse(text).unwrap_err());
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        }
    }

    #[test]
    fn the_file_of_the_user_is_where_settings_are_kept() {
        let of = |variables: &[(&str, &str)]| {
            user_file(|name| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into()))
        };
        let home = ("HOME", "/home/ada");
        assert_eq!(of(&[home]), Some("/home/ada/.config/vn100/vn100.toml".into()));
        assert_eq!(of(&[home, ("XDG_CONFIG_HOME", "/etc/xdg")]), Some("/etc/xdg/vn100/vn100.toml".into()));
        assert_eq!(of(&[home, ("XDG_CONFIG_HOME", "relative")]), Some("/home/ada/.config/vn100/vn100.toml".into()));
        assert_eq!(of(&[]), None);
    }

    #[test]
    fn a_file_that_cannot_be_used_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        let read = || Config::of_file(&path).unwrap_err();
        assert!(read().contains("cannot be read"), "{}", read());
        std::fs::write(&path, "x".repeat(1 << 21)).unwrap();
        assert!(read().contains("1 MiB"));
        std::fs::write(&path, "\nsize = 3").unwrap();
        assert!(read().contains("line 2") && read().contains("size"), "{}", read());
    }
}

//! The options of the live view.

use std::{path::PathBuf, sync::OnceLock};

use anyhow::{Context, Result};
use clap::builder::{PathBufValueParser, TypedValueParser};
use tokio_util::sync::CancellationToken;
use vn100_analysis::Settings;

use vn100_view::{Reference, ThemeChoice, ViewOptions};

use crate::config::Config;

/// How the live view looks; no document, report or exit code depends on it.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Live view")]
pub(crate) struct ViewArgs {
    /// Colours of the live view; auto takes the background from COLORFGBG, else a dark one
    #[arg(long, value_name = "THEME", value_enum)]
    pub(crate) theme: Option<ThemeChoice>,

    /// Show the curve of an earlier record below the present one, measured in the same way
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,

    /// Settings of the user: theme, units and port [default: vn100/vn100.toml in the folder of
    /// settings, ~/.config]
    ///
    /// A TOML file with theme = "auto", "dark", "light" or "16"; units = "datasheet" or "si", those
    /// that the view shows first; port = "/dev/ttyUSB0", the source of attach where none is named.
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(Config::named))]
    config: Option<Config>,
    #[arg(skip)]
    config_of_user: OnceLock<Config>,
}

impl ViewArgs {
    /// Of the file named, else of the user's.
    pub(crate) fn config(&self) -> &Config {
        self.config.as_ref().unwrap_or_else(|| self.config_of_user.get_or_init(Config::of_user))
    }

    /// Of a measurement by these settings, with a page at that address. The reference is measured
    /// from now on.
    pub(crate) fn options(
        &self,
        settings: &Settings,
        page: Option<String>,
        stop: &CancellationToken,
    ) -> Result<ViewOptions> {
        let config = self.config();
        if let Some(path) = &self.reference {
            std::fs::metadata(path).with_context(|| format!("cannot read the reference {}", path.display()))?;
        }
        let measure = |path: &PathBuf| Reference::measure(path.clone(), settings.clone(), stop);
        Ok(ViewOptions {
            theme: self.theme.or(config.theme()?).unwrap_or_default(),
            units: config.units()?.unwrap_or_default(),
            reference: self.reference.as_ref().map(measure),
            page,
        })
    }
}

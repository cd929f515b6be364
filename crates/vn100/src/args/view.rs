//! The options of the live view.

use std::path::PathBuf;

use anyhow::{Context, Result};
use tokio_util::sync::CancellationToken;
use vn100_analysis::Settings;
use vn100_view::{Reference, ThemeChoice, ViewOptions};

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
}

impl ViewArgs {
    /// Of a measurement by these settings, with a page at that address. The reference is measured
    /// from now on.
    pub(crate) fn options(
        &self,
        settings: &Settings,
        page: Option<String>,
        stop: &CancellationToken,
    ) -> Result<ViewOptions> {
        if let Some(path) = &self.reference {
            std::fs::metadata(path).with_context(|| format!("cannot read the reference {}", path.display()))?;
        }
        let measure = |path: &PathBuf| Reference::measure(path.clone(), settings.clone(), stop);
        Ok(ViewOptions { theme: self.theme.unwrap_or_default(), reference: self.reference.as_ref().map(measure), page })
    }
}

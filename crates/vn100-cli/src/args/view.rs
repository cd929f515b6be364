//! The options of the live view.

use crate::view::{ThemeChoice, ViewOptions};

/// How the live view looks; no document, report or exit code depends on it.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Live view")]
pub(crate) struct ViewArgs {
    /// Colours of the live view; auto asks the terminal for its background
    #[arg(long, value_name = "THEME", value_enum)]
    pub(crate) theme: Option<ThemeChoice>,
}

impl ViewArgs {
    pub(crate) fn options(&self) -> ViewOptions {
        ViewOptions { theme: self.theme.unwrap_or_default() }
    }
}

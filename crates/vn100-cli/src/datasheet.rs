//! The data sheet that a user names, and what results are completed with.

use std::{fs, path::Path};

use anyhow::{Context, Result};
use vn100_analysis::Datasheet;
use vn100_report::{Evaluation, parse_datasheet};

use crate::args::MeasureArgs;

/// A user's.
///
/// # Errors
/// When the file cannot be read, is not TOML, or a figure makes no sense; with file, line and the
/// choices there are.
pub(crate) fn open(path: &Path) -> Result<Datasheet> {
    let text = fs::read_to_string(path).with_context(|| format!("cannot read the data sheet {}", path.display()))?;
    parse_datasheet(&text).with_context(|| format!("the data sheet {}", path.display()))
}

/// What completes every result, as asked for.
///
/// # Errors
/// When the data sheet cannot be read.
pub(crate) fn evaluation(args: &MeasureArgs) -> Result<Evaluation> {
    let datasheet = args.datasheet.as_deref().map(open).transpose()?;
    Evaluation::new(datasheet, args.fail_on.clone()).context("the built-in data sheet")
}

//! Options of the command that writes reports.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use clap::builder::{PossibleValue, PossibleValuesParser};
use vn100_report::ExportForm;

use super::{FileArgs, ForceArgs, duration::length, export::ScaleFactorArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// The page to write, ending in .html; another name begins the names of what is exported, and
    /// no page is written [default: NAME.html in the working folder, of the capture NAME]
    #[arg(short, long, help_heading = "Output", value_name = "OUT")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) existing: ForceArgs,

    /// Write the numbers for other programs beside it: once for each form, or with commas between
    /// them
    #[arg(long, help_heading = "Exports", value_name = "FORM", value_parser = export_forms(), value_delimiter = ',')]
    pub(crate) export: Vec<String>,

    /// How long a filter integrates: its random walk drifts over this time as the bias instability
    /// does
    #[arg(long, help_heading = "Exports", value_name = "T", value_parser = length, default_value = "60s")]
    pub(crate) span: Duration,

    /// Take from the data sheet what the record does not show of the values for a filter, marked in
    /// a comment
    #[arg(long, help_heading = "Exports")]
    pub(crate) fill_from_datasheet: bool,

    #[command(flatten)]
    pub(crate) not_shown: ScaleFactorArgs,
}

impl ReportArgs {
    /// The page, or the beginning of the names if no page is wanted.
    pub(crate) fn output(&self) -> PathBuf {
        self.output.clone().unwrap_or_else(|| match &self.files.files[..] {
            [only] if only == Path::new("-") => "stdin.html".into(),
            [only] => page_of(only),
            _ => "report.html".into(),
        })
    }

    /// What the options ask for together, and cannot have.
    pub(super) fn refused(&self) -> Option<String> {
        let output = self.output();
        let is_pdf = output.extension().is_some_and(|end| end.eq_ignore_ascii_case("pdf"));
        if is_page(&output) || (!is_pdf && !self.export.is_empty()) {
            return self.files.refused_taus();
        }
        let advice = match is_pdf {
            true => "name a page, and print it as PDF in a browser",
            false => "and nothing is exported: name a page, or --export something",
        };
        Some(format!("{} does not end in .html, {advice}", output.display()))
    }
}

pub(crate) fn is_page(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("html") || end.eq_ignore_ascii_case("htm"))
}

/// The page of a capture: its name, in the working folder.
fn page_of(capture: &Path) -> PathBuf {
    const COMPRESSED: [&str; 5] = ["gz", "zst", "bz2", "xz", "zip"];
    let name = Path::new(capture.file_name().unwrap_or("report".as_ref()));
    let is_compressed =
        name.extension().is_some_and(|end| COMPRESSED.iter().any(|form| end.eq_ignore_ascii_case(form)));
    let name = if is_compressed { name.with_extension("") } else { name.to_owned() };
    name.with_extension("html")
}

fn export_forms() -> PossibleValuesParser {
    PossibleValuesParser::new(ExportForm::all().into_iter().map(|form| PossibleValue::new(form.name).help(form.help)))
}

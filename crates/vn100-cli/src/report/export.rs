//! The numbers of a report in the forms other programs read.

mod cdr;
pub(crate) mod kalibr;
mod ros2;
mod tables;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::{figure::Figure, figures::Figures, output::Output, record::Record};
use crate::{
    args::{ExportForm, ReportArgs},
    document::Document,
    exit::json_line,
};

/// What comes out of a report beside its page.
pub(crate) struct Exports<'a> {
    /// Each once.
    forms: Vec<ExportForm>,
    args: &'a ReportArgs,
    output: &'a Output,
}

impl<'a> Exports<'a> {
    /// Fails early, where something is in the way.
    pub(crate) fn new(args: &'a ReportArgs, output: &'a Output) -> Result<Self> {
        let mut forms: Vec<ExportForm> = Vec::new();
        for form in &args.export {
            if !forms.contains(form) {
                forms.push(*form);
            }
        }
        let exports = Self { forms, args, output };
        let inputs = &args.files.files;
        for form in &exports.forms {
            for index in 0..inputs.len() {
                for ending in endings(*form) {
                    let path = exports.path(index, ending);
                    match form {
                        ExportForm::Svg | ExportForm::Png => output.check_folder(&path, inputs)?,
                        _ => output.check(&path, inputs)?,
                    }
                }
            }
        }
        if args.export.contains(&ExportForm::Mcap) && inputs.iter().any(|input| input == Path::new("-")) {
            bail!("--export mcap reads the capture again: give a file instead of standard input");
        }
        Ok(exports)
    }

    /// Writes all of them. A form that a record does not allow is an error; the others are written
    /// before it is told.
    ///
    /// `together` are the figures of several records, which only SVG and PNG hold.
    pub(crate) fn write(&self, records: &[Record<'_>], figures: &[Figures], together: &Figures) -> Result<()> {
        let mut refused = None;
        for form in &self.forms {
            for (index, (record, figures)) in records.iter().zip(figures).enumerate() {
                // nothing could be read: the command says so already
                if record.snapshot().timing.samples == 0 {
                    continue;
                }
                if let Err(error) = self.write_one(*form, index, record, figures) {
                    refused.get_or_insert(error);
                }
            }
        }
        if records.len() > 1 {
            for form in &self.forms {
                match form {
                    ExportForm::Svg => self.write_figures(&self.output.beside(SVG), "svg", together, |figure| {
                        Ok(figure.svg_file().into_bytes())
                    })?,
                    ExportForm::Png => {
                        self.write_figures(&self.output.beside(PNG), "png", together, Figure::png_file)?;
                    }
                    ExportForm::Csv | ExportForm::Json | ExportForm::Kalibr | ExportForm::Mcap => {}
                }
            }
        }
        refused.map_or(Ok(()), Err)
    }

    fn write_one(&self, form: ExportForm, index: usize, record: &Record<'_>, figures: &Figures) -> Result<()> {
        let path = |ending: &str| self.path(index, ending);
        match form {
            ExportForm::Csv => {
                for (ending, table) in tables::tables(record) {
                    self.output.write(&path(ending), table.as_bytes())?;
                }
                Ok(())
            }
            ExportForm::Json => {
                let document = serde_json::to_string_pretty(&Document::of(record.measured))?;
                self.output.write(&path(JSON), json_line(&document).as_bytes())
            }
            ExportForm::Kalibr => {
                let yaml = kalibr::yaml(record, self.args.filter_models);
                yaml.complete()?;
                self.output.write(&path(KALIBR), yaml.text().as_bytes())
            }
            ExportForm::Svg => {
                self.write_figures(&path(SVG), "svg", figures, |figure| Ok(figure.svg_file().into_bytes()))
            }
            ExportForm::Png => self.write_figures(&path(PNG), "png", figures, Figure::png_file),
            ExportForm::Mcap => {
                let files = &self.args.files;
                let input = files.files.get(index).context("no such capture")?;
                let bytes = ros2::mcap(input, files, record)?;
                self.output.write(&path(MCAP), &bytes)
            }
        }
    }

    fn write_figures(
        &self,
        folder: &Path,
        ending: &str,
        figures: &Figures,
        bytes: impl Fn(&Figure) -> Result<Vec<u8>>,
    ) -> Result<()> {
        self.output.make_folder(folder)?;
        for figure in figures.all() {
            self.output.write(&folder.join(format!("{}.{ending}", figure.id)), &bytes(figure)?)?;
        }
        Ok(())
    }

    /// Captures are numbered from 1 where there are several.
    fn path(&self, index: usize, ending: &str) -> PathBuf {
        match self.args.files.files.len() {
            0 | 1 => self.output.beside(ending),
            _ => self.output.beside(&format!("-{}{ending}", index + 1)),
        }
    }
}

const JSON: &str = ".json";
const KALIBR: &str = ".imu.yaml";
// folders, for there are many figures
const SVG: &str = ".svg-figures";
const PNG: &str = ".png-figures";
const MCAP: &str = ".ros2.mcap";

fn endings(form: ExportForm) -> &'static [&'static str] {
    match form {
        ExportForm::Csv => &tables::ENDINGS,
        ExportForm::Json => &[JSON],
        ExportForm::Kalibr => &[KALIBR],
        ExportForm::Svg => &[SVG],
        ExportForm::Png => &[PNG],
        ExportForm::Mcap => &[MCAP],
    }
}

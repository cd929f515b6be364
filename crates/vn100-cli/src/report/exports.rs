//! The numbers of a report in the forms other programs read.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, anyhow, bail};
use tokio::runtime::Builder;
use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, Event};
use vn100_report::{CsvTable, Document, Figures, KalibrError, KalibrYaml, Record, Ros2Messages, json_line};

use super::{PROGRAM, output::Output};
use crate::{
    args::{ExportForm, FileArgs, ReportArgs},
    inputs::FileStream,
    words::remedy_words,
};

pub(crate) struct Exports<'a> {
    /// Each once.
    forms: Vec<ExportForm>,
    args: &'a ReportArgs,
    inputs: &'a [FileStream],
    output: &'a Output,
}

impl<'a> Exports<'a> {
    /// Fails early where a file exists.
    pub(crate) fn new(args: &'a ReportArgs, inputs: &'a [FileStream], output: &'a Output) -> Result<Self> {
        let mut forms: Vec<ExportForm> = Vec::new();
        for form in &args.export {
            if !forms.contains(form) {
                forms.push(*form);
            }
        }
        let exports = Self { forms, args, inputs, output };
        let files = &args.files.files;
        for form in &exports.forms {
            for index in 0..inputs.len() {
                for ending in endings(*form) {
                    let path = exports.path(index, ending);
                    match form {
                        ExportForm::Svg | ExportForm::Png => output.check_folder(&path, files)?,
                        _ => output.check(&path, files)?,
                    }
                }
            }
        }
        if args.export.contains(&ExportForm::Mcap) && files.iter().any(|file| file == Path::new("-")) {
            bail!("--export mcap reads the capture again: give a file instead of standard input");
        }
        Ok(exports)
    }

    /// Writes all of them. A form that a record does not allow is an error; the others are written
    /// before it is reported.
    ///
    /// `together` are the figures of several records, which only SVG and PNG hold.
    pub(crate) fn write(&self, records: &[Record<'_>], figures: &[Figures], together: &Figures) -> Result<()> {
        let mut refused = None;
        for form in &self.forms {
            for (index, (record, figures)) in records.iter().zip(figures).enumerate() {
                // nothing could be read: the command says so already
                if record.measured.snapshot.timing.samples == 0 {
                    continue;
                }
                if let Err(error) = self.write_one(*form, index, record, figures) {
                    refused.get_or_insert(error);
                }
            }
        }
        if records.len() > 1 {
            let forms = self.forms.iter().filter(|form| matches!(form, ExportForm::Svg | ExportForm::Png));
            for form in forms {
                self.write_figures(*form, |ending| self.output.beside(ending), together)?;
            }
        }
        refused.map_or(Ok(()), Err)
    }

    fn write_one(&self, form: ExportForm, index: usize, record: &Record<'_>, figures: &Figures) -> Result<()> {
        let path = |ending: &str| self.path(index, ending);
        match form {
            ExportForm::Csv => {
                CsvTable::ALL.iter().try_for_each(|table| self.text(&path(table.ending), &(table.text)(record)))
            }
            ExportForm::Json => {
                let document = serde_json::to_string_pretty(&Document::new(record.measured, true, remedy_words))?;
                self.text(&path(JSON), &json_line(&document))
            }
            ExportForm::Kalibr => {
                let yaml = KalibrYaml::of(record, self.args.filter_models);
                yaml.complete().map_err(|error| anyhow!(refused(&error)))?;
                self.text(&path(KALIBR), &yaml.text())
            }
            ExportForm::Svg | ExportForm::Png => self.write_figures(form, path, figures),
            ExportForm::Mcap => {
                let files = &self.args.files;
                let input = self.inputs.get(index).context("no such capture")?;
                self.output.write(&path(MCAP), |file| write_samples(file, input, files, record))
            }
        }
    }

    /// Writes figures as SVG or else as PNG, into a folder of that ending.
    fn write_figures(&self, form: ExportForm, path: impl Fn(&str) -> PathBuf, figures: &Figures) -> Result<()> {
        let (folder, ending) = if form == ExportForm::Svg { (path(SVG), "svg") } else { (path(PNG), "png") };
        self.output.make_folder(&folder)?;
        for figure in figures.all() {
            let bytes = if form == ExportForm::Svg { figure.svg_file().into_bytes() } else { figure.png_file()? };
            let path = folder.join(format!("{}.{ending}", figure.id));
            self.output.write(&path, |file| Ok(file.write_all(&bytes)?))?;
        }
        Ok(())
    }

    fn text(&self, path: &Path, text: &str) -> Result<()> {
        self.output.write(path, |file| Ok(file.write_all(text.as_bytes())?))
    }

    /// Captures are numbered from 1 where there are several.
    fn path(&self, index: usize, ending: &str) -> PathBuf {
        match self.inputs.len() {
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

fn endings(form: ExportForm) -> Vec<&'static str> {
    match form {
        ExportForm::Csv => CsvTable::ALL.map(|table| table.ending).to_vec(),
        ExportForm::Json => vec![JSON],
        ExportForm::Kalibr => vec![KALIBR],
        ExportForm::Svg => vec![SVG],
        ExportForm::Png => vec![PNG],
        ExportForm::Mcap => vec![MCAP],
    }
}

/// Reads the capture again, with the time base that is now known.
fn write_samples(out: impl Write, input: &FileStream, files: &FileArgs, record: &Record<'_>) -> Result<()> {
    let mut messages = Ros2Messages::new(out, record, PROGRAM.name)?;
    let runtime = Builder::new_current_thread().build().context("cannot read the capture again")?;
    runtime.block_on(async {
        let capture = Capture::open(&input.path, &input.options)?;
        let mut events = capture.read(files.measure.read_options(), CancellationToken::new())?;
        while let Some(event) = events.recv().await {
            if let Event::Batch(batch) = event {
                messages.push(&batch)?;
            }
        }
        anyhow::Ok(())
    })?;
    messages.finish()?;
    Ok(())
}

fn refused(error: &KalibrError) -> String {
    match error {
        KalibrError::Moved => format!("no imu.yaml for Kalibr: {error}. Record it at rest"),
        KalibrError::Lacks(_) => format!(
            "no imu.yaml for Kalibr: {error}. --filter-models gives a white noise and a random walk that lie above the whole curve instead"
        ),
    }
}

//! The numbers of a report in the forms other programs read.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Error, Result, anyhow};
use vn100_analysis::{Completion, SourceResult};
use vn100_report::{
    Consumer, CsvTable, Document, Evaluation, FilterNoise, NotWritten,
    figure::{Figures, ReportFigures},
    json_line,
};

use vn100_session::ReplaySpec;

use super::print_written;
use vn100_report::remedies::remedy_words;

use crate::{
    args::{ExportForm, ReportArgs},
    exit::report as complain,
    output::Output,
};

pub(crate) struct Exports<'a> {
    /// Each once.
    forms: Vec<ExportForm>,
    args: &'a ReportArgs,
    inputs: &'a [ReplaySpec],
    output: &'a Output,
}

impl<'a> Exports<'a> {
    /// Fails early where a file exists.
    pub(crate) fn new(args: &'a ReportArgs, inputs: &'a [ReplaySpec], output: &'a Output) -> Result<Self> {
        let mut forms: Vec<ExportForm> = Vec::new();
        for form in &args.export {
            if !forms.iter().any(|other| other.name() == form.name()) {
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
                        ExportForm::Svg => output.check_folder(&path, files)?,
                        _ => output.check(&path, files)?,
                    }
                }
            }
        }
        Ok(exports)
    }

    /// Writes all of them. A form that a record does not allow is reported and fails the command;
    /// the others are written. Only SVG holds the figures of several records together.
    pub(crate) fn write(
        &self,
        records: &[SourceResult],
        figures: &ReportFigures,
        evaluation: &Evaluation,
    ) -> Completion {
        let mut completion = Completion::Complete;
        let mut check = |written: Result<()>| {
            if let Err(error) = written {
                complain(&format!("{error:#}"));
                completion = Completion::Failed;
            }
        };
        for form in &self.forms {
            for (index, (record, figures)) in records.iter().zip(&figures.records).enumerate() {
                // nothing could be read: the command says so already
                if record.timing.samples == 0 {
                    continue;
                }
                check(self.write_one(*form, index, record, figures, evaluation));
            }
        }
        if records.len() > 1 && self.forms.iter().any(|form| matches!(form, ExportForm::Svg)) {
            check(self.write_figures(&self.output.beside(SVG), &figures.together));
        }
        completion
    }

    fn write_one(
        &self,
        form: ExportForm,
        index: usize,
        record: &SourceResult,
        figures: &Figures,
        evaluation: &Evaluation,
    ) -> Result<()> {
        let path = |ending: &str| self.path(index, ending);
        match form {
            ExportForm::Csv => (CsvTable::ALL.iter())
                .try_for_each(|table| self.text(&path(table.ending), &table.text(record, remedy_words))),
            ExportForm::Json => {
                let document = serde_json::to_string(&Document::new(record, remedy_words))?;
                self.text(&path(JSON), &json_line(&document))
            }
            ExportForm::Svg => self.write_figures(&path(SVG), figures),
            ExportForm::Filter(consumer) => self.write_filter(consumer, index, record, evaluation),
        }
    }

    fn write_filter(
        &self,
        consumer: &Consumer,
        index: usize,
        record: &SourceResult,
        evaluation: &Evaluation,
    ) -> Result<()> {
        let mut noise = FilterNoise::of(record, self.args.span.as_secs_f64());
        noise.scale_factor_ppm = self.args.not_shown.scale_factor;
        if self.args.fill_from_datasheet {
            evaluation.fill(&mut noise, record);
        }
        let path = self.path(index, consumer.ending);
        let text = consumer.file(&noise).map_err(|error| not_written(&path, &error))?;
        self.text(&path, &text)
    }

    fn write_figures(&self, folder: &Path, figures: &Figures) -> Result<()> {
        self.output.make_folder(folder)?;
        for figure in figures.all() {
            let path = folder.join(format!("{}.svg", figure.id));
            self.output.write(&path, |file| Ok(file.write_all(figure.svg_file().as_bytes())?))?;
        }
        print_written(folder)
    }

    fn text(&self, path: &Path, text: &str) -> Result<()> {
        self.output.write(path, |file| Ok(file.write_all(text.as_bytes())?))?;
        print_written(path)
    }

    /// Captures are numbered from 1 if there are several.
    fn path(&self, index: usize, ending: &str) -> PathBuf {
        match self.inputs.len() {
            0 | 1 => self.output.beside(ending),
            _ => self.output.beside(&format!("-{}{ending}", index + 1)),
        }
    }
}

const JSON: &str = ".json";
// a folder, because there are many figures
const SVG: &str = ".svg-figures";

fn endings(form: ExportForm) -> Vec<&'static str> {
    match form {
        ExportForm::Csv => CsvTable::ALL.map(|table| table.ending).to_vec(),
        ExportForm::Json => vec![JSON],
        ExportForm::Svg => vec![SVG],
        ExportForm::Filter(consumer) => vec![consumer.ending],
    }
}

/// Why the file of a filter is not written, and what would give what it lacks.
pub(crate) fn not_written(path: &Path, error: &NotWritten) -> Error {
    anyhow!("{} not written: {error}. To get it: {}", path.display(), error.advice(remedy_words))
}

//! The numbers of a report in the forms other programs read.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Error, Result, anyhow};
use vn100_analysis::{Completion, SourceResult};
use vn100_report::{
    Evaluation, ExportForm, Exported, ExportedFile, FIGURES_ENDING, FilterNoise, NotWritten,
    figure::{Figures, ReportFigures},
    figure_files,
};

use vn100_session::ReplaySpec;

use super::print_written;
use vn100_report::remedies::remedy_words;

use crate::{args::ReportArgs, exit::report as complain, output::Output};

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
        let mut all = ExportForm::all();
        let mut take = |name: &String| Some(all.remove(all.iter().position(|form| form.name == name)?));
        let forms = args.export.iter().filter_map(&mut take).collect();
        let exports = Self { forms, args, inputs, output };
        let files = &args.files.files;
        for form in &exports.forms {
            for index in 0..inputs.len() {
                for ending in &form.endings {
                    let path = exports.path(index, ending);
                    match *ending {
                        FIGURES_ENDING => output.check_folder(&path, files)?,
                        _ => output.check(&path, files)?,
                    }
                }
            }
        }
        Ok(exports)
    }

    /// Writes all of them. A form that a record does not allow is reported and fails the command;
    /// the others are written. Only figures are of several records together.
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
                if record.timing.samples > 0 {
                    check(self.write_one(form, index, &self.exported(records, index, figures, evaluation)));
                }
            }
        }
        if records.len() > 1 && self.forms.iter().any(|form| form.endings.contains(&FIGURES_ENDING)) {
            check(self.write_folder(&self.output.beside(FIGURES_ENDING), &figure_files(&figures.together)));
        }
        completion
    }

    fn exported<'b>(
        &self,
        records: &'b [SourceResult],
        index: usize,
        figures: &'b Figures,
        evaluation: &Evaluation,
    ) -> Exported<'b> {
        let (result, input, span_s) = (&records[index], &self.inputs[index], self.args.span.as_secs_f64());
        let mut noise = FilterNoise::of(result, span_s);
        let others = records.iter().zip(self.inputs).enumerate();
        // streams of one file
        let others = others.filter(|(place, (_, other))| *place != index && other.path == input.path);
        others.for_each(|(_, (other, _))| noise.join(&FilterNoise::of(other, span_s)));
        noise.scale_factor_ppm = self.args.not_shown.scale_factor;
        if self.args.fill_from_datasheet {
            evaluation.fill(&mut noise, result);
        }
        Exported { result, figures, noise, words: remedy_words }
    }

    fn write_one(&self, form: &ExportForm, index: usize, exported: &Exported<'_>) -> Result<()> {
        let path = |ending: &str| self.path(index, ending);
        let files = form.files(exported).map_err(|error| not_written(&path(&form.endings.concat()), &error))?;
        if form.endings == [FIGURES_ENDING] {
            return self.write_folder(&path(FIGURES_ENDING), &files);
        }
        files.iter().try_for_each(|(ending, text)| {
            self.text(&path(ending), text)?;
            print_written(&path(ending))
        })
    }

    fn write_folder(&self, folder: &Path, files: &[ExportedFile]) -> Result<()> {
        self.output.make_folder(folder)?;
        files.iter().try_for_each(|(name, text)| self.text(&folder.join(name), text))?;
        print_written(folder)
    }

    fn text(&self, path: &Path, text: &str) -> Result<()> {
        self.output.write(path, |file| Ok(file.write_all(text.as_bytes())?))
    }

    /// Captures are numbered from 1 if there are several.
    fn path(&self, index: usize, ending: &str) -> PathBuf {
        match self.inputs.len() {
            0 | 1 => self.output.beside(ending),
            _ => self.output.beside(&format!("-{}{ending}", index + 1)),
        }
    }
}

/// Why the file of a filter is not written, and what would give what it lacks.
pub(crate) fn not_written(path: &Path, error: &NotWritten) -> Error {
    anyhow!("{} not written: {error}. To get it: {}", path.display(), error.advice(remedy_words))
}

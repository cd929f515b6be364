//! The numbers of a report in the forms other programs read.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Error, Result, anyhow};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use vn100_analysis::{Completion, SourceResult};
use vn100_report::{
    Consumer, CsvTable, Document, Evaluation, FilterNoise, NotWritten,
    figure::{Figure, Figures},
    json_line, printable,
};

use super::print_written;
use vn100_report::remedies::remedy_words;

use crate::{
    args::{ExportForm, FileArgs, ReportArgs},
    exit::report as complain,
    inputs::FileStream,
    log::takes_terminal,
    output::Output,
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
    /// the others are written.
    ///
    /// `together` are the figures of several records, which only SVG holds.
    pub(crate) fn write(
        &self,
        records: &[SourceResult],
        figures: &[Figures],
        together: &Figures,
        evaluation: &Evaluation,
    ) -> Completion {
        let mut completion = Completion::Complete;
        let mut check = |written: Result<()>| {
            if let Err(error) = written {
                complain(&format!("{error:#}"));
                completion = Completion::Failed;
            }
        };
        let all_figures = || figures.iter().chain([together]).flat_map(Figures::all);
        let unknown = self.args.figures.iter().find(|name| !all_figures().any(|figure| is_named(figure, name)));
        if let Some(unknown) = unknown {
            let mut names: Vec<&str> = Vec::new();
            for name in all_figures().map(Figure::name) {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            check(Err(anyhow!("unknown figure {unknown}; the figures are {}", names.join(", "))));
        }
        let forms = self.forms.iter().filter(|form| unknown.is_none() || !is_svg(form));
        for form in forms.clone() {
            for (index, (record, figures)) in records.iter().zip(figures).enumerate() {
                // nothing could be read: the command says so already
                if record.timing.samples == 0 {
                    continue;
                }
                check(self.write_one(*form, index, record, figures, evaluation));
            }
        }
        if records.len() > 1 && forms.into_iter().any(is_svg) {
            check(self.write_figures(&self.output.beside(SVG), together));
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

    /// Writes the file of a filter.
    fn write_filter(
        &self,
        consumer: &Consumer,
        index: usize,
        record: &SourceResult,
        evaluation: &Evaluation,
    ) -> Result<()> {
        let mut noise = FilterNoise::of(record, self.args.span.as_secs_f64());
        noise.scale_factor_ppm = self.args.scale_factor;
        if self.args.fill_from_datasheet {
            evaluation.fill(&mut noise, record);
        }
        let path = self.path(index, consumer.ending);
        let text = consumer.file(&noise, self.args.require_estimated).map_err(|error| not_written(&path, &error))?;
        self.text(&path, &text)
    }

    /// Writes figures into this folder.
    fn write_figures(&self, folder: &Path, figures: &Figures) -> Result<()> {
        self.output.make_folder(folder)?;
        let chosen = &self.args.figures;
        let is_chosen = |figure: &&Figure| chosen.is_empty() || chosen.iter().any(|name| is_named(figure, name));
        let figures: Vec<&Figure> = figures.all().filter(is_chosen).collect();
        let progress = progress(folder, figures.len() as u64, &self.args.files);
        for figure in figures {
            let path = folder.join(format!("{}.svg", figure.id));
            self.output.write(&path, |file| Ok(file.write_all(figure.svg_file().as_bytes())?))?;
            progress.inc(1);
        }
        progress.finish_and_clear();
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

/// Whether a figure is of that kind, channel or sensor, or has that name, with or without its run
/// before it: `allan`, `gyro_y`, `allan-gyro_y` and `run1-allan-gyro_y` are all names of one. A run
/// alone is no name.
fn is_named(figure: &Figure, name: &str) -> bool {
    figure.id == name || format!("-{}-", figure.name()).contains(&format!("-{name}-"))
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

/// A bar for the parts of a file or folder.
fn progress(path: &Path, parts: u64, files: &FileArgs) -> ProgressBar {
    let target = if takes_terminal(&files.log) { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    // the default style stands in for a template it does not understand
    let style = ProgressStyle::with_template("writing {prefix} {wide_bar} {percent} % {eta}");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    let name = path.file_name().map_or_else(String::new, |name| printable(&name.to_string_lossy()));
    ProgressBar::with_draw_target(Some(parts), target).with_style(style).with_prefix(name)
}

const fn is_svg(form: &ExportForm) -> bool {
    matches!(form, ExportForm::Svg)
}

/// Why the file of a filter is not written, and what would give what it lacks.
pub(crate) fn not_written(path: &Path, error: &NotWritten) -> Error {
    let advice = match error {
        NotWritten::Moved => "record it at rest".into(),
        NotWritten::NotEstimated(_) => "record longer, or remove --require-estimated".into(),
        NotWritten::Lacks(_) => error.advice(remedy_words).join(", or "),
    };
    anyhow!("{} not written: {error}. To get it: {advice}", path.display())
}

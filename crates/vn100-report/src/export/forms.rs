//! The forms in which the numbers of a record are written for other programs: one row each.

use vn100_analysis::{RemedyWords, SourceResult};

use super::{
    consumers::Consumer,
    filter_noise::{FilterNoise, NotWritten},
    tables::CsvTable,
};
use crate::{document::Document, figure::Figures, printable::json_line};

/// A form of the numbers of a record.
pub struct ExportForm {
    /// The name that selects it, such as `csv`.
    pub name: &'static str,
    /// What it is.
    pub help: String,
    /// What the names of its files end with, or that of their folder.
    pub endings: Vec<&'static str>,
    files: Box<dyn Fn(&Exported<'_>) -> Files>,
}

/// What the name of a file ends with, or in a folder its name; and its text.
pub type ExportedFile = (String, String);

type Files = Result<Vec<ExportedFile>, NotWritten>;

/// What is exported of a record.
#[derive(Debug)]
pub struct Exported<'a> {
    /// Its numbers.
    pub result: &'a SourceResult,
    /// Its figures.
    pub figures: &'a Figures,
    /// What a filter takes of it.
    pub noise: FilterNoise,
    /// The words for remedies.
    pub words: RemedyWords,
}

/// The ending of the folder of the figures, which are many.
pub const FIGURES_ENDING: &str = ".svg-figures";

impl ExportForm {
    /// All forms.
    pub fn all() -> Vec<Self> {
        let own = [
            form(
                "csv",
                "Metadata, curves, statistics, parameters in all units, verdicts, warnings and spectra as tables",
                CsvTable::ALL.map(|table| table.ending).into(),
                |of| Ok(CsvTable::ALL.map(|table| (table.ending.into(), table.text(of.result, of.words))).into()),
            ),
            form("json", "The document with every number, as JSON", vec![".json"], |of| {
                // a document has nothing that JSON does not have
                let document = serde_json::to_string(&Document::new(of.result, of.words)).unwrap_or_default();
                Ok(vec![(".json".into(), json_line(&document))])
            }),
            form("svg", "Each figure as SVG, in a folder", vec![FIGURES_ENDING], |of| Ok(figure_files(of.figures))),
        ];
        let of_consumer = |consumer: &'static Consumer| {
            form(consumer.name, consumer.help(), vec![consumer.ending], |of| {
                Ok(vec![(consumer.ending.into(), consumer.file(&of.noise)?)])
            })
        };
        own.into_iter().chain(Consumer::ALL.iter().map(of_consumer)).collect()
    }

    /// Its files.
    ///
    /// # Errors
    /// [`NotWritten`] if a program needs a value that is not known.
    pub fn files(&self, of: &Exported<'_>) -> Result<Vec<ExportedFile>, NotWritten> {
        (self.files)(of)
    }
}

fn form(
    name: &'static str,
    help: impl Into<String>,
    endings: Vec<&'static str>,
    files: impl Fn(&Exported<'_>) -> Files + 'static,
) -> ExportForm {
    ExportForm { name, help: help.into(), endings, files: Box::new(files) }
}

/// A file for each of these figures.
pub fn figure_files(figures: &Figures) -> Vec<ExportedFile> {
    figures.all().map(|figure| (format!("{}.svg", figure.id), figure.svg_file())).collect()
}

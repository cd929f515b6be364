//! The forms in which the page shows and saves results.

use serde::Serialize;
use vn100_analysis::{DEFAULT_CONFIDENCE, SourceResult};
use vn100_report::{
    Consumer, CsvTable, DEFAULT_SPAN_S, Document, Evaluation, FilterNoise,
    figure::ReportFigures,
    html::{PageOptions, Program, report_page},
    json_line,
    remedies::{page_words, remedy_words},
    run_name,
};

use crate::tab::Tab;

const PROGRAM: Program<'static> =
    Program { name: concat!("vn100 ", env!("CARGO_PKG_VERSION")), commit: option_env!("VN100_COMMIT") };

/// A form in which results can be saved.
#[derive(Debug, Clone, Serialize)]
pub struct Output {
    /// The kind of the form.
    pub group: &'static str,
    /// What the form is, within its kind.
    pub label: String,
    /// Name of the file, which [`Tab::output`] takes.
    pub file: String,
    /// Why there is none, and what would give it; `None` if there is one.
    pub missing: Option<String>,
    #[serde(skip)]
    content: Content,
}

#[derive(Debug, Clone)]
enum Content {
    Page,
    Document(usize),
    Table(usize, CsvTable),
    Filter(usize, &'static Consumer),
}

impl Tab {
    /// All forms of the records: the page first, then those of each record.
    pub fn outputs(&self) -> Vec<Output> {
        let output = |group, label: &str, file: String, content| Output {
            group,
            label: label.to_owned(),
            file,
            missing: None,
            content,
        };
        let mut all = vec![output("Report", "HTML", format!("{}.html", self.stem), Content::Page)];
        let has_samples = |index: &usize| self.records[*index].timing.samples > 0;
        for index in (0..self.records.len()).filter(has_samples) {
            let (stem, of) = match self.records.len() {
                1 => (self.stem.clone(), String::new()),
                _ => (format!("{}-{}", self.stem, index + 1), format!(" of {}", run_name(index))),
            };
            let named = |ending: &str| format!("{stem}{ending}");
            all.push(output("Report", &format!("JSON{of}"), named(".json"), Content::Document(index)));
            all.extend(CsvTable::ALL.map(|table| {
                let label = table.ending.trim_matches('.').trim_end_matches(".csv");
                output("Table (CSV)", &format!("{label}{of}"), named(table.ending), Content::Table(index, table))
            }));
            all.extend(Consumer::ALL.iter().map(|consumer| {
                let content = Content::Filter(index, consumer);
                let missing = self.filter(index, consumer).err();
                let label = format!("{}{of}", consumer.title);
                Output { missing, ..output("Filter or simulator", &label, named(consumer.ending), content) }
            }));
        }
        all
    }

    /// The content of the file with this name; `None` if there is none.
    pub fn output(&self, file: &str) -> Option<String> {
        let output = self.outputs().into_iter().find(|output| output.file == file)?;
        match output.content {
            Content::Page => self.page(),
            Content::Document(index) => {
                let document = serde_json::to_string(&Document::new(&self.records[index], remedy_words)).ok()?;
                Some(json_line(&document))
            }
            Content::Table(index, table) => Some(table.text(&self.records[index], remedy_words)),
            Content::Filter(index, consumer) => self.filter(index, consumer).ok(),
        }
    }

    /// The report of all records; `None` if nothing was read of any.
    pub fn page(&self) -> Option<String> {
        if self.records.iter().all(|record| record.link.bytes == 0) {
            return None;
        }
        let options = PageOptions {
            confidence: DEFAULT_CONFIDENCE,
            asked: &self.asked,
            words: page_words,
            program: PROGRAM,
            span_s: DEFAULT_SPAN_S,
        };
        Some(report_page(&self.records, &ReportFigures::of(&self.records), options))
    }

    fn filter(&self, index: usize, consumer: &Consumer) -> Result<String, String> {
        let record: &SourceResult = &self.records[index];
        let mut noise = FilterNoise::of(record, DEFAULT_SPAN_S);
        if let Some(evaluation) = self.evaluation.as_ref().filter(|_| self.fills_from_datasheet) {
            Evaluation::fill(evaluation, &mut noise, record);
        }
        consumer.file(&noise).map_err(|error| format!("{error}. To get it: {}", error.advice(page_words)))
    }
}

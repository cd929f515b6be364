//! Writes the results of a command to standard output.

use anyhow::{Context, Result};
use tokio::task::JoinHandle;
use vn100_pipeline::SourceState;
use vn100_report::{Document, Measured};

use crate::{
    args::OutputFormat,
    exit::{Exit, print, print_json, report},
    measured::FAULT,
    remedy_words::remedy_words,
    text,
};

/// Writes results in the order of the sources.
pub(crate) struct ResultWriter {
    format: OutputFormat,
    documents: Vec<Document>,
    exit: Exit,
}

impl ResultWriter {
    pub(crate) fn new(format: OutputFormat) -> Self {
        Self { format, documents: Vec::new(), exit: Exit::Good }
    }

    /// Writes the next one, or keeps its document for the end.
    pub(crate) fn write(&mut self, measured: &Measured) -> Result<()> {
        self.exit = self.exit.max(measured.completion.into());
        measured.facts.error.iter().chain(&measured.unmet).for_each(|text| report(text));
        match self.format {
            OutputFormat::Json => self.documents.push(Document::of(measured, remedy_words)),
            OutputFormat::Text if measured.facts.kind.is_some() => {
                print(&text::result(measured))?;
            }
            OutputFormat::Summary => print(&text::summary(&measured.facts, &measured.snapshot, &measured.assessment))?,
            OutputFormat::Text | OutputFormat::Ndjson => {}
        }
        Ok(())
    }

    /// After the last: writes what was kept, and gives the exit of the command.
    pub(crate) fn finish(self) -> Result<Exit> {
        if self.format == OutputFormat::Json {
            let document = match &self.documents[..] {
                [document] => serde_json::to_string_pretty(document),
                documents => serde_json::to_string_pretty(documents),
            };
            print_json(&document?)?;
        }
        Ok(self.exit)
    }
}

/// Writes a document in a line.
pub(crate) fn print_line(document: &Document) -> Result<()> {
    print_json(&serde_json::to_string(document)?)
}

/// Writes the document of a session under way in a line.
pub(crate) fn print_state(state: &SourceState) -> Result<()> {
    print_line(&Document::new(&state.facts(), &state.snapshot, &state.assessment(), false, remedy_words))
}

/// The results of all sources of a command, in their order.
pub(crate) async fn all_of(sources: Vec<JoinHandle<Result<Measured>>>) -> Result<Vec<Measured>> {
    let mut all = Vec::new();
    for source in sources {
        all.push(source.await.context(FAULT)??);
    }
    Ok(all)
}

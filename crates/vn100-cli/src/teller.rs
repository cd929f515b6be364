//! How the results of a command reach whoever asked for them.

use anyhow::{Context, Result};
use tokio::task::JoinHandle;
use vn100_report::{Document, Measured};

use crate::{
    args::Telling,
    exit::{Exit, print, print_json, report},
    measured::FAULT,
    remedy_words::remedy_words,
    text,
};

/// Tells results in the order of the sources.
pub(crate) struct Teller {
    telling: Telling,
    documents: Vec<Document>,
    exit: Exit,
}

impl Teller {
    pub(crate) fn new(telling: Telling) -> Self {
        Self { telling, documents: Vec::new(), exit: Exit::Good }
    }

    /// Takes the next one.
    pub(crate) fn tell(&mut self, measured: &Measured) -> Result<()> {
        self.exit = self.exit.max(measured.completion.into());
        measured.facts.error.iter().chain(&measured.unmet).for_each(|text| report(text));
        match self.telling {
            Telling::Json => self.documents.push(Document::of(measured, remedy_words)),
            Telling::Text if measured.facts.kind.is_some() => {
                print(&text::result(measured))?;
            }
            Telling::Summary => print(&text::summary(&measured.facts, &measured.snapshot, &measured.assessment))?,
            Telling::Text | Telling::Ndjson => {}
        }
        Ok(())
    }

    /// After the last: what became of the command.
    pub(crate) fn finish(self) -> Result<Exit> {
        if self.telling == Telling::Json {
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

/// The results of all sources of a command, in their order.
pub(crate) async fn all_of(sources: Vec<JoinHandle<Result<Measured>>>) -> Result<Vec<Measured>> {
    let mut all = Vec::new();
    for source in sources {
        all.push(source.await.context(FAULT)??);
    }
    Ok(all)
}

//! The results of a measurement as documents, figures and files for other programs, and the
//! numbers, names and units in which all faces give them.
//!
//! Everything is made from a [`SourceResult`](vn100_analysis::SourceResult), completed by an
//! [`Evaluation`] and, once it is over, by its [`Ended`]: a [`Document`] or [`plan_document`] as JSON,
//! [`Figures`](figure::Figures), [`CsvTable`]s, and the file of each [`Consumer`]. Units and numbers are
//! chosen in [`units`] and [`numbers`]. Pure: no file is opened and no clock is read.

pub mod caveats;
mod codes;
mod datasheet;
mod document;
mod drift;
mod ended;
mod evaluation;
mod export;
pub mod facts;
pub mod figure;
pub mod glossary;
pub mod goals;
pub mod graphical;
pub mod health;
pub mod html;
pub mod names;
pub mod numbers;
mod printable;
pub mod remedies;
mod schema;
pub mod summary;
#[cfg(test)]
mod tests;
mod toml_text;
pub mod units;
pub mod warnings;
pub mod words;

pub use datasheet::{
    DatasheetError,
    built_in::{DATASHEETS, built_in_datasheet, vn100_datasheet},
    parse_datasheet,
};
pub use document::{
    Document, analysis_schema,
    comparison::ComparisonDocument,
    plan::{PlanCommands, plan_document},
    progress::{HeartbeatDocument, ProgressDocument, progress_schema},
};
pub use ended::{Ended, no_sample, note_failed_recording, note_interrupted};
pub use evaluation::Evaluation;
pub use export::{
    archive::{ArchiveRow, ArchivedFile},
    consumers::{Consumer, Formula},
    filter_noise::{DEFAULT_SPAN_S, FilterNoise, Missing, NotWritten, SheetStream},
    forms::{ExportForm, Exported, ExportedFile, FIGURES_ENDING, figure_files},
    metrics::{METRICS_TYPE, metrics_text},
    own::is_export,
    samples::SampleTable,
    tables::CsvTable,
};
pub use names::run_name;
pub use printable::{json_line, printable, shortened, steers_terminal};
pub use toml_text::{TomlError, parse_toml};

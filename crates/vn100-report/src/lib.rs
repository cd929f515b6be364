//! The results of a measurement as documents, figures and files for other programs, and the
//! numbers, names and units in which all faces give them.
//!
//! Everything is made from a [`Snapshot`](vn100_analysis::Snapshot), its
//! [`Assessment`](vn100_analysis::Assessment) and the [`SourceFacts`](vn100_analysis::SourceFacts)
//! of one source: together a [`Measured`], completed by an [`Evaluation`]. [`Document`],
//! [`ComparisonDocument`] and [`PlanDocument`] serialise to JSON;
//! [`Figures`](figure::Figures) are drawn from a [`Record`], a result in the units of a report;
//! [`CsvTable`] and [`KalibrYaml`] are for other programs. Pure: no file is opened and no clock is
//! read.

mod codes;
mod datasheet;
mod document;
mod export;
pub mod figure;
pub mod glossary;
pub mod goals;
pub mod graphical;
pub mod health;
mod history;
pub mod html;
mod measured;
pub mod names;
pub mod numbers;
mod printable;
pub mod remedies;
pub mod summary;
pub mod temperature;
#[cfg(test)]
mod tests;
mod toml_text;
pub mod units;
pub mod warnings;
pub mod words;

pub use codes::{Code, all_codes, code_of_missing, code_of_rate, code_of_verdict};
pub use datasheet::{DatasheetError, parse_datasheet, vn100_datasheet};
pub use document::{
    ANALYSIS_SCHEMA, Document,
    comparison::ComparisonDocument,
    plan::{PlanCommands, PlanDocument},
    progress::{HeartbeatDocument, PROGRESS_SCHEMA, ProgressDocument},
    source::RecordingDocument,
};
pub use export::{
    archive::{ArchiveRow, ArchivedFile},
    kalibr::{DEFAULT_KALIBR_SPAN_S, KalibrError, KalibrYaml},
    metrics::{MeasuredSource, MetricsForm, metrics_text},
    own::is_export,
    samples::SampleTable,
    tables::CsvTable,
};
pub use history::{History, HistoryColumn};
pub use measured::{Asked, Completion, Evaluation, Measured, Record, no_sample, run_name, run_prefix};
pub use printable::{json_line, printable, steers_terminal};
pub use toml_text::{TomlError, parse_toml};

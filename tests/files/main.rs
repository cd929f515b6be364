//! The program on captures and other files: formats, numbers, verdicts, comparisons, reports, the
//! options, streams and exit codes that scripts rely on, and the commands of the documents.
#![allow(
    clippy::panic,
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails by panicking and says so when it skips"
)]

mod archive;
mod bags;
mod cli_contract;
mod column_rates;
mod compare;
mod cures;
#[cfg(unix)]
mod diagnostics;
#[cfg(unix)]
mod documents;
mod formats;
mod frozen;
mod measure_options;
mod numbers;
mod packets;
mod parts;
mod published;
mod real_captures;
mod replay_logs;
mod report;
mod samples;
mod schema;
mod summary;
#[path = "../support/mod.rs"]
mod support;
#[cfg(unix)]
mod system_faults;
mod tab;
mod tables;
#[cfg(unix)]
mod terminal;
mod twin;
mod uncertainty;
mod verdict;
mod wild_tables;

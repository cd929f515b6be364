//! Accumulators and inference against definitions, published tables and records of known noise.
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a test fails by panicking, and says when it skips")]

#[path = "../synthetic/disturbed.rs"]
mod disturbed;
mod gaps;
mod histogram;
mod metamorphic;
mod noise_changes;
mod noise_model;
mod octaves;
mod octaves_properties;
#[path = "../oracle/mod.rs"]
mod oracle;
mod record_length;
mod recordings;
mod signal;
mod spectrum;
mod stationarity;
mod stretches;
#[path = "../synthetic/mod.rs"]
mod synthetic;
mod unwrap;
mod warnings;

//! Batches to accumulators to snapshots, and what snapshots say.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking and says so when it skips")]

mod arrivals;
mod batches;
mod goals;
mod judgement;
mod noise_shapes;
mod tables;

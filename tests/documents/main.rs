//! The documents: every command that they show is run, every option that they name exists, and
//! what they show as printed is.
#![cfg(unix)]
#![allow(
    clippy::panic,
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails by panicking and says so when it skips"
)]

mod captures;
mod commands;
mod options;
mod printed;
mod shown;
#[path = "../support/mod.rs"]
mod support;

//! The emulated sensor on a clock that the test turns.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "device/bench.rs"]
mod bench;
#[path = "device/commands.rs"]
mod commands;

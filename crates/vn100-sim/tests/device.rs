//! The emulated sensor on a clock that the test turns.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "device/bench.rs"]
mod bench;
#[path = "device/commands.rs"]
mod commands;
#[path = "device/fit.rs"]
mod fit;
#[path = "device/noise.rs"]
mod noise;
#[path = "device/output.rs"]
mod output;
#[path = "device/timing.rs"]
mod timing;

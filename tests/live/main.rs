//! The program on live sources: emulated sensors on pseudo-terminals and over TCP, faults of their
//! links, and the live view in a terminal.
#![allow(
    clippy::panic,
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails by panicking and says so when it skips"
)]

#[cfg(target_os = "linux")]
mod accessible;
mod attach;
#[cfg(target_os = "linux")]
mod browser;
#[cfg(target_os = "linux")]
mod page;
#[cfg(target_os = "linux")]
mod ports;
#[cfg(target_os = "linux")]
mod process;
#[cfg(target_os = "linux")]
mod recording_forms;
#[cfg(target_os = "linux")]
mod sensor;
#[cfg(target_os = "linux")]
mod session;
#[path = "../support/mod.rs"]
mod support;
#[cfg(target_os = "linux")]
mod view;

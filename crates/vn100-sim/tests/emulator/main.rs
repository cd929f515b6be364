//! The emulated sensor: its device, its line, its link over a pseudo-terminal, and its captures.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod device;
mod profiles;
#[cfg(target_os = "linux")]
mod pty;
mod session;
mod wire;

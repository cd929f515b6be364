//! Links to scripted sensors, to sockets and to pseudo-terminals.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod another_sensor;
mod configure;
mod first_opening;
mod paused_output;
mod reconnection;
mod recorded_link;
mod requests;
#[cfg(unix)]
mod return_under_another_name;
#[cfg(unix)]
mod serial;
mod stall;
#[path = "../support/mod.rs"]
mod support;

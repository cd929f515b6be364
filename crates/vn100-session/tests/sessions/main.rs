//! Sessions from their start to their end, in virtual time.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

#[path = "../../../vn100-driver/tests/support/mod.rs"]
mod support;

mod events;
mod link_faults;
mod live;
mod own_questions;
mod replay;

//! The request machine of the protocol against the emulated sensor, on one clock that the test
//! turns.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "session/faults.rs"]
mod faults;
#[path = "session/link.rs"]
mod link;
#[path = "session/properties.rs"]
mod properties;

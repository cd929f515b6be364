//! Rules of the source tree itself: layers and the names of tests in documents.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod layering;
mod reliability;

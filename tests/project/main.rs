//! Rules of the source tree itself: layers, the compiler, and the names of tests in documents.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod compiler;
mod flags;
mod layering;
mod reliability;

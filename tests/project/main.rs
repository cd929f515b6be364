//! Rules of the source tree itself: layers, circles, the compiler, and the names and lists in documents.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod benchmarks;
mod circles;
mod compiler;
mod flags;
mod layering;
mod readme;
mod reliability;
mod source;
mod validation;
mod version;

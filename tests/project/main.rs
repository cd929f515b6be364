//! Rules of the source tree itself: layers, circles, the compiler, and what documents name and list.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod benchmarks;
mod circles;
mod codes;
mod compiler;
mod flags;
mod layering;
mod readme;
mod reliability;
mod source;
mod validation;

//! Rules of the source tree itself: layers, circles, the names of options in libraries, the compiler, and the
//! names of tests and files in documents.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod circles;
mod codes;
mod compiler;
mod flags;
mod layering;
mod readme;
mod reliability;
mod source;
mod validation;

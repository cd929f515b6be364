//! Captures and recordings, read and written through the public interface alone.
#![allow(
    clippy::panic,
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test fails by panicking and says so when it skips"
)]

mod bags;
mod formats;
mod made_bags;
mod packed;
mod read_samples;
mod recorder;
mod recording;

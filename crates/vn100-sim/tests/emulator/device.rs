//! The emulated sensor on a clock that the test turns.

mod bench;
mod commands;
mod fit;
mod noise;
mod output;
mod timing;

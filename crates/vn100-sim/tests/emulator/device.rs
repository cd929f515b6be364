//! The emulated sensor on a clock that the test controls.

mod bench;
mod commands;
mod fit;
mod noise;
mod output;
mod timing;

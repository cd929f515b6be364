//! The time base against streams whose losses, clock and bunching are known.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod adapter;
mod clock;
mod dropped;
mod link;
mod losses;
mod properties;
mod rate;
mod recordings;
mod shapes;

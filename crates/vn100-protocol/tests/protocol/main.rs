//! Tests the protocol with the output of sensors, their manual and the standard library, and with
//! any bytes.
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable,
    clippy::unwrap_used,
    reason = "a test fails by panicking"
)]

mod commands;
mod examples;
mod fast_path;
mod link_budget;
mod no_copy;
mod packets;
mod registers;
mod session;
mod session_echo;
mod stream;
mod support;

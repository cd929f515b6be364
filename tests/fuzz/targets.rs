//! The fuzz targets: a name, the check that must hold for any bytes, and the seeds of mutations.
//!
//! Each check takes any bytes and panics if a property is violated. Two callers share them: the
//! gate's short test in `main.rs`, and the long search of libFuzzer in `libfuzzer.rs`.
#![allow(dead_code, reason = "each of the two callers uses its part")]
#![allow(clippy::unwrap_used, reason = "a check fails by panicking")]

mod captures;
mod framer;
mod messages;
mod options;
mod packets;
mod requests;
mod seeds;
mod session;

pub(crate) struct Target {
    pub(crate) name: &'static str,
    pub(crate) check: fn(&[u8]),
    pub(crate) seeds: fn() -> Vec<Vec<u8>>,
}

#[rustfmt::skip]
pub(crate) const TARGETS: [Target; 9] = [
    Target { name: "framer", check: framer::check, seeds: seeds::streams },
    Target { name: "messages", check: messages::check, seeds: seeds::bodies },
    Target { name: "packets", check: packets::check, seeds: seeds::packets },
    Target { name: "session", check: session::check, seeds: seeds::conversations },
    Target { name: "captures", check: captures::check, seeds: seeds::captures },
    Target { name: "bags", check: captures::check, seeds: seeds::bags },
    Target { name: "timing", check: captures::check_with_sidecar, seeds: seeds::sidecars },
    Target { name: "options", check: options::check, seeds: seeds::options },
    Target { name: "requests", check: requests::check, seeds: requests::seeds },
];

//! The long search: libFuzzer, guided by coverage, runs the check of the target that this is built for.
#![no_main]

#[path = "../../crates/vn100/src/serve/mod.rs"]
#[allow(dead_code, reason = "the program uses all of it")]
mod serve;
mod targets;

use libfuzzer_sys::fuzz_target;
use targets::TARGETS;

fuzz_target!(|input: &[u8]| {
    if let Some(target) = TARGETS.iter().find(|target| target.name == env!("CARGO_BIN_NAME")) {
        (target.check)(input);
    }
});

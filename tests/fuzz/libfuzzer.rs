//! The long search: libFuzzer, led by coverage, on the check of the target that this is built as.
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

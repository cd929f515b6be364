//! The long search: libFuzzer, led by coverage, on the check of the target that this is built as.
#![no_main]

mod targets;

use libfuzzer_sys::fuzz_target;
use targets::TARGETS;

fuzz_target!(|input: &[u8]| {
    if let Some(target) = TARGETS.iter().find(|target| target.name == env!("CARGO_BIN_NAME")) {
        (target.check)(input);
    }
});

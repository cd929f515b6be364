//! The calls between the page and this library: plain numbers, and bytes in two buffers.
#![allow(unsafe_code, reason = "the calls of a WebAssembly host have no safe form")]

mod file;

use std::cell::RefCell;

use serde::Serialize;
use serde_json::{from_slice, to_vec};

use self::file::PageFile;
use crate::Tab;

thread_local! {
    /// What the page hands over.
    static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    /// What it gets.
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static TAB: RefCell<Tab> = RefCell::default();
}

#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Tells how many bytes of the file were measured so far.
    fn progress(bytes: f64);
}

fn tell(bytes: u64) {
    // SAFETY: it takes a number
    unsafe { progress(bytes as f64) }
}

/// A buffer of this length for the request.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn request(length: usize) -> *mut u8 {
    REQUEST.with_borrow_mut(|request| {
        request.clear();
        request.resize(length, 0);
        request.as_mut_ptr()
    })
}

/// Forgets all results.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn clear() {
    TAB.set(Tab::default());
}

/// Measures the file of this length, as the request says. Returns the length of the answer.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn measure(bytes: f64) -> usize {
    let request = REQUEST.take();
    let file = PageFile { bytes: bytes as u64 };
    let answers = from_slice(&request)
        .map_err(|error| error.to_string())
        .and_then(|request| TAB.with_borrow_mut(|tab| tab.measure(&file, &request, &mut tell)));
    set_json(&answers)
}

/// Measures the sample that is built in. Returns the length of the answer.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn measure_sample() -> usize {
    set_json(&TAB.with_borrow_mut(Tab::measure_sample))
}

/// The forms of all results; `fills` is not 0 if files for filters take what is missing from the
/// data sheet. Returns the length of the answer.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn outputs(fills: i32) -> usize {
    set_json(&TAB.with_borrow_mut(|tab| {
        tab.fills_from_datasheet = fills != 0;
        tab.outputs()
    }))
}

/// The file whose name is the request. Returns its length, 0 if there is none.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn output() -> usize {
    let name = REQUEST.take();
    let file = TAB.with_borrow(|tab| tab.output(&String::from_utf8_lossy(&name)));
    set_answer(file.unwrap_or_default().into_bytes())
}

/// The answer of the last call.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

fn set_json(answer: &impl Serialize) -> usize {
    set_answer(to_vec(answer).unwrap_or_default())
}

fn set_answer(bytes: Vec<u8>) -> usize {
    let length = bytes.len();
    ANSWER.set(bytes);
    length
}

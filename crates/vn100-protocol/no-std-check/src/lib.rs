//! Links the decoder into a static library without `std`: a second panic handler besides that of
//! `std` would not link, and neither would a call into `std`.
//!
//! The allocator has no memory. The layouts may own their names, which requires a global allocator;
//! decoding never calls it.
#![no_std]

use core::{
    alloc::{GlobalAlloc, Layout},
    panic::PanicInfo,
    ptr::null_mut,
    slice,
};

use vn100_protocol::{Decoder, Item, Options};

struct NoMemory;

// SAFETY: an allocator without memory returns a null pointer, and has nothing to free.
unsafe impl GlobalAlloc for NoMemory {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        null_mut()
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static ALLOCATOR: NoMemory = NoMemory;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

/// The number of samples in the `length` bytes at `bytes`.
///
/// # Safety
/// `bytes` points to at least `length` readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vn100_count_samples(bytes: *const u8, length: usize) -> u64 {
    // SAFETY: promised by the caller
    let bytes = unsafe { slice::from_raw_parts(bytes, length) };
    let mut decoder = Decoder::new(Options::default());
    let mut samples = 0;
    let mut count = |item: Item<'_>| samples += u64::from(matches!(item, Item::Sample(_)));
    decoder.push(bytes, &mut count);
    decoder.finish(&mut count);
    samples
}

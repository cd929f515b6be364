//! What is allocated to read the bytes of a state is bounded by their number, whatever lengths they
//! claim.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(unsafe_code, reason = "an allocator that counts is one that is asked by unsafe calls")]

use std::{
    alloc::{GlobalAlloc, Layout as Memory, System},
    sync::Arc,
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

use vn100_analysis::{Analysis, Settings, State, StateError};
use vn100_protocol::{Layout, VNYMR, stream::Batch};

/// Counts what is held, and the most of it.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is handed on to the allocator of the system.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, memory: Memory) -> *mut u8 {
        MOST.fetch_max(HELD.fetch_add(memory.size(), Relaxed) + memory.size(), Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(memory) }
    }

    unsafe fn dealloc(&self, place: *mut u8, memory: Memory) {
        HELD.fetch_sub(memory.size(), Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(place, memory) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Magic, version, layout; then eight bytes of length.
const HEAD: usize = 14;

/// A state with this content, and with the length and the checksum that belong to it.
fn state_bytes(content: &[u8]) -> Vec<u8> {
    let head = &State::default().to_bytes()[..HEAD];
    let mut bytes = [head, &(content.len() as u64).to_le_bytes(), content].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// The most that reading these bytes holds at a time, beside them.
fn held_to_read(bytes: &[u8]) -> (usize, Result<State, StateError>) {
    let before = HELD.load(Relaxed);
    MOST.store(before, Relaxed);
    let state = State::from_bytes(bytes);
    (MOST.load(Relaxed) - before, state)
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

#[test]
fn claimed_lengths_allocate_nothing() {
    let layout = Layout { channels: VNYMR.channels[9..10].into(), ..VNYMR.clone() };
    let counts = (0..900).map(|row: i32| row * row % 91 - 45).collect();
    let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
    analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, ..Batch::default() });
    let bytes = State::of("a", Some(7), &mut analysis).to_bytes();
    let content = &bytes[HEAD + 8..bytes.len() - 4];
    let (plain, state) = held_to_read(&bytes);
    assert!(state.is_ok());
    // more than the lists have, more than a list may have, more than any number
    let mut refused = 0;
    for claimed in [1 << 20, 1 << 40, 1 << 60, u64::MAX] {
        let number = varint(claimed);
        for place in 0..content.len() {
            let hostile = [&content[..place], &number, &content[place + 1..]].concat();
            let (held, state) = held_to_read(&state_bytes(&hostile));
            refused += usize::from(state.is_err());
            assert!(held <= 2 * plain, "{claimed} at byte {place}: {held} bytes, {plain} without");
        }
    }
    assert!(refused > content.len(), "{refused} of {}", 4 * content.len());
    let beginnings = [[&varint(1 << 40)[..], b"a"].concat(), [&varint(1)[..], &varint(1 << 40)].concat()];
    for hostile in beginnings {
        let (held, state) = held_to_read(&state_bytes(&hostile));
        assert!(state.is_err() && held < 1000, "{held}");
    }
    println!("{plain} bytes are held to read {}", bytes.len());
}

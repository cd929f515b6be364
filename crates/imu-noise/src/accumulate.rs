//! From samples to exact sums, one channel at a time, in bounded memory.

pub(crate) mod aligned_sums;
pub(crate) mod blocks;
pub(crate) mod channel;
pub(crate) mod counts;
pub(crate) mod histogram;
pub(crate) mod lag_one_sums;
pub(crate) mod moments;
pub(crate) mod octaves;
pub(crate) mod piece;
pub(crate) mod record;
pub(crate) mod signal;
pub(crate) mod spectrum;
pub(crate) mod temperature_blocks;
mod trend;
pub(crate) mod unwrap;
pub(crate) mod window_statistics;

/// A number for the windows, bins, blocks and segments of all sums. Sums in bytes with another
/// number are over other windows, and are not read.
#[must_use]
pub fn layout_of_sums() -> u64 {
    let lengths = [
        blocks::MAX_BLOCKS as u64,
        blocks::WINDOW as u64,
        histogram::MAX_BINS as u64,
        aligned_sums::BLOCK,
        temperature_blocks::MOST_BLOCKS,
        spectrum::LONG as u64,
        spectrum::SHORT as u64,
        octaves::WINDOWS_PER_TAU as u64,
    ];
    // FNV-1a over the bytes
    let bytes = lengths.into_iter().flat_map(u64::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

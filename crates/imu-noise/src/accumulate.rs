//! From samples to exact sums, one channel at a time, in bounded memory.

pub(crate) mod blocks;
pub(crate) mod counts;
pub(crate) mod histogram;
pub(crate) mod moments;
pub(crate) mod octaves;
mod places;
pub(crate) mod record;
pub(crate) mod signal;
pub(crate) mod spectrum;
pub(crate) mod stretch;
pub(crate) mod temperature_blocks;
pub(crate) mod unwrap;
pub(crate) mod window_statistics;

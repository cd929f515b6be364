//! From batches of rows to sums: gaps, segments, the sample rate, one accumulator per channel.

pub(crate) mod analysis;
mod channel_state;
mod evidence;
pub(crate) mod norms;
mod polled;
pub(crate) mod rates;
pub(crate) mod recent;
mod repeats;
mod waiting;

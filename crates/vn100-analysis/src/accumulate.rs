//! From batches of rows to sums. `analysis` takes the batches; rows with stamps or counters wait in
//! `pending_rows` for where samples were dropped; `data_record` passes all on to its parts.

mod accumulators;
pub(crate) mod analysis;
mod channel_state;
mod data_record;
pub(crate) mod fingerprint;
mod gaps;
pub(crate) mod magnitude;
mod measured_span;
mod pending_rows;
mod printed;
mod quaternion;
mod rate_authority;
pub(crate) mod recent;
mod repeats;
mod row_order;
mod row_slice;
pub(crate) mod saturation;
pub(crate) mod sensor_rates;
mod sensor_replies;
pub(crate) mod temperature_record;

//! Framing: sentences and binary packets in any bytes, their checksums, and the byte counts.

pub(crate) mod checksum;
pub(crate) mod framer;
pub(crate) mod packet;
pub(crate) mod sentence;
pub(crate) mod tally;

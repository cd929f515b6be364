//! The numbers of a report in the forms other programs read.

pub(crate) mod archive;
pub(crate) mod consumers;
pub(crate) mod filter_noise;
pub(crate) mod forms;
pub(crate) mod metrics;
pub(crate) mod own;
pub(crate) mod samples;
pub(crate) mod tables;

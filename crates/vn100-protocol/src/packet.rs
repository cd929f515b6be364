//! Binary packets that are measured: what their fields are, and how their floats become counts.

pub(crate) mod field;
pub(crate) mod form;
pub(crate) mod message;

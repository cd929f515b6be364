//! Binary packets that are measured: their fields, and the conversion of their floats to counts.

pub(crate) mod field;
pub(crate) mod form;
pub(crate) mod header;
pub(crate) mod message;

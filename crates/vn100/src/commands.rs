//! The commands of the program, a file for each.

pub(crate) mod archive;
pub(crate) mod attach;
pub(crate) mod compare;
pub(crate) mod documentation;
pub(crate) mod explain;
pub(crate) mod export;
pub(crate) mod plan;
pub(crate) mod ports;
pub(crate) mod replay;
pub(crate) mod report;
pub(crate) mod selftest;
pub(crate) mod sensor;
pub(crate) mod sim;
pub(crate) mod witness;

//! The numbers of a report in the forms other programs read.

mod cdr;
pub(crate) mod kalibr;
pub(crate) mod ros2;
pub(crate) mod tables;

//! Requests to the sensor: commands, replies, device errors, and the machine that matches them.

pub(crate) mod command;
pub(crate) mod device_error;
pub(crate) mod queue;
pub(crate) mod reply;

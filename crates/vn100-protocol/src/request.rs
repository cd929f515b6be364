//! Requests to the sensor: commands, replies, device errors, and the machine that matches them.

pub(crate) mod command;
pub(crate) mod device_error;
mod failure;
pub(crate) mod reply;
pub(crate) mod session;

pub use self::failure::RequestFailure;

//! The request machine of the protocol against the emulated sensor, on one clock that the test
//! controls.

mod link;
mod properties;

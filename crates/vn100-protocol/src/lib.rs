//! The VN-100's serial protocol: bytes to typed messages and back, without I/O, clock or std.
#![cfg_attr(not(test), no_std)]

extern crate alloc;

mod bad_line;
mod checksum;
mod decimal;
mod decoder;
mod framer;
mod layout;
mod message;
mod packet;
mod print_format;
mod sentence;
mod tally;
mod template;

pub use bad_line::{BadKind, BadLine};
pub use checksum::{Check, CheckDigits, crc16, xor8};
pub use decimal::{Decimal, DecimalError};
pub use decoder::{Decoder, Item};
pub use framer::{Frame, Framer, MAX_BODY, Options, Step};
pub use layout::{Channel, Layout, Quantity, VNIMU, VNYMR};
pub use message::{GrammarError, Imu, MessageError, RangeError, Suffix, Ymr};
pub use packet::{MAX_PACKET, Packet};
pub use print_format::PrintFormat;
pub use sentence::Sentence;
pub use tally::{BadTally, Tally};

//! The serial protocol of the VectorNav VN-100: bytes to typed messages and back, without I/O,
//! clock and standard library.
//!
//! ```
//! use vn100_protocol::{Decoder, Item, Options};
//!
//! let bytes = b"$VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66\r\n";
//! let mut decoder = Decoder::new(Options::default());
//! decoder.push(bytes, |item| match item {
//!     Item::Sample(sample) => {
//!         assert_eq!((&*sample.layout.message, sample.counts()[5]), ("VNIMU", 9948)); // in last digits
//!         assert_eq!(sample.values().nth(5), Some(9.948)); // the same in the unit of its channel
//!     }
//!     Item::Rejected(line) => panic!("at byte {}: {}", line.offset, line.kind),
//!     _ => {}
//! });
//! assert_eq!(decoder.tally().valid_sentence_bytes, bytes.len() as u64);
//! ```
//!
//! # From bytes to messages
//!
//! [`Framer`] finds [`Sentence`]s and [`Packet`]s in any bytes and checks their checksums. The
//! [`MESSAGES`] that are measured are a table of [`Layout`]s, and a [`Sample`] is the content of
//! one sentence or packet of such a message. [`Decoder`] combines them and counts every byte in a
//! [`Tally`]. A rejected sentence is an item with its evidence, and not an error of the stream.
//!
//! A number never passes through a float: it becomes the integer of its digits, so that sums of
//! samples are exact.
//!
//! # Asking the sensor
//!
//! A [`RequestQueue`] sends one [`SensorCommand`] at a time and finds each [`Reply`] among the
//! arriving frames; it has neither link nor clock. [`LinkLoad`] tells whether sentences and packets
//! fit the baud rate.
//!
//! ```
//! use std::time::Duration;
//! use vn100_protocol::{AsyncRate, Check, Decoder, Item, Options, Register, Reply, RequestQueue};
//! use vn100_protocol::{Response, SensorCommand};
//!
//! let mut session = RequestQueue::new(Check::Xor8);
//! let asked = session.submit(SensorCommand::ReadRegister(Register::ASYNC_RATE))?;
//! assert_eq!(session.poll_transmit(Duration::ZERO).as_deref(), Some(&b"$VNRRG,07*74\r\n"[..]));
//! Decoder::new(Options::default()).push(b"$VNYPR,+010.071,+000.278,-002.026*60\r\n$VNRRG,07,40*5C\r\n", |item| {
//!     if let Item::Reply(sentence) = item && let Some(reply) = Reply::parse(&sentence) {
//!         session.handle_reply(&reply, Duration::from_millis(12));
//!     }
//! });
//! let Some((ended, Ok(Response::Register(contents)))) = session.poll_completion() else { panic!("no answer") };
//! assert_eq!((ended, contents.value::<AsyncRate>()?.hz()), (asked, 40));
//! # Ok::<_, Box<dyn std::error::Error>>(())
//! ```
//!
//! # Units
//!
//! | quantity | unit | decimals | limit |
//! |---|---|---:|---:|
//! | yaw, pitch, roll | deg | 3 | 180 |
//! | quaternion, scalar last | 1 | 6 | 2 |
//! | magnetic field | gauss | 4 | 10 |
//! | acceleration | m/s² | 3 | 200 |
//! | angular rate | rad/s | 6 | 40 |
//! | temperature | °C | 1 | 200 |
//! | pressure | kPa | 3 | 200 |
//!
//! Axes are those of the body, x forward, y right, z down, in the order x y z. A line with a
//! magnitude beyond its limit is [`RejectReason::Range`]. Old firmware prints fewer decimals: see
//! [`PrintFormat`].
//!
//!
//! # Differences from the maker's manual
//!
//! - The manual (UM001, revision 2.43) prints the polynomial of the 16-bit checksum as 0x07. It is
//!   0x1021, as in the manual's own code and in every line of real sensors.
//! - Some of its sample lines carry wrong digits, such as `$VNRRG,01,VN-310*58` (59 is right), and
//!   its `*XX` in place of a checksum is only for commands to the sensor. Both are
//!   [`RejectReason::Checksum`].
//! - It puts the status before the count in text and after it in an example; [`Suffix`] takes
//!   either order.
//! - Editions disagree on the checksum numbers 0 and 2 of register 30; [`ProtocolControl::check`]
//!   knows only 1 and 3.
#![cfg_attr(not(test), no_std)]

extern crate alloc;

mod framing;
mod link_budget;
mod message;
mod packet;
mod register;
mod request;
pub mod stream;

pub use framing::{
    checksum::{Check, CheckDigits, crc16, xor8},
    framer::{Frame, Framer, Options},
    packet::{MAX_PACKET, Packet},
    sentence::{MAX_BODY, RejectReason, RejectedSentence, Sentence},
    tally::{MeasuredPackets, RejectedCounts, Tally},
};
pub use link_budget::LinkLoad;
pub use message::{
    GrammarError, RangeError,
    decoder::{Decoder, Item},
    increments::VNDTV,
    layout::{Channel, ColumnRead, ColumnsRead, Layout, OUTPUT_RATES_HZ, PrintFormat, Quantity},
    sample::Sample,
    suffix::Suffix,
    table::{MESSAGES, VNIMU, VNMAR, VNQMR, VNYMR},
};
pub use packet::{
    form::{BINARY, PacketForm, RejectedPacket},
    header::PacketHeader,
    message::{MEASUREMENTS_PER_S, PACKET_MESSAGES, PacketMessage},
};
pub use register::{
    AsyncRate, AsyncType, BaudRate, BinaryOutput, ImuFilter, ProtocolControl, ReferenceFrameRotation, Register,
    RegisterContents, RegisterValue, SyncControl, ValueError, WritableValue, fields::RegisterFields,
};
pub use request::{
    command::SensorCommand,
    device_error::DeviceError,
    queue::{Handled, QueueFull, RequestFailure, RequestId, RequestQueue, Response},
    reply::Reply,
};

//! The transport of a link: a serial port, a socket, or a script in a test.

use std::{future::Future, io};

use crate::{connect_error::ConnectError, low_latency::LatencyTimer};
use vn100_capture::Source;
use vn100_protocol::stream::StreamInput;

/// Opens a connection, and opens it again after the link is lost.
pub trait Connect: Send + 'static {
    /// An open link.
    type Connection: Connection;

    /// Whether the link has a baud rate that must be that of the sensor.
    const HAS_BAUD: bool;

    /// Opens the link at a baud rate, which links without one ignore.
    ///
    /// # Errors
    /// Why not, and what to do about it.
    fn open(&mut self, baud: u32) -> impl Future<Output = Result<Self::Connection, ConnectError>> + Send;

    /// The time now, in nanoseconds from the origin that the connection's [`Chunk`](crate::Chunk)s
    /// are stamped from.
    fn now_ns(&self) -> i64;

    /// The link by the name the user gave it.
    fn name(&self) -> String;
}

/// An open connection: a [`Source`] whose end means that the link is lost, and the way back.
pub trait Connection: Source {
    /// The name it was opened by, such as `/dev/ttyUSB0`.
    fn name(&self) -> &str;

    /// Changes the baud rate. Bytes that were received at the old one may still be handed out.
    ///
    /// # Errors
    /// When the port does not support it.
    fn set_baud(&mut self, baud: u32) -> io::Result<()>;

    /// Sends bytes.
    ///
    /// # Errors
    /// When they cannot all be handed to the system, as after an unplug.
    fn write(&mut self, bytes: &[u8]) -> impl Future<Output = io::Result<()>> + Send;

    /// Closes it. When this is done the port can be opened again. Gives the inputs that were read
    /// and not taken, so that every byte is counted.
    fn close(self) -> impl Future<Output = Vec<StreamInput>> + Send;

    /// The latency timer of the adapter, where it has one.
    fn latency_timer(&self) -> Option<&LatencyTimer> {
        None
    }
}

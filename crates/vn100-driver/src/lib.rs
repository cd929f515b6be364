//! Where VN-100 bytes come from, and how they become typed samples.
//!
//! # A recording
//!
//! A [`Source`] hands out [`Chunk`]s: bytes exactly as one read returned them, with the time of
//! that read. [`read_samples`] turns them into [`Event`]s: one [`Batch`] of samples per chunk, with
//! everything that was not a sample counted and placed between them. Only a failing read ends a
//! stream; bad content never does.
//!
//! ```
//! use tokio_util::sync::CancellationToken;
//! use vn100_driver::{Capture, Event, ReadOptions};
//!
//! # #[tokio::main(flavor = "current_thread")] async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let line = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
//! let capture = Capture::from_reader(&line[..], None)?; // or Capture::open("flight.vnymr", None)
//! let mut events = capture.read(ReadOptions::default(), CancellationToken::new())?;
//! while let Some(event) = events.recv().await {
//!     if let Event::Batch(batch) = event {
//!         for counts in batch.rows() {
//!             println!("{counts:?} in units of the last printed digit");
//!         }
//!     }
//! }
//! # Ok(()) }
//! ```
//!
//! # A sensor on a port
//!
//! [`open_link`] opens a port ([`SerialPorts`]) or a socket ([`TcpServer`]), finds the speed, hands
//! out [`Event`]s, and opens the link again when it is lost. [`LinkHandle`] asks the sensor for
//! things meanwhile; [`configure`](configure()) changes what it sends.
//!
//! ```no_run
//! use tokio_util::sync::CancellationToken;
//! use vn100_driver::{Clock, Event, LinkOptions, SerialPorts, open_link, protocol::Register};
//!
//! # #[tokio::main(flavor = "current_thread")] async fn main() {
//! let port = SerialPorts::new("/dev/ttyUSB0", Clock::start());
//! let (link, mut events) = open_link(port, LinkOptions::default(), CancellationToken::new());
//! tokio::spawn(async move {
//!     let rate = link.read(Register::ASYNC_RATE).await;
//!     println!("set to {rate:?}");
//! });
//! while let Some(event) = events.recv().await {
//!     match event {
//!         Event::Batch(batch) => println!("{} samples", batch.row_count()),
//!         Event::Link(event) => println!("{:?}", event.kind),
//!         Event::End(end) => println!("the end: {:?}", end.error),
//!     }
//! }
//! # }
//! ```

mod autobaud;
mod back_off;
mod capture;
mod clock;
mod codec;
mod command_error;
mod configure;
mod connect;
mod connect_error;
mod conversation;
mod csv;
mod diagnostic;
mod event;
mod gunzip;
mod health;
mod link;
mod link_options;
mod link_output;
mod link_state;
mod link_task;
mod lossy_sender;
mod low_latency;
mod output_plan;
mod port_address;
mod ports;
mod read_samples;
mod recognise;
mod recording;
mod rows;
mod serial;
mod set_again;
mod source;
mod tcp;
mod timing;
mod trouble;
mod unasked_errors;

pub use autobaud::BAUD_RATES;
pub use capture::{Capture, OpenError};
pub use clock::Clock;
pub use codec::{Decoded, SentenceCodec};
pub use command_error::CommandError;
pub use configure::{ConfigureError, Configured, configure, restore};
pub use connect::{Connect, Connection};
pub use connect_error::ConnectError;
pub use csv::{ColumnMap, ColumnMapError, CsvError, OddRow, OddRowCounts};
pub use diagnostic::Diagnostic;
pub use event::{
    Arrival, Batch, CsvReport, End, Event, LinkCounts, Mark, MarkKind, MessageName, OddRows, RegisterValue, RowCounter,
};
pub use link::{LinkHandle, open_link};
pub use link_options::LinkOptions;
pub use link_state::{LinkState, Up};
pub use low_latency::{LatencyTimer, shorten_latency};
pub use output_plan::{Change, OutputSettings, PlanError};
pub use ports::{PortEntry, UsbAdapter, list_ports};
pub use read_samples::{ReadOptions, read_samples};
pub use recognise::Format;
pub use recording::{
    RecordError, Recorded, Recorder, RecordingEnd, RecordingError, RecordingReader, RecordingState, RecordingWriter,
};
pub use serial::{SerialConnection, SerialPorts};
pub use source::{Chunk, Input, LinkEvent, LinkEventKind, ReaderSource, Source};
pub use tcp::{TcpConnection, TcpServer};
pub use unasked_errors::UnaskedErrors;
pub use vn100_protocol as protocol;

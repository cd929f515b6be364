//! The live link to a VN-100: opening a port, finding its baud rate, commands, reconnection.
//!
//! [`open_link`] opens a port ([`SerialPorts`]) or a socket ([`TcpServer`]), scans the baud rates,
//! sends [`Event`](vn100_capture::Event)s, and reconnects when the link is lost. [`LinkHandle`]
//! sends commands to the sensor meanwhile; [`configure`](configure()) changes its output.
//!
//! The link itself is a state machine without I/O (`link_machine`) and a task that performs its
//! actions (`link_task`).
//!
//! ```no_run
//! use tokio_util::sync::CancellationToken;
//! use vn100_capture::{Clock, Event};
//! use vn100_driver::{LinkOptions, SerialPorts, open_link};
//! use vn100_protocol::Register;
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

mod configure;
mod connect;
mod link;
mod link_error;
mod link_machine;
mod link_task;
mod lossy_sender;
mod output_plan;
mod ports;
mod question;
mod serial;
mod shared_port;
mod tcp;

pub use configure::{ConfigureError, Configured, OutputLeft, configure, restore};
pub use connect::{Connect, ConnectError, Connection, PortProblem, available_ports, other_program_on};
pub use link::{CommandError, LinkHandle, LinkOptions, LinkState, Up};
pub use link_error::LinkHint;
pub use link_machine::BAUD_RATES;
pub use link_task::open_link;
pub use output_plan::{Change, OutputSettings, PlanError};
pub use ports::{LatencyTimer, PortEntry, list_ports};
pub use serial::{SerialConnection, SerialPorts};
pub use serialport::UsbPortInfo;
pub use tcp::{TcpConnection, TcpServer};

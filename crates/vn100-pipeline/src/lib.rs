//! From the events of a source to snapshots of its statistics.
//!
//! [`start`] leads the events of a source to the accumulators and gives a [`Measurement`]: its
//! latest [`Snapshot`](vn100_analysis::Snapshot) at any time, and its [`Outcome`] at the end. Live
//! sources and captures take the very same path. [`Analysis`](vn100_analysis::Analysis) is the same without tasks.
//!
//! ```
//! use tokio_util::sync::CancellationToken;
//! use vn100_analysis::Settings;
//! use vn100_capture::Capture;
//! use vn100_protocol::stream::ReadOptions;
//! use vn100_pipeline::start;
//!
//! # #[tokio::main(flavor = "current_thread")] async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let line = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
//! let capture = Capture::from_reader(&line[..], None)?; // or Capture::open("flight.vnymr", None)
//! let events = capture.read(ReadOptions::default(), CancellationToken::new())?;
//! let measurement = start(events, Settings::default(), None);
//! let outcome = measurement.outcome().await?;
//! assert_eq!(outcome.snapshot.timing.samples, 1);
//! # Ok(()) }
//! ```

mod pace;
mod run;
mod watchdog;

pub use pace::{Beginning, PaceWish, Position, Speed, paced};
pub use run::{Controls, Died, Measurement, Outcome, every_second, start};
pub use watchdog::{Ceased, NO_MEASUREMENT_AFTER, RateEvent, StreamWatchdog};

//! Sessions: the measurement of one source from its opening to its result.
//!
//! [`Session::live`] measures a sensor, [`Session::replay`] a capture. Both run the same loop in a
//! task of their own: they publish one [`SourceState`], take one kind of [`Command`], report
//! [`SessionEvent`]s and end with a [`SessionResult`], which contains the [`End`](vn100_analysis::End). A face (a
//! view, a page, a script) puts these into words.
//!
//! ```
//! use vn100_analysis::{End, Settings, SourceFacts};
//! use vn100_capture::{Capture, CaptureOptions};
//! use vn100_session::Session;
//! use vn100_analysis::protocol::stream::ReadOptions;
//!
//! # #[tokio::main(flavor = "current_thread")] async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let line = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
//! let capture = Capture::from_reader(&line[..], &CaptureOptions::default())?;
//! let events = capture.read(ReadOptions::default(), Default::default())?;
//! let session = Session::of_events(SourceFacts::default(), events, Settings::default());
//! let result = session.result.await?;
//! assert_eq!(result.measured.timing.samples, 1);
//! assert!(matches!(*result.end, End::SourceEnded));
//! # Ok(()) }
//! ```

mod assessor;
mod channels;
mod command;
mod emulated_port;
mod live;
mod live_source;
mod measure;
mod pace;
mod recording;
mod replay;
mod sample_tap;
mod sensor_setup;
mod session;
mod session_event;
mod session_result;
mod start_error;
mod state;
mod wall_limits;
mod watchdog;

pub use assessor::Assessor;
pub use channels::EventObserver;
pub use command::{Command, CommandRefusal};
pub use emulated_port::{EmulatedConnection, EmulatedPort};
pub use live::LiveSpec;
pub use live_source::LiveSource;
pub use recording::RecordingSpec;
pub use replay::ReplaySpec;
pub use sample_tap::SampleTap;
pub use session::Session;
pub use session_event::SessionEvent;
pub use session_result::SessionResult;
pub use start_error::{LiveError, OtherMessage, SetupError, StartError};
pub use state::{SourceState, Stage, link_facts};
pub use vn100_analysis::{Playback, Speed};
pub use wall_limits::WallLimits;
pub use watchdog::RateEvent;

//! From the events of a source to snapshots of its statistics.
//!
//! [`start`] leads the events of a source to the accumulators and gives a [`Measurement`]: its
//! latest [`Snapshot`] at any time, and its [`Outcome`] at the end. Live sources and captures take
//! the very same path. [`Analysis`] is the same without tasks.
//!
//! ```
//! use tokio_util::sync::CancellationToken;
//! use vn100_driver::{Capture, ReadOptions};
//! use vn100_pipeline::{Settings, start};
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

mod advice;
mod analysis;
mod assessment;
mod channel_state;
mod comparison;
mod datasheet;
mod evidence;
mod figure;
mod goal;
mod norms;
mod plan;
mod polled;
mod rates;
mod recent;
mod repeats;
mod run;
mod settings;
mod snapshot;
mod waiting;
mod warning;

pub use analysis::Analysis;
pub use assessment::{
    Assessment, Assessments, ChannelAssessment, ChannelNoise, Disturbed, FilterModels, LongTaus, Motion,
    OctaveAssessment, Onboard, WalkSeenLater,
};
pub use comparison::{
    Caveat, CaveatKind, Chance, ChannelMeans, Comparison, Disturbance, MeanError, OctaveTest, RankedRecord, Ranking,
    Record, RecordMean, WhiteTest,
};
pub use datasheet::{Datasheet, DatasheetFigure, FigureVerdict, SheetOnboard, StreamUnknown, not_passed};
pub use figure::{Figure, FigureChannels, FigureError};
pub use goal::{Goal, GoalError};
pub use norms::Norm;
pub use plan::{Given, Known, Plan, PlannedWant, PlanningError, Want, WantError};
pub use recent::{Recent, Slot};
pub use run::{Controls, Died, Measurement, Outcome, every_second, start};
pub use settings::{DEFAULT_CONFIDENCE, DEFAULT_RATE_HZ, Settings};
pub use snapshot::{
    ChannelSnapshot, FalseRate, MissingFrom, Outages, PolledChannel, RateChange, RateFrom, Snapshot, Timing,
};
pub use warning::{Warning, WarningKind};

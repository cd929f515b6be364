//! The parts of a stream of samples, as plain data, and the only place that turns rows into batches.
//!
//! A source delivers [`StreamInput`]s; a [`SampleReader`] decodes them and collects the samples in
//! [`Batch`]es, with the [`StreamCounts`] of its whole content.

mod bag_report;
mod batch;
mod counts;
mod input;
mod open_hint;
mod packet_reader;
mod rejected_rows;
mod sample_reader;

pub use bag_report::{BagReport, FileReport, StampSource};
pub use batch::{AbsentCell, Arrival, Batch, Diagnostic, Mark, MarkKind, RowCounter, SingleRows};
pub use counts::{MessageName, StreamCounts, UnsolicitedErrors};
pub use input::{Chunk, LinkEvent, LinkEventKind, StreamInput};
pub use open_hint::OpenHint;
pub use rejected_rows::{AbsentValues, CsvReport, LeftOutColumn, RejectedRow, RejectedRowCounts, RejectedRows};
pub use sample_reader::{FrameKind, MeasuredFrames, ReadOptions, SampleReader};

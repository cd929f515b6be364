//! Files and byte sources that can wait, read as batches of samples.
//!
//! A [`Source`] delivers [`Chunk`](vn100_protocol::stream::Chunk)s: bytes exactly as one read
//! returned them, with the time of that read. [`read_samples`] turns them into [`Event`]s: one
//! [`Batch`](vn100_protocol::stream::Batch) of samples per chunk, and everything else is counted
//! and placed between the samples. Only a failed read ends a stream; malformed content does not. A
//! [`Capture`] is a file of any known [`Format`]; a [`Recorder`] writes one.
//!
//! ```
//! use tokio_util::sync::CancellationToken;
//! use vn100_capture::{Capture, CaptureOptions, Event};
//! use vn100_protocol::stream::ReadOptions;
//!
//! # #[tokio::main(flavor = "current_thread")] async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let line = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
//! let capture = Capture::from_reader(&line[..], &CaptureOptions::default())?; // or Capture::open("flight.vnymr", ..)
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

mod bag;
mod capture;
mod capture_options;
mod captures_below;
mod counted_reader;
mod csv;
mod detect_format;
mod file_stamp;
mod mcap_records;
mod open_error;
mod read_samples;
mod recording;
mod rows_of_samples;
mod source;
mod stored_file;
mod telnet;
mod timing_sidecar;
mod unpack;
mod zstd_reader;

pub use bag::BagForm;
pub use capture::Capture;
pub use capture_options::CaptureOptions;
pub use captures_below::captures_below;
pub use csv::{ColumnMap, ColumnMapError};
pub use detect_format::Format;
pub use file_stamp::file_stamp;
pub use open_error::{OpenError, OpenHint, Unusable, with_causes};
pub use read_samples::{End, Event, FileEvents, WAITING_BATCHES, read_samples};
pub use recording::{
    LowSpace, RecordError, Recorded, Recorder, RecordingEnd, RecordingError, RecordingPart, RecordingReader,
    RecordingState, RecordingWriter, Rotation, joined_parts, missing_parts, part_path, recording_path,
};
pub use source::{Clock, ReaderSource, Source};
pub use stored_file::{ReadSeek, StoredFile};

//! Recordings: everything that a link delivered, in an MCAP file, so that a replay takes the same
//! path as the measurement did.
//!
//! | in the file | is |
//! |---|---|
//! | metadata `vn100.recording` | `format` (this form is 1) and `program` |
//! | metadata `vn100.metadata` | what the caller gave, if anything |
//! | topic `/vn100/bytes` | one message for each chunk, from a serial port a line as a rule: its bytes, with the time of the last read as log time |
//! | topic `/vn100/link` | one JSON object for each [`LinkEvent`](vn100_protocol::stream::LinkEvent), with its time as log time |
//! | metadata `vn100.end` | `reason`: why the recording ended, where that is known |
//!
//! Times are nanoseconds since 1970-01-01 UTC. There are no chunks and there is no compression, so
//! that a file which was cut anywhere holds everything up to the last whole record. The payloads of
//! `/vn100/bytes`, one behind the other, are the stream. Files that other tools have put into
//! chunks and compressed are read as well.

mod link_json;
mod named_file;
mod reader;
mod record_error;
mod recorder;
mod replay;
mod resume;
mod writer;

pub use reader::{Recorded, RecordingEnd, RecordingError, RecordingReader};
pub use record_error::RecordError;
pub use recorder::{Recorder, RecordingState};
pub(crate) use replay::Replay;
pub use writer::RecordingWriter;

/// How every MCAP file begins.
pub(crate) const MAGIC: &[u8] = b"\x89MCAP";

/// The form described above.
const FORMAT: &str = "1";

const PROFILE: &str = "vn100";
const BYTES_TOPIC: &str = "/vn100/bytes";
const BYTES_ENCODING: &str = "application/octet-stream";
const LINK_TOPIC: &str = "/vn100/link";
const LINK_ENCODING: &str = "json";
/// Metadata of a channel of `/vn100/bytes` whose log times are not those of the reads, because
/// these are not known.
const UNSTAMPED: (&str, &str) = ("arrival", "unknown");

const RECORDING_METADATA: &str = "vn100.recording";
/// Set in the metadata of a recording that was resumed.
const RESUMED: &str = "resumed";
const CALLER_METADATA: &str = "vn100.metadata";
const END_METADATA: &str = "vn100.end";

/// MCAP counts time without a sign; times before 1970 are kept as two's complement.
fn log_time(at_ns: i64) -> u64 {
    at_ns.cast_unsigned()
}

fn at_ns(log_time: u64) -> i64 {
    log_time.cast_signed()
}

fn io_error(error: mcap::McapError) -> std::io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        error => std::io::Error::new(std::io::ErrorKind::InvalidData, format!("not readable as MCAP: {error}")),
    }
}

//! Recordings: everything that a link delivered, in an MCAP file, so that a replay takes the same
//! path as the measurement.
//!
//! | in the file | is |
//! |---|---|
//! | metadata `vn100.recording` | `format` (this form is 2) and `program` |
//! | metadata `vn100.part` | of a recording in parts: its `id`, the same in all, and the `number` of this one, from 1 |
//! | metadata `vn100.metadata` | the caller's metadata, if any |
//! | topic `/vn100/bytes` | the bytes of a read of the port, with its time as log time |
//! | topic `/vn100/reads` | reads that came within 50 ms, 4 KiB of them at most (`reads.rs`), with the time of the first as log time |
//! | topic `/vn100/link` | one JSON object for each [`LinkEvent`](vn100_protocol::stream::LinkEvent), with its time as log time |
//! | metadata `vn100.end` | `reason`: why the recording ended, if it is known |
//!
//! Places that the user marked are link events as well.
//!
//! Times are nanoseconds since 1970-01-01 UTC. There are no chunks and there is no compression, so
//! that a file that was cut holds everything up to the last whole record. The bytes of both topics
//! in sequence are the stream. Files that other tools have put into chunks and compressed are read
//! as well, and so is form 1, which has no `/vn100/reads`.

pub(crate) mod part;
pub(crate) mod reader;
mod reads;
mod recorder;
mod samples;
mod writer;

use serde_json::{Value, json};
use vn100_protocol::{
    DeviceError,
    stream::{LinkEvent, LinkEventKind},
};

pub use part::{RecordingPart, Rotation, joined_parts, missing_parts, part_path, recording_path};
pub use reader::{Recorded, RecordingEnd, RecordingError, RecordingReader};
pub use recorder::{LowSpace, RecordError, Recorder, RecordingState};
pub(crate) use samples::open;
pub use writer::RecordingWriter;

/// The first bytes of every MCAP file.
pub(crate) const MAGIC: &[u8] = b"\x89MCAP";

/// The form described above, and the older form.
const FORMAT: &str = "2";
const FORMAT_1: &str = "1";

const PROFILE: &str = "vn100";
pub(crate) const BYTES_TOPIC: &str = "/vn100/bytes";
const BYTES_ENCODING: &str = "application/octet-stream";
const READS_TOPIC: &str = "/vn100/reads";
const READS_ENCODING: &str = "vn100.reads";
const LINK_TOPIC: &str = "/vn100/link";
const LINK_ENCODING: &str = "json";
/// Metadata of a channel of `/vn100/bytes` for which the times of the reads are not known.
const UNSTAMPED: (&str, &str) = ("arrival", "unknown");

const RECORDING_METADATA: &str = "vn100.recording";
/// Set in the metadata of a recording that was resumed.
const RESUMED: &str = "resumed";
const CALLER_METADATA: &str = "vn100.metadata";
const END_METADATA: &str = "vn100.end";

/// The number of bytes that show which program wrote an MCAP file.
pub(crate) const HEAD_BYTES: u64 = 32;

/// The first bytes of an MCAP file whose header names this program: magic, the kind and length of
/// the header, and its profile with its length.
pub(crate) fn is_ours(head: &[u8]) -> bool {
    const PROFILE_AT: usize = 8 + 1 + 8 + 4;
    // a file that was cut before it has no topic
    head.get(PROFILE_AT..).is_none_or(|profile| profile.starts_with(PROFILE.as_bytes()))
}

/// MCAP times are unsigned; times before 1970 are kept as two's complement.
fn log_time(at_ns: i64) -> u64 {
    at_ns.cast_unsigned()
}

pub(crate) fn at_ns(log_time: u64) -> i64 {
    log_time.cast_signed()
}

/// The JSON object of an event on `/vn100/link`, without its time, because the log time gives it.
fn link_to_json(kind: &LinkEventKind) -> Vec<u8> {
    let object = match kind {
        LinkEventKind::Up { port, baud } => json!({ "event": "up", "port": port, "baud": baud }),
        LinkEventKind::Down { cause } => json!({ "event": "down", "cause": cause }),
        LinkEventKind::DiscardedDuringBaudScan { bytes } => json!({ "event": "probed", "bytes": bytes }),
        LinkEventKind::Overrun { bytes } => json!({ "event": "overrun", "bytes": bytes }),
        LinkEventKind::UnsolicitedError { error } => json!({ "event": "unasked-error", "code": error.code() }),
        LinkEventKind::OutputResumed => json!({ "event": "output-resumed" }),
        LinkEventKind::OutputPaused => json!({ "event": "output-paused" }),
        LinkEventKind::PortShared { program } => json!({ "event": "port-shared", "program": program }),
        LinkEventKind::Closed => json!({ "event": "closed" }),
        LinkEventKind::Marked { text } => json!({ "event": "mark", "text": text }),
    };
    object.to_string().into_bytes()
}

/// The event; `None` if the object is no event of this form.
fn link_from_json(at_ns: i64, object: &[u8]) -> Option<LinkEvent> {
    let object: Value = serde_json::from_slice(object).ok()?;
    let text = |name: &str| Some(object.get(name)?.as_str()?.to_owned());
    let bytes = || object.get("bytes")?.as_u64();
    let kind = match object.get("event")?.as_str()? {
        "up" => LinkEventKind::Up {
            port: text("port")?,
            baud: match object.get("baud")? {
                Value::Null => None,
                baud => Some(baud.as_u64()?.try_into().ok()?),
            },
        },
        "down" => LinkEventKind::Down { cause: text("cause")? },
        "probed" => LinkEventKind::DiscardedDuringBaudScan { bytes: bytes()? },
        "overrun" => LinkEventKind::Overrun { bytes: bytes()? },
        "unasked-error" => {
            let code = object.get("code")?.as_u64()?.try_into().ok()?;
            LinkEventKind::UnsolicitedError { error: DeviceError::from_code(code) }
        }
        "output-resumed" => LinkEventKind::OutputResumed,
        "output-paused" => LinkEventKind::OutputPaused,
        "port-shared" => LinkEventKind::PortShared { program: text("program")? },
        "closed" => LinkEventKind::Closed,
        "mark" => LinkEventKind::Marked { text: text("text")? },
        _ => return None,
    };
    Some(LinkEvent { at_ns, kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_as_documented() {
        let objects = [
            (
                LinkEventKind::Up { port: "COM3".into(), baud: Some(115_200) },
                r#"{"baud":115200,"event":"up","port":"COM3"}"#,
            ),
            (LinkEventKind::Up { port: "a:1".into(), baud: None }, r#"{"baud":null,"event":"up","port":"a:1"}"#),
            (LinkEventKind::Down { cause: "\"gone\"".into() }, r#"{"cause":"\"gone\"","event":"down"}"#),
            (
                LinkEventKind::DiscardedDuringBaudScan { bytes: u64::MAX },
                r#"{"bytes":18446744073709551615,"event":"probed"}"#,
            ),
            (LinkEventKind::Overrun { bytes: 1 }, r#"{"bytes":1,"event":"overrun"}"#),
            (
                LinkEventKind::UnsolicitedError { error: DeviceError::InvalidCommand },
                r#"{"code":4,"event":"unasked-error"}"#,
            ),
            (LinkEventKind::OutputResumed, r#"{"event":"output-resumed"}"#),
            (LinkEventKind::OutputPaused, r#"{"event":"output-paused"}"#),
            (
                LinkEventKind::PortShared { program: "cat (process 7)".into() },
                r#"{"event":"port-shared","program":"cat (process 7)"}"#,
            ),
            (LinkEventKind::Closed, r#"{"event":"closed"}"#),
            (LinkEventKind::Marked { text: "fan \"on\"".into() }, r#"{"event":"mark","text":"fan \"on\""}"#),
        ];
        for (kind, object) in objects {
            assert_eq!(link_to_json(&kind), object.as_bytes());
            assert_eq!(link_from_json(-5, object.as_bytes()), Some(LinkEvent { at_ns: -5, kind }));
        }
    }

    #[test]
    fn anything_else_is_no_event() {
        for object in [
            "",
            "7",
            "{}",
            r#"{"event":"sideways"}"#,
            r#"{"event":"up","port":"COM3","baud":-1}"#,
            r#"{"event":"probed"}"#,
            r#"{"event":"unasked-error","code":256}"#,
        ] {
            assert_eq!(link_from_json(0, object.as_bytes()), None, "{object}");
        }
    }
}

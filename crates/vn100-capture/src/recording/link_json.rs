//! Link events as the JSON objects of `/vn100/link`.

use serde_json::{Value, json};
use vn100_protocol::DeviceError;

use vn100_protocol::stream::{LinkEvent, LinkEventKind};

/// The object of an event, without its time: that is the log time.
pub(super) fn to_json(kind: &LinkEventKind) -> Vec<u8> {
    let object = match kind {
        LinkEventKind::Up { port, baud } => json!({ "event": "up", "port": port, "baud": baud }),
        LinkEventKind::Down { cause } => json!({ "event": "down", "cause": cause }),
        LinkEventKind::DiscardedDuringBaudScan { bytes } => json!({ "event": "probed", "bytes": bytes }),
        LinkEventKind::Overrun { bytes } => json!({ "event": "overrun", "bytes": bytes }),
        LinkEventKind::UnsolicitedError { error } => json!({ "event": "unasked-error", "code": error.code() }),
        LinkEventKind::OutputResumed => json!({ "event": "output-resumed" }),
        LinkEventKind::OutputPaused => json!({ "event": "output-paused" }),
    };
    object.to_string().into_bytes()
}

/// `None` for what is no event of this form.
pub(super) fn from_json(at_ns: i64, object: &[u8]) -> Option<LinkEvent> {
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
        ];
        for (kind, object) in objects {
            assert_eq!(to_json(&kind), object.as_bytes());
            assert_eq!(from_json(-5, object.as_bytes()), Some(LinkEvent { at_ns: -5, kind }));
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
            assert_eq!(from_json(0, object.as_bytes()), None, "{object}");
        }
    }
}

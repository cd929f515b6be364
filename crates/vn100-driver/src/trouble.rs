//! Why a live link does not go on, in the words that its user reads.

use std::io::{self, ErrorKind};

use thiserror::Error;
use vn100_protocol::{DeviceError, RequestFailure};

use crate::{autobaud::QUESTION, connect_error::ConnectError, link_output::NobodyListens};

/// Why a link does not go on.
#[derive(Debug, Error)]
pub(crate) enum Trouble {
    #[error("told to stop")]
    Stopped,
    #[error("nobody listens")]
    NobodyListens,
    #[error(transparent)]
    Refused(#[from] ConnectError),
    #[error("{}", lost(.0))]
    Lost(#[from] io::Error),
    #[error("no sensor is heard on {port}{}: {}; {}", at_speeds(tried), heard_instead(*bytes, *echoes), advice(tried, *echoes, *bytes == 0 && !asked))]
    Unheard { port: String, tried: Vec<u32>, bytes: u64, echoes: u64, asked: bool },
    #[error("{bytes} bytes came in {ms} ms and no good line was among them")]
    Garbled { bytes: u64, ms: u128 },
    #[error("the other end closed the connection, as a server that stops, or that has the port for another program")]
    Closed,
    #[error("the sensor says nothing and does not answer")]
    Silent,
    #[error("{0}")]
    Restarted(DeviceError),
    #[error("the sensor was silent, and may have restarted")]
    Returned,
    #[error("another sensor, serial {serial}, is on the port; it was {known}")]
    Another { serial: String, known: String },
    #[error("the sensor is back and cannot be set as it was: {0}")]
    NotSet(#[from] RequestFailure),
}

impl From<NobodyListens> for Trouble {
    fn from(_: NobodyListens) -> Self {
        Self::NobodyListens
    }
}

impl Trouble {
    /// Whether trying again does not help until somebody has done something.
    pub(crate) fn needs_help(&self) -> bool {
        matches!(self, Self::Refused(ConnectError::Busy { .. } | ConnectError::Denied { .. }) | Self::NotSet(_))
    }
}

/// What a read or write says when the link is gone, in the words of the one who pulled the cable.
fn lost(error: &io::Error) -> String {
    // a write to an adapter that is gone: EIO, ENXIO, ENODEV
    let is_gone = cfg!(unix) && matches!(error.raw_os_error(), Some(5 | 6 | 19));
    match error.kind() {
        _ if is_gone => GONE.into(),
        ErrorKind::BrokenPipe => GONE.into(),
        ErrorKind::UnexpectedEof | ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted => {
            Trouble::Closed.to_string()
        }
        _ => format!("the link was lost: {error}"),
    }
}

const GONE: &str = "the port is gone, as when the cable is pulled out or the adapter loses its power";

fn at_speeds(tried: &[u32]) -> String {
    match tried {
        [] => String::new(),
        [baud] => format!(" at {baud} baud"),
        several => format!(" at {} speeds", several.len()),
    }
}

/// `bytes` of which `echoes` copies of the question are a part.
fn heard_instead(bytes: u64, echoes: u64) -> String {
    let others = bytes.saturating_sub(echoes * QUESTION.len() as u64);
    match (echoes, others) {
        (0, 0) => "nothing came".into(),
        (0, bytes) => format!("{bytes} bytes came and none of them made a good line"),
        (_, 0) => "the line echoes, and nothing came but what was sent".into(),
        (_, bytes) => format!("the line echoes, and {bytes} bytes that were not sent made no good line"),
    }
}

/// `may_be_paused` where nothing came and nothing was asked.
fn advice(tried: &[u32], echoes: u64, may_be_paused: bool) -> &'static str {
    match (echoes, tried) {
        _ if may_be_paused => {
            "its output may be paused, which cannot be told without asking it: leave --listen-only out, or check the cable and the power \
             of the sensor"
        }
        (1.., _) => "take a loopback plug off; on RS-485 check the wires and the power of the sensor",
        // the server at the other end has set the speed
        (0, []) => "check the cable and the power of the sensor, and the speed that the server is set to",
        (0, _) => "check the cable, the power of the sensor and --baud",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_is_told_without_the_words_of_the_system() {
        for kind in [ErrorKind::BrokenPipe, ErrorKind::UnexpectedEof, ErrorKind::ConnectionReset] {
            let told = Trouble::from(io::Error::from(kind)).to_string();
            assert!(told.contains("cable") || told.contains("server"), "{told}");
            assert!(!told.contains(&io::Error::from(kind).to_string()), "{told}");
        }
        let other = Trouble::from(io::Error::other("a fault")).to_string();
        assert_eq!(other, "the link was lost: a fault");
    }

    #[test]
    fn advice_names_no_option_that_does_not_fit() {
        let told = |tried: &[u32], bytes, asked| {
            Trouble::Unheard { port: "x".into(), tried: tried.into(), bytes, echoes: 0, asked }.to_string()
        };
        assert!(told(&[9600], 0, true).contains("--baud"));
        assert!(!told(&[], 0, true).contains("--baud"));
        let paused = [(0, true), (1, false), (0, false)]
            .map(|(bytes, asked)| told(&[9600], bytes, asked).contains("may be paused"));
        assert_eq!(paused, [false, false, true], "only where silence is all that is known");
    }
}

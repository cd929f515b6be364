//! Why a live link does not go on, in the words that its user reads.

use std::io;

use thiserror::Error;
use vn100_protocol::{DeviceError, RequestFailure};

use crate::{connect_error::ConnectError, link_output::NobodyListens};

/// Why a link does not go on.
#[derive(Debug, Error)]
pub(crate) enum Trouble {
    #[error("told to stop")]
    Stopped,
    #[error("nobody listens")]
    NobodyListens,
    #[error(transparent)]
    Refused(#[from] ConnectError),
    #[error("the link was lost: {0}")]
    Lost(#[from] io::Error),
    #[error("no sensor is heard on {port}{}: {}; check the cable, the power of the sensor and --baud", at_speeds(tried), heard_instead(*bytes))]
    Unheard { port: String, tried: Vec<u32>, bytes: u64 },
    #[error("{bytes} bytes came in {ms} ms and no good line was among them")]
    Garbled { bytes: u64, ms: u128 },
    #[error("the other end closed the link")]
    Closed,
    #[error("the sensor says nothing and does not answer")]
    Silent,
    #[error("{0}")]
    Restarted(DeviceError),
    #[error("the sensor was silent, and may have restarted")]
    Returned,
    #[error("the sensor is back and cannot be set as it was: {0}")]
    NotSet(#[from] RequestFailure),
}

impl From<NobodyListens> for Trouble {
    fn from(_: NobodyListens) -> Self {
        Self::NobodyListens
    }
}

fn at_speeds(tried: &[u32]) -> String {
    match tried {
        [] => String::new(),
        [baud] => format!(" at {baud} baud"),
        several => format!(" at {} speeds", several.len()),
    }
}

fn heard_instead(bytes: u64) -> String {
    match bytes {
        0 => "nothing came".into(),
        bytes => format!("{bytes} bytes came and none of them made a good line"),
    }
}

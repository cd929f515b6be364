//! Why a request failed.

use alloc::{format, string::String};
use core::time::Duration;

use thiserror::Error;

use crate::{register::fields::RegisterFields, request::device_error::DeviceError};

/// Why a request failed. `line` is the command as sent, without CR and LF.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RequestFailure {
    /// The sensor said nothing.
    #[error(
        "no answer to {line}, {} in {:.1} s: check the baud rate and the wire to the sensor; a sensor whose error mode \
         (register 30) is 0 says nothing to a command that it refuses", sent(*.attempts), .after.as_secs_f64()
    )]
    Timeout {
        /// The command.
        line: String,
        /// How often it was sent.
        attempts: u32,
        /// From the first time it was sent to the end of the wait.
        after: Duration,
    },
    /// The sensor refused it.
    #[error("the sensor refused {line} with {error}: {}", .error.advice())]
    Device {
        /// The command.
        line: String,
        /// What it said.
        error: DeviceError,
    },
    /// The link went down before an answer came.
    #[error("the link went down before {line} was answered ({})", sent(*.attempts))]
    LinkDown {
        /// The command.
        line: String,
        /// How often it was sent; 0 for one that waited for others.
        attempts: u32,
    },
    /// The sensor took a write, but not as it was asked.
    #[error(
        "the sensor answered {line} with other fields: asked for {asked}, got {got}; read the register to see what it holds"
    )]
    EchoDiffers {
        /// The command.
        line: String,
        /// The fields sent.
        asked: RegisterFields,
        /// The fields of the reply.
        got: RegisterFields,
    },
}

fn sent(times: u32) -> String {
    match times {
        0 => "not yet sent".into(),
        1 => "sent once".into(),
        times => format!("sent {times} times"),
    }
}

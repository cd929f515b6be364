//! What a link is doing, as whoever watches it is told.

use std::time::Duration;

use vn100_protocol::DeviceError;

use crate::low_latency::LatencyTimer;

/// What a link is doing.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkState {
    /// The port is being opened.
    Opening,
    /// A sensor is listened for.
    Probing {
        /// The port by its name.
        port: String,
        /// The speed that is tried; `None` where the link has none.
        baud: Option<u32>,
    },
    /// The sensor is heard.
    Up(Up),
    /// The port is open and nothing has come on it for several lines' time.
    Silent(Up),
    /// There is no link, and it will be opened again.
    Down {
        /// Whether a sensor was heard before: else it is not lost, but was never there.
        was_up: bool,
        /// What happened, in words.
        cause: String,
        /// Whether somebody must do something before it can come back: the port is taken or not
        /// allowed to this user, or the sensor cannot be set as it was.
        needs_help: bool,
        /// The wait before the next attempt.
        retry_in: Duration,
    },
    /// It is over; the last event says why.
    Closed {
        /// Whether an output that was found paused by somebody else, and was made to go on, is
        /// paused again; `None` where there was none such.
        paused_again: Option<bool>,
    },
}

/// What is known of a link that is up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Up {
    /// The port by its name, such as `/dev/ttyUSB0`.
    pub port: String,
    /// Speed of the line in baud; `None` where the link has none.
    pub baud: Option<u32>,
    /// Since when, in nanoseconds from the origin of the arrival times.
    pub since_ns: i64,
    /// The latency timer of the adapter, where it has one, and how to shorten it where the link was
    /// not allowed to.
    pub latency_timer: Option<LatencyTimer>,
    /// The error with which the sensor has restarted by itself while the link was up, where that is
    /// why it is up anew.
    pub restarted: Option<DeviceError>,
    /// Whether the output of the sensor was found paused by somebody else, and was made to go on.
    /// It is paused again when the link is stopped, unless a request has asked for it.
    pub output_resumed: bool,
}

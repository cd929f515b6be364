//! What a link is doing, as its user sees it.

use std::time::Duration;

use vn100_protocol::DeviceError;

use crate::low_latency::LatencyTimer;

/// What a link is doing.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkState {
    /// The port is being opened.
    Opening,
    /// A baud scan searches the sensor.
    Probing {
        /// The port by its name.
        port: String,
        /// The baud rate that is tried; `None` where the link has none.
        baud: Option<u32>,
    },
    /// The sensor is connected.
    Up(Up),
    /// The port is open, and the output of the sensor has been silent for several of its periods.
    Silent(Up),
    /// The link is lost, or cannot be connected, and is tried again.
    Down {
        /// Whether the sensor was connected before: else it is not lost, but was never there.
        was_up: bool,
        /// Why, in words.
        cause: String,
        /// Whether the next attempt fails, too, unless the user does something: the port is in use
        /// or not allowed to this user, or the sensor refuses its settings.
        needs_help: bool,
        /// The delay before the next attempt.
        retry_in: Duration,
    },
    /// The link has ended; the last event says why.
    Closed {
        /// Whether an output that was found paused by another program, and was resumed, is paused
        /// again; `None` where there was none such.
        paused_again: Option<bool>,
    },
}

/// What is known of a connected link.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Up {
    /// The port by its name, such as `/dev/ttyUSB0`.
    pub port: String,
    /// The baud rate; `None` where the link has none.
    pub baud: Option<u32>,
    /// Since when, in nanoseconds from the origin of the arrival times.
    pub since_ns: i64,
    /// The latency timer of the adapter, where it has one, and how to shorten it where the link may
    /// not.
    pub latency_timer: Option<LatencyTimer>,
    /// The error that the sensor reported when it restarted on an open port, where that is why the
    /// link is up anew.
    pub restarted: Option<DeviceError>,
    /// Whether the output of the sensor was found paused by another program, and was resumed. It is
    /// paused again when the link is stopped, unless a command of the user has resumed it, too.
    pub output_resumed: bool,
}

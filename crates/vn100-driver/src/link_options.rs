//! How a link is opened, read and kept.

use std::time::Duration;

use tokio::sync::mpsc;

use crate::output_plan::Change;
use vn100_protocol::stream::{Input, ReadOptions};

/// How a link is opened and read.
#[derive(Debug, Default)]
pub struct LinkOptions {
    /// Speed of the line in baud; `None` to try all that the sensor has.
    pub baud: Option<u32>,
    /// Send nothing, as on a line that others listen to. Finding the speed then takes up to 12 s.
    pub listen_only: bool,
    /// How the bytes are read.
    pub read: ReadOptions,
    /// Where a copy of everything that comes is sent, in order. What it does not take at once is
    /// dropped and told in it as [`Overrun`](vn100_protocol::stream::LinkEventKind::Overrun): recording never delays
    /// measuring.
    pub recording: Option<mpsc::Sender<Input>>,
    /// Read the temperature and the uncompensated measurements (register 54) this often between the
    /// lines, where the line has room for it. The answers are among the
    /// [`registers`](vn100_protocol::stream::Batch::registers) of the batches.
    pub poll_temperature: Option<Duration>,
    /// What [`configure`](crate::configure()) has changed, to be written again when the sensor
    /// comes back: it may have lost its power, and with it all that was not saved. Until it is so
    /// the link does not count as up. The speed of the line is not set again: the sensor is heard
    /// at the one it has. Nothing where the link listens only.
    pub desired_settings: Vec<Change>,
    /// The serial number of the sensor that is measured on, where that is known: another one is
    /// taken as one that comes back in its place. It cannot be told where the link listens only.
    pub known_serial: Option<String>,
}

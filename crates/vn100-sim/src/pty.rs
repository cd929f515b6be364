//! The emulated sensor as a serial port of this machine: a pseudo-terminal, which any program can
//! open. Only on Linux, which reports the opening and closing of the port by a host.
//!
//! ```no_run
//! use vn100_sim::{Device, DeviceConfig, pty::{PtyOptions, serve}};
//!
//! let sensor = serve(Device::new(DeviceConfig::default()), PtyOptions::default())?;
//! println!("open {}", sensor.path().display());
//! let stats = sensor.stop()?;
//! println!("{} bytes too many for a host that did not read", stats.bytes_dropped);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A host that reads at another rate than the sensor sends reads garbled bytes, and one that does
//! not read loses bytes once its terminal is full and another 64 KiB are pending: the sensor never
//! waits. After the host has closed the port, or was killed, a new pseudo-terminal replaces it, so
//! that no old bytes and no exclusive access remain; only a link ([`PtyOptions::link`]) stays the
//! same.

mod port;
mod server;

use std::{path::PathBuf, time::Duration};

use crate::fault::FaultPlan;

pub use server::{PtySensor, serve};

/// The connection of the emulated sensor.
#[derive(Debug, Clone, Default)]
pub struct PtyOptions {
    /// A symbolic link to the present pseudo-terminal; `None` for no link. An existing link is
    /// replaced, and the link is removed at the end. A sensor that returns under another name has
    /// the link with `-1` appended.
    pub link: Option<PathBuf>,
    /// The faults of the link.
    pub faults: FaultPlan,
    /// Seed of the faults.
    pub seed: u64,
    /// The time for which the sensor has been on when it is connected. Times of faults count from
    /// power-up.
    pub on_for: Duration,
}

/// Byte counts of an emulated port.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PtyStats {
    /// Number of openings of the port.
    pub openings: u64,
    /// Bytes in the terminal of the host; after the end, those that it has read.
    pub bytes_sent: u64,
    /// Bytes that were dropped because the terminal and the 64 KiB after it were full.
    pub bytes_dropped: u64,
    /// Bytes that were pending when the port was closed, or the sensor unplugged.
    pub bytes_unread: u64,
}

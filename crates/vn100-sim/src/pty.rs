//! The emulated sensor as a serial port of this machine: a pseudo-terminal, which any program can
//! open. Only on Linux, if the machine reports the opening and closing of the port by a host.
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

#[cfg(target_os = "linux")]
mod port;
#[cfg(target_os = "linux")]
mod server;

use std::{io, path::PathBuf, time::Duration};

use thiserror::Error;

use crate::fault::FaultPlan;

#[cfg(target_os = "linux")]
pub use server::{PtySensor, serve};

/// The connection of the emulated sensor.
#[derive(Debug, Clone, Default)]
pub struct PtyOptions {
    /// A symbolic link to the present pseudo-terminal; `None` for no link. An existing link is
    /// replaced, and the link is removed at the end. A sensor that returns under another name has
    /// the link with `-1` appended.
    pub link: Option<PathBuf>,
    /// The latency timer of a USB adapter; `None` to forward bytes as they come.
    pub usb_latency: Option<Duration>,
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
    /// Bytes that the host has received.
    pub bytes_sent: u64,
    /// Bytes that were dropped because the terminal and the 64 KiB after it were full.
    pub bytes_dropped: u64,
    /// Bytes that were pending when the port was closed, or the sensor unplugged.
    pub bytes_unread: u64,
}

/// The reason why the sensor cannot be connected, or is no longer connected.
#[derive(Debug, Error)]
pub enum PtyError {
    /// This system is not Linux.
    #[error(
        "an emulated port needs a pseudo-terminal of Linux, which this system does not have: serve the sensor at a TCP address, or write a capture"
    )]
    Unsupported,
    /// The system provides no pseudo-terminal.
    #[error("no pseudo-terminal for the emulated sensor")]
    Open(#[source] io::Error),
    /// The symbolic link cannot be made.
    #[error("cannot make the link {} to the emulated sensor", path.display())]
    SymbolicLink {
        /// The path of the link.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// A file other than a link has the path of the link.
    #[error("{} exists and is not a symbolic link: remove it, or choose another place for the link", path.display())]
    LinkTaken {
        /// The path of the link.
        path: PathBuf,
    },
    /// A link with that path has a target, such as the port of another sensor.
    #[error("{} already leads to {}: end that program, or choose another place for the link", path.display(), leads_to.display())]
    LinkInUse {
        /// The path of the link.
        path: PathBuf,
        /// The target of the existing link.
        leads_to: PathBuf,
    },
    /// The thread of the sensor cannot be started.
    #[error("cannot start the thread of the emulated sensor")]
    Thread(#[source] io::Error),
    /// The thread of the sensor has panicked.
    #[error("internal error in the emulated sensor")]
    Panicked,
}

/// A sensor on a pseudo-terminal; on this system there are none.
#[cfg(not(target_os = "linux"))]
#[derive(Debug)]
pub enum PtySensor {}

/// # Errors
/// Always [`PtyError::Unsupported`].
#[cfg(not(target_os = "linux"))]
pub fn serve(_: crate::Device, _: PtyOptions) -> Result<PtySensor, PtyError> {
    Err(PtyError::Unsupported)
}

#[cfg(not(target_os = "linux"))]
impl PtySensor {
    /// The path for a host to open.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        match *self {}
    }

    /// Byte counts so far.
    #[must_use]
    pub fn stats(&self) -> PtyStats {
        match *self {}
    }

    /// Unplugs the sensor.
    ///
    /// # Errors
    /// Never fails here.
    pub fn stop(self) -> Result<PtyStats, PtyError> {
        match self {}
    }
}

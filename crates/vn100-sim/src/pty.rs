//! The emulated sensor as a serial port of this machine: a pseudo-terminal, which any program can
//! open. Linux only, where the machine reports when a host opens and closes the port.
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
//! not read loses bytes once its terminal is full and 64 KiB wait behind it: the sensor never
//! waits. When the host has closed the port, or was killed, a new pseudo-terminal takes its place,
//! so that no old bytes and no exclusive access are left behind; only a link ([`PtyOptions::link`])
//! stays the same.

#[cfg(target_os = "linux")]
mod port;
#[cfg(target_os = "linux")]
mod server;

use std::{io, path::PathBuf, time::Duration};

use thiserror::Error;

use crate::fault::FaultPlan;

#[cfg(target_os = "linux")]
pub use server::{PtySensor, serve};

/// How the sensor is connected.
#[derive(Debug, Clone, Default)]
pub struct PtyOptions {
    /// A symbolic link to the current pseudo-terminal. It is made anew where one
    /// exists, and removed at the end. A sensor that returns under another name has it with `-1`
    /// behind.
    pub link: Option<PathBuf>,
    /// The latency timer of a USB adapter; `None`: bytes are forwarded as they come.
    pub usb_latency: Option<Duration>,
    /// The faults of the link.
    pub faults: FaultPlan,
    /// Seed of the faults.
    pub seed: u64,
    /// For how long the sensor has been on when it is connected. Times of faults count from
    /// power-up.
    pub on_for: Duration,
}

/// Byte counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PtyStats {
    /// How often the port was opened.
    pub openings: u64,
    /// Bytes handed to a host.
    pub bytes_sent: u64,
    /// Bytes that found the terminal full, and the 64 KiB too that wait for room in it.
    pub bytes_dropped: u64,
    /// Bytes that waited for room when the port was closed, or the sensor taken away.
    pub bytes_unread: u64,
}

/// Why the sensor cannot be connected, or no longer.
#[derive(Debug, Error)]
pub enum PtyError {
    /// This system is not Linux.
    #[error(
        "an emulated port needs a pseudo-terminal of Linux, which this system does not have: write a capture instead"
    )]
    Unsupported,
    /// The system gives no pseudo-terminal.
    #[error("no pseudo-terminal for the emulated sensor")]
    Open(#[source] io::Error),
    /// The link cannot be made.
    #[error("cannot make the link {} to the emulated sensor", path.display())]
    SymbolicLink {
        /// Where it should be.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Something other than a link is in its place.
    #[error("{} exists and is not a symbolic link: remove it, or choose another place for the link", path.display())]
    LinkTaken {
        /// Where it should be.
        path: PathBuf,
    },
    /// A link of that name has a target, such as the port of another sensor.
    #[error("{} already leads to {}: end that program, or choose another place for the link", path.display(), leads_to.display())]
    LinkInUse {
        /// Where it should be.
        path: PathBuf,
        /// The target of that link.
        leads_to: PathBuf,
    },
    /// The thread of the sensor cannot be started.
    #[error("cannot start the thread of the emulated sensor")]
    Thread(#[source] io::Error),
    /// The thread of the sensor has ended by a fault of its own.
    #[error("internal error in the emulated sensor")]
    Panicked,
}

/// A sensor on a pseudo-terminal, where there are any.
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
    /// The path to open.
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
    /// None here.
    pub fn stop(self) -> Result<PtyStats, PtyError> {
        match self {}
    }
}

//! The emulated VN-100: seeded noise with known truth, printed as the sensor prints it.
//!
//! A [`Profile`] states the truth of all twelve channels of `$VNYMR`, a [`Generator`] turns it into
//! rows, and [`write_next`](capture::write_next) prints them. The same profile, rate and seed give the same bytes.
//!
//! ```
//! use vn100_sim::{Generator, Message, Profile, capture::write_next};
//!
//! let mut generator = Generator::new(&Profile::lab3(), 40, 1)?;
//! let mut capture = Vec::new();
//! let message = Message::named("VNYMR").ok_or("no such message")?;
//! (0..40).for_each(|_| write_next(&mut capture, message, &mut generator));
//! assert!(capture.starts_with(b"$VNYMR,+052."));
//! assert_eq!(capture.iter().filter(|&&byte| byte == b'\n').count(), 40);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Device`] is the whole sensor with its serial line, on a clock that is passed in; a
//! [`Wire`](wire::Wire) puts cable, adapter and faults between the device and a host;
//! [`pty::serve`] makes the device a serial port of this machine.

pub mod capture;
pub mod device;
pub mod fault;
mod flicker;
mod gauss_markov;
mod message;
pub mod noise;
mod normal;
mod onboard;
mod packets;
mod profile;
#[cfg(target_os = "linux")]
pub mod pty;
mod receiver;
mod sensor;
mod sensor_clock;
mod thermal;
pub mod wire;

pub use capture::{Generator, UnsupportedRate};
pub use device::{Device, DeviceConfig};
pub use message::Message;
pub use onboard::{AveragingWindow, LowPass};
pub use packets::PacketStream;
pub use profile::{NoTwin, Profile};
pub use thermal::{Thermal, ThermalError};

pub(crate) const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

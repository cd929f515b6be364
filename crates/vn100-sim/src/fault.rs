//! The faults of a serial link, as a plan written in one line of text.
//!
//! ```
//! use vn100_sim::fault::FaultPlan;
//!
//! let plan: FaultPlan = "drop@12.5s flip@0.1%:bit6 unplug@20s+3s stale".parse()?;
//! assert_eq!(plan.faults.len(), 4);
//! # Ok::<(), vn100_sim::fault::FaultPlanError>(())
//! ```
//!
//! Faults are separated by spaces. Times count from power-up: `12.5s`, `20ms`, `5min`, `2h`.
//!
//! | fault | does |
//! |---|---|
//! | `drop@TIME` `drop@TIME+TIME` `drop@P%` | loses one byte; all bytes for a while; each byte with this chance |
//! | `flip@…[:bitN]` | the same, but inverts a bit, N from 0 to 7, or any |
//! | `splice@TIME` | loses the end of one line and the beginning of the next |
//! | `stall@TIME+TIME` | holds all bytes back, and lets them go at once |
//! | `unplug@TIME` `unplug@TIME+TIME[:other]` | the port vanishes, with the power of the sensor, and returns; with `other`, under another name |
//! | `reboot@TIME` | the sensor reports a hard fault and restarts |
//! | `baud@TIME:RATE` | the sensor's line runs at another rate |
//! | `stale` | the first bytes after the port is opened are old |
//! | `badopen@P%` | each opening of the port has this chance of bit 6 of every byte being inverted until it is closed |

mod injector;

use std::{num::NonZeroU32, str::FromStr, time::Duration};

pub use injector::PlugEvent;
pub(crate) use injector::{Injector, ScheduledEvent};

use thiserror::Error;
use vn100_protocol::BaudRate;

/// The bytes that a fault affects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bytes {
    /// The first byte at this time or later.
    At(Duration),
    /// All bytes from the first time on, for the second.
    During(Duration, Duration),
    /// Each byte with this probability, from 0 to 1.
    Chance(f64),
}

/// One fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Bytes are lost.
    Drop(Bytes),
    /// A bit of bytes is inverted; a random one if none is named.
    Flip(Bytes, Option<u8>),
    /// The end of one line and the beginning of the next are lost.
    Splice(Duration),
    /// Bytes are delayed for a while.
    Stall(Duration, Duration),
    /// The port disappears.
    Unplug {
        /// The time when the port disappears.
        at: Duration,
        /// The time until the port returns; `None` for never.
        back_after: Option<Duration>,
        /// Whether the port returns under another name.
        other_name: bool,
    },
    /// The sensor fails and restarts.
    Reboot(Duration),
    /// The sensor changes to another baud rate.
    Baud(Duration, NonZeroU32),
    /// The first bytes after an opening are old.
    Stale,
    /// Each opening has this probability, from 0 to 1, of being bad.
    BadOpen(f64),
}

/// The faults of a link, in the order in which they were written.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaultPlan {
    /// The faults.
    pub faults: Vec<Fault>,
}

/// An item of a plan that is no fault.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{0}` {1}")]
pub struct FaultPlanError(String, String);

impl FromStr for FaultPlan {
    type Err = FaultPlanError;

    /// An empty text is a plan without faults.
    fn from_str(text: &str) -> Result<Self, FaultPlanError> {
        Ok(Self { faults: text.split_whitespace().map(Fault::from_str).collect::<Result<_, _>>()? })
    }
}

impl FromStr for Fault {
    type Err = FaultPlanError;

    fn from_str(text: &str) -> Result<Self, FaultPlanError> {
        Self::parse(text).map_err(|problem| FaultPlanError(text.into(), problem))
    }
}

impl Fault {
    fn parse(text: &str) -> Result<Self, String> {
        let (head, detail) = text.split_once(':').map_or((text, None), |(head, detail)| (head, Some(detail)));
        let (name, when) = head.split_once('@').map_or((head, None), |(name, when)| (name, Some(when)));
        let when = || when.ok_or_else(|| "has no time: add `@` and a time from power-up, such as `@12.5s`".to_owned());
        let wrong_detail = || {
            let rates = BaudRate::ALL.map(|rate| rate.to_string()).join(", ");
            let detail = detail.unwrap_or_default();
            format!(
                "has `{detail}` after the colon: flip takes bit0 to bit7, unplug with two times takes other, baud needs one of {rates}"
            )
        };
        let plain = |fault: Self| if detail.is_none() { Ok(fault) } else { Err(wrong_detail()) };
        match name {
            "drop" => plain(Self::Drop(bytes(when()?)?)),
            "flip" => {
                let bit = |detail: &str| {
                    let bit = detail.strip_prefix("bit").and_then(|bit| bit.parse().ok());
                    bit.filter(|bit| *bit < 8).ok_or_else(wrong_detail)
                };
                Ok(Self::Flip(bytes(when()?)?, detail.map(bit).transpose()?))
            }
            "splice" => plain(Self::Splice(time(when()?)?)),
            "reboot" => plain(Self::Reboot(time(when()?)?)),
            "badopen" => plain(Self::BadOpen(chance(when()?)?)),
            "stall" => {
                let (at, length) = span(when()?)?;
                plain(Self::Stall(at, length.ok_or("has no length: add `+` and a duration, such as `@10s+2s`")?))
            }
            "unplug" => {
                let (at, back_after) = span(when()?)?;
                let other_name = match detail {
                    None => false,
                    Some("other") if back_after.is_some() => true,
                    Some(_) => return Err(wrong_detail()),
                };
                Ok(Self::Unplug { at, back_after, other_name })
            }
            "baud" => {
                let baud = detail.and_then(|rate| rate.parse::<NonZeroU32>().ok());
                let baud = baud.filter(|baud| BaudRate::new(baud.get()).is_some()).ok_or_else(wrong_detail)?;
                Ok(Self::Baud(time(when()?)?, baud))
            }
            "stale" if head == name => plain(Self::Stale),
            _ => Err(
                "is no fault: use drop, flip, splice, stall, unplug, reboot, baud or badopen with @ and a time, or \
                      stale alone"
                    .into(),
            ),
        }
    }
}

fn bytes(when: &str) -> Result<Bytes, String> {
    if when.ends_with('%') {
        return Ok(Bytes::Chance(chance(when)?));
    }
    Ok(match span(when)? {
        (at, None) => Bytes::At(at),
        (from, Some(length)) => Bytes::During(from, length),
    })
}

fn span(when: &str) -> Result<(Duration, Option<Duration>), String> {
    match when.split_once('+') {
        None => Ok((time(when)?, None)),
        Some((from, length)) => Ok((time(from)?, Some(time(length)?))),
    }
}

fn chance(text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').and_then(number).filter(|percent| *percent <= 100.0);
    let problem = || format!("has `{text}`, which is no chance: write a number from 0 to 100 and `%`, such as `0.1%`");
    Ok(percent.ok_or_else(problem)? / 100.0)
}

fn time(text: &str) -> Result<Duration, String> {
    let units = [("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0)];
    let seconds = units.iter().find_map(|(unit, seconds)| Some(number(text.strip_suffix(unit)?)? * seconds));
    let time = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    time.ok_or_else(|| {
        format!("has `{text}`, which is no time: write a number and one of ms, s, min, h, such as `12.5s`")
    })
}

/// Digits with at most one point; no sign, no exponent.
fn number(text: &str) -> Option<f64> {
    text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'.')).then(|| text.parse().ok())?
}

#[cfg(test)]
mod tests;

//! The faults of a serial link, as a plan written in one line of text.
//!
//! ```
//! use vn100_sim::fault::FaultPlan;
//!
//! let plan: FaultPlan = "drop@12.5s flip@0.1%:bit6 unplug@20s+3s stale".parse()?;
//! assert_eq!(plan.to_string(), "drop@12.5s flip@0.1%:bit6 unplug@20s+3s stale");
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

use std::{fmt, num::NonZeroU32, str::FromStr, time::Duration};

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

/// The reason why an item of a plan is no fault. Each variant gives the item as it was written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FaultPlanError {
    /// The item names no fault.
    #[error(
        "`{0}` is no fault: use drop, flip, splice, stall, unplug, reboot, baud or badopen with @ and a time, or stale alone"
    )]
    Unknown(String),
    /// The item lacks a time.
    #[error("`{0}` has no time: add `@` and a time from power-up, such as `@12.5s`")]
    WhenMissing(String),
    /// The item lacks a duration.
    #[error("`{0}` has no length: add `+` and a duration, such as `@10s+2s`")]
    LengthMissing(String),
    /// A part of the item is no time.
    #[error("`{text}` in `{item}` is no time: write a number and one of ms, s, min, h, such as `12.5s`")]
    Time {
        /// The item.
        item: String,
        /// The wrong part.
        text: String,
    },
    /// A part of the item is no probability.
    #[error("`{text}` in `{item}` is no chance: write a number from 0 to 100 and `%`, such as `0.1%`")]
    Chance {
        /// The item.
        item: String,
        /// The wrong part.
        text: String,
    },
    /// The option after the colon is not valid for this fault.
    #[error(
        "`{detail}` after the colon does not fit `{item}`: flip takes bit0 to bit7, unplug with two times takes other, baud needs one of {}",
        BaudRate::ALL.map(|rate| rate.to_string()).join(", ")
    )]
    Detail {
        /// The item as written.
        item: String,
        /// The wrong part; empty if it is missing.
        detail: String,
    },
}

impl FromStr for FaultPlan {
    type Err = FaultPlanError;

    /// An empty text is a plan without faults.
    fn from_str(text: &str) -> Result<Self, FaultPlanError> {
        Ok(Self { faults: text.split_whitespace().map(Fault::from_str).collect::<Result<_, _>>()? })
    }
}

impl fmt::Display for FaultPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faults: Vec<_> = self.faults.iter().map(ToString::to_string).collect();
        f.write_str(&faults.join(" "))
    }
}

impl FromStr for Fault {
    type Err = FaultPlanError;

    fn from_str(text: &str) -> Result<Self, FaultPlanError> {
        let (head, detail) = text.split_once(':').map_or((text, None), |(head, detail)| (head, Some(detail)));
        let (name, when) = head.split_once('@').map_or((head, None), |(name, when)| (name, Some(when)));
        let item = || text.to_owned();
        let when = || when.ok_or_else(|| FaultPlanError::WhenMissing(item()));
        let wrong_detail = || FaultPlanError::Detail { item: item(), detail: detail.unwrap_or_default().to_owned() };
        let plain = |fault: Self| if detail.is_none() { Ok(fault) } else { Err(wrong_detail()) };
        match name {
            "drop" => plain(Self::Drop(bytes(when()?, text)?)),
            "flip" => {
                let bit = |detail: &str| {
                    let bit = detail.strip_prefix("bit").and_then(|bit| bit.parse().ok());
                    bit.filter(|bit| *bit < 8).ok_or_else(wrong_detail)
                };
                Ok(Self::Flip(bytes(when()?, text)?, detail.map(bit).transpose()?))
            }
            "splice" => plain(Self::Splice(time(when()?, text)?)),
            "reboot" => plain(Self::Reboot(time(when()?, text)?)),
            "badopen" => plain(Self::BadOpen(chance(when()?, text)?)),
            "stall" => {
                let (at, length) = span(when()?, text)?;
                plain(Self::Stall(at, length.ok_or_else(|| FaultPlanError::LengthMissing(item()))?))
            }
            "unplug" => {
                let (at, back_after) = span(when()?, text)?;
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
                Ok(Self::Baud(time(when()?, text)?, baud))
            }
            "stale" if head == name => plain(Self::Stale),
            _ => Err(FaultPlanError::Unknown(item())),
        }
    }
}

fn bytes(when: &str, item: &str) -> Result<Bytes, FaultPlanError> {
    if when.ends_with('%') {
        return Ok(Bytes::Chance(chance(when, item)?));
    }
    Ok(match span(when, item)? {
        (at, None) => Bytes::At(at),
        (from, Some(length)) => Bytes::During(from, length),
    })
}

fn span(when: &str, item: &str) -> Result<(Duration, Option<Duration>), FaultPlanError> {
    match when.split_once('+') {
        None => Ok((time(when, item)?, None)),
        Some((from, length)) => Ok((time(from, item)?, Some(time(length, item)?))),
    }
}

fn chance(text: &str, item: &str) -> Result<f64, FaultPlanError> {
    let percent = text.strip_suffix('%').and_then(number).filter(|percent| *percent <= 100.0);
    let error = || FaultPlanError::Chance { item: item.to_owned(), text: text.to_owned() };
    Ok(percent.ok_or_else(error)? / 100.0)
}

fn time(text: &str, item: &str) -> Result<Duration, FaultPlanError> {
    let units = [("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0)];
    let seconds = units.iter().find_map(|(unit, seconds)| Some(number(text.strip_suffix(unit)?)? * seconds));
    let error = || FaultPlanError::Time { item: item.to_owned(), text: text.to_owned() };
    Duration::try_from_secs_f64(seconds.ok_or_else(error)?).map_err(|_| error())
}

/// Digits with at most one point; no sign, no exponent.
fn number(text: &str) -> Option<f64> {
    text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'.')).then(|| text.parse().ok())?
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = |time: &Duration| format!("{}s", time.as_secs_f64());
        match self {
            Self::Drop(bytes) => write!(f, "drop@{bytes}"),
            Self::Flip(bytes, None) => write!(f, "flip@{bytes}"),
            Self::Flip(bytes, Some(bit)) => write!(f, "flip@{bytes}:bit{bit}"),
            Self::Splice(at) => write!(f, "splice@{}", seconds(at)),
            Self::Stall(from, length) => write!(f, "stall@{}+{}", seconds(from), seconds(length)),
            Self::Unplug { at, back_after, other_name } => {
                write!(f, "unplug@{}", seconds(at))?;
                back_after.map_or(Ok(()), |back_after| write!(f, "+{}", seconds(&back_after)))?;
                f.write_str(if *other_name { ":other" } else { "" })
            }
            Self::Reboot(at) => write!(f, "reboot@{}", seconds(at)),
            Self::Baud(at, baud) => write!(f, "baud@{}:{baud}", seconds(at)),
            Self::Stale => f.write_str("stale"),
            Self::BadOpen(chance) => write!(f, "badopen@{}%", percent(*chance)),
        }
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(at) => write!(f, "{}s", at.as_secs_f64()),
            Self::During(from, length) => write!(f, "{}s+{}s", from.as_secs_f64(), length.as_secs_f64()),
            Self::Chance(chance) => write!(f, "{}%", percent(*chance)),
        }
    }
}

/// Undoes the division by 100: the quotient need not have an exact inverse.
fn percent(chance: f64) -> f64 {
    (chance * 1e14).round() / 1e12
}

#[cfg(test)]
mod tests;

//! Injects the faults of a plan into the bytes of a link.

use std::{collections::VecDeque, time::Duration};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Bytes, Fault, FaultPlan};

/// Old bytes at the beginning of a session: fewer than a line has.
const STALE_BYTES: usize = 40;

/// The most bytes that a splice takes from the second line; it takes at least one.
const SPLICED_BYTES: u8 = 60;

/// The bit that a bad session inverts, as seen on a real host.
const BAD_SESSION_BIT: u8 = 6;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ScheduledEvent {
    Plug(PlugEvent),
    Reboot,
    Baud(std::num::NonZeroU32),
}

/// The port disappears or returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlugEvent {
    /// The port disappears.
    Unplugged,
    /// The port is back, and the sensor starts from power-up.
    Replugged {
        /// Whether the port is back under another name.
        other_name: bool,
    },
}

/// The position of the stream in a splice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Splice {
    /// Bytes are lost up to the end of the line.
    FirstLine,
    /// This many more bytes are lost.
    SecondLine(u8),
}

/// A plan in execution. Equal plans, seeds and bytes give equal results.
#[derive(Debug, Clone)]
pub(crate) struct Injector {
    /// Faults of bytes; those that have happened are removed.
    faults: Vec<Fault>,
    events: VecDeque<(Duration, ScheduledEvent)>,
    splice: Option<Splice>,
    bad_session: bool,
    recent: VecDeque<u8>,
    rng: ChaCha8Rng,
}

impl Injector {
    pub(crate) fn new(plan: &FaultPlan, seed: u64) -> Self {
        let mut events = Vec::new();
        for fault in &plan.faults {
            match *fault {
                Fault::Unplug { at, back_after, other_name } => {
                    events.push((at, ScheduledEvent::Plug(PlugEvent::Unplugged)));
                    let replugged = ScheduledEvent::Plug(PlugEvent::Replugged { other_name });
                    let replug = |after| (at.saturating_add(after), replugged);
                    events.extend(back_after.map(replug));
                }
                Fault::Reboot(at) => events.push((at, ScheduledEvent::Reboot)),
                Fault::Baud(at, baud) => events.push((at, ScheduledEvent::Baud(baud))),
                _ => {}
            }
        }
        events.sort_by_key(|(at, _)| *at);
        Self {
            faults: plan.faults.clone(),
            events: events.into(),
            splice: None,
            bad_session: false,
            recent: VecDeque::new(),
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    pub(crate) fn next_event(&self) -> Option<Duration> {
        self.events.front().map(|(at, _)| *at)
    }

    /// The next event that is due by `now`, with its time.
    pub(crate) fn take_event(&mut self, now: Duration) -> Option<(Duration, ScheduledEvent)> {
        self.next_event().filter(|at| *at <= now)?;
        self.events.pop_front()
    }

    /// The port is opened: returns the old bytes that come first.
    pub(crate) fn open(&mut self) -> Vec<u8> {
        self.bad_session = false;
        let mut stale = Vec::new();
        for fault in &self.faults {
            match fault {
                Fault::BadOpen(chance) => self.bad_session |= self.rng.random::<f64>() < *chance,
                Fault::Stale => stale = self.recent.iter().copied().collect(),
                _ => {}
            }
        }
        stale
    }

    /// The forwarded byte, with its time; `None` if it is lost.
    pub(crate) fn pass(&mut self, at: Duration, byte: u8) -> Option<(Duration, u8)> {
        let mut byte = byte;
        let mut lost = false;
        let mut release = at;
        let rng = &mut self.rng;
        let splice = &mut self.splice;
        self.faults.retain(|fault| {
            let when = match *fault {
                Fault::Drop(bytes) | Fault::Flip(bytes, _) => bytes,
                Fault::Splice(time) => Bytes::At(time),
                Fault::Stall(from, length) => Bytes::During(from, length),
                _ => return true,
            };
            let strikes = match when {
                Bytes::At(time) => at >= time,
                Bytes::During(from, length) => at >= from && at < from.saturating_add(length),
                Bytes::Chance(chance) => rng.random::<f64>() < chance,
            };
            if !strikes {
                return true;
            }
            match *fault {
                Fault::Drop(_) => lost = true,
                Fault::Flip(_, bit) => byte ^= 1 << bit.unwrap_or_else(|| rng.random_range(0..8)),
                Fault::Splice(_) => *splice = Some(Splice::FirstLine),
                Fault::Stall(from, length) => release = release.max(from.saturating_add(length)),
                _ => {}
            }
            !matches!(when, Bytes::At(_))
        });
        if self.bad_session {
            byte ^= 1 << BAD_SESSION_BIT;
        }
        lost |= self.spliced(byte);
        if self.recent.len() == STALE_BYTES {
            self.recent.pop_front();
        }
        self.recent.push_back(byte);
        (!lost).then_some((release, byte))
    }

    fn spliced(&mut self, byte: u8) -> bool {
        let Some(splice) = self.splice else { return false };
        self.splice = match splice {
            Splice::FirstLine if byte == b'\n' => Some(Splice::SecondLine(self.rng.random_range(1..=SPLICED_BYTES))),
            Splice::FirstLine => Some(splice),
            Splice::SecondLine(1) => None,
            Splice::SecondLine(count) => Some(Splice::SecondLine(count - 1)),
        };
        true
    }
}

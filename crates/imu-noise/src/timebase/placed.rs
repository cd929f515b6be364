//! What comes out of a time base.

use super::{NominalRate, Refusal, TimebaseSummary};

/// Rate, lines, losses and refusal, in order, as their places become sure. When it is asked for
/// them changes nothing but how the lines between two others are divided among
/// [`Lines`](Self::Lines).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// The rate the lines stand for: once, before the first of them. Not told when the stamps are
    /// refused before it is known, nor for a single line of unknown rate.
    Rate(NominalRate),
    /// The next so many lines follow each other.
    Lines(u64),
    /// Lines are missing here.
    Gap {
        /// How many, at least 1.
        missing: u64,
    },
    /// From here on, give or take a few lines, lines come at another of the sensor's rates, and
    /// time is not connected with that before.
    RateChanged {
        /// Rate before, in Hz.
        from_hz: f64,
        /// Rate from here on, in Hz.
        to_hz: f64,
        /// What the stamps said of the lines before, but for its `lines` and `backwards`: these
        /// tell of all that were pushed.
        until: TimebaseSummary,
    },
    /// From here on stamps are not used: the lines that follow are placed without gaps. Told once,
    /// and nothing but lines comes after it.
    Refused(Refusal),
}

//! Decisions on samples that arrived late or early.

use super::gap_event::GapEvent;

/// Reads, or samples, that confirm what the ones before showed, besides the window of the reads: of
/// the samples of a read only the last is about as early as it can be. Chosen.
pub(super) const CONFIRMATIONS: usize = 12;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Judgement {
    /// They, or the gap before them, are certain.
    Event(GapEvent),
    /// The rate has not increased: the pending events hold.
    IncreaseCleared,
    /// The samples judged have this lower rate, in Hz.
    Decreased(f64),
    /// The pending samples have this higher rate, in Hz.
    Increased(f64),
    /// The pending samples come at this rate in Hz, which the sensor cannot have.
    TooFast(f64),
}

//! Decisions on samples that arrived late or early.

use super::gap_event::GapEvent;

/// The number of reads, or samples, that must confirm what the earlier ones showed, besides the
/// window of the reads: of the samples of one read only the last is about as early as it can be.
/// Chosen.
pub(super) const CONFIRMATIONS: usize = 12;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Judgement {
    /// The samples, or the gap before them, are decided.
    Event(GapEvent),
    /// The rate has not increased: the pending events are valid.
    IncreaseCleared,
    /// The judged samples have this lower rate, in Hz.
    Decreased(f64),
    /// The pending samples have this higher rate, in Hz.
    Increased(f64),
    /// The pending samples arrive at this rate in Hz, which the sensor cannot have.
    TooFast(f64),
}

//! Time base of a stream: its sample rate, and the samples that were dropped on the way.
//!
//! The device time of each sample shows the rate and the dropped samples exactly
//! (`device_clock.rs`), and a counter in each sample the dropped ones (`sample_counter.rs`). Most
//! streams have neither: there only the arrival stamps of the host remain (`arrival_times.rs`).
//! `gap_detector.rs` chooses between them.
//!
//! # Arrival times
//!
//! Samples arrive late, never early: an arrival is the time of sending plus a delay that is not
//! negative. So the lower edge of the arrivals over the sample number shows the clock of the
//! sensor. A dropped sample raises that edge by one period for good; bunching (several samples in
//! one read of the host) and stalls raise single samples, after which the arrivals return to the
//! edge.
//!
//! ```text
//! lag in periods
//!   3 |                   o                             o
//!   2 |                    o                           o o oo o   <- the least lag stays: Missing(2)
//!   1 |      o     o        o        o         o
//!   0 | oo oo oo oo oo oo o  oo oo ooo ooo oo oo                  <- lower edge
//!     +----------------------------------------------------- sample
//!            jitter         stall                      2 dropped
//! ```
//!
//! 1. *Rate* (`rate_search.rs`): the first samples are held until two estimates agree on a rate of
//!    the sensor, at most 1024 of them. One estimate uses single intervals, which drops do not
//!    bias; the other the ends of stretches of 32 samples, which bunching does not bias
//!    (`rate_estimates.rs`). A rate known beforehand is confirmed sooner, by a second of single
//!    intervals. Of a sensor without a list of rates, samples that are missing evenly or at random
//!    are shown by the step of which all intervals are multiples (`base_step.rs`).
//! 2. *Lag* (`lag_tracker.rs`): a sample is due a period after the one before. The due time follows
//!    an earlier arrival at once, and the least lag of each block of 16 samples: so it follows the
//!    sensor's clock. It follows arrivals 0.3 periods early only if there are four
//!    of them in 12: a USB adapter that keeps the end of each sample until the next one comes sends
//!    a sample in 31 or 62 at once, where it ends with a full packet. From 0.82 periods on a sample
//!    is in doubt, and held.
//! 3. *Gap*: if the least lag of the samples held is steady over 12 reads and the window in which
//!    reads meet every phase (0.1 s and more, `read_pattern.rs`), floor(lag / period + 0.18)
//!    samples are missing. If a gap was counted one too large samples then come a period early;
//!    that is taken off the next gap. At the end of the stream samples in doubt are a gap if no
//!    sample was late before.
//! 4. *Change of rate*: samples in doubt that come evenly at a lower rate of the sensor, 32 of
//!    them; or early samples, held until two stretches in a row show the same higher rate, or 12
//!    samples and the window pass without another early one (`rate_increase.rs`). Time starts anew
//!    there.
//! 5. *Fitted rate* (`envelope.rs`): the median slope between the earliest arrivals of at most 64
//!    blocks of the record. It shows the offset of the sensor's clock.
//!
//! Stamps that go back by more than 10 ms are out of order if at most two samples in succession
//! have them; with a third the clock was set back, and time continues by the new clock.

mod arrival_times;
mod base_step;
mod device_clock;
mod envelope;
mod gap_detector;
mod gap_event;
mod interval_statistics;
mod judgement;
mod lag_tracker;
mod rate_estimates;
mod rate_increase;
mod rate_search;
mod read_pattern;
mod sample_counter;
mod stall;
#[cfg(test)]
mod tests;

pub use device_clock::ClockAfterOutage;
pub use gap_detector::GapDetector;
pub use gap_event::{GapEvent, NominalRate, Refusal, TimebaseSummary};
pub use interval_statistics::Arrivals;
pub use stall::{LATEST_ARRIVAL, StallDetector};

//! Time base of a stream: its sample rate, and its dropped samples.
//!
//! Three sources, the most reliable first: a counter in each sample shows the dropped ones exactly
//! (`sample_counter.rs`), the device time of each sample shows the rate as well
//! (`device_clock.rs`). Most streams have neither: then only the arrival times, or the stamps of a
//! table, remain (`arrival_times.rs`). `gap_detector.rs` chooses between them.
//!
//! # Arrival times
//!
//! Samples arrive late, never early: an arrival is the time of sending plus a delay that is not
//! negative. So the lower edge of the arrivals over the sample number shows the clock of the
//! sensor. A dropped sample raises that edge by one period permanently; bunching (several samples
//! in one read of the host) and stalls raise single samples, after which the arrivals return to the
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
//! `edge_tracker.rs` follows that edge for a given period. A sample that lags by 0.82 periods is in
//! doubt, and pending; if the least lag persists over 12 reads and 0.1 s, that many samples are
//! missing. This time grows if doubts last longer and are cleared. If a gap was counted too large,
//! later samples come early, and the next gap is smaller. So the total is right even if samples are
//! several periods late.
//!
//! Sources of the period:
//!
//! 1. *A known rate*, given by the user or reported by the sensor, starts the tracker with the first
//!    sample. Slower arrivals are counted as loss, unless they are too even for one
//!    (`sensor_rates.rs`); faster ones contradict the rate. A reported rate gives way to another one
//!    of the sensor's, a given one leads to a refusal. Later, even arrivals at another rate of the
//!    sensor are a change of its rate.
//! 2. *A sensor with listed rates* is searched for at most four seconds (`rate_search.rs`): the rate
//!    with the shortest description of the arrivals counts. If none is clearly the best, the stamps
//!    are refused, because the number of missing samples is unknown.
//! 3. *Any sensor*, as in tables and bags, has no nominal rate. The local step comes from the 1024
//!    surrounding samples (`local_steps.rs`), and a gap is a departure from it; another step that
//!    stays is a change of the rate. Samples that had waited when the recording began come faster, and
//!    do not count for the rate: all samples divided by all time without long gaps, known at the end.
//!    Above 50 kHz stamps must have another unit, and are refused.
//!
//! `envelope.rs` fits the rate of the whole record, which shows the offset of the sensor's clock.
//! Stamps that decrease by more than 10 ms are out of order if at most two successive samples have
//! them; a third one shows that the clock was set back, and time continues by the new clock.

mod arrival_times;
mod device_clock;
mod edge_tracker;
mod envelope;
mod gap_detector;
mod gap_event;
mod interval_statistics;
mod local_steps;
mod rate_search;
mod sample_counter;
mod sensor_rates;
mod stall;
mod whole_steps;

pub use device_clock::ClockAfterOutage;
pub use gap_detector::GapDetector;
pub use gap_event::{GapEvent, NominalRate, Refusal, TimebaseSummary};
pub use interval_statistics::Arrivals;
pub use local_steps::Unevenness;
pub use stall::{LATEST_ARRIVAL, StallDetector};

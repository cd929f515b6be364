//! A gap: the number of missing samples, their place, and the source of this knowledge.

use std::collections::VecDeque;

use thiserror::Error;

use super::interval_statistics::Arrivals;
use super::local_steps::Unevenness;

/// The fastest rate of any sensor, in Hz. Stamps with a higher rate have another unit.
pub(super) const FASTEST_HZ: f64 = 50_000.0;

/// The next decided event of a stream. The times of polling only affect the division of the samples
/// between two other events among [`Samples`](Self::Samples).
#[derive(Clone, Debug, PartialEq)]
pub enum GapEvent {
    /// This number of samples, at least 1, follow each other without a gap.
    Samples(u64),
    /// This number of samples, at least 1, were dropped here.
    Missing(u64),
    /// An unknown number of samples may have been dropped here: the counter restarted, or the times
    /// of the sensor do not fit a whole number of samples.
    UnknownGap,
    /// The clock of the sensor restarted here: an unknown number of samples may be missing.
    Restart,
    /// The clock of the sensor stepped ahead here: an unknown number of samples may be missing.
    TimeStep,
    /// The next sample has a time that neither neighbour confirms: damage that the checksum does not
    /// detect. The sample does not count, and one is missing in its place.
    FalseTime,
    /// From here on a counter decides which samples are missing, while samples carry it.
    CounterInUse,
    /// From here on device times decide which samples are missing, and show this rate.
    DeviceTimeInUse {
        /// The rate in Hz.
        rate_hz: f64,
    },
    /// The nominal rate, before the first sample; from here on arrival times decide which samples are
    /// missing. It comes once more if a reported rate is false, and when a
    /// [measured](NominalRate::Measured) one becomes more exact.
    Rate(NominalRate),
    /// From about here on samples arrive at another rate of the sensor; time is not continuous.
    RateChanged {
        /// Rate before, in Hz.
        from_hz: f64,
        /// Rate from here on, in Hz.
        to_hz: f64,
        /// Summary of the samples before; its `samples` and `backwards` count all added samples.
        until: Box<TimebaseSummary>,
    },
    /// From here on arrival times are ignored. Reported once; no event of arrival times follows.
    Refused(Refusal),
}

/// The decided events of a stream that are not reported yet, and the gaps so far.
#[derive(Clone, Debug, Default)]
pub(super) struct GapEvents {
    waiting: VecDeque<GapEvent>,
    /// Number of missing samples, and of gaps.
    pub(super) missing: u64,
    pub(super) gaps: u64,
}

impl GapEvents {
    /// Adds an event; one of no samples is none.
    pub(super) fn push(&mut self, event: GapEvent) {
        match (&event, self.waiting.back_mut()) {
            (GapEvent::Samples(0) | GapEvent::Missing(0), _) => return,
            (GapEvent::Samples(more), Some(GapEvent::Samples(samples))) => {
                *samples += more;
                return;
            }
            (GapEvent::Missing(missing), _) => {
                self.missing += missing;
                self.gaps += 1;
            }
            _ => {}
        }
        self.waiting.push_back(event);
    }

    /// Takes the first event.
    pub(super) fn next(&mut self) -> Option<GapEvent> {
        self.waiting.pop_front()
    }
}

/// Nominal rate of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NominalRate {
    /// Known in advance, in Hz.
    Known(f64),
    /// The rate of the sensor that the arrivals show, in Hz.
    Snapped(f64),
    /// Measured, in Hz: the sensor has no rate close to it, or none is listed; in the latter case it
    /// is the rate of all samples so far.
    Measured(f64),
}

impl NominalRate {
    /// The rate in Hz.
    pub const fn hz(self) -> f64 {
        match self {
            Self::Known(hz) | Self::Snapped(hz) | Self::Measured(hz) => hz,
        }
    }
}

/// The reason why arrival times are no time base. From there on they detect no dropped sample.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// Stamps decrease by more than 10 ms too often: 9 times, and more than once in 256 samples.
    #[error("time stamps not used: they step backwards {times} times in {samples} lines")]
    Backwards {
        /// Number of stamps that decrease.
        times: u64,
        /// Number of samples.
        samples: u64,
    },
    /// Samples arrive at more than 1.25 times the sensor's fastest rate.
    #[error("time stamps not used: {}", too_fast(*.measured_hz, *.fastest_hz))]
    TooFast {
        /// Measured rate in Hz.
        measured_hz: f64,
        /// The sensor's fastest rate in Hz.
        fastest_hz: f64,
    },
    /// Samples arrive unevenly: how many are missing cannot be known.
    #[error("time stamps not used: {measured_hz:.2} lines a second arrive, and too unevenly for a rate")]
    Uneven {
        /// Samples that arrive per second, in Hz.
        measured_hz: f64,
    },
    /// Samples of any sensor come in even pairs: two sources, or a buffer of two.
    #[error(
        "time stamps not used: rows come in pairs, {measured_hz:.2} a second, as of two sources on one topic, or of a buffer of two"
    )]
    Pairs {
        /// Samples that arrive per second, in Hz.
        measured_hz: f64,
    },
    /// The measured rate contradicts the known one.
    #[error("time stamps not used: they give {measured_hz:.4} Hz, the known rate is {known_hz} Hz")]
    OtherRate {
        /// Rate known in advance, in Hz.
        known_hz: f64,
        /// Measured rate, in Hz.
        measured_hz: f64,
    },
    /// All stamps are equal.
    #[error("time stamps not used: all {samples} lines have the same stamp")]
    NoTimePasses {
        /// Number of samples.
        samples: u64,
    },
}

fn too_fast(measured_hz: f64, fastest_hz: f64) -> String {
    if fastest_hz != FASTEST_HZ {
        return format!("lines arrive at {measured_hz:.0} Hz, but the sensor sends at most {fastest_hz} Hz");
    }
    format!(
        "by them rows come at {measured_hz:.0} Hz, and no sensor sends more than {FASTEST_HZ} Hz; their unit may be \
         another one, such as the days of a spreadsheet (multiply these by 86400 for seconds)"
    )
}

/// Summary of the arrival times of a stream; of its rate since the last change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimebaseSummary {
    /// Number of samples added.
    pub samples: u64,
    /// Number of stamps more than 10 ms earlier than the previous stamp; a clock that was set back
    /// counts once. With device times: number of restarts of the sensor.
    pub backwards: u64,
    /// Nominal rate, the last one if it changed; `None` until it is known, and after a refusal.
    pub nominal: Option<NominalRate>,
    /// Fitted rate in Hz; `None` below about 130 samples since the rate changed. Without a nominal
    /// rate it is that of all samples.
    pub measured_hz: Option<f64>,
    /// (Fitted / nominal rate - 1) in ppm: positive if the clock of the sensor is faster than that
    /// of the host. `None` if either rate is missing.
    pub offset_ppm: Option<f64>,
    /// The reason why the stamps are no time base; `None` if they are one.
    pub refusal: Option<Refusal>,
    /// Missing samples, by arrival times, or by device time if samples carry it.
    pub missing: u64,
    /// Number of gaps, in the same way.
    pub gaps: u64,
    /// The unevenness of the stamps, for a stream without a nominal rate; `None` for even ones.
    pub unevenness: Option<Unevenness>,
    /// Number of samples at the beginning that had waited, and arrived together.
    pub flushed: u64,
    /// Times between samples; `None` below two samples, and without a nominal rate.
    pub arrivals: Option<Arrivals>,
}

impl TimebaseSummary {
    /// Number of samples that are pending until their rate is certain; `None` if there are none.
    pub fn samples_pending(&self) -> Option<u64> {
        (self.nominal.is_none() && self.refusal.is_none() && self.samples > 0).then_some(self.samples)
    }
}

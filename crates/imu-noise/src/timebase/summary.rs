//! What a time base reports: rate, refusal, arrivals, losses.

use std::fmt;

/// Rate the lines stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NominalRate {
    /// Given beforehand, in Hz, and not contradicted by the stamps.
    Known(f64),
    /// One of the sensor's rates, in Hz: the nearest to the measured one, and within 1 % of it;
    /// within 5 % where bunched lines are lost from the start.
    Snapped(f64),
    /// As measured from the first lines, in Hz, to the decimal they support: the sensor has no rate
    /// near it, or its rates are not known.
    Measured(f64),
}

impl NominalRate {
    /// The rate in Hz.
    #[must_use]
    pub const fn hz(self) -> f64 {
        match self {
            Self::Known(hz) | Self::Snapped(hz) | Self::Measured(hz) => hz,
        }
    }
}

/// Why stamps are no time base. Missing lines cannot be seen from there on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// Stamps lie more than 10 ms before the one before them too often: 9 times, and more than once
    /// in 256 lines.
    Backwards {
        /// How often.
        times: u64,
        /// In how many lines.
        lines: u64,
    },
    /// Lines come more than 1.25 times as fast as the sensor can send them.
    TooFast {
        /// Measured rate in Hz.
        measured_hz: f64,
        /// The sensor's fastest rate in Hz.
        fastest_hz: f64,
    },
    /// Lines came at another rate than the one known beforehand from the start.
    OtherRate {
        /// Rate known beforehand, in Hz.
        known_hz: f64,
        /// Rate by the stamps, in Hz.
        measured_hz: f64,
    },
    /// All lines have the same stamp.
    NoTimePasses {
        /// How many lines.
        lines: u64,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Backwards { times, lines } => write!(
                f,
                "stamps are no time base: in {lines} lines they go back {times} times; stamp with a clock that is not set, and keep the lines in order"
            ),
            Self::TooFast { measured_hz, fastest_hz } => write!(
                f,
                "stamps are no time base: lines come at {measured_hz:.0} Hz, the sensor sends at most {fastest_hz} Hz"
            ),
            Self::OtherRate { known_hz, measured_hz } => write!(
                f,
                "lines come at {measured_hz:.4} Hz by their stamps, not at the {known_hz} Hz known beforehand: tau is by {known_hz} Hz, stamps are not used, and lines lost whole cannot be seen"
            ),
            Self::NoTimePasses { lines } => {
                write!(f, "stamps are no time base: all {lines} lines have the same")
            }
        }
    }
}

/// How lines arrive, over the whole stream: a change of the rate does not begin it anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrivals {
    /// Median time between lines in microseconds, to three digits as the next one: the middle of
    /// its class.
    pub p50_us: u64,
    /// 99th percentile of the time between lines in microseconds.
    pub p99_us: u64,
    /// Longest time between lines in microseconds, exactly.
    pub max_us: u64,
    /// Part of the lines, 0 to 1, that came within 0.2 periods of the one before, by the nominal
    /// rate now.
    pub share_together: f64,
    /// Mean number of lines that came together; 1 when each came alone.
    pub lines_together: f64,
}

/// What the stamps say about the stream. After a change of the rate `nominal`, `measured_hz` and
/// `offset_ppm` are those of the part since the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimebaseSummary {
    /// Lines pushed.
    pub lines: u64,
    /// How often a stamp lay more than 10 ms before the one before: a clock set back counts once,
    /// and so does a stamp out of order.
    pub backwards: u64,
    /// Rate the lines stand for, the last one if it changed; absent until it is sure and after a
    /// refusal.
    pub nominal: Option<NominalRate>,
    /// Rate of the line fitted under the arrivals in Hz; absent for fewer than about 130 lines
    /// since the rate changed.
    pub measured_hz: Option<f64>,
    /// Fitted against nominal rate in parts per million, positive when the sensor is fast.
    pub offset_ppm: Option<f64>,
    /// Why the stamps are no time base.
    pub refusal: Option<Refusal>,
    /// Lines missing.
    pub missing: u64,
    /// Places where lines are missing.
    pub gaps: u64,
    /// How lines arrive; absent for fewer than two lines, and without a nominal rate.
    pub arrivals: Option<Arrivals>,
}

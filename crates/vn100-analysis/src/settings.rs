//! The settings of an analysis.

use std::time::Duration;

use imu_noise::{Deviation, Estimator};

use crate::{averaging_times::AveragingTimes, coast::Coast, goal::Goal};

/// The default output rate of the sensor in hertz, which is assumed where the rate is not known.
pub const DEFAULT_RATE_HZ: f64 = 40.0;

/// The two-sided level of intervals where no other is asked for.
pub const DEFAULT_CONFIDENCE: f64 = 0.95;

/// How a stream is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Nominal sample rate in hertz; `None` where the user does not give it.
    pub rate_hz: Option<f64>,
    /// Which windows are averaged in the deviation.
    pub estimator: Estimator,
    /// The deviation: Allan or Hadamard.
    pub deviation: Deviation,
    /// The averaging times at which the final result gives the deviation; others than the octaves
    /// only with [`Estimator::Full`].
    pub averaging_times: AveragingTimes,
    /// Data time excluded at the beginning; zero for none.
    pub skip: Duration,
    /// Data time from the first sample at which the measurement ends; `None` for no end.
    pub duration: Option<Duration>,
    /// Whether quantisation noise is fitted in addition to the other terms.
    pub quantization: bool,
    /// The averaging window of gyroscope and accelerometer in refreshes, for a stream that does not
    /// carry register 85; `None` where the user does not give it.
    pub window: Option<u32>,
    /// Whether the rates are compensated, as the user states, which outranks the message; `None`
    /// where the user does not state it.
    pub compensated: Option<bool>,
    /// The measurement ends once all of these goals are met, if there are any.
    pub until: Vec<Goal>,
    /// Two-sided level of every interval, 0 < p < 1.
    pub confidence: f64,
    /// The rests and coasts of the drift; none for [`Coast::DEFAULTS`].
    pub coasts: Vec<Coast>,
    /// Whether the latest samples of every channel are kept, for a screen; no result depends on it.
    pub recent: bool,
    /// The shortest interval between two snapshots for faces, to a millisecond.
    pub watch_every: Duration,
}

impl Settings {
    /// Whether the measurement may end between two reads. Its lines are then taken one by one, so
    /// that the result does not depend on the division of the bytes into reads.
    pub fn ends_between_reads(&self) -> bool {
        self.duration.is_some() || !self.until.is_empty()
    }
}

impl Default for Settings {
    /// Everything included, no rate given, intervals at 95 %, ten snapshots a second.
    fn default() -> Self {
        Self {
            rate_hz: None,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
            averaging_times: AveragingTimes::Octave,
            skip: Duration::ZERO,
            duration: None,
            quantization: false,
            window: None,
            compensated: None,
            until: Vec::new(),
            confidence: DEFAULT_CONFIDENCE,
            coasts: Vec::new(),
            recent: false,
            watch_every: Duration::from_millis(100),
        }
    }
}

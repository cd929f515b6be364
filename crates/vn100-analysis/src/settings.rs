//! What the user sets of an analysis.

use std::time::Duration;

use imu_noise::{BadEncoding, ByteReader, Deviation, Encoded, Estimator, check_encoded};

use crate::{assessment::DEFAULT_CONFIDENCE, averaging_times::AveragingTimes, detrend::Detrend, goal::Goal};

/// The sensor's default output rate, assumed where the rate is unknown.
pub const DEFAULT_RATE_HZ: f64 = 40.0;

/// How a stream is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Nominal sample rate in hertz, if the user knows it.
    pub rate_hz: Option<f64>,
    /// Which windows enter the deviation.
    pub estimator: Estimator,
    /// Which deviation.
    pub deviation: Deviation,
    /// At which averaging times the final result gives the deviation; others than the octaves with
    /// [`Estimator::Full`] alone.
    pub averaging_times: AveragingTimes,
    /// Data time excluded at the beginning.
    pub skip: Duration,
    /// Data time from the first sample, behind which the measurement ends; `None` for all there is.
    pub duration: Option<Duration>,
    /// What is removed from each channel before its deviation is taken.
    pub detrend: Option<Detrend>,
    /// Fit quantisation noise in addition to the other terms.
    pub quantization: bool,
    /// The averaging window of gyroscope and accelerometer that register 85 had, in refreshes,
    /// where the stream does not carry the register.
    pub window: Option<u32>,
    /// Whether the rates are compensated, as the user says; outranks what the message says.
    pub compensated: Option<bool>,
    /// The measurement ends once all of these are known; with none it does not end for that.
    pub until: Vec<Goal>,
    /// Two-sided level of every interval, 0 < p < 1.
    pub confidence: f64,
    /// Keep the last minutes of every channel, for a screen; no result depends on it.
    pub recent: bool,
    /// Keep the deviation that is not asked for, too, Hadamard's or Allan's, for a screen; no
    /// result depends on it.
    pub other_deviation: bool,
    /// How often watchers get a new snapshot at most, down to a millisecond.
    pub watch_every: Duration,
}

impl Default for Settings {
    /// Everything included, rate unknown, intervals at 95 %, ten snapshots a second.
    fn default() -> Self {
        Self {
            rate_hz: None,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
            averaging_times: AveragingTimes::Octave,
            skip: Duration::ZERO,
            duration: None,
            detrend: None,
            quantization: false,
            window: None,
            compensated: None,
            until: Vec::new(),
            confidence: DEFAULT_CONFIDENCE,
            recent: false,
            other_deviation: false,
            watch_every: Duration::from_millis(100),
        }
    }
}

impl Settings {
    /// What a result depends on: goals, screens and watchers have ended.
    pub(crate) fn encode(&self, out: &mut Vec<u8>) {
        let Self {
            rate_hz, estimator, deviation, averaging_times, skip, duration, detrend, quantization, window, ..
        } = self;
        rate_hz.encode(out);
        estimator.encode(out);
        deviation.encode(out);
        averaging_times.encode(out);
        skip.encode(out);
        duration.encode(out);
        detrend.encode(out);
        quantization.encode(out);
        window.encode(out);
        self.compensated.encode(out);
        self.confidence.encode(out);
    }

    pub(crate) fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let settings = Self {
            rate_hz: Encoded::decode(input)?,
            estimator: Encoded::decode(input)?,
            deviation: Encoded::decode(input)?,
            averaging_times: Encoded::decode(input)?,
            skip: Encoded::decode(input)?,
            duration: Encoded::decode(input)?,
            detrend: Encoded::decode(input)?,
            quantization: Encoded::decode(input)?,
            window: Encoded::decode(input)?,
            compensated: Encoded::decode(input)?,
            confidence: Encoded::decode(input)?,
            ..Self::default()
        };
        check_encoded(
            settings.rate_hz.is_none_or(|hz| hz > 0.0) && settings.confidence > 0.0 && settings.confidence < 1.0,
        )?;
        Ok(settings)
    }
}

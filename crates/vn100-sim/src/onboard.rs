//! The on-board processing of white noise before a sample is sent: low pass, averaging window and
//! decimation.

use std::num::NonZeroU32;

use rand_chacha::ChaCha8Rng;

use crate::normal::normal;

/// Rates at which the sensor refreshes gyro and accelerometer, and the magnetometer, Hz.
pub(crate) const IMU_REFRESH_HZ: u32 = 800;
pub(crate) const MAG_REFRESH_HZ: u32 = 250;

/// The path of white noise to the output.
///
/// After a window of w refreshes, samples that are less than w refreshes apart are correlated by
/// (w-lag)/w. If fewer samples are sent than are averaged (w < refresh/rate), noise is aliased, and
/// the density of the output is higher than that of the sensor: by √(200/rate) for 4 samples at 800
/// Hz.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum AveragingWindow {
    /// The noise is drawn at the output rate: the density is that of the output.
    #[default]
    None,
    /// The density is that of the sensor, which refreshes at `refresh_hz`, after a low-pass filter;
    /// each output sample is the mean of the latest `samples` values, and an output faster than the
    /// refresh repeats them.
    Boxcar {
        /// Rate of the values that are averaged, Hz.
        refresh_hz: u32,
        /// Number of averaged values; 0 and 1 mean no averaging.
        samples: u32,
        /// The low-pass filter before the window.
        low_pass: LowPass,
    },
}

/// The low-pass filter of the sensor, of second order and with unit gain at zero frequency: y(k) =
/// (1 - a1 - a2) x(k) + a1 y(k-1) + a2 y(k-2).
///
/// The maker does not document it. After a window of 4, one second of a real sensor has the
/// autocorrelations 0.83, 0.49, 0.17, -0.02, -0.05 (gyro) and 0.86, 0.60, 0.35, 0.14, 0.08
/// (accelerometer) at lags of 1 to 5 samples of 800 Hz, each within about 0.07. The filters of
/// [`Profile::datasheet`](crate::Profile::datasheet) agree within that, and alias noise by 2.31 and
/// 2.08 at 40 Hz, like real sensors within a tenth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    pub(crate) a1: f64,
    pub(crate) a2: f64,
}

impl LowPass {
    pub(crate) const NONE: Self = Self { a1: 0.0, a2: 0.0 };

    /// Number of values after which the influence of earlier ones is below 10^-6.
    const MEMORY: usize = 20;

    fn memory(self) -> usize {
        if self == Self::NONE { 0 } else { Self::MEMORY }
    }
}

/// White noise after the window, one value per output sample.
#[derive(Debug, Clone)]
pub(crate) struct White {
    sigma: f64,
    low_pass: LowPass,
    /// Its last two output values.
    passed: [f64; 2],
    /// The latest values of the sensor, as many as the window averages: a ring, never empty.
    recent: Vec<f64>,
    oldest: usize,
    refresh_hz: u64,
    rate_hz: u64,
    sent: u64,
    rng: ChaCha8Rng,
}

impl White {
    pub(crate) fn new(density: f64, window: AveragingWindow, rate_hz: NonZeroU32, rng: ChaCha8Rng) -> Self {
        let (refresh_hz, samples, low_pass) = match window {
            AveragingWindow::None => (rate_hz.get(), 1, LowPass::NONE),
            AveragingWindow::Boxcar { refresh_hz, samples, low_pass } => (refresh_hz, samples, low_pass),
        };
        Self::of_values(density * f64::from(refresh_hz).sqrt(), low_pass, refresh_hz, samples, rate_hz.get(), rng)
    }

    /// White noise from values with the standard deviation `sigma` before the low pass. The window
    /// is filled from the start; windows of 0 and 1 do not average.
    pub(crate) fn of_values(
        sigma: f64,
        low_pass: LowPass,
        refresh_hz: u32,
        samples: u32,
        rate_hz: u32,
        rng: ChaCha8Rng,
    ) -> Self {
        let samples = samples.max(1) as usize;
        let mut white = Self {
            sigma,
            low_pass,
            passed: [0.0; 2],
            recent: vec![0.0; samples],
            oldest: 0,
            refresh_hz: refresh_hz.into(),
            rate_hz: rate_hz.into(),
            sent: 0,
            rng,
        };
        white.draw(low_pass.memory() + samples);
        white
    }

    /// Another window from here on: the latest values stay; if more are needed, values before the
    /// beginning are drawn.
    pub(crate) fn set_window(&mut self, samples: u32) {
        let samples = samples.max(1) as usize;
        if samples == self.recent.len() {
            return;
        }
        self.recent.rotate_left(self.oldest);
        self.oldest = 0;
        let surplus = self.recent.len().saturating_sub(samples);
        self.recent.drain(..surplus);
        let older: Vec<f64> = (self.recent.len()..samples).map(|_| self.sigma * normal(&mut self.rng)).collect();
        self.recent.splice(..0, older);
    }

    fn draw(&mut self, values: usize) {
        let LowPass { a1, a2 } = self.low_pass;
        for _ in 0..values {
            let [last, before] = self.passed;
            let value = (1.0 - a1 - a2) * self.sigma * normal(&mut self.rng) + a1 * last + a2 * before;
            self.passed = [value, last];
            self.recent[self.oldest] = value;
            self.oldest = (self.oldest + 1) % self.recent.len();
        }
    }

    /// Draws the values up to the next output sample.
    pub(crate) fn advance(&mut self) {
        let refreshes_until = |sent: u64| sent * self.refresh_hz / self.rate_hz;
        let fresh = refreshes_until(self.sent + 1) - refreshes_until(self.sent);
        self.sent += 1;
        // values that would leave the window and the low pass before the output sample need not be drawn
        self.draw(fresh.min((self.low_pass.memory() + self.recent.len()) as u64) as usize);
    }

    pub(crate) fn latest(&self) -> f64 {
        let len = self.recent.len();
        self.recent[(self.oldest + len - 1) % len]
    }

    pub(crate) fn mean(&self) -> f64 {
        self.recent.iter().sum::<f64>() / self.recent.len() as f64
    }
}

#[cfg(test)]
mod tests;

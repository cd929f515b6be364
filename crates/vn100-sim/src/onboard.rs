//! What the sensor does to its white noise before a sample is sent: averaging window and
//! decimation.

use std::num::NonZeroU32;

use rand_chacha::ChaCha8Rng;

use crate::noise::normal;

/// Rates at which the sensor refreshes gyro and accelerometer, and the magnetometer, Hz.
pub(crate) const IMU_REFRESH_HZ: u32 = 800;
pub(crate) const MAG_REFRESH_HZ: u32 = 250;

/// How white noise reaches the output.
///
/// A window of w refreshes leaves samples that lie less than w refreshes apart correlated, by
/// (w - lag)/w. Where fewer are sent than are averaged (w < refresh/rate), noise is aliased and the
/// output shows a density higher than the sensor's: by √(200/rate) for 4 of 800 Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AveragingWindow {
    /// The noise is drawn at the output rate: the density is that of the output.
    None,
    /// The density is that of the sensor, which refreshes at `refresh_hz`; each output sample is
    /// the mean of the latest `samples` values, and output faster than the refresh repeats them.
    Boxcar {
        /// Rate of the values that are averaged, Hz.
        refresh_hz: u32,
        /// Number of values averaged; 0 and 1 average nothing.
        samples: u32,
    },
}

impl AveragingWindow {
    /// Gyro and accelerometer as delivered: 4 samples at 800 Hz.
    pub const IMU_DEFAULT: Self = Self::Boxcar { refresh_hz: IMU_REFRESH_HZ, samples: 4 };

    /// Magnetometer as delivered: no averaging, refreshed at 250 Hz.
    pub const MAG_DEFAULT: Self = Self::Boxcar { refresh_hz: MAG_REFRESH_HZ, samples: 0 };
}

/// White noise behind the window, one value per output sample.
#[derive(Debug, Clone)]
pub(crate) struct White {
    sigma: f64,
    /// The latest values of the sensor, as many as the window averages: a ring, never empty.
    recent: Vec<f64>,
    oldest: usize,
    refresh_hz: u64,
    rate_hz: u64,
    /// Output samples sent.
    sent: u64,
    rng: ChaCha8Rng,
}

impl White {
    pub(crate) fn new(density: f64, window: AveragingWindow, rate_hz: NonZeroU32, rng: ChaCha8Rng) -> Self {
        let (refresh_hz, samples) = match window {
            AveragingWindow::None => (rate_hz.get(), 1),
            AveragingWindow::Boxcar { refresh_hz, samples } => (refresh_hz, samples),
        };
        Self::of_values(density * f64::from(refresh_hz).sqrt(), refresh_hz, samples, rate_hz.get(), rng)
    }

    /// Of values with the standard deviation `sigma`. The window is filled from the start; one of 0
    /// and of 1 averages nothing.
    pub(crate) fn of_values(sigma: f64, refresh_hz: u32, samples: u32, rate_hz: u32, mut rng: ChaCha8Rng) -> Self {
        let recent = (0..samples.max(1)).map(|_| sigma * normal(&mut rng)).collect();
        Self { sigma, recent, oldest: 0, refresh_hz: refresh_hz.into(), rate_hz: rate_hz.into(), sent: 0, rng }
    }

    /// Another window from here on: the latest values stay, values before the beginning are drawn
    /// where more are needed.
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

    /// Draws the values up to the next output sample.
    pub(crate) fn advance(&mut self) {
        let refreshes_until = |sent: u64| sent * self.refresh_hz / self.rate_hz;
        let fresh = refreshes_until(self.sent + 1) - refreshes_until(self.sent);
        self.sent += 1;
        // values that would leave the window before it is read need not be drawn
        for _ in 0..fresh.min(self.recent.len() as u64) {
            self.recent[self.oldest] = self.sigma * normal(&mut self.rng);
            self.oldest = (self.oldest + 1) % self.recent.len();
        }
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

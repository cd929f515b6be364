//! White noise averaged on board over a window that may be longer than the interval between
//! outputs.

use crate::infer::power_law::PowerLaw;

/// A sensor that averages `length` internal samples and sends every `decimation`-th average.
///
/// With `length` <= `decimation` the averages share nothing. Above, neighbours share samples, and
/// white noise is depressed at short averaging times. Its effect on flicker noise and random walk
/// is neglected: white noise is above them there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxcarWindow {
    /// Internal samples averaged; 0 counts as 1.
    pub length: u32,
    /// Internal samples from one output to the next: internal rate / output rate. Values below 1,
    /// and no numbers, count as 1; not whole where the rates are no multiples.
    pub decimation: f64,
}

impl BoxcarWindow {
    /// Autocovariance of averaged white noise at distances of 0, 1, 2, ... outputs, scaled so that
    /// over both signs they sum to 1: N is that at long averaging times.
    ///
    /// Two averages `l` internal samples apart share `length` - l of them.
    fn autocovariance(self) -> Vec<f64> {
        let shared: Vec<f64> = self.shared().collect();
        let sum = 2.0 * shared.iter().sum::<f64>() - shared[0];
        shared.iter().map(|shared| shared / sum).collect()
    }

    /// Factor from the sensor's own density of white noise to the one measured at long averaging
    /// times.
    ///
    /// √(d Σ r(jd)) over all whole j, with the window w, the decimation d and the autocorrelation
    /// r(l) = (w - |l|)/w² of a mean of w independent values, |l| < w: 1 where w = d, √(d/w) where
    /// w <= d.
    ///
    /// ```
    /// use imu_noise::BoxcarWindow;
    ///
    /// // 800 Hz inside, averages of 4, sent at 40 Hz
    /// let window = BoxcarWindow { length: 4, decimation: 20.0 };
    /// assert_eq!((window.white_factor() * 1e3).round(), 2236.0);
    /// ```
    #[must_use]
    pub fn white_factor(self) -> f64 {
        let length = f64::from(self.length.max(1));
        let sum = 2.0 * self.shared().sum::<f64>() - length;
        (self.outputs_apart() * sum).sqrt() / length
    }

    /// Whether successive outputs share internal samples.
    #[must_use]
    pub fn overlaps(self) -> bool {
        f64::from(self.length) > self.outputs_apart()
    }

    fn outputs_apart(self) -> f64 {
        self.decimation.max(1.0)
    }

    /// Internal samples that averages 0, 1, 2, ... outputs apart share.
    fn shared(self) -> impl Iterator<Item = f64> {
        let length = f64::from(self.length.max(1));
        let decimation = self.outputs_apart();
        (0_u32..).map(move |outputs| length - f64::from(outputs) * decimation).take_while(|shared| *shared > 0.0)
    }
}

/// White noise as a stream carries it: averaged by its window, or as it is.
pub(super) struct StreamedWhite {
    /// At distances of 0, 1, 2, ... outputs.
    autocovariance: Vec<f64>,
}

impl StreamedWhite {
    pub(super) fn new(window: Option<BoxcarWindow>) -> Self {
        Self { autocovariance: window.map_or_else(|| vec![1.0], BoxcarWindow::autocovariance) }
    }

    /// Distance in outputs from which on two of them share nothing.
    pub(super) fn length(&self) -> u64 {
        self.autocovariance.len() as u64
    }

    /// Generalised covariance of the phase: that of white noise, seen through the autocovariance.
    pub(super) fn phase_covariance(&self, lag: f64) -> f64 {
        let phase = |lag| PowerLaw::White.phase_covariance(lag);
        let neighbours = self.autocovariance.iter().enumerate().skip(1);
        let sides = neighbours.map(|(apart, weight)| weight * (phase(lag - apart as f64) + phase(lag + apart as f64)));
        self.autocovariance[0] * phase(lag) + sides.sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_those_of_the_theory() {
        for (length, decimation, expected) in [
            (4, 4.0, 1.0),
            (4, 8.0, 2_f64.sqrt()),
            (4, 16.0, 2.0),
            (4, 20.0, 5_f64.sqrt()),
            (20, 20.0, 1.0),
            // averages that overlap whole keep the density
            (20, 4.0, 1.0),
            (4, 1.0, 1.0),
            // no averaging
            (0, 6.25, 2.5),
            (1, f64::NAN, 1.0),
        ] {
            let factor = BoxcarWindow { length, decimation }.white_factor();
            assert!((factor - expected).abs() < 1e-12, "window {length}, decimation {decimation}: {factor}");
        }
    }

    #[test]
    fn only_a_window_longer_than_the_interval_overlaps() {
        assert!(BoxcarWindow { length: 20, decimation: 4.0 }.overlaps());
        assert!(!BoxcarWindow { length: 4, decimation: 4.0 }.overlaps());
    }
}

//! White noise averaged on board over a window that may be longer than the interval between outputs.

/// A sensor that averages `length` internal samples and sends every `decimation`-th average.
///
/// With `length` <= `decimation` the averages share nothing. Above, neighbours share samples, and white noise is
/// depressed at short averaging times. Its effect on flicker noise and random walk is neglected: white noise is above
/// them there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoxcarWindow {
    /// Internal samples averaged; 0 counts as 1.
    pub length: u32,
    /// Internal samples between outputs; 0 counts as 1.
    pub decimation: u32,
}

impl BoxcarWindow {
    /// Autocovariance of averaged white noise at distances of 0, 1, 2, ... outputs, scaled so that over both signs
    /// they sum to 1: N is what is read at long averaging times.
    ///
    /// Two averages `l` internal samples apart share `length` - l of them.
    pub(super) fn autocovariance(self) -> Vec<f64> {
        let (length, decimation) = (self.length.max(1), self.decimation.max(1));
        let shared: Vec<f64> =
            (0..length).step_by(decimation as usize).map(|apart| f64::from(length - apart)).collect();
        let sum = 2.0 * shared.iter().sum::<f64>() - shared[0];
        shared.iter().map(|shared| shared / sum).collect()
    }
}

/// The covariance `phase` of white noise with the autocovariance `boxcar` instead.
pub(super) fn convolved(boxcar: &[f64], lag: f64, phase: impl Fn(f64) -> f64) -> f64 {
    let neighbours = boxcar.iter().enumerate().skip(1);
    let sides = neighbours.map(|(apart, weight)| weight * (phase(lag - apart as f64) + phase(lag + apart as f64)));
    boxcar[0] * phase(lag) + sides.sum::<f64>()
}

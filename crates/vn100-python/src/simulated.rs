//! Samples with known noise, by the generator of the emulated sensor.

use std::num::NonZeroU32;

use numpy::PyArray1;
use pyo3::{exceptions::PyValueError, prelude::*};
use vn100_sim::{
    AveragingWindow,
    noise::{ChannelStream, NoiseTruth},
};

/// Samples that are made between looks at signals.
const BLOCK: usize = 1 << 20;

/// An array for each channel of (mean, N, B, K, R), in the unit of the channel.
#[pyfunction]
pub(crate) fn simulated<'py>(
    py: Python<'py>,
    channels: Vec<(f64, f64, f64, f64, f64)>,
    rate: u32,
    samples: usize,
    seed: u64,
) -> PyResult<Vec<Bound<'py, PyArray1<f64>>>> {
    let rate_hz = NonZeroU32::new(rate).filter(|rate| rate.get() <= 100_000);
    let rate_hz =
        rate_hz.ok_or_else(|| PyValueError::new_err(format!("rate: {rate} Hz is not between 1 and 100000 Hz")))?;
    let mut arrays = Vec::with_capacity(channels.len());
    for ((mean, white_density, bias_instability, random_walk, ramp), channel) in channels.into_iter().zip(0..) {
        let truth = NoiseTruth { mean, white_density, bias_instability, random_walk, ramp, ..NoiseTruth::default() };
        let mut stream = ChannelStream::new(&truth, AveragingWindow::None, rate_hz, seed, channel);
        let mut values = Vec::new();
        values.try_reserve_exact(samples).map_err(|_| {
            PyValueError::new_err(format!("seconds: {samples} samples of a channel do not fit into memory"))
        })?;
        while values.len() < samples {
            let block = BLOCK.min(samples - values.len());
            py.detach(|| values.extend((0..block).map(|_| stream.next_sample())));
            py.check_signals()?;
        }
        arrays.push(PyArray1::from_vec(py, values));
    }
    Ok(arrays)
}

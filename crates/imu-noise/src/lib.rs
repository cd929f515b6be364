//! The noise of inertial sensor channels, streaming and exact, from samples to conclusions: Allan
//! and Hadamard deviation at octave averaging times with confidence intervals, a noise model with
//! N, B and K and their intervals, and verdicts against a data sheet; also moments, histogram,
//! spectrum and unwrapped angles.
//!
//! ```
//! use imu_noise::{ChannelCurve,
//!     Deviation, Estimator, NoiseModel, Octaves, RecordShape, Term,
//!     counts_to_unit,
//! };
//!
//! // a gyroscope at 40 Hz, in rad/s with six decimals; its white noise: uniform, 0 to 999 counts
//! let next = |state: &u32| Some(state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
//! let states = std::iter::successors(Some(1), next);
//! let samples: Vec<i32> = states.map(|state| (state >> 16) as i32 % 1000).take(16_384).collect();
//!
//! let (estimator, deviation) = (Estimator::Strided, Deviation::Allan);
//! let mut gyro = Octaves::new(estimator, deviation);
//! gyro.push(&samples); // and gyro.gap(Some(2)) where two were lost
//! let sums = gyro.sums();
//! let variances = sums.filter_map(|sum| {
//!     Some((sum.octave(), counts_to_unit(sum.variance_counts2()?, 12)))
//! });
//! let (octaves, variances): (Vec<_>, Vec<f64>) = variances.unzip();
//! let shape = RecordShape { samples: 16_384, interval_s: 0.025, estimator, deviation };
//! let model = NoiseModel::new(&octaves, &shape, None, false);
//! let fit = model.fit(&ChannelCurve::new(&variances, false), 0.95);
//!
//! // N, the angle random walk: 0.001 rad/s / sqrt(12 * 40 Hz) is the truth
//! let white = fit.parameter(Term::White).ok_or("not in the model")?;
//! let (Some(n), Some(lower), Some(upper)) = (white.value, white.lower, white.upper) else {
//!     return Err("no estimate");
//! };
//! println!("{n:.3e} rad/s/sqrt(Hz), between {lower:.3e} and {upper:.3e} with 95 %");
//! assert!(lower < 4.564e-5 && 4.564e-5 < upper && upper - lower < 0.05 * n);
//! # Ok::<(), &str>(())
//! ```
//!
//! Samples are integer counts of the last digit that a sensor prints, so that every sum is an exact
//! integer: results do not depend on how samples are divided over calls, and do not lose digits
//! over years of data. Floats appear when a result is read, with a relative error below 1e-13 for
//! deviations and 1e-12 for moments. Without enough samples a result is `None` or absent, never
//! zero or NaN.
//!
//! [`ChannelSignal`] detects what invalidates such results: spectral peaks, disturbances, warm-up
//! and steps of the level.
//!
//! Each accumulator holds one channel, and knows no sensor, no clock and no sampling interval: the
//! averaging time is m times the interval that the user of the result knows.
//!
//! # Divisions of a record
//!
//! The result is the same, bit by bit, for any division of a record over calls:
//!
//! - Windows of octaves, blocks, windows for disturbances and segments of the spectrum lie on the
//!   grid of absolute indices.
//! - What is kept are sums of integers. A window of an octave that lacks samples, and the power of a
//!   segment at each frequency, are rounded once, by the samples of that window alone.
//! - If the record outgrows its room, blocks of twice the length replace pairs of them, and
//!   segments are taken twice as far apart, by the number of samples before.
//!
//! Exact for any length of the record are the octaves (`None` beyond 128 bits), moments and
//! histogram; block sums up to 2^32 samples of full scale, and powers up to a sum of 2^41 counts². The
//! transforms of the segments, in single precision, and the results read from the sums are the same
//! numbers on processors with the same vector instructions.
//!
//! # References
//!
//! - D. W. Allan, "Statistics of atomic frequency standards", Proc. IEEE 54 (1966).
//! - W. J. Riley, "Handbook of Frequency Stability Analysis", NIST SP 1065 (2008): definitions and
//!   test suites.
//! - P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE
//!   Trans. Audio Electroacoust. 15 (1967).
//! - A. C. Harvey, "Forecasting, Structural Time Series Models and the Kalman Filter" (1989): the
//!   local level model.
//! - IEEE Std 952 and 1293: the Allan variance of gyroscopes and accelerometers.

mod accumulate;
mod infer;
#[cfg(test)]
#[path = "../tests/oracle/mod.rs"]
mod oracle;
pub mod timebase;

pub use accumulate::blocks::{Block, MAX_BLOCKS};
pub use accumulate::counts::counts_to_unit;
pub use accumulate::histogram::{Histogram, HistogramBars, MAX_BINS};
pub use accumulate::moments::Moments;
pub use accumulate::octaves::window_plan::WindowPlans;
pub use accumulate::octaves::{OctaveSum, Octaves};
pub use accumulate::record::{Deviation, Estimator, Octave, RecordShape};
pub use accumulate::signal::ChannelSignal;
pub use accumulate::spectrum::{Density, Sides, Spectrum, SpectrumPlan};
pub use accumulate::stretch::Stretch;
pub use accumulate::temperature_blocks::TemperatureBlocks;
pub use accumulate::unwrap::Unwrap;
pub use infer::chi_squared;
pub use infer::confidence::{Interval, edf};
pub use infer::convention::{Convention, STANDARD_GRAVITY_M_S2, Sensor, conventions, si_unit, temperature_conventions};
pub use infer::curve_reading::{GraphicalReading, GraphicalReadings, NotRead, curve_minimum};
pub use infer::disturbance::Disturbance;
pub use infer::drift::{CurvePoint, Drift, Integral};
pub use infer::identification::noise_types;
pub use infer::level_change::{LevelChange, LevelFindings, LevelSearch, LevelShape};
pub use infer::narrow_bands::NarrowBand;
pub use infer::noise_change::{Frozen, NoiseChange, NoiseChanges};
pub use infer::noise_model::{
    Aim, BoxcarWindow, ChannelCurve, FitQuality, GaussMarkovProcess, NoiseFit, NoiseModel, PROVED_P, Parameter,
    SlowNoise, Status, Term, Wanted, Withheld, white_deficit,
};
pub use infer::power_law::PowerLaw;
pub use infer::spectral_lines::SpectralLine;
pub use infer::spikes::Spikes;
pub use infer::temperature::{LEAST_EXCURSION_C, NoCoefficient, TemperatureCoefficient, TemperatureSearch};
pub use infer::verdict::{Claim, Grade, Verdict};

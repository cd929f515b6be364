//! Statistics of inertial sensor channels, streaming and exact: Allan and Hadamard deviation over octaves of averaging
//! time, moments, histogram, and angles made continuous.
//!
//! ```
//! use imu_noise::{ChannelAccumulator, Deviation, Estimator, counts_to_unit};
//!
//! let interval_s = 0.025;
//! let mut gyro = ChannelAccumulator::new(Estimator::Strided, Deviation::Allan);
//! gyro.push(&[1063, 1249, 1251]); // rad/s with six decimals
//! gyro.gap(Some(2)); // two samples lost
//! gyro.push(&[856, 1563]);
//!
//! assert_eq!(gyro.moments().mean_counts(), Some(1196.4));
//! for octave in gyro.octaves().sums() {
//!     let tau_s = octave.m as f64 * interval_s;
//!     let deviation_rad_s = octave.deviation_counts().map(|counts| counts_to_unit(counts, 6));
//!     println!("{tau_s} s: {deviation_rad_s:?} rad/s from {} windows", octave.terms);
//! }
//! ```
//!
//! Samples are integer counts of the last digit a sensor prints, so every sum is an exact integer: results do not
//! depend on how samples are divided over calls, and do not lose digits over years of data. Floats appear when a
//! result is read out, with a relative error below 1e-13 for deviations and 1e-12 for moments. Without enough samples a
//! result is `None` or absent, never zero or NaN.
//!
//! Beside them, [`ChannelSignal`] watches what makes such numbers untrue: vibration lines in the power spectral density,
//! disturbances, warm-up and steps of the level, values that are not normally distributed.
//!
//! Each accumulator holds one channel. It knows no sensor, no clock and no sampling interval: the averaging time is
//! m times that interval.
//!
//! # References
//!
//! - D. W. Allan, "Statistics of atomic frequency standards", Proc. IEEE 54 (1966).
//! - W. J. Riley, "Handbook of Frequency Stability Analysis", NIST SP 1065 (2008): definitions and test suites.
//! - P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio
//!   Electroacoust. 15 (1967).
//! - A. C. Harvey, "Forecasting, Structural Time Series Models and the Kalman Filter" (1989): the local level model.
//! - IEEE Std 952 and 1293: the Allan variance of gyroscopes and accelerometers.

mod aligned;
mod blocks;
mod channel;
mod chi_squared;
mod comparison;
mod confidence;
mod convention;
mod counter;
mod histogram;
mod identification;
mod lanes;
mod moments;
mod noise_model;
mod normality;
mod octaves;
#[cfg(test)]
#[path = "../tests/oracle/mod.rs"]
mod oracle;
mod power_law;
mod record;
mod record_length;
mod scale;
mod signal;
mod significance;
mod spectrum;
mod stationarity;
mod timebase;
mod trend;
mod unwrap;
mod verdict;

pub use blocks::{Block, MAX_BLOCKS};
pub use channel::ChannelAccumulator;
pub use comparison::{Spread, VarianceEstimate, f_test, holm};
pub use confidence::{Interval, edf};
pub use convention::{Convention, STANDARD_GRAVITY_M_S2, Sensor, Sides, conventions};
pub use counter::{Counted, LineCounter};
pub use histogram::{Bars, Histogram, MAX_BINS};
pub use identification::{LagOne, NoiseType};
pub use moments::Moments;
pub use noise_model::{
    BoxcarWindow, ClassicalReading, FitQuality, GaussMarkovFit, NoiseFit, NoiseModel, OverBound, Parameter, Status,
    Term, Terms, classical_reading, curve_minimum, over_bound, visible_random_walk, white_deficit,
};
pub use normality::{Normality, NotJudged};
pub use octaves::{Deviation, Estimator, OctaveSum, Octaves};
pub use power_law::PowerLaw;
pub use record::{Octave, RecordShape};
pub use record_length::{Aim, Wanted};
pub use scale::counts_to_unit;
pub use signal::ChannelSignal;
pub use spectrum::{Density, DensityPoint, Line, Spectrum, SpectrumPlan};
pub use stationarity::{Disturbance, LevelChange, LevelShape};
pub use timebase::{Arrivals, NominalRate, Placed, Refusal, Timebase, TimebaseSummary};
pub use unwrap::Unwrap;
pub use verdict::{Claim, Grade, StreamFactor, Verdict};

//! The noise of several records compared: whether variances differ, how far means may lie apart
//! under a fitted noise, and what many records of one amplitude say together.
//!
//! ```
//! use imu_noise::Parameter;
//! use noise_comparison::RandomEffects;
//!
//! // N of one gyroscope, from four recordings
//! let of = |n: f64| Parameter::estimated(n, 0.98 * n, 1.02 * n);
//! let recordings = [of(0.0031), of(0.0030), of(0.0033), of(0.0031)];
//! let together = RandomEffects::of(&recordings, 0.95).ok_or("too few")?;
//! assert!(together.lower < 0.0031 && 0.0031 < together.upper);
//! # Ok::<(), &str>(())
//! ```

mod hypothesis_tests;
mod random_effects;
mod two_sample;

pub use hypothesis_tests::{Spread, VarianceEstimate, f_test, holm};
pub use random_effects::{FarthestRecord, RandomEffects, common_bound};
pub use two_sample::{SquaredAmplitude, Stretch, mean_difference_test, standard_error_of_mean};

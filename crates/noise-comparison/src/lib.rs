//! The noise of several records compared: whether variances differ, and how far means may lie apart
//! under a fitted noise.

mod hypothesis_tests;
mod two_sample;

pub use hypothesis_tests::{Spread, VarianceEstimate, f_test, holm};
pub use two_sample::{SquaredAmplitude, Stretch, mean_difference_test, standard_error_of_mean};

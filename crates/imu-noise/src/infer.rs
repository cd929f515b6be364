//! From sums to conclusions: degrees of freedom, intervals, noise models, tests and verdicts.

pub mod chi_squared;
pub(crate) mod confidence;
pub(crate) mod convention;
pub(crate) mod curve_reading;
pub(crate) mod disturbance;
pub(crate) mod drift;
pub(crate) mod identification;
pub(crate) mod level_change;
pub(crate) mod level_series;
pub(crate) mod narrow_bands;
pub(crate) mod noise_change;
pub(crate) mod noise_model;
pub(crate) mod power_law;
pub(crate) mod spectral_lines;
pub(crate) mod spikes;
pub(crate) mod temperature;
pub(crate) mod verdict;

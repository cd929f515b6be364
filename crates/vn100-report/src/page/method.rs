//! How the numbers were made from the samples.

use imu_noise::{Deviation, Estimator};

use super::fact_table::{Row, row};
use crate::{numbers::trimmed, record::Record};

pub(super) fn method(record: &Record<'_>, asked: &str) -> Vec<Row> {
    let snapshot = record.snapshot();
    vec![
        row(
            "Deviation",
            match snapshot.deviation {
                Deviation::Allan => "Allan, over octaves τ = 1, 2, 4, … sample intervals [1, 2]",
                Deviation::Hadamard => "Hadamard, over octaves τ = 1, 2, 4, … sample intervals [2]",
            },
        ),
        row(
            "Estimator",
            match snapshot.estimator {
                Estimator::Strided => {
                    "windows at stride τ/16: all overlaps up to τ = 16 samples, within 1 % of the information of all overlaps beyond"
                }
                Estimator::Full => "all overlaps (OADEV)",
                Estimator::Plain => "no overlap (ADEV)",
            },
        ),
        row("Detrended", if snapshot.detrended { "a regression line was taken from each channel" } else { "no" }),
        row(
            "Confidence",
            format!(
                "{} % two-sided, chi-squared with the degrees of freedom of the fitted mixture of noises [3]; each interval holds alone",
                trimmed(100.0 * record.assessment().confidence, 2)
            ),
        ),
        row(
            "Model",
            "N²/τ + 0.4413·B² + K²τ/3 + R²τ²/2 [4], squared amplitudes not negative, all octaves weighed by their joint covariance; the shortest are left out until p ≥ 0.01",
        ),
        row(
            "Conventions",
            "N is two-sided, as data sheets and Kalibr print it; a one-sided amplitude density is √2 N. B is the flat part of the curve over 0.664",
        ),
        row("Options", asked),
    ]
}

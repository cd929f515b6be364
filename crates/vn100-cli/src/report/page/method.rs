//! How the numbers were made from the samples.

use std::{path::Path, time::Duration};

use imu_noise::{Deviation, Estimator};

use super::{
    super::{numbers::trimmed, record::Record},
    fact_table::{Row, row},
};
use crate::args::ReportArgs;

pub(super) fn method(record: &Record<'_>, options: &ReportArgs) -> Vec<Row> {
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
        row("Options", options_in_words(options)),
    ]
}

/// As somebody would give them again.
fn options_in_words(options: &ReportArgs) -> String {
    let measure = &options.files.measure;
    let mut words: Vec<String> = Vec::new();
    let mut option = |name: &str, value: Option<String>| {
        words.extend(
            value.map(|value| if value.is_empty() { format!("--{name}") } else { format!("--{name} {value}") }),
        );
    };
    let flag = |set: bool| set.then(String::new);
    let length = |length: Duration| humantime::format_duration(length).to_string();
    option("rate", measure.rate.map(|hz| hz.to_string()));
    option("estimator", Some(format!("{:?}", measure.estimator).to_lowercase()));
    option("deviation", Some(format!("{:?}", measure.deviation).to_lowercase()));
    option("skip", Some(length(measure.skip)).filter(|_| !measure.skip.is_zero()));
    option("duration", measure.duration.map(length));
    for goal in &measure.until {
        option("until", Some(format!("\"{goal}\"")));
    }
    option("detrend", measure.detrend.map(|_| "linear".into()));
    option("quantization", flag(measure.quantization));
    option("confidence", measure.confidence.map(|level| level.to_string()));
    for figure in &measure.fail_on {
        option("fail-on", Some(format!("\"{figure}\"")));
    }
    // without its folder: the page says the same wherever the files lie
    let sheet = measure.datasheet.as_deref().and_then(Path::file_name);
    option("datasheet", sheet.map(|name| name.to_string_lossy().into_owned()));
    option("filter-models", flag(options.filter_models));
    option("accept-unchecked", flag(measure.accept_unchecked));
    words.join(" ")
}

//! Conclusions in words. Every sentence rests on a number of the record, or states that there is
//! none.

mod limits;
mod noise;
#[cfg(test)]
mod tests;
mod trust;

use vn100_analysis::RemedyWords;

use crate::html::findings::Findings;

/// Each question with the sentences that answer it.
pub(crate) fn conclusions(findings: &Findings, words: RemedyWords) -> [(&'static str, Vec<String>); 7] {
    [
        ("How noisy is the sensor?", noise::noise(findings)),
        ("Can these numbers be trusted?", trust::trust(findings)),
        ("Does it meet the data sheet?", limits::against_data_sheet(findings, words)),
        ("What limits this record?", limits::limits(findings)),
        ("How to improve the measurement", limits::advice(findings, words)),
        ("Which values for Kalman filters and Kalibr?", noise::filters(findings, words)),
        ("What was not tested?", limits::not_tested(findings)),
    ]
}

/// `a`, `a and b`, `a, b and c`.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

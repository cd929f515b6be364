//! Conclusions in words. Every sentence rests on a number of the record, or states that there is
//! none.

mod limits;
mod noise;
#[cfg(test)]
mod tests;
mod trust;

use vn100_analysis::RemedyWords;

use super::findings::Findings;

/// Each question with the sentences that answer it.
pub(crate) fn conclusions(findings: &Findings, words: RemedyWords) -> [(&'static str, Vec<String>); 7] {
    [
        ("How noisy is the sensor?", noise::noise(findings)),
        ("Can these numbers be trusted?", trust::trust(findings)),
        ("Is it within its data sheet, and why does it differ?", limits::against_data_sheet(findings, words)),
        ("What limits this record?", limits::limits(findings)),
        ("What would make a better one?", limits::advice(findings, words)),
        ("What do I give a filter, or Kalibr?", noise::filters(findings, words)),
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

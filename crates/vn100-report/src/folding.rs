//! Why records of one sensor are not ranked.

use vn100_analysis::{Onboard, Ranking};

use crate::{numbers::plain::four_digits, record::record_letter};

/// Why none is the quietest where white noise does not fold alike.
#[must_use]
pub fn folding(ranking: &Ranking) -> String {
    let own: Vec<String> = (ranking.records.iter())
        .map(|ranked| match ranked.white_factor {
            Some(factor) => format!("{} {factor:.2}, {}", record_letter(ranked.record), four_digits(ranked.own())),
            None => format!("{} not known", record_letter(ranked.record)),
        })
        .collect();
    format!(
        "none is named the quietest: white noise folds differently in them, by a factor known to ±{:.0} %. The factor, and N over it, by which \
         they are ordered: {}. Compare records of one rate and averaging window",
        100.0 * Onboard::UNCERTAINTY,
        own.join("; ")
    )
}

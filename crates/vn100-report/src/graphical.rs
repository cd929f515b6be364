//! The results of the graphical slope method, in the words of laboratories.

use vn100_analysis::noise::{NotRead, Term};

/// The parameters that the graphical slope method reads, and the rule by which it reads each, also in few
/// characters.
pub const GRAPHICAL: [(Term, &str, &str); 3] = [
    (Term::White, "slope −½ at τ = 1 s", "  slope −½ at 1 s"),
    (Term::BiasInstability, "minimum / 0.664", "  minimum / 0.664"),
    (Term::RateRandomWalk, "slope +½ at τ = 3 s", "  slope +½ at 3 s"),
];

/// Why the graphical slope method gives no value of that parameter, in words.
pub fn not_read(term: Term, why: NotRead) -> &'static str {
    match (why, term) {
        (NotRead::NoSlope, Term::White) => "not read: no slope −½ region",
        (NotRead::NoSlope, _) => "not read: no slope +½ region",
        (NotRead::NoMinimum, _) => "not read: no minimum within the curve",
        (NotRead::OutsideCurve, Term::White) => "not read: τ = 1 s lies outside the curve",
        (NotRead::OutsideCurve, _) => "not read: τ = 3 s lies outside the curve",
        (NotRead::NotApplicable, _) => "not read: no Allan deviation at rest",
    }
}

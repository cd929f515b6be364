//! How well a record can show a parameter at best, without a fit.

use super::Term;
use crate::infer::chi_squared;

/// The interval of N is no narrower than so much of the Cramér-Rao bound of white noise alone.
const WHITE: f64 = 0.93;

/// That of B and K than so much of what the octaves would give if nothing else were unknown.
const SLOW: f64 = 0.6;

/// Standard deviations by which a fitted curve passes above an octave at most.
const ABOVE: f64 = 4.0;

/// A lower limit of half the width of the interval of `term` over its value that a fit to a record
/// of so many `samples` finds, in far less time than the fit: cheap enough to ask every second
/// whether a fit is worth while. `octaves`: averaging factor and variance of each.
///
/// White noise of n samples shows N² with a relative variance of 2/n at best. For slow terms an
/// octave of averaging factor m counts as n/m independent squares, and with the share that the term
/// has in it at most: the fitted curve does not pass far above any octave. 0 if nothing is said.
#[must_use]
pub fn least_half_width(
    term: Term,
    octaves: impl Iterator<Item = (u64, f64)> + Clone,
    samples: u64,
    confidence: f64,
) -> f64 {
    let Some(z) = chi_squared::normal_two_sided(confidence) else { return 0.0 };
    let growth: fn(f64) -> f64 = match term {
        Term::White => return WHITE * z / (2.0 * samples as f64).sqrt(),
        Term::BiasInstability => |_| 1.0,
        Term::RateRandomWalk => |m| m,
        Term::Quantization | Term::RateRamp => return 0.0,
    };
    let usable = octaves.filter(|(_, variance)| *variance > 0.0).map(|(m, variance)| {
        let m = m as f64;
        // in units of the term alone, and of how many squares it is the mean
        (variance / growth(m), samples as f64 / m)
    });
    let highest = usable.clone().map(|(level, squares)| level * (1.0 + ABOVE * (2.0 / squares).sqrt()));
    let highest = highest.fold(f64::INFINITY, f64::min);
    let information: f64 = usable.map(|(level, squares)| squares * (highest / level).min(1.0).powi(2)).sum();
    if information > 0.0 { SLOW * z / (2.0 * information.sqrt()) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(term: Term, variance: impl Fn(f64) -> f64 + Copy) -> f64 {
        let octaves = (0..14).map(|k| (1_u64 << k, variance((1_u64 << k) as f64)));
        least_half_width(term, octaves, 24_000, 0.95)
    }

    #[test]
    fn white_noise_is_known_no_better_than_its_samples_allow() {
        let found = of(Term::White, |m| 1.0 / m);
        assert!((found / (0.93 * 1.959_964 / 48_000_f64.sqrt()) - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn white_noise_shows_no_slow_term_and_a_slow_one_shows_itself() {
        for (term, own) in [(Term::BiasInstability, 0.0), (Term::RateRandomWalk, 1.0)] {
            let hidden = of(term, |m| 1.0 / m);
            let alone = of(term, |m| m.powf(own));
            assert!(hidden > 0.08 && alone < 0.01, "{term:?}: {hidden}, {alone}");
        }
        assert_eq!(of(Term::RateRamp, |m| m), 0.0);
        assert_eq!(least_half_width(Term::RateRandomWalk, core::iter::empty(), 5, 0.95), 0.0);
    }
}

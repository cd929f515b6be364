//! How long a record must be to show a noise parameter.

use crate::{Deviation, Estimator, NoiseModel, Octave, RecordShape, Status, Term, Terms};

/// Two-sided level at 1.96 + 1.282 standard deviations, 2 Φ(3.242) - 1: what lies above zero at this level on average passes the threshold
/// of presence, 1.96, in nine of ten records.
const FOUND_LEVEL: f64 = 0.998_813;

/// Longest record that is thought of.
const LONGEST_S: f64 = 100.0 * 86_400.0;

/// Lengths are found to this relative error.
const TOLERANCE: f64 = 0.02;

/// What a record shall show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// The term is [`Status::Estimated`] in nine of ten records.
    Found,
    /// It is, and half the width of its interval, relative to the value, is so much at most in a record as the model expects it.
    HalfWidth(f64),
}

/// A noise parameter that a record shall show, beside all the others that it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted<'a> {
    /// The parameter.
    pub term: Term,
    /// How well.
    pub aim: Aim,
    /// All parameters of the noise in SI units, the wanted one among them.
    pub truth: &'a [(Term, f64)],
}

impl Wanted<'_> {
    /// Length in seconds of the shortest record sampled every `interval_s` that shows it, rounded up by 2 % at most, with strided windows of
    /// the Allan deviation and intervals at the level `confidence`; `None` where 100 days do not.
    ///
    /// By the model's own covariance of the octaves, without a simulation: see [`NoiseModel::expected_fit`]. A random walk lengthens it:
    /// beyond some length, white noise is known no better.
    #[must_use]
    pub fn record_s(&self, interval_s: f64, confidence: f64) -> Option<f64> {
        let shown = |duration_s: f64| self.is_shown(duration_s, interval_s, confidence);
        // the shortest that has an octave for each parameter
        let mut long = 16.0 * interval_s;
        while !shown(long) {
            long *= 2.0;
            if long > LONGEST_S {
                return None;
            }
        }
        let mut short = long / 2.0;
        while long / short > 1.0 + TOLERANCE {
            let middle = (short * long).sqrt();
            if shown(middle) {
                long = middle;
            } else {
                short = middle;
            }
        }
        Some(long)
    }

    fn is_shown(&self, duration_s: f64, interval_s: f64, confidence: f64) -> bool {
        let shape = RecordShape {
            samples: (duration_s / interval_s).floor() as u64,
            interval_s,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let model = noise_model(&shape);
        let parameter = |level| model.expected_fit(self.truth, level).parameter(self.term);
        let found = parameter(FOUND_LEVEL)
            .is_some_and(|parameter| parameter.status == Status::Estimated && parameter.lower > Some(0.0));
        match self.aim {
            Aim::Found => found,
            Aim::HalfWidth(most) => {
                found
                    && parameter(confidence).is_some_and(|parameter| {
                        parameter.relative_half_width().is_some_and(|half_width| half_width <= most)
                    })
            }
        }
    }
}

/// All terms of a rate, for a record without gaps.
fn noise_model(shape: &RecordShape) -> NoiseModel {
    let octaves: Vec<Octave> = (0..u64::BITS)
        .map(|power| 1_u64 << power)
        .map(|m| Octave { m, terms: shape.windows(m) })
        .take_while(|octave| octave.terms > 0)
        .collect();
    NoiseModel::new(&octaves, shape, Terms::RATE, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two thirds of a gyroscope by its data sheet: 0.0035 deg/s/√Hz and 6 deg/h.
    const TRUTH: [(Term, f64); 2] = [(Term::White, 6.11e-5), (Term::BiasInstability, 2.9e-5)];

    fn seconds(term: Term, aim: Aim, truth: &[(Term, f64)]) -> Option<f64> {
        Wanted { term, aim, truth }.record_s(0.025, 0.95)
    }

    #[test]
    fn print_lengths() {
        for p in [0.1, 0.05, 0.02, 0.01] {
            println!("N {p} {:?}", seconds(Term::White, Aim::HalfWidth(p), &TRUTH));
        }
        for b in [2e-5, 2.424e-5, 2.9e-5, 3.4e-5, 4.85e-5] {
            let truth = [(Term::White, 6.11e-5), (Term::BiasInstability, b)];
            println!("B {b} {:?}", seconds(Term::BiasInstability, Aim::Found, &truth));
            for p in [0.5, 0.2, 0.1] {
                println!("B {b} {p} {:?}", seconds(Term::BiasInstability, Aim::HalfWidth(p), &truth));
            }
        }
        for k in [1e-7, 2e-7, 1e-6, 5e-6] {
            let t = 20.0 * 3_f64.sqrt() * 6.11e-5 / k;
            let truth = [(Term::White, 6.11e-5), (Term::RateRandomWalk, k)];
            println!("K {k} rule {t} without B {:?}", seconds(Term::RateRandomWalk, Aim::Found, &truth));
            let truth = [(Term::White, 6.11e-5), (Term::BiasInstability, 2.424e-5), (Term::RateRandomWalk, k)];
            println!("K {k} rule {t} with B {:?}", seconds(Term::RateRandomWalk, Aim::Found, &truth));
        }
    }
}

//! How long a record must be to show a noise parameter.

use super::noise_model::{NoiseModel, Term, Terms};
use crate::accumulate::record::{Deviation, Estimator, RecordShape};

/// Longest record that is thought of.
const LONGEST_S: f64 = 100.0 * 86_400.0;

/// Lengths are found to this relative error.
const TOLERANCE: f64 = 0.02;

/// What a record shall show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// About nine of ten records estimate the term, see [`NoiseModel::is_found`].
    Found,
    /// They do, and half the width of its interval, relative to the value, is so much at most in a
    /// record as the model expects it.
    HalfWidth(f64),
}

/// A noise parameter that a record shall show, together with all its other noise.
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
    /// Length in seconds of the shortest record sampled every `interval_s` that shows it, rounded
    /// up by 2 % at most, with strided windows of the Allan deviation and intervals at the level
    /// `confidence`; `None` where 100 days do not.
    ///
    /// By the model's own covariance of the octaves, without a simulation: see
    /// [`NoiseModel::expected_fit`].
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
        let model = NoiseModel::new(&shape.octaves(), &shape, Terms::RATE, None);
        if !model.is_found(self.truth, self.term) {
            return false;
        }
        match self.aim {
            Aim::Found => true,
            Aim::HalfWidth(most) => {
                let parameter = model.expected_fit(self.truth, confidence).parameter(self.term);
                parameter
                    .and_then(|parameter| parameter.relative_half_width())
                    .is_some_and(|half_width| half_width <= most)
            }
        }
    }
}

//! What a record to come can be expected to show, by the model fitted to the values that it expects
//! itself, and how long a record must be to show a parameter.

use std::sync::Arc;

use super::{
    NoiseModel, Parameter, SharedShapes, Status, Term,
    channel_fit::ReadOut,
    density::{FLICKER, WALK, WHITE},
    parameter::PROVED_P,
    search::Search,
    spectral_rows::ChannelData,
    thresholds::{OF_MISSED, PLANNED_BIAS, PLANNED_WALK, PRESENT, WIDER, WIDER_WHITE},
};
use crate::accumulate::record::{Deviation, Estimator, RecordShape};
use crate::infer::chi_squared;

impl NoiseModel {
    /// What the record says of `term` whose squared amplitude comes out at this quantile.
    fn parameter_at(&self, truth: &[(Term, f64)], term: Term, quantile: f64, confidence: f64) -> Option<Parameter> {
        let z = chi_squared::normal_two_sided(confidence)?;
        let data = self.unlucky(truth, term, quantile)?;
        ReadOut::expecting(self, &data, z)?.parameter(term, confidence)
    }

    /// What the record shows in which the squared amplitude of `term` comes out at this quantile, and
    /// everything else as is expected.
    fn unlucky(&self, truth: &[(Term, f64)], term: Term, quantile: f64) -> Option<ChannelData<'_>> {
        let mut squares = self.squares(truth);
        let place = self.column(term)?;
        let expected = ChannelData::expecting(&self.grid, &squares);
        let search = Search::new(&expected, &self.layout, self.shapes_of(&expected), true, 1.0);
        let edf = 2.0 / search.relative_variance(place)?;
        squares[place] *= chi_squared::quantile(quantile, edf)? / edf;
        Some(ChannelData::expecting(&self.grid, &squares))
    }

    pub(super) fn column(&self, term: Term) -> Option<usize> {
        match term {
            Term::White => Some(WHITE),
            Term::BiasInstability => Some(FLICKER),
            Term::RateRandomWalk => Some(WALK),
            Term::Quantization => self.layout.quantization,
            Term::RateRamp => None,
        }
    }

    /// By component, in units of one sample.
    fn squares(&self, truth: &[(Term, f64)]) -> Vec<f64> {
        let mut squares = vec![0.0; self.layout.components.len()];
        for (term, value) in truth {
            if let Some(column) = self.column(*term) {
                squares[column] = (value / term.per_second(self.shape.interval_s)).powi(2);
            }
        }
        squares
    }
}

/// By how much the expected evidence shall exceed the one needed.
const fn margin(term: Term) -> f64 {
    match term {
        Term::BiasInstability => PLANNED_BIAS,
        Term::RateRandomWalk => PLANNED_WALK,
        Term::Quantization | Term::White | Term::RateRamp => 1.0,
    }
}

const LONGEST_S: f64 = 100.0 * 86_400.0;

/// Between a value that is enough and one that is not, the least that is, too high by the `tolerance` at most.
fn narrowed(mut found: f64, mut missed: f64, tolerance: f64, is_enough: impl Fn(f64) -> bool) -> f64 {
    while found / missed > 1.0 + tolerance {
        let middle = (found * missed).sqrt();
        *if is_enough(middle) { &mut found } else { &mut missed } = middle;
    }
    found
}

/// What a record shall show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// The term is estimated.
    Found,
    /// And half the width of its interval, relative to the value, is so much at most.
    HalfWidth(f64),
    /// Its interval, or its bound, lies below this.
    Below(f64),
    /// Its interval lies above this.
    Above(f64),
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
    /// The share of records that may miss it, for one axis; above 0 and below 1.
    pub missed: f64,
    /// How many slow terms on how many axes are tested in one record.
    pub tests: usize,
}

impl Wanted<'_> {
    /// Length in seconds of the shortest record sampled every `interval_s` that shows it, rounded up by
    /// 2 % at most, with strided windows of the Allan deviation and intervals at the level `confidence`;
    /// `None` where 100 days do not. By the covariance of the octaves, not by simulation.
    pub fn record_s(&self, interval_s: f64, confidence: f64) -> Option<f64> {
        // doubled lengths have as many blocks
        let shapes = Arc::default();
        let is_shown = |duration_s: f64| self.is_shown(duration_s, interval_s, confidence, &shapes);
        // from the shortest that has an octave for each parameter
        let doubled = core::iter::successors(Some(16.0 * interval_s), |length_s| Some(2.0 * length_s));
        let lengths_s: Vec<f64> = doubled.take_while(|length_s| *length_s <= LONGEST_S).collect();
        let place = lengths_s.partition_point(|length_s| !is_shown(*length_s));
        let found_s = *lengths_s.get(place)?;
        Some(if place == 0 { found_s } else { narrowed(found_s, 0.5 * found_s, 0.02, is_shown) })
    }

    fn is_shown(&self, duration_s: f64, interval_s: f64, confidence: f64, shapes: &SharedShapes) -> bool {
        let shape = RecordShape {
            samples: (duration_s / interval_s).floor() as u64,
            interval_s,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let model = NoiseModel::new(&shape.octaves(), &shape, None, false);
        let model = NoiseModel { shapes: Arc::clone(shapes), ..model };
        let [low, high] = OF_MISSED.map(|part| part * self.missed);
        let quantile = if matches!(self.aim, Aim::Below(_)) { 1.0 - high } else { low };
        let Some(parameter) = model.parameter_at(self.truth, self.term, quantile, confidence) else { return false };
        // the evidence that all tests of a record ask for
        let needed = chi_squared::normal_quantile(1.0 - (PROVED_P / self.tests as f64).min(0.5)).max(PRESENT);
        let evidence = parameter.p.map(|p| chi_squared::normal_quantile(1.0 - p.clamp(1e-300, 1.0 - 1e-16)));
        let is_proved =
            self.term == Term::White || evidence.is_some_and(|evidence| evidence > margin(self.term) * needed);
        let is_found = parameter.status == Status::Estimated && is_proved;
        match self.aim {
            Aim::Found => is_found,
            Aim::HalfWidth(most) => {
                let wider = if self.term == Term::White { 1.0 + WIDER_WHITE * most.sqrt() } else { WIDER };
                is_found && parameter.relative_half_width().is_some_and(|half_width| wider * half_width <= most)
            }
            Aim::Below(limit) => parameter.upper.is_some_and(|upper| upper <= limit),
            Aim::Above(limit) => is_found && parameter.lower.is_some_and(|lower| lower >= limit),
        }
    }
}

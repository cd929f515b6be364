//! The noise parameters: the components of the noise of a rate, and what is known of each.

use super::regression::{Regression, Solution};
use crate::accumulate::record::{Deviation, RecordShape};
use crate::infer::chi_squared;
use crate::infer::power_law::PowerLaw;

/// Standard deviations above zero that exclude it: χ² falls by more than 3.84, which noise without
/// the term does in 2.5 % of records.
pub(super) const PRESENT: f64 = 1.96;

/// A square that is so small a part of the best one is as good as zero: at zero itself the model
/// may lack what keeps the other terms apart, and χ² leaps.
const NEGLIGIBLE: f64 = 1e-4;

/// Probability, corrected for all slow terms and axes of a record together, up to which one of them
/// is proved.
pub const PROVED_P: f64 = 0.03;

/// Relative error of the squared parameter.
const TOLERANCE: f64 = 2e-3;

/// A component of the noise of a rate, with its letter in IEEE Std 952 and its Allan variance.
/// Amplitudes follow the two-sided spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Term {
    /// Q, unit · s: 3 Q²/τ². Rounding of an angle; rounding of a rate is white.
    Quantization,
    /// N, unit/√Hz: N²/τ. Angle or velocity random walk.
    White,
    /// B, unit: (2 ln 2/π) B². Flicker noise.
    BiasInstability,
    /// K, unit/√s: K² τ/3.
    RateRandomWalk,
    /// R, unit/s, with a sign: R² τ²/2. Not random.
    RateRamp,
}

impl Term {
    /// All terms, in the order in which results are given.
    pub const ALL: [Self; 5] =
        [Self::Quantization, Self::White, Self::BiasInstability, Self::RateRandomWalk, Self::RateRamp];

    /// The Allan or Hadamard variance, in the unit of the channel squared, that this component
    /// alone, at `amplitude` in its own unit, has at averaging factor `m` >= 1 of a record of this
    /// shape. Exact at every m, as [`PowerLaw::variance`], but for averaging on board. A ramp has
    /// no Hadamard variance.
    #[must_use]
    pub fn variance(self, amplitude: f64, m: u64, shape: &RecordShape) -> f64 {
        let amplitude = amplitude / self.per_second(shape.interval_s);
        let of = |law: PowerLaw| law.variance(shape.deviation, m);
        amplitude
            * amplitude
            * match (self, shape.deviation) {
                (Self::Quantization, _) => of(PowerLaw::WhitePhase),
                (Self::White, _) => of(PowerLaw::White),
                (Self::BiasInstability, _) => of(PowerLaw::Flicker),
                (Self::RateRandomWalk, _) => of(PowerLaw::RandomWalk),
                (Self::RateRamp, Deviation::Allan) => (m as f64).powi(2) / 2.0,
                (Self::RateRamp, Deviation::Hadamard) => 0.0,
            }
    }

    /// From an amplitude in sample intervals to one in seconds.
    pub(super) fn per_second(self, interval_s: f64) -> f64 {
        match self {
            Self::Quantization => interval_s,
            Self::White => interval_s.sqrt(),
            Self::BiasInstability => 1.0,
            Self::RateRandomWalk => 1.0 / interval_s.sqrt(),
            Self::RateRamp => 1.0 / interval_s,
        }
    }
}

/// A set of terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Terms(u8);

impl Terms {
    /// What a rate may have: white noise, bias instability, rate random walk, and a ramp.
    pub const RATE: Self = Self::of(&[Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp]);
    /// White noise alone.
    pub const WHITE: Self = Self::of(&[Term::White]);

    /// The set of `terms`.
    #[must_use]
    pub const fn of(terms: &[Term]) -> Self {
        let mut set = 0;
        let mut i = 0;
        while i < terms.len() {
            set |= 1 << terms[i] as u8;
            i += 1;
        }
        Self(set)
    }

    /// The set with `term` in it too.
    #[must_use]
    pub const fn and(self, term: Term) -> Self {
        Self(self.0 | 1 << term as u8)
    }

    /// Whether `term` is in the set.
    #[must_use]
    pub const fn contains(self, term: Term) -> bool {
        self.0 & (1 << term as u8) != 0
    }
}

/// What is known of a noise parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// It is there, and has a value and a two-sided interval.
    Estimated,
    /// It may be absent; it is not above the upper bound.
    Bounded,
    /// The record does not show it.
    NotObservable,
    /// The stream does not carry it, however long the record; set by the caller.
    NotMeasurable,
    /// No range of averaging times follows the model.
    ModelRejected,
}

impl Status {
    /// From what is known best to what is known least.
    pub const ALL: [Self; 5] =
        [Self::Estimated, Self::Bounded, Self::NotObservable, Self::NotMeasurable, Self::ModelRejected];
}

/// A noise parameter, in the unit of its term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// What is known.
    pub status: Status,
    /// The best value, where estimated.
    pub value: Option<f64>,
    /// Lower end of the interval, where estimated.
    pub lower: Option<f64>,
    /// Upper end of the interval, where estimated; the bound on the magnitude, where bounded.
    pub upper: Option<f64>,
    /// Probability that noise without this term would show as much of it; `None` where that was
    /// not tested.
    pub p: Option<f64>,
}

impl Parameter {
    /// A parameter of which nothing more is known than `status`.
    #[must_use]
    pub const fn without_value(status: Status) -> Self {
        Self { status, value: None, lower: None, upper: None, p: None }
    }

    /// A value with the interval from `lower` to `upper`.
    #[must_use]
    pub const fn estimated(value: f64, lower: f64, upper: f64) -> Self {
        Self { status: Status::Estimated, value: Some(value), lower: Some(lower), upper: Some(upper), p: None }
    }

    /// A bound from above.
    #[must_use]
    pub const fn bounded(upper: f64) -> Self {
        Self { upper: Some(upper), ..Self::without_value(Status::Bounded) }
    }

    /// The same, known to be no more than bounded: it may be absent after all.
    #[must_use]
    pub fn not_proved(self) -> Self {
        // of a ramp that falls the lower end is the larger magnitude
        let upper = self.lower.into_iter().chain(self.upper).map(f64::abs).reduce(f64::max);
        Self { status: Status::Bounded, value: None, lower: None, upper, ..self }
    }

    /// Half the width of the interval over the value; `None` without a value other than zero.
    #[must_use]
    pub fn relative_half_width(&self) -> Option<f64> {
        let half_width = (self.upper? - self.lower?) / 2.0;
        self.value.filter(|value| *value != 0.0).map(|value| (half_width / value).abs())
    }

    /// Reads parameter `term`, a square, off the best fit; the result is its root.
    pub(super) fn of(regression: &Regression<'_>, solution: &Solution, term: usize, confidence: f64) -> Self {
        let search = Search { regression, solution, term };
        let found = chi_squared::normal_two_sided(confidence).and_then(|z| Some((z, search.crossing_above(z)?)));
        let Some((z, upper)) = found else { return Self::without_value(Status::NotObservable) };
        let best = solution.parameters[term];
        let (lower, at_zero) = search.lower(z);
        let found = match at_zero > PRESENT {
            true => Self::estimated(best.sqrt(), lower.sqrt(), upper.sqrt()),
            false => Self::bounded(upper.sqrt()),
        };
        Self { p: Some(chi_squared::normal_above(at_zero)), ..found }
    }

    /// By how many standard deviations zero is excluded for parameter `term`.
    pub(super) fn evidence(regression: &Regression<'_>, solution: &Solution, term: usize) -> f64 {
        let search = Search { regression, solution, term };
        if search.best() > 0.0 { search.at_zero().0 } else { 0.0 }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        let scaled = |value: Option<f64>| value.map(|value| value * factor);
        Self { value: scaled(self.value), lower: scaled(self.lower), upper: scaled(self.upper), ..self }
    }
}

/// The ramp from the slope of the regression line and the standard deviation that noise gives it,
/// with `dof` degrees of freedom. It is there above twice that, which a random walk reaches at K
/// √(1.2/T), or more where the noise is poorly known (Student, 1908).
pub(super) fn ramp(slope: f64, deviation: f64, dof: f64, confidence: f64) -> Parameter {
    let quantiles = chi_squared::student_two_sided(confidence, dof).zip(chi_squared::student_two_sided(0.96, dof));
    let Some((t, present)) = quantiles else { return Parameter::without_value(Status::NotObservable) };
    let found = match slope.abs() > present.max(2.0) * deviation {
        true => Parameter::estimated(slope, slope - t * deviation, slope + t * deviation),
        false => Parameter::bounded(slope.abs() + t * deviation),
    };
    Parameter { p: chi_squared::student_two_sided_above(slope.abs() / deviation, dof), ..found }
}

struct Search<'a> {
    regression: &'a Regression<'a>,
    solution: &'a Solution,
    term: usize,
}

impl Search<'_> {
    fn best(&self) -> f64 {
        self.solution.parameters[self.term]
    }

    /// Standard deviations by which the data lie above `value`, and the fit there.
    fn score(&self, value: f64, near: &[f64]) -> Option<(f64, Vec<f64>)> {
        let solution = self.regression.fit_with(self.term, value, near)?;
        Some((solution.score(self.term)?, solution.parameters))
    }

    /// The root of what χ² rises from the best fit to `value` below it, and the fit there. With few
    /// degrees of freedom that finds a weak term more often than the score does, which weighs by
    /// the covariance without it.
    fn rise(&self, value: f64, near: &[f64]) -> Option<(f64, Vec<f64>)> {
        let solution = self.regression.fit_with(self.term, value, near)?;
        Some(((solution.chi2 - self.solution.chi2).max(0.0).sqrt(), solution.parameters))
    }

    /// Standard deviations by which the data lie above zero, and the fit there: without the term
    /// there may be nothing left that could explain the data.
    fn at_zero(&self) -> (f64, Vec<f64>) {
        let near = &self.solution.parameters;
        let without = self.regression.fit_without(self.term, near);
        let rise = |without: Solution| ((without.chi2 - self.solution.chi2).max(0.0).sqrt(), without.parameters);
        without.map(rise).unwrap_or((f64::INFINITY, near.clone()))
    }

    /// The largest value less than `z` standard deviations above the data. Where the best fit is
    /// zero and the data lie below even that, distances count from there, in squares.
    fn crossing_above(&self, z: f64) -> Option<f64> {
        let mut low = self.best();
        let at_best = if low > 0.0 { 0.0 } else { self.solution.score(self.term)? };
        let z = z.hypot(at_best);
        let mut step = (z + 1.0) * self.solution.standard_deviation(self.term)?;
        let mut near = self.solution.parameters.clone();
        for _ in 0..30 {
            let high = low + step;
            let (score, parameters) = self.score(high, &near)?;
            near = parameters;
            if score + z < 0.0 {
                let low_score = if low == self.best() { at_best + z } else { self.score(low, &near)?.0 + z };
                return Some(self.root(Self::score, (low, low_score), (high, score + z), z, &near));
            }
            low = high;
            step *= 2.0;
        }
        None
    }

    /// The smallest value less than `z` standard deviations below the data, and how many of them
    /// zero is.
    fn lower(&self, z: f64) -> (f64, f64) {
        let best = self.best();
        if best == 0.0 {
            return (0.0, self.solution.score(self.term).unwrap_or(0.0));
        }
        let near = &self.solution.parameters;
        let (at_zero, parameters) = self.at_zero();
        if at_zero <= PRESENT.max(z) {
            return (0.0, at_zero);
        }
        let deviation = self.solution.standard_deviation(self.term).unwrap_or(best);
        // Far from zero the bound is near the normal one.
        let mut low = best - (z + 1.0) * deviation;
        if low > 0.0 {
            while let Some((rise, _)) = self.rise(low, near) {
                if rise > z {
                    return (self.root(Self::rise, (low, rise - z), (best, -z), -z, near), at_zero);
                }
                low = 2.0 * low - best;
                if low <= 0.0 {
                    break;
                }
            }
        }
        let finite = at_zero.min(100.0);
        let lower = self.root(Self::rise, (0.0, finite - z), (best, -z), -z, &parameters);
        let negligible = NEGLIGIBLE * best;
        match self.rise(negligible, &parameters).filter(|_| lower < negligible) {
            Some((above_zero, _)) => (0.0, above_zero.min(at_zero)),
            None => (lower, at_zero),
        }
    }

    /// Where `distance` + `offset` falls through zero, by false position with halving of a stale
    /// end (Dowell and Jarratt, 1971).
    fn root(
        &self,
        distance: impl Fn(&Self, f64, &[f64]) -> Option<(f64, Vec<f64>)>,
        low: (f64, f64),
        high: (f64, f64),
        offset: f64,
        near: &[f64],
    ) -> f64 {
        let ((mut low, mut at_low), (mut high, mut at_high)) = (low, high);
        let mut near = near.to_vec();
        let mut middle = high;
        for _ in 0..30 {
            let before = middle;
            middle = (low * at_high - high * at_low) / (at_high - at_low);
            if !(middle > low && middle < high) {
                middle = (low + high) / 2.0;
            }
            let tolerance = TOLERANCE * middle.max(TOLERANCE * self.best());
            if (middle - before).abs() <= tolerance || high - low <= tolerance {
                break;
            }
            let Some((found, parameters)) = distance(self, middle, &near) else { break };
            near = parameters;
            let value = found + offset;
            if value > 0.0 {
                (low, at_low) = (middle, value);
                at_high /= 2.0;
            } else {
                (high, at_high) = (middle, value);
                at_low /= 2.0;
            }
        }
        middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::Estimator;

    #[test]
    fn long_averaging_times_show_the_published_formulas() {
        let shape =
            RecordShape { samples: 0, interval_s: 0.01, estimator: Estimator::Full, deviation: Deviation::Allan };
        let (amplitude, m) = (3.0, 1 << 12);
        let tau = m as f64 * shape.interval_s;
        for (term, expected) in [
            (Term::Quantization, 3.0 / (tau * tau)),
            (Term::White, 1.0 / tau),
            (Term::BiasInstability, 2.0 * core::f64::consts::LN_2 / core::f64::consts::PI),
            (Term::RateRandomWalk, tau / 3.0),
            (Term::RateRamp, tau * tau / 2.0),
        ] {
            let off = term.variance(amplitude, m, &shape) / (amplitude * amplitude * expected) - 1.0;
            assert!(off.abs() < 1e-6, "{term:?} {off}");
        }
        let hadamard = RecordShape { deviation: Deviation::Hadamard, ..shape };
        assert_eq!(Term::RateRamp.variance(amplitude, m, &hadamard), 0.0);
    }
}

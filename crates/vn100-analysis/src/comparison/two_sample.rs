//! The difference of two means: Barnes' two-sample variance with dead time, for stretches of any
//! length.

use core::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use imu_noise::{Parameter, Status, Term, chi_squared};

use crate::hypothesis_tests::VarianceEstimate;

/// Beyond so many times the longer stretch the closed form of flicker noise loses digits, and what
/// it tends to is good to 10⁻⁶.
const FAR: f64 = 1e3;

/// A stretch of time over which a mean is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    /// Its beginning in seconds, from any origin.
    pub(super) start_s: f64,
    /// Its length in seconds, above 0.
    pub(super) duration_s: f64,
}

impl Stretch {
    /// Its end in seconds, from the same origin.
    #[must_use]
    pub(super) fn end_s(self) -> f64 {
        self.start_s + self.duration_s
    }

    /// Seconds between the two, whichever comes first; `None` where they overlap.
    #[must_use]
    pub(super) fn dead_time_s(self, other: Self) -> Option<f64> {
        let dead_s = (other.start_s - self.end_s()).max(self.start_s - other.end_s());
        (dead_s >= 0.0).then_some(dead_s)
    }

    /// Variance of the difference of the means over this stretch and another, where the component
    /// `term` alone, at `amplitude` in its own unit, is in both: for equal stretches 2 B₂(r) times
    /// the Allan variance at their length, with B₂ of the ratio r of the distance of their starts
    /// to their length (Barnes, NBS Technical Note 375, 1969; Barnes and Allan, NIST Technical
    /// Note 1318, 1990). `None` where they overlap. A ramp is not random and adds nothing. Samples
    /// missing within a stretch change only what white noise adds (B₃ of the latter differs from 1
    /// by less than their share).
    #[must_use]
    pub(super) fn mean_difference_variance(self, other: Self, term: Term, amplitude: f64) -> Option<f64> {
        let dead_s = self.dead_time_s(other)?;
        let durations_s = (self.duration_s, other.duration_s);
        let (long, short) = (durations_s.0.max(durations_s.1), durations_s.0.min(durations_s.1));
        let of_one = match term {
            Term::Quantization => 2.0 * (1.0 / long).powi(2) + 2.0 * (1.0 / short).powi(2),
            Term::White => 1.0 / long + 1.0 / short,
            Term::BiasInstability => flicker(dead_s / long, short / long),
            Term::RateRandomWalk => dead_s + (long + short) / 3.0,
            Term::RateRamp => 0.0,
        };
        Some(amplitude * amplitude * of_one)
    }
}

/// Of flicker noise of B = 1, for stretches of lengths 1 and `short` with `dead` between them: from
/// the generalised covariance t² ln t/(2π) of its integral.
fn flicker(dead: f64, short: f64) -> f64 {
    let distance = 0.5 + dead + 0.5 * short;
    if dead > FAR {
        return ((distance * distance / short).ln() + 3.0) / PI;
    }
    let covariance = |t: f64| if t == 0.0 { 0.0 } else { t * t * t.abs().ln() / TAU };
    // the phase at the four ends, and its weight
    let ends = [(0.0, 1.0), (1.0, -1.0), (1.0 + dead, -1.0 / short), (1.0 + dead + short, 1.0 / short)];
    let pairs = ends.iter().flat_map(|a| ends.iter().map(move |b| (a, b)));
    pairs.map(|((at, weight), (other, factor))| weight * factor * covariance(at - other)).sum()
}

/// The information of records on the square of an amplitude, the likelihood taken for normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SquaredAmplitude {
    centre: f64,
    deviation: f64,
}

impl SquaredAmplitude {
    /// Of a `parameter` with an interval or a bound at the level `confidence`. Where it is bounded,
    /// its p gives the centre of the likelihood, and the bound how wide it is. `None` where
    /// there is neither.
    #[must_use]
    pub(super) fn of(parameter: &Parameter, confidence: f64) -> Option<Self> {
        let z = chi_squared::normal_two_sided(confidence)?;
        let upper = parameter.upper?.powi(2);
        let (centre, deviation) = match parameter.status {
            Status::Estimated => {
                let (value, lower) = (parameter.value?, parameter.lower?);
                (value * value, (upper - lower * lower) / (2.0 * z))
            }
            Status::Bounded => {
                let above_zero = -chi_squared::normal_quantile(parameter.p?.clamp(1e-4, 0.999));
                let deviation = upper / (above_zero + z.hypot(above_zero.min(0.0)));
                (above_zero * deviation, deviation)
            }
            _ => return None,
        };
        (deviation > 0.0 && deviation.is_finite()).then_some(Self { centre, deviation })
    }

    /// The information of two independent records together. Where both see the amplitude, each
    /// counts as sharply as it is known relative to itself: the deviation grows with the value, and
    /// weights by it would favour the smaller one.
    #[must_use]
    pub(super) fn and(self, other: Self) -> Self {
        let seen = |one: &Self| one.centre > one.deviation;
        let both = [self, other];
        let weights = match both.iter().all(seen) {
            true => both.map(|one| (one.centre / one.deviation).powi(2)),
            false => both.map(|one| one.deviation.powi(-2)),
        };
        let sum = weights[0] + weights[1];
        let centre = (weights[0] * self.centre + weights[1] * other.centre) / sum;
        let deviation = if both.iter().all(seen) { centre * sum.powf(-0.5) } else { sum.powf(-0.5) };
        Self { centre, deviation }
    }

    /// Its most likely value, with the degrees of freedom that spread as much, two at least. What
    /// is hardly seen, nearer to zero than two deviations, counts as a tenth of a deviation more:
    /// so that neither flicker noise nor a walk too weak to be seen makes more false differences of
    /// means than what is seen, chosen by simulation (the benchmark `cells`, means).
    #[must_use]
    pub(super) fn estimate(self) -> VarianceEstimate {
        let unseen = if self.centre < 2.0 * self.deviation { 0.1 * self.deviation } else { 0.0 };
        let variance = self.centre.max(0.0) + unseen;
        VarianceEstimate { variance, edf: (2.0 * (variance / self.deviation).powi(2)).max(2.0) }
    }
}

/// The probability that noise alone makes two means differ by `difference` at least, either way,
/// where the variance of the difference is `noise` (Student, 1908). `None` where either is no
/// number.
#[must_use]
pub(super) fn mean_difference_test(difference: f64, noise: VarianceEstimate) -> Option<f64> {
    chi_squared::student_two_sided_above(difference.abs() / noise.variance.sqrt(), noise.edf)
}

/// The standard error of a mean of one stretch: √½ of the deviation of its difference from the mean
/// of another stretch as long, right behind it; from the `variance` of that difference.
#[must_use]
pub(super) fn standard_error_of_mean(variance: f64) -> f64 {
    variance.sqrt() * FRAC_1_SQRT_2
}

#[cfg(test)]
mod tests {
    use super::*;
    use imu_noise::{Deviation, Estimator, RecordShape};

    fn stretch(start_s: f64, duration_s: f64) -> Stretch {
        Stretch { start_s, duration_s }
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, not {expected}");
    }

    /// B₂(r, μ) = (1 + ½ (2 r^(μ+2) - (r+1)^(μ+2) - (r-1)^(μ+2))) / (2 (1 - 2^μ)), flicker noise
    /// its limit for μ = 0, as published.
    fn barnes(term: Term, r: f64) -> f64 {
        let squared_ln = |x: f64| if x == 0.0 { 0.0 } else { x * x * x.ln() };
        match term {
            Term::White => 1.0,
            Term::BiasInstability => {
                (-2.0 * squared_ln(r) + squared_ln(r + 1.0) + squared_ln(r - 1.0)) / (4.0 * 2_f64.ln())
            }
            _ => (3.0 * r - 1.0) / 2.0,
        }
    }

    #[test]
    fn equal_stretches_have_the_published_two_sample_variance() {
        let shape =
            RecordShape { samples: 0, interval_s: 1e-3, estimator: Estimator::Full, deviation: Deviation::Allan };
        for (term, tolerance) in [(Term::White, 1e-12), (Term::BiasInstability, 1e-5), (Term::RateRandomWalk, 1e-5)] {
            for r in [1.0, 1.01, 2.0, 7.5, 300.0, 999.0, 1002.0, 1e4] {
                let duration_s = 100.0;
                let found = stretch(5.0, duration_s).mean_difference_variance(
                    stretch(5.0 + r * duration_s, duration_s),
                    term,
                    3.0,
                );
                let allan = term.variance(3.0, 100_000, &shape);
                near(found.unwrap(), 2.0 * barnes(term, r) * allan, tolerance);
            }
        }
    }

    /// From the covariances of sampled noise, sample by sample.
    #[test]
    fn unequal_stretches_have_the_variance_of_sampled_noise() {
        let (a, b, dead) = (300_usize, 70_usize, 41_usize);
        // E (x_i - x_j)²/2 of each noise at the distance d
        let walk = |d: f64| d / 2.0;
        let weights: Vec<f64> = (0..a + dead + b)
            .map(|i| match i {
                i if i < a => 1.0 / a as f64,
                i if i < a + dead => 0.0,
                _ => -1.0 / b as f64,
            })
            .collect();
        let mut by_samples = 0.0;
        for (i, weight) in weights.iter().enumerate() {
            for (j, other) in weights.iter().enumerate() {
                by_samples -= weight * other * walk(i.abs_diff(j) as f64);
            }
        }
        let (first, second) = (stretch(0.0, a as f64), stretch((a + dead) as f64, b as f64));
        for (first, second) in [(first, second), (second, first)] {
            near(first.mean_difference_variance(second, Term::RateRandomWalk, 1.0).unwrap(), by_samples, 1e-4);
        }
        let white = first.mean_difference_variance(second, Term::White, 2.0).unwrap();
        near(white, 4.0 / 300.0 + 4.0 / 70.0, 1e-12);
    }

    #[test]
    fn flicker_noise_does_not_jump_where_the_form_changes() {
        for short in [1.0, 0.3, 0.01] {
            near(flicker(1.0001 * FAR, short), flicker(FAR, short), 1e-4);
        }
    }

    #[test]
    fn stretches_that_overlap_have_none() {
        for term in Term::ALL {
            assert_eq!(stretch(0.0, 10.0).mean_difference_variance(stretch(9.0, 10.0), term, 1.0), None);
            assert!(stretch(10.0, 10.0).mean_difference_variance(stretch(0.0, 10.0), term, 1.0).is_some());
        }
        assert_eq!(stretch(0.0, 2.0).dead_time_s(stretch(5.0, 1.0)), Some(3.0));
        assert_eq!(stretch(5.0, 1.0).dead_time_s(stretch(0.0, 2.0)), Some(3.0));
    }

    #[test]
    fn what_is_known_well_counts_as_its_value() {
        let known = Parameter::estimated(2.0, 1.9, 2.1);
        let estimate = SquaredAmplitude::of(&known, 0.95).unwrap().estimate();
        near(estimate.variance, 4.0, 1e-12);
        near(estimate.edf, 2.0 * (4.0 * 3.919_927_969_f64 / 0.8).powi(2), 1e-6);
        let twice = SquaredAmplitude::of(&known, 0.95).unwrap();
        near(twice.and(twice).estimate().edf, 2.0 * estimate.edf, 1e-6);
    }

    #[test]
    fn a_bound_counts_as_what_is_most_likely() {
        // zero lies one standard deviation below: the bound 2.96 above it
        let bounded = Parameter { p: Some(0.158_655_253_931_457), ..Parameter::bounded(2.959_963_985_f64.sqrt()) };
        let estimate = SquaredAmplitude::of(&bounded, 0.95).unwrap().estimate();
        near(estimate.variance, 1.1, 1e-7);
        near(estimate.edf, 2.42, 1e-7);
        // the data lie below zero already
        let absent = Parameter { p: Some(0.9), ..bounded };
        let absent = SquaredAmplitude::of(&absent, 0.95).unwrap();
        near(absent.estimate().variance, 0.1 * absent.deviation, 1e-12);
        assert_eq!(absent.estimate().edf, 2.0);
        let seen = SquaredAmplitude::of(&bounded, 0.95).unwrap().and(absent).estimate();
        assert!(seen.variance < 1.1, "{seen:?}");
        assert_eq!(SquaredAmplitude::of(&Parameter::bounded(1.0), 0.95), None);
        assert_eq!(SquaredAmplitude::of(&Parameter::without_value(Status::NotObservable), 0.95), None);
    }

    #[test]
    fn of_two_values_known_alike_the_mean_counts() {
        let of = |value: f64| SquaredAmplitude { centre: value, deviation: 0.3 * value };
        let together = of(1.0).and(of(1.6)).estimate();
        near(together.variance, 1.3, 1e-12);
        near(together.edf, 4.0 / 0.09, 1e-12);
    }

    /// From SciPy 1.17.1: `2 * stats.t.sf(2.5, 7)`.
    #[test]
    fn a_difference_is_tested_with_the_degrees_of_freedom_of_its_noise() {
        let noise = VarianceEstimate { variance: 4.0, edf: 7.0 };
        near(mean_difference_test(-5.0, noise).unwrap(), 0.040_992_218_585_752_89, 1e-9);
        assert_eq!(mean_difference_test(0.0, noise), Some(1.0));
        assert_eq!(mean_difference_test(f64::NAN, noise), None);
        near(standard_error_of_mean(8.0), 2.0, 1e-12);
    }
}

//! What is read off a deviation curve: the graphical N, B and K, the upper bound that a filter
//! designer draws, and the minimum that data sheets print as in-run bias stability.

use core::f64::consts::{LN_2, PI};
use schemars::JsonSchema;
use serde::Serialize;

use super::convention::{Sensor, si_unit};
use super::noise_model::{Parameter, Status, Term};

const PLATEAU: f64 = 2.0 * LN_2 / PI;

/// What the graphical slope method (IEEE Std 952) reads off the curve.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct GraphicalReadings {
    /// N: the line of slope -1/2 at 1 s.
    pub white: GraphicalReading,
    /// B: the minimum over 0.664.
    pub bias_instability: GraphicalReading,
    /// K: the line of slope +1/2 at 3 s.
    pub rate_random_walk: GraphicalReading,
}

/// One reading of the graphical slope method; it has no interval.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct GraphicalReading {
    /// Value in the SI unit; null if it is not read.
    pub value: Option<f64>,
    /// SI unit.
    pub unit: &'static str,
    /// Averaging time at which the line touches the curve, in seconds.
    pub tau_s: Option<f64>,
    /// Why there is no value; null if there is one.
    pub not_read: Option<NotRead>,
}

/// Why the graphical slope method gives no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotRead {
    /// No pair of neighbours has a slope within 1/4 of the line's.
    NoSlope,
    /// The lowest octave is the first or the last: the curve still falls, or only rises.
    NoMinimum,
    /// The averaging time at which the value is read lies outside the curve.
    OutsideCurve,
    /// The method does not hold for such a record, or the parameter is none of its three.
    NotApplicable,
}

impl GraphicalReadings {
    /// Averaging time at which N is read, in seconds.
    pub const WHITE_TAU_S: f64 = 1.0;
    /// Averaging time at which K is read, in seconds.
    pub const RANDOM_WALK_TAU_S: f64 = 3.0;

    /// Those of a record for which the method does not hold.
    pub fn not_applicable(sensor: Sensor) -> Self {
        Self::each(sensor, [Err(NotRead::NotApplicable); 3])
    }

    /// Reads N, B and K off octaves of deviation by the graphical rules of IEEE Std 952, annex C, for
    /// comparison with published figures only. A line is read where a pair of neighbours has its slope
    /// within 1/4, through the pair nearest to it, and the curve has its averaging time. N is read up to a
    /// twentieth of the record of `duration_s`: beyond, curves wander and have any slope by chance.
    pub fn of(sensor: Sensor, tau_s: &[f64], deviations: &[f64], duration_s: f64) -> Self {
        let points: Vec<(f64, f64)> = tau_s.iter().copied().zip(deviations.iter().copied()).collect();
        let usable = points.iter().all(|(tau, deviation)| *tau > 0.0 && *deviation > 0.0);
        // a low pass makes the curve rise before it falls
        let falls = points.windows(2).position(|pair| pair[1].1 < pair[0].1).unwrap_or(0);
        let lowest = (falls..points.len()).min_by(|a, b| points[*a].1.total_cmp(&points[*b].1));
        let line = |slope: f64, read_at_s: f64, from_s: f64, longest_s: f64| {
            let within = |pair: &&[(f64, f64)]| usable && pair[0].0 >= from_s && pair[1].0 <= longest_s;
            let pairs = points.windows(2).filter(within).map(|pair| {
                let [(tau_1, dev_1), (tau_2, dev_2)] = [pair[0], pair[1]];
                let apart = ((dev_2 / dev_1).ln() / (tau_2 / tau_1).ln() - slope).abs();
                let tau_s = (tau_1 * tau_2).sqrt();
                (apart, ((dev_1 * dev_2).sqrt() * (read_at_s / tau_s).powf(slope), tau_s))
            });
            let nearest = pairs.filter(|(apart, _)| *apart <= 0.25).min_by(|(a, _), (b, _)| a.total_cmp(b));
            let (_, found) = nearest.ok_or(NotRead::NoSlope)?;
            let is_inside = points.first().is_some_and(|(first, _)| *first <= read_at_s)
                && points.last().is_some_and(|(last, _)| read_at_s <= *last);
            if is_inside { Ok(found) } else { Err(NotRead::OutsideCurve) }
        };
        let inner = lowest.filter(|lowest| usable && *lowest > 0 && lowest + 1 < points.len());
        let flat = |lowest: usize| (points[lowest].1 / PLATEAU.sqrt(), points[lowest].0);
        let rises_s = lowest.map_or(0.0, |lowest| points[lowest].0);
        let white = line(-0.5, Self::WHITE_TAU_S, 0.0, duration_s / 20.0);
        let walk = line(0.5, Self::RANDOM_WALK_TAU_S, rises_s, f64::INFINITY);
        Self::each(sensor, [white, inner.map(flat).ok_or(NotRead::NoMinimum), walk])
    }

    /// N, B and K, each with the averaging time at which it was read.
    fn each(sensor: Sensor, read: [Result<(f64, f64), NotRead>; 3]) -> Self {
        let [white, bias, walk] = read;
        let of = |term, read: Result<(f64, f64), NotRead>| GraphicalReading {
            value: read.ok().map(|(value, _)| value),
            unit: si_unit(sensor, term),
            tau_s: read.ok().map(|(_, tau_s)| tau_s),
            not_read: read.err(),
        };
        Self {
            white: of(Term::White, white),
            bias_instability: of(Term::BiasInstability, bias),
            rate_random_walk: of(Term::RateRandomWalk, walk),
        }
    }

    /// The reading of a parameter; `None` for a parameter that the method does not have.
    pub const fn reading(&self, term: Term) -> Option<&GraphicalReading> {
        match term {
            Term::White => Some(&self.white),
            Term::BiasInstability => Some(&self.bias_instability),
            Term::RateRandomWalk => Some(&self.rate_random_walk),
            Term::Quantization | Term::RateRamp => None,
        }
    }
}

/// The minimum of the Allan deviation over all averaging times, from the fitted N, B and K of a
/// channel.
///
/// Flicker noise alone is flat at √(2 ln 2/π) B = 0.664 B. White noise and random walk lift the
/// lowest point: N²/τ + K² τ/3 has its minimum 2 N K/√3 at τ = √3 N/K, so that the square of the
/// result is (2 ln 2/π) B² + 2 N K/√3.
///
/// The status is that of `bias_instability`, but a bound needs one for every term. The lower end
/// counts the flicker noise alone or, if that is only bounded, white noise and random walk if they are
/// estimated; the upper end counts every term at its own. So the interval holds at the level of those
/// three or above (Bonferroni). An end is `None` if nothing gives it. A K that is only bounded lifts the
/// minimum too, so that the value counts the one of the likeliest noise, `likeliest_walk`.
pub fn curve_minimum(
    white: &Parameter,
    bias_instability: &Parameter,
    random_walk: &Parameter,
    likeliest_walk: f64,
) -> Parameter {
    let minimum = |white: f64, bias: f64, walk: f64| (PLATEAU * bias * bias + 2.0 * white * walk / 3_f64.sqrt()).sqrt();
    let upper = white.upper.zip(bias_instability.upper).zip(random_walk.upper);
    let upper = upper.map(|((white, bias), walk)| minimum(white, bias, walk));
    match bias_instability.status {
        Status::Estimated => Parameter {
            value: (white.value.zip(bias_instability.value))
                .map(|(white, bias)| minimum(white, bias, random_walk.value.unwrap_or(likeliest_walk))),
            lower: bias_instability.lower.map(|bias| minimum(0.0, bias, 0.0)),
            upper,
            ..Parameter::without_value(Status::Estimated)
        },
        Status::Bounded if upper.is_some() => {
            // both are there only if both are estimated
            let lower = white.lower.zip(random_walk.lower).map(|(white, walk)| minimum(white, 0.0, walk));
            Parameter { lower, upper, ..Parameter::without_value(Status::Bounded) }
        }
        Status::Bounded => Parameter::without_value(Status::NotObservable),
        status => Parameter::without_value(status),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(tau_s: &[f64], deviations: &[f64], duration_s: f64) -> GraphicalReadings {
        GraphicalReadings::of(Sensor::Gyroscope, tau_s, deviations, duration_s)
    }

    fn curve(n: f64, b: f64, k: f64) -> (Vec<f64>, Vec<f64>) {
        let tau_s: Vec<f64> = (0..20).map(|i| 0.025 * f64::from(1 << i)).collect();
        let plateau = 2.0 * LN_2 / PI;
        let deviation = |tau: &f64| (n * n / tau + plateau * b * b + k * k * tau / 3.0).sqrt();
        let deviations = tau_s.iter().map(deviation).collect();
        (tau_s, deviations)
    }

    #[test]
    fn lines_and_minimum_are_read_where_they_are() {
        let (tau_s, deviations) = curve(2e-4, 3e-5, 2e-6);
        let reading = read(&tau_s, &deviations, f64::INFINITY);
        let value = |read: GraphicalReading| read.value.unwrap();
        assert!((value(reading.white) / 2e-4 - 1.0).abs() < 0.01, "{reading:?}");
        assert!((value(reading.rate_random_walk) / 2e-6 - 1.0).abs() < 0.1, "{reading:?}");
        assert!((1.0..1.6).contains(&(value(reading.bias_instability) / 3e-5)), "{reading:?}");
        // the line touches the curve where it was read
        let line = reading.rate_random_walk;
        let tau_s = line.tau_s.unwrap();
        let there = (2e-4_f64.powi(2) / tau_s + PLATEAU * 3e-5_f64.powi(2) + 2e-6_f64.powi(2) * tau_s / 3.0).sqrt();
        assert!((value(line) * (tau_s / 3.0).sqrt() / there - 1.0).abs() < 0.02, "{line:?}, {there}");
        // What the rule makes of white noise and random walk alone: 1.62 √(N K), not 0.
        let (tau_s, deviations) = curve(2e-4, 0.0, 2e-6);
        let reading = read(&tau_s, &deviations, f64::INFINITY);
        assert!((value(reading.bias_instability) / (1.62 * (2e-4_f64 * 2e-6).sqrt()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn the_rise_behind_a_low_pass_is_no_random_walk() {
        let (tau_s, mut deviations) = curve(2e-4, 3e-5, 2e-6);
        let expected = read(&tau_s, &deviations, f64::INFINITY).rate_random_walk;
        // up to the third octave the deviation rises as the square root, from below the minimum or not
        for lowest in [1.0, 1e-3] {
            for i in 0..3 {
                deviations[i] = deviations[3] * lowest * (tau_s[i] / tau_s[3]).sqrt();
            }
            let reading = read(&tau_s, &deviations, f64::INFINITY);
            assert_eq!(reading.rate_random_walk, expected);
        }
    }

    #[test]
    fn what_the_curve_does_not_show_is_not_read() {
        let (tau_s, deviations) = curve(2e-4, 0.0, 0.0);
        let reading = read(&tau_s, &deviations, f64::INFINITY);
        assert_eq!(reading.bias_instability.not_read, Some(NotRead::NoMinimum));
        assert_eq!(reading.rate_random_walk.not_read, Some(NotRead::NoSlope));
        let (no_slope, no_minimum) = (Err(NotRead::NoSlope), Err(NotRead::NoMinimum));
        let nothing = GraphicalReadings::each(Sensor::Gyroscope, [no_slope, no_minimum, no_slope]);
        assert_eq!(read(&[], &[], 1.0), nothing);
        assert_eq!(read(&[1.0, 2.0], &[0.0, 0.0], 100.0), nothing);
        // white noise that is averaged for 4 s at least, and a walk that ends after 2 s
        let reading = read(&[4.0, 8.0], &[0.5, 0.125_f64.sqrt()], 200.0);
        assert_eq!(reading.white.not_read, Some(NotRead::OutsideCurve));
        let reading = read(&[1.0, 2.0], &[1.0, 2_f64.sqrt()], 100.0);
        assert_eq!(reading.rate_random_walk.not_read, Some(NotRead::OutsideCurve));
    }

    #[test]
    fn white_noise_is_not_read_where_the_curve_wanders() {
        let (tau_s, mut deviations) = curve(2e-4, 1e-5, 0.0);
        // a pair of exactly this slope, far above the curve
        let last = deviations.len() - 1;
        deviations[last - 1] *= 20.0;
        deviations[last] = deviations[last - 1] / 2_f64.sqrt();
        let reading = |duration_s| read(&tau_s, &deviations, duration_s).white.value.unwrap();
        assert!((reading(20.0 * tau_s[last - 1]) / 2e-4 - 1.0).abs() < 0.01);
        assert!(reading(20.0 * tau_s[last]) > 1e-3);
    }

    fn estimated(value: f64, lower: f64, upper: f64) -> Parameter {
        Parameter::estimated(value, lower, upper)
    }

    fn bounded(upper: f64) -> Parameter {
        Parameter { upper: Some(upper), ..Parameter::without_value(Status::Bounded) }
    }

    /// The lowest point of N²/τ + (2 ln 2/π) B² + K² τ/3, searched.
    fn searched([white, bias, walk]: [f64; 3]) -> f64 {
        let variance = |tau: f64| white * white / tau + 2.0 * LN_2 / PI * bias * bias + walk * walk * tau / 3.0;
        (0..40_000).map(|i| variance(1e-3 * 1.0005_f64.powi(i))).fold(f64::INFINITY, f64::min).sqrt()
    }

    #[test]
    fn it_is_the_lowest_point_of_the_curve() {
        for truth in [[1.4e-4, 2.4e-5, 2e-7], [1.4e-4, 1e-9, 2e-7], [2e-3, 3e-4, 1e-5]] {
            let [white, bias, walk] = truth.map(|value| estimated(value, value, value));
            let minimum = curve_minimum(&white, &bias, &walk, 0.0);
            let expected = searched(truth);
            for found in [minimum.value, minimum.upper] {
                assert!((found.unwrap() / expected - 1.0).abs() < 1e-3, "{truth:?}: {found:?}, not {expected}");
            }
            // a walk that is not proved is in the curve
            assert_eq!(curve_minimum(&white, &bias, &bounded(1.0), truth[2]).value, minimum.value);
        }
    }

    #[test]
    fn without_flicker_noise_it_over_0_664_is_the_phantom_that_the_recipe_prints() {
        let minimum = curve_minimum(&estimated(3.0, 3.0, 3.0), &bounded(0.0), &estimated(2.0, 2.0, 2.0), 2.0);
        assert_eq!(minimum.status, Status::Bounded);
        let phantom = minimum.upper.unwrap() / (2.0 * LN_2 / PI).sqrt();
        assert!((phantom - 1.62 * 6_f64.sqrt()).abs() < 0.01, "{phantom}");
    }

    #[test]
    fn white_noise_and_walk_alone_lift_the_lower_end() {
        let (white, walk) = (estimated(3.0, 2.9, 3.1), estimated(2.0, 1.5, 2.5));
        let minimum = curve_minimum(&white, &bounded(1.0), &walk, 2.0);
        assert_eq!((minimum.status, minimum.value), (Status::Bounded, None));
        assert!((minimum.lower.unwrap() - searched([2.9, 1e-9, 1.5])).abs() < 1e-3, "{minimum:?}");
        for (white, walk) in [(white, bounded(2.5)), (bounded(3.1), walk)] {
            assert_eq!(curve_minimum(&white, &bounded(1.0), &walk, 2.0).lower, None);
        }
    }

    #[test]
    fn a_missing_bound_leaves_the_upper_end_open() {
        let (white, unseen) = (estimated(1.0, 0.9, 1.1), Parameter::without_value(Status::NotObservable));
        let minimum = curve_minimum(&white, &estimated(1.0, 0.5, 2.0), &unseen, 0.0);
        assert_eq!((minimum.status, minimum.upper), (Status::Estimated, None));
        assert!((minimum.lower.unwrap() - 0.332).abs() < 1e-3);
        assert_eq!(curve_minimum(&white, &bounded(2.0), &unseen, 0.0).status, Status::NotObservable);
        for status in [Status::NotMeasurable, Status::NotObservable, Status::ModelRejected] {
            let minimum = curve_minimum(&white, &Parameter::without_value(status), &bounded(1.0), 0.0);
            assert_eq!(minimum, Parameter::without_value(status));
        }
    }
}

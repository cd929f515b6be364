//! The minimum of the deviation that a fitted model draws: what data sheets print as in-run bias
//! stability.

use core::f64::consts::{LN_2, PI};

use super::{Parameter, Status};

/// The minimum of the Allan deviation over all averaging times, from the fitted N, B and K of a
/// channel.
///
/// Flicker noise alone is flat at √(2 ln 2/π) B = 0.664 B. White noise and random walk lift the
/// lowest point: N²/τ + K² τ/3 has its minimum 2 N K/√3 at τ = √3 N/K, so that the square of the
/// result is (2 ln 2/π) B² + 2 N K/√3. Without flicker noise, too, the curve has a minimum; printed
/// as B it would be 1.62 √(N K).
///
/// The status is that of `bias_instability`, but for a bound, which needs one for every term:
/// otherwise it is [`Status::NotObservable`]. The lower end counts the flicker noise alone. Where
/// that is only bounded and the white noise and the random walk are estimated, it counts those two
/// at their own: both ends are right together as often as an interval, even if one knew nothing of
/// the other (Bonferroni). The upper end counts every term at its own. So the interval holds at the
/// level of those three or above. An end is `None` where nothing gives it.
///
/// ```
/// use imu_noise::{Parameter, Status, curve_minimum};
///
/// let (status, end) = (Status::Estimated, Some);
/// let exactly = |x| Parameter { status, value: end(x), lower: end(x), upper: end(x) };
/// let flicker_alone = curve_minimum(&exactly(0.0), &exactly(1.0), &exactly(0.0));
/// assert_eq!(flicker_alone.upper.map(|minimum| (minimum * 1e4).round()), Some(6643.0));
/// ```
#[must_use]
pub fn curve_minimum(white: &Parameter, bias_instability: &Parameter, random_walk: &Parameter) -> Parameter {
    const PLATEAU: f64 = 2.0 * LN_2 / PI;
    let minimum = |white: f64, bias: f64, walk: f64| (PLATEAU * bias * bias + 2.0 * white * walk / 3_f64.sqrt()).sqrt();
    let upper = white.upper.zip(bias_instability.upper).zip(random_walk.upper);
    let upper = upper.map(|((white, bias), walk)| minimum(white, bias, walk));
    match bias_instability.status {
        Status::Estimated => Parameter {
            value: (white.value.zip(bias_instability.value))
                .map(|(white, bias)| minimum(white, bias, random_walk.value.unwrap_or(0.0))),
            lower: bias_instability.lower.map(|bias| minimum(0.0, bias, 0.0)),
            upper,
            status: Status::Estimated,
        },
        Status::Bounded if upper.is_some() => {
            // both are there only where both are estimated
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

    fn estimated(value: f64, lower: f64, upper: f64) -> Parameter {
        Parameter { status: Status::Estimated, value: Some(value), lower: Some(lower), upper: Some(upper) }
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
            let minimum = curve_minimum(&white, &bias, &walk);
            let expected = searched(truth);
            for found in [minimum.value, minimum.upper] {
                assert!((found.unwrap() / expected - 1.0).abs() < 1e-3, "{truth:?}: {found:?}, not {expected}");
            }
        }
    }

    #[test]
    fn without_flicker_noise_it_over_0_664_is_the_phantom_that_the_recipe_prints() {
        let minimum = curve_minimum(&estimated(3.0, 3.0, 3.0), &bounded(0.0), &estimated(2.0, 2.0, 2.0));
        assert_eq!(minimum.status, Status::Bounded);
        let phantom = minimum.upper.unwrap() / (2.0 * LN_2 / PI).sqrt();
        assert!((phantom - 1.62 * 6_f64.sqrt()).abs() < 0.01, "{phantom}");
    }

    #[test]
    fn white_noise_and_walk_alone_lift_the_lower_end() {
        let (white, walk) = (estimated(3.0, 2.9, 3.1), estimated(2.0, 1.5, 2.5));
        let minimum = curve_minimum(&white, &bounded(1.0), &walk);
        assert_eq!((minimum.status, minimum.value), (Status::Bounded, None));
        assert!((minimum.lower.unwrap() - searched([2.9, 1e-9, 1.5])).abs() < 1e-3, "{minimum:?}");
        for (white, walk) in [(white, bounded(2.5)), (bounded(3.1), walk)] {
            assert_eq!(curve_minimum(&white, &bounded(1.0), &walk).lower, None);
        }
    }

    #[test]
    fn a_missing_bound_leaves_the_upper_end_open() {
        let (white, unseen) = (estimated(1.0, 0.9, 1.1), Parameter::without_value(Status::NotObservable));
        let minimum = curve_minimum(&white, &estimated(1.0, 0.5, 2.0), &unseen);
        assert_eq!((minimum.status, minimum.upper), (Status::Estimated, None));
        assert!((minimum.lower.unwrap() - 0.332).abs() < 1e-3);
        assert_eq!(curve_minimum(&white, &bounded(2.0), &unseen).status, Status::NotObservable);
        for status in [Status::NotMeasurable, Status::NotObservable, Status::ModelRejected] {
            let minimum = curve_minimum(&white, &Parameter::without_value(status), &bounded(1.0));
            assert_eq!(minimum, Parameter::without_value(status));
        }
    }
}

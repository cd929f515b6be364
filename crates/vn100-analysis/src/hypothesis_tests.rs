//! Whether deviations differ significantly.

use imu_noise::chi_squared;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal};

/// The probability that two estimates of the same variance, each with its degrees of freedom, lie
/// at least as far apart as these, either way: the two-sided F-test (Fisher, 1924; Snedecor, 1934).
/// `None` if one of the four is not positive and finite.
pub(crate) fn f_test(a: (f64, f64), b: (f64, f64)) -> Option<f64> {
    let ((variance_a, edf_a), (variance_b, edf_b)) = (a, b);
    let usable = [variance_a, edf_a, variance_b, edf_b].iter().all(|value| value.is_finite() && *value > 0.0);
    let distribution = FisherSnedecor::new(edf_a, edf_b).ok().filter(|_| usable)?;
    let ratio = variance_a / variance_b;
    let (below, above) = match nearly_normal(ratio, edf_a, edf_b).zip(Normal::new(0.0, 1.0).ok()) {
        Some((z, normal)) => (normal.cdf(z), normal.sf(z)),
        None => (distribution.cdf(ratio), distribution.sf(ratio)),
    };
    Some((2.0 * below.min(above)).min(1.0))
}

/// The ratio as a standard normal value (Paulson, 1942), good to 10⁻⁶ for so many degrees of
/// freedom and so near to 1: the continued fraction of the F distribution does not converge there.
fn nearly_normal(ratio: f64, edf_a: f64, edf_b: f64) -> Option<f64> {
    const MANY: f64 = 1e5;
    const NEAR: f64 = 1.0;
    let root = ratio.cbrt();
    let (of_a, of_b) = (2.0 / (9.0 * edf_a), 2.0 / (9.0 * edf_b));
    let z = ((1.0 - of_b) * root - (1.0 - of_a)) / (of_b * root * root + of_a).sqrt();
    (edf_a.min(edf_b) > MANY && z.abs() < NEAR).then_some(z)
}

/// Probabilities of several tests made at once, corrected so that the chance of even one false
/// alarm stays that of a single test (Holm, "A simple sequentially rejective multiple test
/// procedure", Scandinavian Journal of Statistics 6, 1979). It holds however the tests depend on
/// each other, and errs on the side of no alarm. None is below the one it comes from, none above 1.
pub(crate) fn holm(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
    let mut corrected = vec![0.0; probabilities.len()];
    let mut greatest: f64 = 0.0;
    for (rank, &index) in order.iter().enumerate() {
        let tests_left = (probabilities.len() - rank) as f64;
        greatest = greatest.max(probabilities[index] * tests_left).min(1.0);
        corrected[index] = greatest;
    }
    corrected
}

/// An estimated variance and what is known of its error: sums of such have degrees of freedom too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VarianceEstimate {
    /// In the unit of the channel squared.
    pub variance: f64,
    /// Equivalent degrees of freedom.
    pub edf: f64,
}

impl VarianceEstimate {
    /// The square of an amplitude with the two-sided interval `lower` to `upper` at the level
    /// `confidence`, with the degrees of freedom with which ln χ² spreads as much, ½ (2z /
    /// ln(upper/lower))², exact for narrow intervals. `None` unless 0 < `lower` < `upper`.
    pub(crate) fn of_interval(value: f64, lower: f64, upper: f64, confidence: f64) -> Option<Self> {
        let width = (upper / lower).ln();
        let z =
            chi_squared::normal_two_sided(confidence).filter(|_| lower > 0.0 && width > 0.0 && width.is_finite())?;
        Some(Self { variance: value * value, edf: 0.5 * (2.0 * z / width).powi(2) })
    }

    /// Of independent estimates, each with a factor (Satterthwaite, 1946; Welch, 1947).
    pub(crate) fn sum(parts: impl IntoIterator<Item = (f64, Self)>) -> Option<Self> {
        let (mut variance, mut error) = (0.0, 0.0);
        for (factor, part) in parts {
            let scaled = factor * part.variance;
            variance += scaled;
            error += scaled * scaled / part.edf;
        }
        (variance > 0.0 && error > 0.0).then_some(Self { variance, edf: variance * variance / error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    fn near(found: f64, expected: f64, tolerance: f64) -> bool {
        (found / expected - 1.0).abs() < tolerance
    }

    /// From SciPy 1.17.1, as below: many degrees of freedom, and a ratio near 1.
    const NORMAL: [(f64, f64, f64, f64); 4] = [
        (1.0001, 5e6, 5e6, 0.910_983_729_187_674_2),
        (1.000_01, 480_000.0, 480_000.0, 0.997_236_067_591_247_3),
        (0.9996, 2e7, 1.5e6, 0.737_974_366_298_186_4),
        (1.002, 719_999.0, 360_000.3, 0.489_106_588_803_046_25),
    ];

    /// From SciPy 1.17.1: `2 * min(stats.f.cdf(ratio, a, b), stats.f.sf(ratio, a, b))`.
    #[test]
    fn probabilities_are_those_of_the_reference() {
        for (ratio, edf_a, edf_b, expected) in [
            (2.0, 20.0, 20.0, 0.129_532_345_581_925_78),
            (0.5, 20.0, 20.0, 0.129_532_345_581_925_78),
            (1.21, 8000.0, 8000.0, 1.621_984_235_780_852_7e-17),
            (3.0, 2.5, 7.3, 0.212_538_860_672_832_1),
            (0.1, 3.0, 500.0, 0.080_021_919_845_744_14),
            (1.5, 150.25, 33.7, 0.168_253_077_276_625_3),
            // octaves of five hours, and of less than one window
            (1.05, 719_999.0, 360_000.3, 9.697_266_612_202_544e-64),
            (0.7, 68.0, 4213.5, 0.058_341_241_734_932_14),
            (3.5, 1.0, 1e5, 0.122_743_494_639_957_8),
            (40.0, 0.134, 12.7, 0.006_518_112_240_181_946),
            (250.0, 0.5, 0.7, 0.150_015_616_298_066_98),
        ] {
            let p = f_test((7.0 * ratio, edf_a), (7.0, edf_b)).unwrap();
            assert!(near(p, expected, 1e-9), "{ratio} {edf_a} {edf_b}: {p}");
        }
        assert!(near(f_test((1.0, 20.0), (1.0, 20.0)).unwrap(), 1.0, 1e-12));
        // many degrees of freedom, near 1: the normal approximation
        for (ratio, edf_a, edf_b, expected) in NORMAL {
            let p = f_test((7.0 * ratio, edf_a), (7.0, edf_b)).unwrap();
            assert!(near(p, expected, 1e-6), "{ratio} {edf_a} {edf_b}: {p}");
        }
    }

    #[test]
    fn what_is_no_estimate_is_not_tested() {
        for (variance, edf) in [(0.0, 5.0), (1.0, 0.0), (f64::NAN, 5.0), (1.0, f64::INFINITY), (-1.0, 5.0)] {
            assert_eq!(f_test((variance, edf), (1.0, 5.0)), None);
            assert_eq!(f_test((1.0, 5.0), (variance, edf)), None);
        }
    }

    /// By hand: 5 · 0.005, 4 · 0.011, 3 · 0.02, then the
    /// greatest so far.
    #[test]
    fn corrections_are_those_of_the_definition() {
        let corrected = holm(&[0.04, 0.005, 0.9, 0.02, 0.011]);
        for (found, expected) in corrected.iter().zip([0.08, 0.025, 0.9, 0.06, 0.044]) {
            assert!(near(*found, expected, 1e-12), "{corrected:?}");
        }
        assert_eq!(holm(&[]), [0.0; 0]);
        // from NumPy 2.4.6, with ties: the greatest so far of p times the tests left
        let corrected = holm(&[0.0203, 0.7574, 1e-12, 0.0033, 0.0203, 0.0859, 0.6, 0.0033]);
        for (found, expected) in corrected.iter().zip([0.1015, 1.0, 8e-12, 0.0231, 0.1015, 0.2577, 1.0, 0.0231]) {
            assert!(near(*found, expected, 1e-12), "{corrected:?}");
        }
    }

    proptest! {
        #[test]
        fn corrections_keep_the_order_and_never_shrink(probabilities in vec(0.0..1.0, 1..40)) {
            let corrected = holm(&probabilities);
            for (a, b) in probabilities.iter().zip(&corrected) {
                prop_assert!(a <= b && *b <= 1.0);
            }
            for i in 0..probabilities.len() {
                for j in 0..probabilities.len() {
                    prop_assert!(probabilities[i] > probabilities[j] || corrected[i] <= corrected[j]);
                }
            }
        }
    }

    /// From SciPy 1.17.1: `chi2.ppf` with 1000 degrees of freedom gives this interval of a
    /// deviation.
    #[test]
    fn an_interval_shows_its_degrees_of_freedom() {
        let estimate = VarianceEstimate::of_interval(1.0, 0.958_032_45, 1.045_841_37, 0.95).unwrap();
        assert!(near(estimate.edf, 1000.0, 2e-3), "{estimate:?}");
        assert_eq!(VarianceEstimate::of_interval(1.0, 0.0, 1.0, 0.95), None);
        assert_eq!(VarianceEstimate::of_interval(1.0, 1.0, 1.0, 0.95), None);
        assert_eq!(VarianceEstimate::of_interval(1.0, 0.5, 2.0, 1.0), None);
    }

    #[test]
    fn equal_estimates_add_their_degrees_of_freedom() {
        let one = VarianceEstimate { variance: 2.0, edf: 10.0 };
        let sum = VarianceEstimate::sum([(0.5, one), (0.5, one)]).unwrap();
        assert!(near(sum.variance, 2.0, 1e-12) && near(sum.edf, 20.0, 1e-12), "{sum:?}");
        assert_eq!(VarianceEstimate::sum([]), None);
    }
}

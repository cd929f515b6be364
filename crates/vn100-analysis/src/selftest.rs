//! Published and exact reference values, compared with those that this code computes from the same
//! inputs, which are built in.

use imu_noise::{Deviation, Estimator, Interval, Octave, Octaves, PowerLaw, RecordShape, counts_to_unit, edf};

/// Reference values of one source.
#[derive(Debug, Clone, PartialEq)]
pub struct SelfTestSuite {
    /// Where the values are published, or how they were computed.
    pub source: &'static str,
    /// Each reference value with the computed one.
    pub checks: Vec<SelfTestCheck>,
}

/// A reference value, and the value that this program computes.
#[derive(Debug, Clone, PartialEq)]
pub struct SelfTestCheck {
    /// Name of the statistic.
    pub statistic: String,
    /// Averaging factor; `None` for a statistic without one.
    pub m: Option<u64>,
    /// The reference value, as it is printed.
    pub reference: &'static str,
    /// The computed value; `None` where the computation gives none.
    pub ours: Option<f64>,
    /// The largest relative difference that counts as agreement.
    pub tolerance: f64,
}

impl SelfTestCheck {
    /// (computed - reference) / reference; `None` without a computed value.
    pub fn relative_difference(&self) -> Option<f64> {
        let reference: f64 = self.reference.parse().ok()?;
        Some(self.ours? / reference - 1.0)
    }

    /// Whether the two values agree to within `tolerance`; `false` without a computed value.
    pub fn passes(&self) -> bool {
        self.relative_difference().is_some_and(|difference| difference.abs() <= self.tolerance)
    }
}

/// The 1000-point suite of NIST SP 1065, section 12.4: statistic, m, value.
const NIST1000_PUBLISHED: [(Estimator, Deviation, u64, &str); 12] = [
    (Estimator::Plain, Deviation::Allan, 1, "2.922319e-01"),
    (Estimator::Plain, Deviation::Allan, 10, "9.965736e-02"),
    (Estimator::Plain, Deviation::Allan, 100, "3.897804e-02"),
    (Estimator::Full, Deviation::Allan, 1, "2.922319e-01"),
    (Estimator::Full, Deviation::Allan, 10, "9.159953e-02"),
    (Estimator::Full, Deviation::Allan, 100, "3.241343e-02"),
    (Estimator::Plain, Deviation::Hadamard, 1, "2.943883e-01"),
    (Estimator::Plain, Deviation::Hadamard, 10, "1.052754e-01"),
    (Estimator::Plain, Deviation::Hadamard, 100, "3.910860e-02"),
    (Estimator::Full, Deviation::Hadamard, 1, "2.943883e-01"),
    (Estimator::Full, Deviation::Hadamard, 10, "9.581083e-02"),
    (Estimator::Full, Deviation::Hadamard, 100, "3.237638e-02"),
];

/// The nine-point suite of NBS Monograph 140, annex 8.E, in the same form.
const NBS14: [i32; 9] = [892, 809, 823, 798, 671, 644, 883, 903, 677];
const NBS14_PUBLISHED: [(Estimator, Deviation, u64, &str); 8] = [
    (Estimator::Plain, Deviation::Allan, 1, "91.22945"),
    (Estimator::Plain, Deviation::Allan, 2, "115.8082"),
    (Estimator::Full, Deviation::Allan, 1, "91.22945"),
    (Estimator::Full, Deviation::Allan, 2, "85.95287"),
    (Estimator::Plain, Deviation::Hadamard, 1, "70.80607"),
    (Estimator::Plain, Deviation::Hadamard, 2, "116.7980"),
    (Estimator::Full, Deviation::Hadamard, 1, "70.80607"),
    (Estimator::Full, Deviation::Hadamard, 2, "85.61487"),
];

/// For 1000 samples, all overlapping: deviation, kind of noise, m, degrees of freedom.
const EDF_EXACT: [(Deviation, PowerLaw, u64, &str); 10] = [
    (Deviation::Allan, PowerLaw::White, 1, "666.222296395"),
    (Deviation::Allan, PowerLaw::White, 16, "91.1526889158"),
    (Deviation::Allan, PowerLaw::White, 64, "21.2328472722"),
    (Deviation::Allan, PowerLaw::Flicker, 1, "809.923188697"),
    (Deviation::Allan, PowerLaw::Flicker, 16, "71.66699755"),
    (Deviation::Allan, PowerLaw::Flicker, 64, "16.4969612395"),
    (Deviation::Allan, PowerLaw::RandomWalk, 16, "56.5856191541"),
    (Deviation::Allan, PowerLaw::RandomWalk, 64, "12.9728881373"),
    (Deviation::Hadamard, PowerLaw::White, 64, "17.1166691522"),
    (Deviation::Hadamard, PowerLaw::RandomWalk, 64, "12.8307249493"),
];

/// Degrees of freedom, level, and the confidence limits of a deviation of 1.
const BOUNDS_EXACT: [(f64, f64, &str, &str); 4] = [
    (2.0, 0.95, "0.520658266698817327", "6.28473469648538237"),
    (10.0, 0.95, "0.698717044163424394", "1.75493354741335593"),
    (100.0, 0.90, "0.896790249489029506", "1.13278933658431787"),
    (10_000.0, 0.99, "0.982091186215891528", "1.0185285266559558"),
];

/// Computes all suites, which takes some milliseconds.
pub fn self_test() -> Vec<SelfTestSuite> {
    let deviations = |published: &[(Estimator, Deviation, u64, &'static str)], counts: &[i32], decimals, tolerance| {
        let check = |(estimator, deviation, m, reference): &(Estimator, Deviation, u64, &'static str)| SelfTestCheck {
            statistic: statistic(*estimator, *deviation).into(),
            m: Some(*m),
            reference,
            ours: deviation_of(counts, decimals, *estimator, *deviation, *m),
            tolerance,
        };
        published.iter().map(check).collect()
    };
    vec![
        SelfTestSuite {
            source: "NIST SP 1065 (2008), section 12.4: 1000-point suite",
            checks: deviations(&NIST1000_PUBLISHED, &nist1000(), 7, 5e-7),
        },
        SelfTestSuite {
            source: "NBS Monograph 140 (1974), annex 8.E: nine-point suite, as in NIST SP 1065",
            checks: deviations(&NBS14_PUBLISHED, &NBS14, 0, 1e-6),
        },
        SelfTestSuite {
            source: "degrees of freedom of 1000 samples, all overlaps: exact sums, 60 digits",
            checks: EDF_EXACT.iter().map(edf_check).collect(),
        },
        SelfTestSuite {
            source: "chi-squared bounds of a deviation of 1: incomplete gamma function, 40 digits",
            checks: BOUNDS_EXACT.iter().flat_map(bound_checks).collect(),
        },
    ]
}

/// The series n_0 = 1234567890, n_(i+1) = 16807 n_i mod 2147483647, divided by 2147483647, to seven
/// decimals as the handbook prints it.
fn nist1000() -> Vec<i32> {
    const MODULUS: u64 = 2_147_483_647;
    let states = std::iter::successors(Some(1_234_567_890_u64), |state| Some(16_807 * state % MODULUS));
    states.take(1000).map(|state| ((state * 10_000_000 + MODULUS / 2) / MODULUS) as i32).collect()
}

const fn statistic(estimator: Estimator, deviation: Deviation) -> &'static str {
    match (estimator, deviation) {
        (Estimator::Plain, Deviation::Allan) => "Allan deviation",
        (Estimator::Plain, Deviation::Hadamard) => "Hadamard deviation",
        (_, Deviation::Allan) => "overlapping Allan deviation",
        (_, Deviation::Hadamard) => "overlapping Hadamard deviation",
    }
}

/// The deviation of the series. The non-overlapping deviation at m is that at m = 1 of the sums of m
/// samples, divided by m.
fn deviation_of(counts: &[i32], decimals: u8, estimator: Estimator, deviation: Deviation, m: u64) -> Option<f64> {
    let mut octaves = Octaves::new(estimator, deviation);
    let (sum, divisor) = if estimator == Estimator::Plain {
        octaves.push(&counts.chunks_exact(m as usize).map(|block| block.iter().sum()).collect::<Vec<_>>());
        (octaves.sums().next()?, m)
    } else {
        octaves.push(counts);
        (octaves.sum_at(m)?, 1)
    };
    Some(counts_to_unit(sum.deviation_counts()?, decimals) / divisor as f64)
}

fn edf_check((deviation, law, m, reference): &(Deviation, PowerLaw, u64, &'static str)) -> SelfTestCheck {
    let shape = RecordShape { samples: 1000, interval_s: 1.0, estimator: Estimator::Full, deviation: *deviation };
    let noise = match law {
        PowerLaw::WhitePhase => "white phase noise",
        PowerLaw::FlickerPhase => "flicker phase noise",
        PowerLaw::White => "white noise",
        PowerLaw::Flicker => "flicker noise",
        PowerLaw::RandomWalk => "random walk",
    };
    let name = if *deviation == Deviation::Allan { "Allan" } else { "Hadamard" };
    SelfTestCheck {
        statistic: format!("{name}, {noise}"),
        m: Some(*m),
        reference,
        ours: edf(&Octave::whole(*m, shape.windows(*m)), &shape, *law),
        tolerance: 1e-6,
    }
}

fn bound_checks((edf, level, lower, upper): &(f64, f64, &'static str, &'static str)) -> [SelfTestCheck; 2] {
    let interval = Interval::new(1.0, *edf, *level);
    let check = |end: &str, reference: &'static str, ours: Option<f64>| SelfTestCheck {
        statistic: format!("{end} bound, {edf} degrees of freedom, {} %", 100.0 * level),
        m: None,
        reference,
        ours,
        tolerance: 1e-10,
    };
    [
        check("lower", lower, interval.map(|interval| interval.lower)),
        check("upper", upper, interval.map(|interval| interval.upper)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_value_is_reached() {
        let suites = self_test();
        assert_eq!(suites.iter().map(|suite| suite.checks.len()).collect::<Vec<_>>(), [12, 8, 10, 8]);
        for check in suites.iter().flat_map(|suite| &suite.checks) {
            assert!(check.passes(), "{check:?}: {:?}", check.relative_difference());
        }
    }

    #[test]
    fn what_differs_or_is_missing_does_not_pass() {
        let check = |ours| SelfTestCheck { statistic: String::new(), m: None, reference: "2.5", ours, tolerance: 1e-6 };
        assert!(check(Some(2.500_002)).passes());
        for ours in [Some(2.500_003), Some(-2.5), Some(f64::NAN), None] {
            assert!(!check(ours).passes(), "{ours:?}");
        }
        assert_eq!(deviation_of(&[1, 2, 3], 0, Estimator::Full, Deviation::Allan, 2), None);
        assert_eq!(deviation_of(&[1, 2, 3], 0, Estimator::Plain, Deviation::Allan, 2), None);
    }

    #[test]
    fn the_series_is_the_one_published() {
        let counts = nist1000();
        assert_eq!((counts[0], counts.iter().max(), counts.iter().min()), (5_748_905, Some(&9_957_453), Some(&13_718)));
    }
}

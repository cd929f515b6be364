//! The rate of a sensor without a list of rates, where samples are missing evenly, or so many of
//! them that neither single intervals nor stretches show the rate: the step of which all intervals
//! are multiples.
//!
//! The stamps are taken as angles of a frequency. If that is the rate of the sensor, they all point
//! in the same direction, whatever is missing: the length of their mean is exp(-2 (π s)²) for
//! arrivals with a standard deviation of s periods (the resultant length of circular statistics,
//! Mardia and Jupp, *Directional Statistics*, 2000, section 3.4.1), 0.45 for a fifth of a period.
//!
//! A host that reads at an even rate above that of the samples makes the same stamps as samples
//! that are missing evenly: 40 Hz read at 50 Hz is 50 Hz with every fifth sample missing. Such
//! stamps are taken for those of the sensor, except at the intervals at which USB adapters are
//! read.

use std::f64::consts::TAU;

/// The number of samples that are searched, and the least number: of fewer samples the resultant is
/// too long by chance.
const SEARCHED: usize = 256;
const FEWEST: usize = 96;

/// The shortest resultant that counts: seven standard deviations of that of random stamps in
/// [`FEWEST`] samples, and the length for arrivals with a standard deviation of a quarter of a
/// period.
const SHORTEST_RESULTANT: f64 = 0.3;

/// By what factor the resultant must be longer than that at the mean rate. Chosen: with every third
/// sample missing, and arrivals with a standard deviation of a fifth of a period, the factor is
/// 1.29.
const BETTER: f64 = 1.1;

/// The range of the rate over the mean rate: below it the other estimates find the rate, and above
/// it most samples are missing.
const LEAST_MISSING: f64 = 1.02;
const MOST_MISSING: f64 = 1.75;

/// The least fraction of the intervals that are a single step. Chosen: arrivals with a standard
/// deviation of a fifth of a period reduce it by a tenth, also from the half that remains with
/// every third sample missing.
const SINGLE: f64 = 0.42;

/// The least fraction of the intervals with three steps or more where samples are missing at
/// random. A reader at an even pace finds a sample of a slower sensor at every step or every second
/// one.
const AT_RANDOM: f64 = 0.05;

/// The interval at which USB adapters are read, in seconds; a power of two less is possible.
const LATENCY_S: f64 = 0.016;
const SAME_STEP: f64 = 0.01;

/// The rate in Hz of the step between the samples, where some of them are missing. `None` without
/// sufficient evidence: for samples that arrive in batches, at the pace of a reader, or without a
/// common step.
pub(super) fn rate_by_base_step(stamps_s: &[f64]) -> Option<f64> {
    let searched_s = &stamps_s[..stamps_s.len().min(SEARCHED)];
    let span_s = searched_s.last()? - searched_s.first()?;
    if searched_s.len() < FEWEST || span_s <= 0.0 {
        return None;
    }
    let mean_hz = (searched_s.len() - 1) as f64 / span_s;
    let step_hz = 0.25 / span_s;
    let candidates = ((MOST_MISSING - LEAST_MISSING) * mean_hz / step_hz) as u32;
    let at = |index: u32| LEAST_MISSING * mean_hz + f64::from(index) * step_hz;
    let (length, near_hz) = (0..candidates)
        .map(|index| (resultant(searched_s, at(index)).0, at(index)))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    if length < SHORTEST_RESULTANT.max(BETTER * resultant(searched_s, mean_hz).0) {
        return None;
    }
    let hz = fitted(stamps_s, fitted(searched_s, near_hz)?)?;
    is_evident(stamps_s, hz).then_some(hz)
}

/// Length and angle of the mean resultant of the stamps at this frequency.
fn resultant(stamps_s: &[f64], hz: f64) -> (f64, f64) {
    let origin_s = stamps_s[0];
    let (mut cosines, mut sines) = (0.0, 0.0);
    for at_s in stamps_s {
        let (sine, cosine) = (TAU * ((at_s - origin_s) * hz).fract()).sin_cos();
        cosines += cosine;
        sines += sine;
    }
    (f64::hypot(cosines, sines) / stamps_s.len() as f64, sines.atan2(cosines))
}

/// The slope of the least-squares line through the stamps, each at its whole number of periods.
fn fitted(stamps_s: &[f64], near_hz: f64) -> Option<f64> {
    let phase = resultant(stamps_s, near_hz).1 / TAU;
    let periods: Vec<f64> = stamps_s.iter().map(|at_s| ((at_s - stamps_s[0]) * near_hz - phase).round()).collect();
    let count = stamps_s.len() as f64;
    let (mean_periods, mean_s) = (periods.iter().sum::<f64>() / count, stamps_s.iter().sum::<f64>() / count);
    let variance: f64 = periods.iter().map(|at| (at - mean_periods).powi(2)).sum();
    let covariance: f64 = periods.iter().zip(stamps_s).map(|(at, at_s)| (at - mean_periods) * (at_s - mean_s)).sum();
    (covariance > 0.0).then(|| variance / covariance)
}

/// Whether single steps are the rule, and this is not how a reader meets a slower sensor.
fn is_evident(stamps_s: &[f64], hz: f64) -> bool {
    let (mut single, mut longer) = (0, 0);
    for pair in stamps_s.windows(2) {
        let periods = (pair[1] - pair[0]) * hz;
        single += usize::from((0.5..1.5).contains(&periods));
        longer += usize::from(periods >= 2.5);
    }
    let intervals = (stamps_s.len() - 1) as f64;
    let is_at_random = longer as f64 >= AT_RANDOM * intervals;
    let is_reader = is_of_adapter(hz) && !is_at_random;
    single as f64 >= SINGLE * intervals && !is_reader
}

/// Whether the step is an interval at which USB adapters are read.
fn is_of_adapter(hz: f64) -> bool {
    (0..5).any(|halvings| (LATENCY_S / f64::from(1 << halvings) * hz - 1.0).abs() < SAME_STEP)
}

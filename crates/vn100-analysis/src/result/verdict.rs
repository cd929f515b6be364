//! The record that would decide a verdict.

use imu_noise::{Aim, Term, Wanted};

use crate::{
    assessment::ChannelNoise,
    datasheet::{FigureVerdict, floor_of_flicker},
    plan::{Plan, SLOW_TERMS, TakenAt},
};

/// The length in seconds of a record with the noise that this axis shows and that would decide a
/// verdict which the interval leaves open; `None` if 100 days do not. A parameter that is only
/// bounded is taken at as much of the limit as in a plan.
pub(super) fn deciding_record_s(
    verdict: &FigureVerdict,
    noise: &ChannelNoise,
    interval_s: f64,
    confidence: f64,
) -> Option<f64> {
    let FigureVerdict { figure, range: (passes_below, fails_above), .. } = verdict;
    let term = figure.term;
    let of_term = if figure.is_curve_minimum() { floor_of_flicker() } else { 1.0 };
    let value = verdict.measured.value.unwrap_or(TakenAt::BESIDE * passes_below);
    let aim = match value > *fails_above {
        true => Aim::Above(fails_above / of_term),
        false => Aim::Below(passes_below / of_term),
    };
    let others = Term::ALL.into_iter().filter(|other| ![term, Term::Quantization].contains(other));
    let others = others.filter_map(|other| Some((other, noise.parameter(other)?.value?)));
    let truth: Vec<(Term, f64)> = others.chain([(term, value / of_term)]).collect();
    let wanted = Wanted { term, aim, truth: &truth, missed: 1.0 - Plan::MET_IN, tests: SLOW_TERMS };
    wanted.record_s(interval_s, confidence)
}

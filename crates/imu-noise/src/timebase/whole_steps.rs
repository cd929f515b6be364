//! Whole steps between samples, in what a sensor counts: events of its own, or nanoseconds.

/// The fraction of a step by which an interval may differ from whole steps. Chosen: real intervals at
/// 800 Hz differ by a fortieth, and counters by one event in four or more.
pub(super) const TOLERANCE: f64 = 0.25;

/// An interval of more steps belongs to another counter or clock: as a gap at 800 Hz it would last two
/// months.
const MAX_STEPS: f64 = 4_294_967_296.0;

/// The number of steps in the interval, at least one; `None` if it is not a whole number.
pub(super) fn whole_steps(interval: u64, step: f64) -> Option<u64> {
    let quotient = interval as f64 / step;
    let steps = quotient.round();
    let is_whole = (quotient - steps).abs() <= TOLERANCE && (1.0..=MAX_STEPS).contains(&steps);
    is_whole.then_some(steps as u64)
}

/// The mean of the intervals within half of the shortest one, which are single steps if there are
/// two consecutive samples among them; `None` without an interval.
pub(super) fn single_step(intervals: impl Iterator<Item = u64> + Clone) -> Option<f64> {
    let least = intervals.clone().min()? as f64;
    let single: Vec<f64> = intervals.map(|interval| interval as f64).filter(|step| *step <= 1.5 * least).collect();
    Some(single.iter().sum::<f64>() / single.len() as f64)
}

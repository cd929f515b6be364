//! Missing samples by the counter that each sample carries.

use std::collections::VecDeque;

use state_bytes::{BadEncoding, ByteReader, Encoded, encode_hash};

use thiserror::Error;

use super::gap_event::GapEvent;
use super::rate_estimates::RUN;

/// The fraction of a step by which an increment may differ from a whole number of steps. Chosen:
/// counters that run at 800 Hz differ by one event in four or more.
const TOLERANCE: f64 = 0.25;

/// An increment of more steps is no gap but another counter: at 200 Hz such a gap would last eight
/// months.
const MAX_STEPS: f64 = 4_294_967_296.0;

/// Judges the counters of the samples of a stream, in bounded memory.
///
/// A sensor counts events of its own, a fixed number of them per sample: the step. The step is the
/// mean of those among the first 31 increments that are within half of the smallest one; it is
/// correct as long as two consecutive samples are anywhere among them. An increment of n steps
/// means n - 1 missing samples. Any other increment, one of more than 2^32 steps, and a counter
/// that goes back is a new start: [`GapEvent::UnknownGap`]. Counters may wrap at 2^32.
///
/// A counter that does not change between two of the first samples counts something slower: it is
/// ignored, and [`GapEvent::CounterInUse`] is never reported.
#[derive(Clone, Debug, Default)]
pub(super) struct SampleCounter {
    first: Option<u64>,
    last: Option<u64>,
    /// Increments before the pending samples; empty once the step is known.
    pending: Vec<Increment>,
    /// 0 for a counter that is ignored.
    step: Option<f64>,
    pub(super) events: VecDeque<GapEvent>,
    /// Whether [`finish`](Self::finish) was called.
    pub(super) has_ended: bool,
}

#[derive(Clone, Copy, Debug)]
enum Increment {
    By(u64),
    Back,
}

impl SampleCounter {
    pub(super) fn push(&mut self, count: u64) {
        let Some(last) = self.last.replace(count) else {
            self.first = Some(count);
            return self.add_sample();
        };
        let increment = increment(last, count);
        if let Some(step) = self.step {
            self.judge(increment, step);
        } else {
            self.pending.push(increment);
            if self.pending.len() == RUN - 1 {
                self.learn_step();
            }
        }
    }

    /// No sample with a counter follows: decides the pending ones.
    pub(super) fn finish(&mut self) {
        self.learn_step();
        self.has_ended = true;
    }

    pub(super) fn summary(&self) -> Option<CounterSummary> {
        let (first, last) = self.first.zip(self.last)?;
        Some(CounterSummary { first, last, step: self.step, is_device_time: false })
    }

    fn learn_step(&mut self) {
        if self.pending.is_empty() {
            return;
        }
        let step = step(&self.pending);
        self.step = Some(step);
        if step > 0.0 {
            self.events.push_back(GapEvent::CounterInUse);
        }
        std::mem::take(&mut self.pending).into_iter().for_each(|increment| self.judge(increment, step));
    }

    fn judge(&mut self, increment: Increment, step: f64) {
        let gap = match increment {
            _ if step == 0.0 => None,
            Increment::By(events) => {
                let steps = (events as f64 / step).round();
                let is_whole = (events as f64 / step - steps).abs() <= TOLERANCE && (1.0..=MAX_STEPS).contains(&steps);
                if is_whole {
                    (steps > 1.0).then(|| GapEvent::Missing(steps as u64 - 1))
                } else {
                    Some(GapEvent::UnknownGap)
                }
            }
            Increment::Back => Some(GapEvent::UnknownGap),
        };
        self.events.extend(gap);
        self.add_sample();
    }

    fn add_sample(&mut self) {
        match self.events.back_mut() {
            Some(GapEvent::Samples(samples)) => *samples += 1,
            _ => self.events.push_back(GapEvent::Samples(1)),
        }
    }
}

/// The counters of the samples of a stream so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CounterSummary {
    /// Counter of the first sample.
    pub first: u64,
    /// Counter of the last sample.
    pub last: u64,
    /// The step of the counter from sample to sample, 0 for a counter that is ignored; `None` while
    /// the step is not known, at least until the second sample.
    pub step: Option<f64>,
    /// Whether the counter is the device time in nanoseconds.
    pub is_device_time: bool,
}

/// The counter of a piece does not continue that of the piece before.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the counter rises by {next_step} per sample, previously by {step}: cut longer pieces, and start each with its place"
)]
pub struct OtherCounter {
    /// Step of the counter in the piece before.
    pub step: f64,
    /// Step of the counter in the next piece.
    pub next_step: f64,
}

impl CounterSummary {
    /// The summary over this piece of a stream and the next, whose first sample is `distance`
    /// places, at least 1, after the last sample of this one.
    ///
    /// # Errors
    /// [`OtherCounter`] where the counters rise by different steps, or the difference between the
    /// pieces does not match the number of places.
    pub fn append(&self, next: &Self, distance: u64) -> Result<Self, OtherCounter> {
        let increment = match self.is_device_time {
            // device times in nanoseconds do not wrap
            true => next.first.checked_sub(self.last).map_or(Increment::Back, Increment::By),
            false => increment(self.last, next.first),
        };
        let between = match increment {
            Increment::By(events) => events as f64 / distance as f64,
            Increment::Back => -1.0,
        };
        let step = self.step.or(next.step).unwrap_or_else(|| between.max(0.0));
        let is_other = |next_step: f64, places: f64| (next_step - step).abs() * places > TOLERANCE * step;
        let places = if step > 0.0 { distance as f64 } else { 0.0 };
        let next_step = next.step.filter(|next_step| is_other(*next_step, 1.0));
        match next_step.or_else(|| is_other(between, places).then_some(between)) {
            Some(next_step) => Err(OtherCounter { step, next_step }),
            None => Ok(Self { last: next.last, step: Some(step), ..*self }),
        }
    }
}

fn increment(last: u64, count: u64) -> Increment {
    const WRAP: u64 = 1 << 32;
    match count.checked_sub(last) {
        Some(events) => Increment::By(events),
        None if last < WRAP && last - count > WRAP / 2 => Increment::By(count + WRAP - last),
        None => Increment::Back,
    }
}

/// Events per sample; 0 for a counter that does not change.
fn step(increments: &[Increment]) -> f64 {
    if increments.iter().any(|increment| matches!(increment, Increment::By(0))) {
        return 0.0;
    }
    let events = increments.iter().filter_map(|increment| match increment {
        Increment::By(events) => Some(*events as f64),
        Increment::Back => None,
    });
    let Some(least) = events.clone().reduce(f64::min) else {
        return 0.0;
    };
    let single: Vec<_> = events.filter(|&events| events <= 1.5 * least).collect();
    single.iter().sum::<f64>() / single.len() as f64
}

impl Encoded for CounterSummary {
    fn encode(&self, out: &mut Vec<u8>) {
        encode_hash(self.first, out);
        encode_hash(self.last, out);
        self.step.encode(out);
        self.is_device_time.encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        Ok(Self {
            first: input.hash()?,
            last: input.hash()?,
            step: Encoded::decode(input)?,
            is_device_time: Encoded::decode(input)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::gap_event::GapEvent::{CounterInUse, Missing, Samples, UnknownGap};
    use super::*;

    fn events(counts: impl IntoIterator<Item = u64>) -> Vec<GapEvent> {
        let mut counter = SampleCounter::default();
        counts.into_iter().for_each(|count| counter.push(count));
        counter.finish();
        std::iter::from_fn(|| counter.events.pop_front()).collect()
    }

    /// The first sample, that the counter is used, and this.
    fn counted(then: impl IntoIterator<Item = GapEvent>) -> Vec<GapEvent> {
        [Samples(1), CounterInUse].into_iter().chain(then).collect()
    }

    #[test]
    fn zero_and_one_sample() {
        assert_eq!(events([]), []);
        assert_eq!(events([7]), [Samples(1)]);
    }

    #[test]
    fn a_counter_that_stays_the_same_is_ignored() {
        assert_eq!(events([5; 100]), [Samples(100)]);
        // two samples per event
        assert_eq!(events((0..100).map(|sample| sample / 2)), [Samples(100)]);
        assert_eq!(events((1..100).rev()), [Samples(99)], "one that goes back from the start");
    }

    #[test]
    fn a_new_start_is_an_unknown_gap_and_the_wrap_is_none() {
        assert_eq!(events((1..=50).chain(1..=50)), counted([Samples(49), UnknownGap, Samples(50)]));
        let wrapped = ((1_u64 << 32) - 3..1 << 32).chain(1..40);
        assert_eq!(events(wrapped), counted([Samples(2), Missing(1), Samples(39)]));
        let half = (1_u64 << 31) - 60;
        assert_eq!(events((half..half + 50).chain([1])), counted([Samples(49), UnknownGap, Samples(1)]), "no wrap");
    }

    #[test]
    fn an_increment_within_a_quarter_step_is_whole() {
        let after = |events_more: u64| events((0..40).map(|sample| 20 * sample).chain([780 + events_more]));
        assert_eq!(after(25), counted([Samples(40)]));
        assert_eq!(after(35), counted([Samples(39), Missing(1), Samples(1)]));
        for no_step in [4, 26, 34] {
            assert_eq!(after(no_step), counted([Samples(39), UnknownGap, Samples(1)]), "{no_step}");
        }
    }

    #[test]
    fn a_leap_that_no_gap_makes_is_a_new_start() {
        // twice, as two such gaps are more than 64 bits hold
        let leaps = (1..=40).chain([u64::MAX - 9, 1, u64::MAX]);
        let starts = std::iter::repeat_n([UnknownGap, Samples(1)], 3).flatten();
        assert_eq!(events(leaps), counted(std::iter::once(Samples(39)).chain(starts)));
        let longest = [Samples(39), Missing((1 << 32) - 1), Samples(1)];
        assert_eq!(events((1..=40).chain([40 + (1 << 32)])), counted(longest));
    }

    #[test]
    fn events_come_as_soon_as_the_step_is_known() {
        let mut counter = SampleCounter::default();
        (0..31).for_each(|count| counter.push(count));
        assert_eq!((counter.events.pop_front(), counter.events.pop_front()), (Some(Samples(1)), None));
        counter.push(31);
        assert_eq!((counter.events.pop_front(), counter.events.pop_front()), (Some(CounterInUse), Some(Samples(31))));
        counter.push(33);
        assert_eq!((counter.events.pop_front(), counter.events.pop_front()), (Some(Missing(1)), Some(Samples(1))));
    }

    proptest! {
        /// Any samples dropped, each sample reported once and in its place.
        #[test]
        fn any_gap_is_counted(
            step in prop_oneof![Just(1_u64), Just(4), Just(20), Just(800)],
            jitter in 0..2_u64,
            dropped in prop::collection::vec(prop::bool::weighted(0.25), 100..400),
        ) {
            let jitter = if step >= 20 { jitter } else { 0 };
            let kept: Vec<usize> =
                dropped.iter().enumerate().filter(|(_, dropped)| !**dropped).map(|(sample, _)| sample).collect();
            let counts = kept.iter().map(|&sample| 1000 + sample as u64 * step + (sample as u64 % 2) * jitter);
            let mut expected = counted([]);
            for pair in kept.windows(2) {
                if pair[1] - pair[0] > 1 {
                    expected.push(Missing((pair[1] - pair[0]) as u64 - 1));
                }
                match expected.last_mut() {
                    Some(Samples(samples)) => *samples += 1,
                    _ => expected.push(Samples(1)),
                }
            }
            prop_assert_eq!(events(counts), expected);
        }
    }

    #[test]
    fn a_counter_continues_if_it_rises_by_as_many_as_there_are_places() {
        let piece = |counts: &[u64]| {
            let mut counter = SampleCounter::default();
            counts.iter().for_each(|count| counter.push(*count));
            counter.finish();
            counter.summary().unwrap()
        };
        let joined = |before: &[u64], next: &[u64], distance| {
            piece(before).append(&piece(next), distance).map(|joined| (joined.first, joined.last, joined.step))
        };
        let other = |step, next_step| Err(OtherCounter { step, next_step });
        assert_eq!(SampleCounter::default().summary(), None);
        assert_eq!(joined(&[5, 25], &[45, 65], 1), Ok((5, 65, Some(20.0))));
        assert_eq!(joined(&[5], &[65], 3), Ok((5, 65, Some(20.0))), "neither knows the step");
        assert_eq!(joined(&[5, 25], &[85], 3), Ok((5, 85, Some(20.0))));
        assert_eq!(joined(&[5], &[85, 105], 4), Ok((5, 105, Some(20.0))));
        assert_eq!(joined(&[(1 << 32) - 10], &[10], 1), Ok(((1 << 32) - 10, 10, Some(20.0))), "it wraps");
        assert_eq!(joined(&[5, 25], &[86], 2), other(20.0, 30.5), "one sample more is missing");
        assert_eq!(joined(&[5, 25], &[45, 95], 1), other(20.0, 50.0), "no two of a piece follow each other");
        assert_eq!(joined(&[5, 25], &[3], 1), other(20.0, -1.0), "it starts anew");
        assert_eq!(joined(&[5, 5], &[5], 1), Ok((5, 5, Some(0.0))), "it counts something slower");
        assert_eq!(joined(&[5], &[5], 1), Ok((5, 5, Some(0.0))));
        assert_eq!(joined(&[5, 25], &[25], 1), other(20.0, 0.0));
        assert_eq!(joined(&[5, 5], &[45, 65], 2), other(0.0, 20.0));
    }
}

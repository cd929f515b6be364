//! Missing samples from the counter that each sample carries.

use super::gap_event::{GapEvent, GapEvents};
use super::sensor_rates::RUN;
use super::whole_steps::{single_step, whole_steps};

/// Judges the counters of the samples of a stream, in bounded memory.
///
/// A sensor counts events of its own, a fixed number per sample: the step, the mean of the increments
/// among the first 31 that are within half of the smallest one. An increment of n steps means n - 1
/// missing samples. Any other increment, one of more than 2^32 steps, and a counter that decreases is a
/// new start: [`GapEvent::UnknownGap`]. Counters may wrap at 2^32. One that does not change between two
/// of the first samples counts slower events: it is ignored.
#[derive(Clone, Debug, Default)]
pub(super) struct SampleCounter {
    last: Option<u64>,
    /// Increments before the pending samples, `None` for a counter that decreased; empty once the
    /// step is known.
    pending: Vec<Option<u64>>,
    /// 0 for an ignored counter.
    step: Option<f64>,
    pub(super) events: GapEvents,
    /// Whether [`finish`](Self::finish) was called.
    pub(super) has_ended: bool,
}

impl SampleCounter {
    pub(super) fn push(&mut self, count: u64) {
        let Some(last) = self.last.replace(count) else { return self.events.push(GapEvent::Samples(1)) };
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

    fn learn_step(&mut self) {
        if self.pending.is_empty() {
            return;
        }
        let increments = self.pending.iter().copied();
        let step = match increments.clone().any(|increment| increment == Some(0)) {
            true => 0.0,
            false => single_step(increments.flatten()).unwrap_or(0.0),
        };
        self.step = Some(step);
        if step > 0.0 {
            self.events.push(GapEvent::CounterInUse);
        }
        std::mem::take(&mut self.pending).into_iter().for_each(|increment| self.judge(increment, step));
    }

    fn judge(&mut self, increment: Option<u64>, step: f64) {
        if step > 0.0 {
            let steps = increment.and_then(|events| whole_steps(events, step));
            self.events.push(steps.map_or(GapEvent::UnknownGap, |steps| GapEvent::Missing(steps - 1)));
        }
        self.events.push(GapEvent::Samples(1));
    }
}

/// `None` if the counter decreased.
fn increment(last: u64, count: u64) -> Option<u64> {
    const WRAP: u64 = 1 << 32;
    let wraps = last < WRAP && last.saturating_sub(count) > WRAP / 2;
    count.checked_sub(last).or_else(|| wraps.then(|| count + WRAP - last))
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
        std::iter::from_fn(|| counter.events.next()).collect()
    }

    /// The first sample, the start of the counter's use, and these events.
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
        // two, because the sum of two such gaps exceeds 64 bits
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
        assert_eq!((counter.events.next(), counter.events.next()), (Some(Samples(1)), None));
        counter.push(31);
        assert_eq!((counter.events.next(), counter.events.next()), (Some(CounterInUse), Some(Samples(31))));
        counter.push(33);
        assert_eq!((counter.events.next(), counter.events.next()), (Some(Missing(1)), Some(Samples(1))));
    }

    proptest! {
        /// Any samples are dropped, and each sample is reported once and in its place.
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
}

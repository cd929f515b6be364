//! Puts messages into the order of their times, within a bounded window; messages of a clock that
//! was set back are kept as they are.

use std::collections::VecDeque;

/// The most pending messages: more than the threads of a driver put out of order. As many messages
/// after them show whether a clock was set back.
const WINDOW: usize = 32;

/// This many messages on each side show that a clock was set back.
const EVIDENCE: usize = 8;

/// Messages in the order of their times; messages of one time in the order of their arrival.
///
/// Where a clock is set back by less than the window, the order of the times would mix messages
/// from before with messages from after the step. The times of recording decide: after such a step
/// every message is recorded later, relative to its own time, by the length of the step; after a
/// message out of order none is.
#[derive(Debug)]
pub(super) struct TimeOrder<T> {
    /// Messages in the order of their arrival.
    ahead: VecDeque<Coming<T>>,
    /// Messages in the order of their times.
    pending: VecDeque<Pending<T>>,
    /// The memory of messages that were taken.
    spare: Vec<T>,
    last: Option<(u64, i64)>,
    /// The delays of the messages last taken, in this stretch.
    delays_ns: VecDeque<i64>,
    /// How often a message arrived too late for its place: what follows stays after what came
    /// before.
    stretch: u64,
    /// How many messages arrived after one of a later time, and were moved to their place.
    pub(super) moved: u64,
    /// How many messages arrived after ones of later times had been taken, or after a clock was set
    /// back.
    pub(super) late: u64,
}

#[derive(Debug)]
struct Coming<T> {
    at_ns: i64,
    /// From the time of the message to that of its recording.
    delay_ns: i64,
    message: T,
}

#[derive(Debug)]
struct Pending<T> {
    /// The stretch and the time of the message.
    place: (u64, i64),
    delay_ns: i64,
    message: T,
}

impl<T: Default> TimeOrder<T> {
    pub(super) fn new() -> Self {
        Self {
            ahead: VecDeque::new(),
            pending: VecDeque::new(),
            spare: Vec::new(),
            last: None,
            delays_ns: VecDeque::new(),
            stretch: 0,
            moved: 0,
            late: 0,
        }
    }

    /// The memory of a message taken before, for the next message.
    pub(super) fn spare(&mut self) -> T {
        self.spare.pop().unwrap_or_default()
    }

    pub(super) fn push(&mut self, at_ns: i64, record_ns: i64, message: T) {
        self.ahead.push_back(Coming { at_ns, delay_ns: record_ns.saturating_sub(at_ns), message });
    }

    /// The first pending message, once there are enough after it; at the `end` any.
    pub(super) fn pop(&mut self, end: bool) -> Option<(i64, &T)> {
        let kept = if end { 0 } else { WINDOW };
        while self.pending.len() <= WINDOW && self.ahead.len() > kept {
            self.hold_next();
        }
        if self.pending.len() <= kept {
            return None;
        }
        let first = self.pending.pop_front()?;
        self.last = Some(first.place);
        if self.delays_ns.len() == WINDOW {
            self.delays_ns.pop_front();
        }
        self.delays_ns.push_back(first.delay_ns);
        self.spare.push(first.message);
        self.spare.last().map(|message| (first.place.1, message))
    }

    /// The time of the latest arrival among the pending messages.
    pub(super) fn latest_ns(&self) -> Option<i64> {
        let pending = || self.pending.back().map(|last| last.place.1);
        self.ahead.back().map(|last| last.at_ns).or_else(pending)
    }

    fn hold_next(&mut self) {
        let Some(next) = self.ahead.pop_front() else { return };
        let is_too_late = self.last.is_some_and(|last| (self.stretch, next.at_ns) < last);
        if is_too_late || self.is_set_back(&next) {
            self.late += 1;
            self.stretch += 1;
            self.delays_ns.clear();
        }
        let place = (self.stretch, next.at_ns);
        let index = self.pending.iter().rposition(|before| before.place <= place).map_or(0, |before| before + 1);
        self.moved += u64::from(index < self.pending.len());
        self.pending.insert(index, Pending { place, delay_ns: next.delay_ns, message: next.message });
    }

    /// Whether the clock of the messages was set back before this one: it and all that follow are
    /// delayed by most of the step, and more than any message before.
    fn is_set_back(&self, next: &Coming<T>) -> bool {
        let latest_ns = self.pending.back().filter(|last| last.place > (self.stretch, next.at_ns));
        let Some(Pending { place: (_, latest_ns), .. }) = latest_ns else { return false };
        let pending =
            self.pending.iter().filter(|pending| pending.place.0 == self.stretch).map(|pending| pending.delay_ns);
        let before = || self.delays_ns.iter().copied().chain(pending.clone());
        let after = || self.ahead.iter().map(|message| message.delay_ns).chain([next.delay_ns]);
        if before().count() < EVIDENCE || after().count() < EVIDENCE {
            return false;
        }
        let (Some(longest), Some(shortest)) = (before().max(), after().min()) else { return false };
        let back_ns = i128::from(*latest_ns) - i128::from(next.at_ns);
        4 * (i128::from(shortest) - i128::from(longest)) > 3 * back_ns
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Messages that are recorded one a tick.
    fn ordered(times: &[i64]) -> (Vec<i64>, u64, u64) {
        ordered_by(times, 1)
    }

    fn ordered_by(times: &[i64], tick: i64) -> (Vec<i64>, u64, u64) {
        let mut order = TimeOrder::<usize>::new();
        let mut out = Vec::new();
        for (place, &at_ns) in times.iter().enumerate() {
            order.push(at_ns, place as i64 * tick, place);
            out.extend(order.pop(false).map(|(at_ns, _)| at_ns));
        }
        while let Some((at_ns, _)) = order.pop(true) {
            out.push(at_ns);
        }
        (out, order.moved, order.late)
    }

    #[test]
    fn only_what_comes_behind_the_window_stays_late() {
        assert_eq!(ordered(&[1, 3, 2, 2, 4]), (vec![1, 2, 2, 3, 4], 2, 0));
        let mut times: Vec<i64> = (0..1000).collect();
        times.push(10);
        let (out, moved, late) = ordered(&times);
        assert_eq!((out.len(), moved, late), (1001, 0, 1));
        // a clock set back for good: the one stretch behind the other
        let set_back: Vec<i64> = (0..500).chain(100..600).collect();
        assert_eq!(ordered(&set_back), (set_back.clone(), 0, 1));
    }

    #[test]
    fn a_clock_that_is_set_back_a_little_mixes_nothing() {
        for back in 2..100 {
            let set_back: Vec<i64> = (0..500).chain(500 - back..1000).collect();
            assert_eq!(ordered(&set_back), (set_back.clone(), 0, 1), "{back}");
        }
        // blocks that changed places, and one message that is late, of a clock that drifts
        for late in 1..WINDOW as i64 {
            for first in [0, 1, 40, 470 - 2 * late] {
                let end = 500;
                let blocks = (0..first).chain(first + late..first + 2 * late).chain(first..first + late);
                let blocks: Vec<i64> = blocks.chain(first + 2 * late..end).collect();
                let one = (0..first).chain(first + 1..=first + late).chain([first]).chain(first + late + 1..end);
                for times in [blocks, one.collect()] {
                    let drifting: Vec<i64> = times.iter().map(|time| time * 999).collect();
                    let sorted: Vec<i64> = (0..end).map(|time| time * 999).collect();
                    let (out, moved, late_ones) = ordered_by(&drifting, 1000);
                    assert_eq!((out, late_ones), (sorted, 0), "{late} at {first}");
                    assert!(moved >= 1);
                }
            }
        }
    }

    #[test]
    fn a_delay_no_longer_than_one_before_is_no_clock_that_is_set_back() {
        // all from the 130th on are delayed by 15
        let mut times: Vec<i64> = (0..130).chain(115..500).collect();
        assert_eq!(ordered(&times).2, 1);
        // and one that was taken before by 20
        times[100] = 80;
        let mut sorted = times.clone();
        sorted.sort_unstable();
        let (out, _, late) = ordered(&times);
        assert_eq!((out, late), (sorted, 0));
    }

    proptest! {
        #[test]
        fn within_the_window_all_are_sorted(jitter in prop::collection::vec(0..WINDOW as i64 / 2, 1..2000)) {
            let times: Vec<i64> = jitter.iter().enumerate().map(|(place, jitter)| place as i64 + jitter).collect();
            let mut sorted = times.clone();
            sorted.sort_unstable();
            prop_assert_eq!(ordered(&times).0, sorted);
        }
    }
}

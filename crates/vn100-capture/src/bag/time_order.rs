//! Puts messages into the order of their times, within a bounded window.

use std::collections::VecDeque;

/// The most pending messages: threads of a driver put fewer out of order.
const WINDOW: usize = 32;

/// Messages in the order of their times; messages of one time in the order of their arrival.
#[derive(Debug)]
pub(super) struct TimeOrder<T> {
    /// Messages in order: the stretch and the time of each.
    pending: VecDeque<((u64, i64), T)>,
    /// The memory of messages that were taken.
    spare: Vec<T>,
    last: Option<(u64, i64)>,
    /// The time of the latest arrival.
    latest_ns: Option<i64>,
    /// The number of messages that arrived too late for their place; each of them and all later
    /// ones stay after those before.
    stretch: u64,
    /// Messages that arrived after one of a later time and were moved to their place.
    pub(super) moved: u64,
    /// Messages that arrived after messages of later times had been taken, as after a clock was set
    /// back.
    pub(super) late: u64,
}

impl<T: Default> TimeOrder<T> {
    pub(super) fn new() -> Self {
        Self { pending: VecDeque::new(), spare: Vec::new(), last: None, latest_ns: None, stretch: 0, moved: 0, late: 0 }
    }

    /// The memory of a message taken before, for the next message.
    pub(super) fn spare(&mut self) -> T {
        self.spare.pop().unwrap_or_default()
    }

    /// Adds a message. Without a time of its own it is placed after those before it, the first
    /// message at `record_ns`.
    pub(super) fn push(&mut self, at_ns: Option<i64>, record_ns: i64, message: T) {
        let at_ns = at_ns.or(self.latest_ns).unwrap_or(record_ns);
        self.latest_ns = Some(at_ns);
        if self.last.is_some_and(|last| (self.stretch, at_ns) < last) {
            self.late += 1;
            self.stretch += 1;
        }
        let place = (self.stretch, at_ns);
        let index = self.pending.iter().rposition(|(before, _)| *before <= place).map_or(0, |before| before + 1);
        self.moved += u64::from(index < self.pending.len());
        self.pending.insert(index, (place, message));
    }

    /// The first pending message, once enough messages follow it; at the `end` without this condition.
    pub(super) fn pop(&mut self, end: bool) -> Option<(i64, &T)> {
        if self.pending.len() <= if end { 0 } else { WINDOW } {
            return None;
        }
        let (place, message) = self.pending.pop_front()?;
        self.last = Some(place);
        self.spare.push(message);
        self.spare.last().map(|message| (place.1, message))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn ordered(times: &[i64]) -> (Vec<i64>, u64, u64) {
        let mut order = TimeOrder::<usize>::new();
        let mut out = Vec::new();
        for (place, &at_ns) in times.iter().enumerate() {
            order.push(Some(at_ns), 0, place);
            out.extend(order.pop(false).map(|(at_ns, _)| at_ns));
        }
        while let Some((at_ns, _)) = order.pop(true) {
            out.push(at_ns);
        }
        (out, order.moved, order.late)
    }

    #[test]
    fn only_messages_after_the_window_stay_late() {
        assert_eq!(ordered(&[1, 3, 2, 2, 4]), (vec![1, 2, 2, 3, 4], 2, 0));
        let mut times: Vec<i64> = (0..1000).collect();
        times.push(10);
        let (out, moved, late) = ordered(&times);
        assert_eq!((out.len(), moved, late), (1001, 0, 1));
        // a clock set back permanently gives two stretches in sequence
        let set_back: Vec<i64> = (0..500).chain(100..600).collect();
        assert_eq!(ordered(&set_back), (set_back.clone(), 0, 1));
    }

    #[test]
    fn a_message_without_a_time_stays_in_its_place() {
        let mut order = TimeOrder::<usize>::new();
        [(None, 7), (Some(20), 21), (None, 22), (Some(30), 31)]
            .into_iter()
            .enumerate()
            .for_each(|(place, (at_ns, record_ns))| order.push(at_ns, record_ns, place));
        let mut out = Vec::new();
        while let Some((at_ns, place)) = order.pop(true) {
            out.push((at_ns, *place));
        }
        assert_eq!(out, [(7, 0), (20, 1), (20, 2), (30, 3)]);
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

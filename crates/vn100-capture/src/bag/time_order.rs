//! Puts messages in the order of their times, within a bounded window.

use std::collections::VecDeque;

/// Messages that are held at most: more than a second of any sensor that is not read by itself.
const WINDOW: usize = 256;

/// Messages in the order of their times; those of one time in the order they came.
#[derive(Debug)]
pub(super) struct TimeOrder<T> {
    held: VecDeque<(i64, T)>,
    /// Storage of those that were taken.
    spare: Vec<T>,
    last_ns: Option<i64>,
    /// How many came behind one of a later time, and found their place.
    pub(super) moved: u64,
    /// How many came so late that those of later times had been taken.
    pub(super) late: u64,
}

impl<T: Default> TimeOrder<T> {
    pub(super) fn new() -> Self {
        Self { held: VecDeque::new(), spare: Vec::new(), last_ns: None, moved: 0, late: 0 }
    }

    /// Room for one more, which holds what one taken before did.
    pub(super) fn spare(&mut self) -> T {
        self.spare.pop().unwrap_or_default()
    }

    pub(super) fn push(&mut self, at_ns: i64, message: T) {
        let place = self.held.iter().rposition(|(before_ns, _)| *before_ns <= at_ns).map_or(0, |before| before + 1);
        if self.last_ns.is_some_and(|last_ns| at_ns < last_ns) {
            self.late += 1;
        } else if place < self.held.len() {
            self.moved += 1;
        }
        self.held.insert(place, (at_ns, message));
    }

    /// The first of those held, once there are enough behind it; any at the `end`.
    pub(super) fn pop(&mut self, end: bool) -> Option<(i64, &T)> {
        if self.held.len() <= if end { 0 } else { WINDOW } {
            return None;
        }
        let (at_ns, message) = self.held.pop_front()?;
        self.last_ns = Some(at_ns);
        self.spare.push(message);
        self.spare.last().map(|message| (at_ns, message))
    }

    /// The latest time of those held.
    pub(super) fn latest_ns(&self) -> Option<i64> {
        self.held.back().map(|(at_ns, _)| *at_ns)
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
            order.push(at_ns, place);
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

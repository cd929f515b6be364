//! Puts messages in the order of their times, within a bounded window.

use std::collections::VecDeque;

/// Messages that are held at most: more than threads of a driver put out of order, and fewer than a
/// clock that is set back repeats.
const WINDOW: usize = 32;

/// Messages in the order of their times; those of one time in the order they came.
#[derive(Debug)]
pub(super) struct TimeOrder<T> {
    held: VecDeque<Held<T>>,
    /// Storage of those that were taken.
    spare: Vec<T>,
    last: Option<(u64, i64)>,
    /// How often a message came too late for its place: what follows keeps behind what came before.
    stretch: u64,
    /// How many came behind one of a later time, and found their place.
    pub(super) moved: u64,
    /// How many came so late that those of later times had been taken.
    pub(super) late: u64,
}

#[derive(Debug)]
struct Held<T> {
    /// Its stretch, and its time.
    place: (u64, i64),
    message: T,
}

impl<T: Default> TimeOrder<T> {
    pub(super) fn new() -> Self {
        Self { held: VecDeque::new(), spare: Vec::new(), last: None, stretch: 0, moved: 0, late: 0 }
    }

    /// Room for one more, which holds what one taken before did.
    pub(super) fn spare(&mut self) -> T {
        self.spare.pop().unwrap_or_default()
    }

    pub(super) fn push(&mut self, at_ns: i64, message: T) {
        if self.last.is_some_and(|last| (self.stretch, at_ns) < last) {
            self.late += 1;
            self.stretch += 1;
        }
        let place = (self.stretch, at_ns);
        let index = self.held.iter().rposition(|before| before.place <= place).map_or(0, |before| before + 1);
        self.moved += u64::from(index < self.held.len());
        self.held.insert(index, Held { place, message });
    }

    /// The first of those held, once there are enough behind it; any at the `end`.
    pub(super) fn pop(&mut self, end: bool) -> Option<(i64, &T)> {
        if self.held.len() <= if end { 0 } else { WINDOW } {
            return None;
        }
        let first = self.held.pop_front()?;
        self.last = Some(first.place);
        self.spare.push(first.message);
        self.spare.last().map(|message| (first.place.1, message))
    }

    /// The latest time of those held.
    pub(super) fn latest_ns(&self) -> Option<i64> {
        self.held.back().map(|last| last.place.1)
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
        // a clock set back for good: the one stretch behind the other
        let set_back: Vec<i64> = (0..500).chain(100..600).collect();
        assert_eq!(ordered(&set_back), (set_back.clone(), 0, 1));
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

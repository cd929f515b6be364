//! Lost lines of a stream that counts: a counter in each line says exactly how many are missing
//! before it.

use std::collections::VecDeque;

/// Increments that tell how far the counter goes from line to line.
const LEARNED_FROM: usize = 31;

/// An increment within so many steps of a whole number of steps is that number.
const TOLERANCE: f64 = 0.25;

/// A loss of more lines than this is no loss but another counter: 200 lines a second take eight
/// months to it.
const MOST_MISSING: f64 = 4_294_967_296.0;

/// What a [`LineCounter`] says of the lines pushed, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counted {
    /// So many lines, nothing missing between them or before the first.
    Lines(u64),
    /// So many lines are missing here.
    Missing(u64),
    /// The counter does not go on from where it was: nobody knows how many lines are missing here.
    Restart,
}

/// Judges the counters of a stream's lines; streaming, in bounded memory.
///
/// A sensor counts events of its own, a fixed number of them per line. That number, the step, is
/// the mean of those among the first 31 increments that are within half of the smallest one; the
/// first 32 lines are held until it is known. So it is right as long as a line follows the one
/// before it anywhere among them. An increment of n steps, within a quarter step, is n - 1 missing
/// lines; any other one, one beyond 2^32 missing lines, or a counter that goes back, is a restart.
/// Counters may wrap at 2^32.
///
/// A counter that stands still from one line to the next, always or at times, counts something
/// slower than the lines: then no line is missing as far as it knows, see
/// [`is_counting`](Self::is_counting).
///
/// ```
/// use imu_noise::{Counted, LineCounter};
///
/// let mut counter = LineCounter::new();
/// // 800 events a second, 40 lines a second; the lines at 60 and 80 are lost
/// for count in [20, 40, 100, 120, 140] {
///     counter.push(count);
/// }
/// counter.finish();
/// let told: Vec<_> = std::iter::from_fn(|| counter.poll()).collect();
/// assert_eq!(told, [Counted::Lines(2), Counted::Missing(2), Counted::Lines(3)]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct LineCounter {
    last: Option<u64>,
    /// Increments of the lines held; none once the step is known.
    held: Vec<Increment>,
    step: Option<f64>,
    told: VecDeque<Counted>,
}

#[derive(Clone, Copy, Debug)]
enum Increment {
    By(u64),
    Back,
}

impl LineCounter {
    /// A counter that has seen no line.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the next line and its counter.
    pub fn push(&mut self, count: u64) {
        let Some(last) = self.last.replace(count) else {
            self.tell_line();
            return;
        };
        let increment = increment(last, count);
        if self.step.is_some() {
            self.judge(increment);
        } else {
            self.held.push(increment);
            if self.held.len() == LEARNED_FROM {
                self.finish();
            }
        }
    }

    /// Nothing follows: decides on the lines still held.
    pub fn finish(&mut self) {
        let held = std::mem::take(&mut self.held);
        if self.step.is_none() && !held.is_empty() {
            self.step = Some(step(&held));
        }
        held.into_iter().for_each(|increment| self.judge(increment));
    }

    /// The next lines or losses.
    pub fn poll(&mut self) -> Option<Counted> {
        self.told.pop_front()
    }

    /// Whether the counter moves; `None` until the step is known.
    #[must_use]
    pub fn is_counting(&self) -> Option<bool> {
        self.step.map(|step| step > 0.0)
    }

    fn judge(&mut self, increment: Increment) {
        let step = self.step.unwrap_or_default();
        let verdict = match increment {
            _ if step == 0.0 => None,
            Increment::By(events) => {
                let steps = (events as f64 / step).round();
                let whole = (events as f64 / step - steps).abs() <= TOLERANCE && (1.0..=MOST_MISSING).contains(&steps);
                if whole { (steps > 1.0).then_some(Counted::Missing(steps as u64 - 1)) } else { Some(Counted::Restart) }
            }
            Increment::Back => Some(Counted::Restart),
        };
        self.told.extend(verdict);
        self.tell_line();
    }

    fn tell_line(&mut self) {
        match self.told.back_mut() {
            Some(Counted::Lines(lines)) => *lines += 1,
            _ => self.told.push_back(Counted::Lines(1)),
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

/// Events from line to line; 0 for a counter that stands still.
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn told(counts: impl IntoIterator<Item = u64>) -> Vec<Counted> {
        let mut counter = LineCounter::new();
        counts.into_iter().for_each(|count| counter.push(count));
        counter.finish();
        std::iter::from_fn(|| counter.poll()).collect()
    }

    #[test]
    fn nothing_and_one_line() {
        assert_eq!(told([]), []);
        assert_eq!(told([7]), [Counted::Lines(1)]);
    }

    #[test]
    fn a_counter_that_stands_still_counts_nothing() {
        let mut counter = LineCounter::new();
        (0..40).for_each(|_| counter.push(11_912));
        assert_eq!(counter.is_counting(), Some(false));
        assert_eq!(told([5; 100]), [Counted::Lines(100)]);
        // two lines to each event
        assert_eq!(told((0..100).map(|line| line / 2)), [Counted::Lines(100)]);
    }

    #[test]
    fn a_restart_is_no_count_and_the_wrap_is_none() {
        let restarted = (1..=50).chain(1..=50);
        assert_eq!(told(restarted), [Counted::Lines(50), Counted::Restart, Counted::Lines(50)]);
        let wrapped = ((1_u64 << 32) - 3..1 << 32).chain(1..40);
        assert_eq!(told(wrapped), [Counted::Lines(3), Counted::Missing(1), Counted::Lines(39)]);
    }

    #[test]
    fn a_leap_that_no_loss_makes_is_a_restart() {
        // twice, as two such losses are more than 64 bits hold
        let leaps = (1..=40).chain([u64::MAX - 9, 1, u64::MAX]);
        let restarts = std::iter::repeat_n([Counted::Restart, Counted::Lines(1)], 3).flatten();
        assert_eq!(told(leaps), std::iter::once(Counted::Lines(40)).chain(restarts).collect::<Vec<_>>());
        let longest = [Counted::Lines(40), Counted::Missing((1 << 32) - 1), Counted::Lines(1)];
        assert_eq!(told((1..=40).chain([40 + (1 << 32)])), longest);
    }

    #[test]
    fn lines_are_told_as_soon_as_the_step_is_known() {
        let mut counter = LineCounter::new();
        (0..31).for_each(|count| counter.push(count));
        assert_eq!((counter.poll(), counter.poll()), (Some(Counted::Lines(1)), None));
        counter.push(31);
        assert_eq!(counter.poll(), Some(Counted::Lines(31)));
        counter.push(33);
        assert_eq!((counter.poll(), counter.poll()), (Some(Counted::Missing(1)), Some(Counted::Lines(1))));
    }

    proptest! {
        /// Any lines lost, each line of the truth told once and in its place.
        #[test]
        fn any_loss_is_counted(
            step in prop_oneof![Just(1_u64), Just(4), Just(20), Just(800)],
            jitter in 0..2_u64,
            lost in prop::collection::vec(prop::bool::weighted(0.25), 100..400),
        ) {
            let jitter = if step >= 20 { jitter } else { 0 };
            let kept: Vec<usize> = lost.iter().enumerate().filter(|(_, lost)| !**lost).map(|(line, _)| line).collect();
            let counts = kept.iter().map(|&line| 1000 + line as u64 * step + (line as u64 % 2) * jitter);
            let mut expected = Vec::new();
            for (index, &line) in kept.iter().enumerate() {
                let missing = if index == 0 { 0 } else { line - kept[index - 1] - 1 };
                if missing > 0 {
                    expected.push(Counted::Missing(missing as u64));
                }
                match expected.last_mut() {
                    Some(Counted::Lines(lines)) => *lines += 1,
                    _ => expected.push(Counted::Lines(1)),
                }
            }
            prop_assert_eq!(told(counts), expected);
        }
    }
}

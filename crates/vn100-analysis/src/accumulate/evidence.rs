//! What is known of the place of each line: by the counter it carries, else by when it arrived.

use std::time::Duration;

use imu_noise::{Counted, LineCounter, NominalRate, Placed, Refusal, Timebase, TimebaseSummary};

/// All evidence of one stream, line by line. A line has its place once every evidence has placed
/// it; what is missing, the counter says where there is one that counts.
#[derive(Debug)]
pub(crate) struct Evidence {
    arrivals: Option<Timebase>,
    counter: Option<LineCounter>,
    /// Whether the next line may still carry a counter.
    counter_goes_on: bool,
    /// Whether the counter was told to count.
    counting: bool,
    lines: u64,
    given: u64,
    /// Lines that have their place by their arrival, and by their counter, and were not given out;
    /// `u64::MAX` where that is no evidence.
    by_arrival: u64,
    by_counter: u64,
}

/// What comes next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Verdict {
    /// So many lines with nothing missing before or between them.
    Lines(u64),
    /// So many are missing here.
    Missing(u64),
    /// An unknown number is missing here.
    Unknown,
    /// The rate that the lines that follow stand for; their stamps tell what is missing.
    Rate(NominalRate),
    /// From here on the stamps tell nothing: why.
    Refused(Refusal),
    /// From here on the lines come at another rate; what the stamps said until then.
    RateChanged { from_hz: f64, to_hz: f64, until: TimebaseSummary },
    /// From here on a counter tells what is missing.
    Counting,
}

impl Evidence {
    /// `arrivals` of a stream with stamps.
    pub(crate) fn new(arrivals: Option<Timebase>) -> Self {
        Self {
            arrivals,
            counter: None,
            counter_goes_on: false,
            counting: false,
            lines: 0,
            given: 0,
            by_arrival: 0,
            by_counter: 0,
        }
    }

    /// Adds the next line: when it arrived, and its counter. The first line decides whether there
    /// are counters; where they end, they have ended for good.
    pub(crate) fn push(&mut self, at: Duration, count: Option<u64>) {
        if self.lines == 0 && count.is_some() {
            (self.counter, self.counter_goes_on) = (Some(LineCounter::new()), true);
        }
        self.lines += 1;
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.push(at);
        }
        match (&mut self.counter, count) {
            (Some(counter), Some(count)) if self.counter_goes_on => counter.push(count),
            (Some(counter), _) if self.counter_goes_on => {
                counter.finish();
                self.counter_goes_on = false;
            }
            _ => {}
        }
    }

    /// The sensor says its rate.
    pub(crate) fn know_rate(&mut self, rate_hz: f64) {
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.know_rate(rate_hz);
        }
    }

    /// Nothing follows.
    pub(crate) fn finish(&mut self) {
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.finish();
        }
        if let Some(counter) = &mut self.counter {
            counter.finish();
        }
    }

    /// The next verdict that is sure.
    pub(crate) fn next(&mut self) -> Option<Verdict> {
        loop {
            if self.by_counter == 0
                && let Some(verdict) = self.next_by_counter()?
            {
                return Some(verdict);
            }
            if self.by_arrival == 0
                && let Some(verdict) = self.next_by_arrival()?
            {
                return Some(verdict);
            }
            let lines = self.by_arrival.min(self.by_counter).min(self.lines - self.given);
            if lines > 0 {
                self.given += lines;
                for left in [&mut self.by_arrival, &mut self.by_counter] {
                    *left -= if *left == u64::MAX { 0 } else { lines };
                }
                return Some(Verdict::Lines(lines));
            }
            if self.lines == self.given {
                return None;
            }
        }
    }

    /// What the stamps say; `None` without stamps.
    pub(crate) fn summary(&self) -> Option<TimebaseSummary> {
        self.arrivals.as_ref().map(Timebase::summary)
    }

    /// Refills `by_counter`. `None` where the next line must wait.
    fn next_by_counter(&mut self) -> Option<Option<Verdict>> {
        let Some(counter) = &mut self.counter else {
            self.by_counter = u64::MAX;
            return Some(None);
        };
        if !self.counting && counter.is_counting() == Some(true) {
            self.counting = true;
            return Some(Some(Verdict::Counting));
        }
        Some(match counter.poll() {
            Some(Counted::Lines(lines)) => {
                self.by_counter = lines;
                None
            }
            Some(Counted::Missing(missing)) => Some(Verdict::Missing(missing)),
            Some(Counted::Restart) => Some(Verdict::Unknown),
            None if self.counter_goes_on => return None,
            None => {
                (self.counter, self.counting) = (None, false);
                None
            }
        })
    }

    /// Refills `by_arrival`. `None` where the next line must wait.
    fn next_by_arrival(&mut self) -> Option<Option<Verdict>> {
        let Some(arrivals) = &mut self.arrivals else {
            self.by_arrival = u64::MAX;
            return Some(None);
        };
        Some(match arrivals.poll()? {
            Placed::Lines(lines) => {
                self.by_arrival = lines;
                None
            }
            // the counter has said it
            Placed::Gap { .. } if self.counting => None,
            Placed::Gap { missing } => Some(Verdict::Missing(missing)),
            Placed::Rate(nominal) => Some(Verdict::Rate(nominal)),
            Placed::Refused(refusal) => Some(Verdict::Refused(refusal)),
            Placed::RateChanged { from_hz, to_hz, until } => Some(Verdict::RateChanged { from_hz, to_hz, until }),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{
        Verdict::{Counting, Lines, Missing, Rate, Unknown},
        *,
    };

    /// The verdicts on lines, each with its arrival in ms, if the stream has stamps, and its
    /// counter.
    fn verdicts(stamped: bool, lines: impl IntoIterator<Item = (u64, Option<u64>)>) -> Vec<Verdict> {
        let mut evidence = Evidence::new(stamped.then(|| Timebase::new(&[40.0])));
        let mut verdicts = Vec::new();
        let mut take = |evidence: &mut Evidence| {
            while let Some(verdict) = evidence.next() {
                match (verdicts.last_mut(), verdict) {
                    (Some(Lines(before)), Lines(lines)) => *before += lines,
                    _ => verdicts.push(verdict),
                }
            }
        };
        for (at_ms, count) in lines {
            evidence.push(Duration::from_millis(at_ms), count);
            take(&mut evidence);
        }
        evidence.finish();
        take(&mut evidence);
        verdicts
    }

    /// Lines of a 40 Hz stream, without those lost, with a counter of 20 events a line.
    fn kept(lost: std::ops::Range<u64>) -> impl Iterator<Item = (u64, u64)> + Clone {
        (0..500).filter(move |line| !lost.contains(line)).map(|line| (25 * line, 20 * line + 7))
    }

    #[test]
    fn the_counter_tells_what_is_missing_and_the_stamps_the_rate() {
        let rate = Rate(NominalRate::Snapped(40.0));
        let lost = 300..305;
        let counted = kept(lost.clone()).map(|(at_ms, count)| (at_ms, Some(count)));
        assert_eq!(verdicts(true, counted.clone()), [rate, Lines(1), Counting, Lines(299), Missing(5), Lines(195)]);
        assert_eq!(verdicts(false, counted), [Lines(1), Counting, Lines(299), Missing(5), Lines(195)]);
        let stamped = kept(lost).map(|(at_ms, _)| (at_ms, None));
        assert_eq!(verdicts(true, stamped), [rate, Lines(300), Missing(5), Lines(195)]);
    }

    #[test]
    fn arrivals_that_lie_do_not_overrule_a_counter() {
        // a pause of the host: the lines behind it are late for good
        let late = kept(0..0).map(|(at_ms, count)| (if count > 6000 { at_ms + 500 } else { at_ms }, Some(count)));
        assert!(!verdicts(true, late).iter().any(|verdict| matches!(verdict, Missing(_))));
    }

    #[test]
    fn a_counter_that_stands_still_leaves_it_to_the_stamps() {
        let stuck = kept(300..305).map(|(at_ms, _)| (at_ms, Some(11_912)));
        let found = verdicts(true, stuck);
        assert!(found.contains(&Missing(5)) && !found.contains(&Counting), "{found:?}");
    }

    #[test]
    fn where_the_counters_end_the_stamps_go_on() {
        let ends = kept(300..305).map(|(at_ms, count)| (at_ms, (count < 4000).then_some(count)));
        let found = verdicts(true, ends);
        assert_eq!(found.last_chunk(), Some(&[Missing(5), Lines(195)]));
        let ends = kept(300..305).map(|(at_ms, count)| (at_ms, (count < 4000).then_some(count)));
        assert_eq!(verdicts(false, ends), [Lines(1), Counting, Lines(494)]);
    }

    #[test]
    fn a_counter_that_starts_anew_leaves_an_unknown_gap() {
        let restarted = (0..100).chain(3..50).map(|count| (0, Some(count)));
        assert_eq!(verdicts(false, restarted), [Lines(1), Counting, Lines(99), Unknown, Lines(47)]);
    }
}

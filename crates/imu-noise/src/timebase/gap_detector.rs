//! The time base of a stream: its missing samples, from counters, arrival times or device time.

use std::time::Duration;

use super::arrival_times::ArrivalTimes;
use super::device_clock::{ClockAfterOutage, DeviceClock};
use super::gap_event::{GapEvent, TimebaseSummary};
use super::sample_counter::SampleCounter;

/// Finds the gaps of one stream, sample by sample, in bounded memory and without a clock of its
/// own.
///
/// Every added sample is reported once, in order, as soon as it is decided whether samples are missing
/// before it. If samples carry device times, only these decide. Otherwise a counter decides, because it
/// is exact, and arrival times only show the rate; after its end, or without one, arrival times decide.
/// No stamp is an error: stamps that are no time base are [refused](GapEvent::Refused).
///
/// ```
/// use std::time::Duration;
/// use imu_noise::timebase::{GapDetector, GapEvent, NominalRate};
///
/// let mut detector = GapDetector::new(&[10.0, 40.0, 100.0], None);
/// for sample in (0..500).filter(|sample| !(300..305).contains(sample)) {
///     detector.push(Duration::from_millis(25 * sample), None);
/// }
/// detector.finish();
///
/// let events: Vec<_> = std::iter::from_fn(|| detector.poll()).collect();
/// let rate = GapEvent::Rate(NominalRate::Snapped(40.0));
/// assert_eq!(events, [rate, GapEvent::Samples(300), GapEvent::Missing(5), GapEvent::Samples(195)]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct GapDetector {
    arrivals: Option<ArrivalTimes>,
    counter: Option<SampleCounter>,
    counter_in_use: bool,
    /// Used in place of counter and arrival times; `None` without device times.
    device_clock: Option<Box<DeviceClock>>,
    /// Number of added samples; `reported` is the number of reported ones.
    pushed: u64,
    reported: u64,
    /// Number of decided samples that are not reported yet, by arrival times and by counter;
    /// `u64::MAX` without stamps or counters.
    by_arrival: u64,
    by_counter: u64,
}

impl GapDetector {
    /// A detector for a stream with arrival stamps, of a sensor with these rates in Hz; empty for any
    /// sensor, whose rate is measured. `known_hz`, which need not be listed, is used from the first sample
    /// on: slower arrivals are dropped samples, unless they are even, and faster ones are
    /// [refused](crate::timebase::Refusal::OtherRate). It is ignored if it is not finite and positive.
    pub fn new(rates_hz: &'static [f64], known_hz: Option<f64>) -> Self {
        let known_hz = known_hz.filter(|hz| is_rate(*hz));
        Self { arrivals: Some(ArrivalTimes::new(rates_hz, known_hz)), ..Self::without_stamps() }
    }

    /// A detector for a stream without arrival stamps: only counters show missing samples.
    pub fn without_stamps() -> Self {
        Self::default()
    }

    /// Sets the rate in Hz that the sensor reports, for the samples that are still pending and all
    /// later ones. It gives way to even arrivals at another listed rate, which is then
    /// [`NominalRate::Snapped`](crate::timebase::NominalRate::Snapped). No effect after a
    /// [rate](GapEvent::Rate) or a refusal was reported, and without listed rates.
    pub fn set_reported_rate(&mut self, reported_hz: f64) {
        if let (Some(arrivals), true) = (&mut self.arrivals, is_rate(reported_hz)) {
            arrivals.set_reported_rate(reported_hz);
        }
    }

    /// Adds the next sample: its arrival time since any fixed origin, which samples of one read may
    /// share, and its counter. The first sample decides whether there are counters; those that have
    /// ended do not begin again.
    pub fn push(&mut self, at: Duration, count: Option<u64>) {
        if self.pushed == 0 && count.is_some() {
            self.counter = Some(SampleCounter::default());
        }
        self.pushed += 1;
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.push(at);
        }
        if let Some(counter) = self.counter.as_mut().filter(|counter| !counter.has_ended) {
            match count {
                Some(count) => counter.push(count),
                None => counter.finish(),
            }
        }
    }

    /// Adds the next sample of a stream in which all samples carry their device time, in nanoseconds since
    /// the sensor started; arrival times show the offset of the clocks alone.
    pub fn push_device_time(&mut self, device_ns: u64, at: Option<Duration>) {
        self.device_clock.get_or_insert_with(Box::default).push(device_ns, at);
    }

    /// Whether the samples carry device times.
    pub const fn has_device_time(&self) -> bool {
        self.device_clock.is_some()
    }

    /// The state of the sensor's clock if the first sample after an outage has this device time in
    /// nanoseconds and this arrival time. Unless the clock [kept running](ClockAfterOutage::RunsOn), a new
    /// detector is needed. Must be called after [`finish`](Self::finish).
    pub fn after_outage(&mut self, device_ns: Option<u64>, at: Duration) -> ClockAfterOutage {
        match (&mut self.device_clock, device_ns) {
            (Some(clock), Some(device_ns)) => clock.after_outage(device_ns, at),
            _ => ClockAfterOutage::Unknown,
        }
    }

    /// Restarts the statistics of the intervals between arrivals; the time base continues.
    pub fn restart_intervals(&mut self) {
        if let Some(clock) = &mut self.device_clock {
            clock.restart_intervals();
        }
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.restart_intervals();
        }
    }

    /// No sample follows: decides the pending samples, which [`poll`](Self::poll) then reports.
    pub fn finish(&mut self) {
        if let Some(clock) = &mut self.device_clock {
            clock.finish();
        }
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.finish();
        }
        if let Some(counter) = &mut self.counter {
            counter.finish();
        }
    }

    /// The next decided event; `None` if it depends on later samples.
    pub fn poll(&mut self) -> Option<GapEvent> {
        if let Some(clock) = &mut self.device_clock {
            return clock.events.next();
        }
        loop {
            if self.by_counter == 0 {
                match self.counter.as_mut().map(|counter| (counter.events.next(), counter.has_ended)) {
                    None => self.by_counter = u64::MAX,
                    Some((Some(GapEvent::Samples(samples)), _)) => self.by_counter = samples,
                    Some((Some(event), _)) => {
                        self.counter_in_use |= event == GapEvent::CounterInUse;
                        return Some(event);
                    }
                    Some((None, true)) => (self.by_counter, self.counter_in_use) = (u64::MAX, false),
                    Some((None, false)) => return None,
                }
            } else if self.by_arrival == 0 {
                match self.arrivals.as_mut().map(|arrivals| arrivals.events.next()) {
                    None => self.by_arrival = u64::MAX,
                    Some(Some(GapEvent::Samples(samples))) => self.by_arrival = samples,
                    Some(Some(GapEvent::Missing(_))) if self.counter_in_use => {}
                    Some(event) => return event,
                }
            } else {
                let samples = self.by_arrival.min(self.by_counter).min(self.pushed - self.reported);
                self.reported += samples;
                for left in [&mut self.by_arrival, &mut self.by_counter] {
                    *left -= if *left == u64::MAX { 0 } else { samples };
                }
                return (samples > 0).then_some(GapEvent::Samples(samples));
            }
        }
    }

    /// The summary of the arrival times so far; `None` without stamps.
    pub fn summary(&self) -> Option<TimebaseSummary> {
        if let Some(clock) = &self.device_clock {
            return clock.summary();
        }
        self.arrivals.as_ref().map(ArrivalTimes::summary)
    }
}

fn is_rate(hz: f64) -> bool {
    hz.is_finite() && hz > 0.0
}

#[cfg(test)]
mod tests {
    use super::super::gap_event::{
        GapEvent::{CounterInUse, Missing, Rate, Samples, UnknownGap},
        NominalRate,
    };
    use super::*;

    /// The events of samples, each with its arrival in ms, if the stream has stamps, and its
    /// counter.
    fn events(stamped: bool, samples: impl IntoIterator<Item = (u64, Option<u64>)>) -> Vec<GapEvent> {
        let mut detector = if stamped { GapDetector::new(&[40.0], None) } else { GapDetector::without_stamps() };
        let mut events = Vec::new();
        let mut poll = |detector: &mut GapDetector| {
            while let Some(event) = detector.poll() {
                match (events.last_mut(), event) {
                    (Some(Samples(before)), Samples(samples)) => *before += samples,
                    (_, event) => events.push(event),
                }
            }
        };
        for (at_ms, count) in samples {
            detector.push(Duration::from_millis(at_ms), count);
            poll(&mut detector);
        }
        detector.finish();
        poll(&mut detector);
        events
    }

    /// Samples of a 40 Hz stream, without the dropped ones, with a counter of 20 events per sample.
    fn kept(dropped: std::ops::Range<u64>) -> impl Iterator<Item = (u64, u64)> + Clone {
        (0..500).filter(move |sample| !dropped.contains(sample)).map(|sample| (25 * sample, 20 * sample + 7))
    }

    #[test]
    fn the_counter_decides_and_the_stamps_show_the_rate() {
        let rate = Rate(NominalRate::Snapped(40.0));
        let counted = kept(300..305).map(|(at_ms, count)| (at_ms, Some(count)));
        let expected = [Samples(1), CounterInUse, Samples(299), Missing(5), Samples(195)];
        assert_eq!(events(false, counted.clone()), expected);
        assert_eq!(events(true, counted), [&[rate.clone()][..], &expected].concat());
        let stamped = kept(300..305).map(|(at_ms, _)| (at_ms, None));
        assert_eq!(events(true, stamped), [rate, Samples(300), Missing(5), Samples(195)]);
    }

    #[test]
    fn without_stamps_and_counters_nothing_is_missing() {
        let neither = kept(300..305).map(|_| (0, None));
        assert_eq!(events(false, neither), [Samples(495)]);
        assert_eq!(GapDetector::without_stamps().summary(), None);
    }

    #[test]
    fn late_arrivals_do_not_overrule_a_counter() {
        // a pause of the host: the samples after it are permanently late
        let late = kept(0..0).map(|(at_ms, count)| (if count > 6000 { at_ms + 500 } else { at_ms }, Some(count)));
        assert!(!events(true, late).iter().any(|event| matches!(event, Missing(_))));
    }

    #[test]
    fn a_counter_that_stays_the_same_leaves_it_to_the_stamps() {
        let stuck = kept(300..305).map(|(at_ms, _)| (at_ms, Some(11_912)));
        let found = events(true, stuck);
        assert!(found.contains(&Missing(5)) && !found.contains(&CounterInUse), "{found:?}");
    }

    #[test]
    fn after_the_end_of_counters_the_stamps_decide() {
        let ends = kept(300..305).map(|(at_ms, count)| (at_ms, (count < 4000).then_some(count)));
        let found = events(true, ends.clone());
        assert_eq!(found.last_chunk(), Some(&[Missing(5), Samples(195)]));
        assert_eq!(events(false, ends), [Samples(1), CounterInUse, Samples(494)]);
    }

    #[test]
    fn counters_that_begin_later_or_again_are_ignored() {
        let later = kept(300..305).map(|(_, count)| (0, (count > 100).then_some(count)));
        assert_eq!(events(false, later), [Samples(495)]);
        let again = kept(300..305).map(|(_, count)| (0, (count != 2007).then_some(count)));
        assert_eq!(events(false, again), [Samples(1), CounterInUse, Samples(494)]);
    }

    #[test]
    fn a_restarted_counter_leaves_an_unknown_gap() {
        let restarted = (0..100).chain(3..50).map(|count| (0, Some(count)));
        assert_eq!(events(false, restarted), [Samples(1), CounterInUse, Samples(99), UnknownGap, Samples(47)]);
    }
}

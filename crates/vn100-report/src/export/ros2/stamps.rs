//! The times of exported samples: fitted, of arrival, or of the sensor.

use vn100_analysis::RateFrom;

use crate::measured::Record;

/// The times of the messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stamps {
    /// Times on an even grid with the measured rate from the first arrival on, without the jitter
    /// of the transport; the arrival times where samples are missing or no rate was measured. The
    /// device time where the capture has no arrival times; where the sensor restarts, it continues
    /// with one interval.
    #[default]
    Fitted,
    /// The arrival time of each frame.
    Arrival,
}

/// Gives each sample its time, in nanoseconds since 1970 where the capture has dates, else since
/// its beginning.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// Samples a second on an even grid; `None` for arrival times.
    grid_hz: Option<f64>,
    has_arrivals: bool,
    /// Why the grid is none though it was asked for.
    why_not_fitted: &'static str,
    /// What the times of arrival are counted from, where that is known.
    origin_ns: i64,
    /// Of the first row; the stamps of a capture may begin anywhere, before 1970 too.
    first_ns: Option<i64>,
    /// Where the times are those of the sensor.
    device: Option<DeviceTimes>,
}

/// The device time of the last sample, and the time since the first.
#[derive(Debug, Clone, Copy)]
struct DeviceTimes {
    last: Option<DeviceTime>,
    /// The one before the last, which a false time in between does not change.
    before: Option<DeviceTime>,
    is_step_back: bool,
    /// Between samples, for the place where a sensor has started again.
    interval_ns: u64,
}

impl DeviceTimes {
    /// The time since the first sample at a sample with this device time; without one it stays.
    /// After a false time it continues from the sample before, after a restart of the sensor with
    /// one interval.
    fn at(&mut self, device_ns: Option<u64>) -> u64 {
        let since_last_ns = self.last.map_or(0, |last| last.since_first_ns);
        let Some(device_ns) = device_ns else { return since_last_ns };
        let from = |time: Option<DeviceTime>| {
            let time = time?;
            Some(time.since_first_ns.saturating_add(device_ns.checked_sub(time.device_ns)?))
        };
        let on_from_last = from(self.last).filter(|_| !self.is_step_back);
        let known = on_from_last.or_else(|| from(self.before)).or_else(|| from(self.last));
        let since_first_ns = match self.last {
            None => 0,
            Some(_) => known.unwrap_or(since_last_ns.saturating_add(self.interval_ns)),
        };
        self.is_step_back = self.last.is_some() && known.is_none();
        self.before = self.last;
        self.last = Some(DeviceTime { device_ns, since_first_ns });
        since_first_ns
    }
}

#[derive(Debug, Clone, Copy)]
struct DeviceTime {
    device_ns: u64,
    since_first_ns: u64,
}

impl Clock {
    pub(super) fn new(record: &Record<'_>, stamps: Stamps) -> Self {
        let snapshot = &record.measured.snapshot;
        let timing = &snapshot.timing;
        let clock = |grid_hz, why_not_fitted| Self {
            grid_hz,
            has_arrivals: snapshot.arrivals.is_some(),
            why_not_fitted,
            origin_ns: record.measured.facts.csv.as_ref().and_then(|csv| csv.first_stamp_ns).unwrap_or(0),
            first_ns: None,
            device: None,
        };
        let Some(arrivals) = &snapshot.arrivals else {
            let is_counted = timing.rate_from != RateFrom::DeviceTime;
            let interval_ns = (1e9 / timing.rate_hz).round() as u64;
            let device = DeviceTimes { last: None, before: None, is_step_back: false, interval_ns };
            return Self { device: (!is_counted).then_some(device), ..clock(is_counted.then_some(timing.rate_hz), "") };
        };
        match (stamps, arrivals.measured_hz) {
            (Stamps::Arrival, _) => clock(None, ""),
            (Stamps::Fitted, _) if timing.missing > 0 || timing.segments > 1 => {
                clock(None, "; not on an even grid, as samples are missing")
            }
            (Stamps::Fitted, None) => clock(None, "; not on an even grid, as no rate was measured"),
            (Stamps::Fitted, hz) => clock(hz, ""),
        }
    }

    /// A time in the first year after 1970 is that of a clock that counts from its start.
    fn is_dated(&self) -> bool {
        const YEAR_NS: i64 = 365 * 24 * 3600 * 1_000_000_000;
        self.first_ns.is_some_and(|first_ns| first_ns >= YEAR_NS)
    }

    pub(super) fn stamp(&mut self, sample: u64, arrival_ns: Option<i64>, device_ns: Option<u64>) -> u64 {
        if let Some(device) = &mut self.device {
            return device.at(device_ns);
        }
        let arrival_ns = arrival_ns.map(|at_ns| at_ns.saturating_add(self.origin_ns));
        if let Some(arrival_ns) = arrival_ns.filter(|_| self.has_arrivals) {
            self.first_ns.get_or_insert(arrival_ns);
        }
        let first_ns = self.first_ns.unwrap_or(0);
        let origin_ns = if self.is_dated() { 0 } else { first_ns };
        let since_first_ns = match self.grid_hz {
            Some(hz) => (sample as f64 / hz * 1e9).round() as i64,
            None => arrival_ns.unwrap_or(first_ns).saturating_sub(first_ns),
        };
        u64::try_from(first_ns.saturating_sub(origin_ns).saturating_add(since_first_ns)).unwrap_or(0)
    }

    pub(super) fn text(&self) -> String {
        let times = match self.grid_hz {
            Some(hz) if self.has_arrivals => {
                format!("fitted: first arrival + number of the sample / {hz} Hz, the measured rate")
            }
            Some(hz) => format!("number of the sample / {hz} Hz: the capture has no arrival times"),
            None if self.device.is_some() => "device time of each sample: the capture has no arrival times".into(),
            None => format!("arrival: when the read that completed the line returned{}", self.why_not_fitted),
        };
        let origin =
            if self.is_dated() { "since 1970" } else { "from 0 at the first sample: the capture has no dates" };
        format!("{times}; {origin}")
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::tests::fixture::at_rest;

    #[test]
    fn stamps_are_dates_where_the_capture_has_them() {
        let clock = |grid_hz| Clock {
            grid_hz,
            has_arrivals: true,
            why_not_fitted: "",
            origin_ns: 0,
            first_ns: None,
            device: None,
        };
        let dated = 1_700_000_000_000_000_000;
        for (first_ns, expected) in [(dated, dated as u64), (5_000_000_000, 0), (-7, 0)] {
            let mut fitted = clock(Some(40.0));
            assert_eq!(fitted.stamp(0, Some(first_ns), None), expected);
            assert_eq!(fitted.stamp(4, Some(first_ns + 123), None), expected + 100_000_000);
            assert!(fitted.text().contains(if expected > 0 { "since 1970" } else { "no dates" }));
            let mut arrival = clock(None);
            assert_eq!(arrival.stamp(0, Some(first_ns), None), expected);
            assert_eq!(arrival.stamp(1, Some(first_ns + 123), None), expected + 123);
        }
        let mut counted = Clock { origin_ns: dated, ..clock(None) };
        assert_eq!(
            (counted.stamp(0, Some(0), None), counted.stamp(1, Some(5), None)),
            (dated as u64, dated as u64 + 5)
        );
        let mut without = Clock { has_arrivals: false, ..clock(Some(40.0)) };
        assert_eq!((without.stamp(0, None, None), without.stamp(1, None, None)), (0, 25_000_000));
        assert!(without.text().contains("no arrival times") && without.text().contains("no dates"));
    }

    #[test]
    fn an_even_grid_needs_every_sample() {
        let mut measured = at_rest(4096, &[]);
        for (missing, segments, text) in [
            (0, 1, "fitted: first arrival + number of the sample / "),
            (1, 1, "; not on an even grid, as samples are missing"),
            (0, 2, "; not on an even grid, as samples are missing"),
        ] {
            let timing = &mut Arc::make_mut(&mut measured.snapshot).timing;
            (timing.missing, timing.segments) = (missing, segments);
            let said = Clock::new(&Record::new(&measured), Stamps::Fitted).text();
            assert!(said.contains(text), "{said}");
        }
    }

    #[test]
    fn stamps_of_packets_without_arrival_times_keep_gaps_and_continue_after_a_restart() {
        let mut times = DeviceTimes { last: None, before: None, is_step_back: false, interval_ns: 5 };
        let device_ns = [Some(1000), Some(1005), Some(1105), None, Some(3), Some(8)];
        assert_eq!(device_ns.map(|device_ns| times.at(device_ns)), [0, 5, 105, 105, 110, 115]);
        // one false time changes no other
        for (false_ns, stamp_ns) in [(900_000, 899_000), (3, 10)] {
            let mut times = DeviceTimes { last: None, before: None, is_step_back: false, interval_ns: 5 };
            let stamps = [1000, 1005, false_ns, 1010, 1015].map(|device_ns| times.at(Some(device_ns)));
            assert_eq!(stamps, [0, 5, stamp_ns, 10, 15]);
        }
    }
}

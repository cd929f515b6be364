//! Whether an open link still carries a sensor, judged by what arrives on it.

use std::time::Duration;

/// Without a good line for this long, while bytes arrive, nothing on the line is understood:
/// another speed, or a receiver that flips bits for the whole session.
const GARBLED_AFTER: Duration = Duration::from_millis(300);

/// So many bytes without a good line are no single damaged line: four of the usual ones.
const GARBLED_BYTES: u64 = 512;

/// A stream is silent after so many of its own line periods, and not before the pauses of an
/// adapter and of a busy machine.
const SILENT_PERIODS: u32 = 5;
const SILENT_AT_LEAST: Duration = Duration::from_millis(250);

/// Silence of a stream whose period is not known: three lines of the slowest.
const SILENT_UNKNOWN: Duration = Duration::from_secs(3);

/// One line more or less in a read moves the estimated period by this part.
const PERIOD_SMOOTHING: f64 = 1.0 / 8.0;

/// What a stream has carried so far, in lines and packets with a right checksum.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// All of them.
    pub(crate) understood: u64,
    /// Of these, all but answers.
    pub(crate) unasked: u64,
}

/// Watches one connection.
#[derive(Debug, Clone)]
pub(crate) struct Health {
    /// What the stream had carried at the last read.
    seen: Seen,
    /// When the first byte came that no good line followed; `None` right behind one.
    bad_since_ns: Option<i64>,
    bad_bytes: u64,
    last_good_ns: Option<i64>,
    period_s: Option<f64>,
}

impl Health {
    /// At the start of a connection, on a stream that has carried something before.
    pub(crate) fn new(seen: Seen) -> Self {
        Self { seen, bad_since_ns: None, bad_bytes: 0, last_good_ns: None, period_s: None }
    }

    /// Takes a read: when it came, its length, and what the stream has carried with it.
    pub(crate) fn read(&mut self, at_ns: i64, length: usize, seen: Seen) -> Reading {
        let before = std::mem::replace(&mut self.seen, seen);
        if seen.unasked > before.unasked {
            self.learn_period(at_ns, seen.unasked - before.unasked);
        }
        if seen.understood > before.understood {
            (self.bad_since_ns, self.bad_bytes) = (None, 0);
            return Reading::Good;
        }
        let since_ns = *self.bad_since_ns.get_or_insert(at_ns);
        self.bad_bytes += length as u64;
        let lasted = duration_ns(at_ns, since_ns);
        if self.bad_bytes >= GARBLED_BYTES && lasted >= GARBLED_AFTER {
            Reading::Garbled { bytes: self.bad_bytes, lasted }
        } else {
            Reading::Open
        }
    }

    /// After how long without a byte the stream counts as silent.
    pub(crate) fn silent_after(&self) -> Duration {
        match self.period_s {
            Some(period_s) => Duration::from_secs_f64(period_s)
                .saturating_mul(SILENT_PERIODS)
                .clamp(SILENT_AT_LEAST, SILENT_UNKNOWN * 2),
            None => SILENT_UNKNOWN,
        }
    }

    fn learn_period(&mut self, at_ns: i64, lines: u64) {
        if let Some(last_ns) = self.last_good_ns.replace(at_ns) {
            let seen_s = duration_ns(at_ns, last_ns).as_secs_f64() / lines as f64;
            let before_s = self.period_s.unwrap_or(seen_s);
            self.period_s = Some(before_s + (seen_s - before_s) * PERIOD_SMOOTHING);
        }
    }
}

/// What a read says of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reading {
    /// It brought a good line or packet.
    Good,
    /// It did not; nothing follows from that.
    Open,
    /// For too long nothing has been good.
    Garbled { bytes: u64, lasted: Duration },
}

fn duration_ns(later_ns: i64, earlier_ns: i64) -> Duration {
    Duration::from_nanos(later_ns.saturating_sub(earlier_ns).try_into().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn lines(lines: u64) -> Seen {
        Seen { understood: lines, unasked: lines }
    }

    #[test]
    fn a_garbled_session_is_known_within_a_third_of_a_second() {
        let mut health = Health::new(lines(7));
        assert_eq!(health.read(0, 122, lines(8)), Reading::Good);
        let reads = (1..).map(|line| (line * 25 * MS, health.read(line * 25 * MS, 122, lines(8))));
        let (at_ns, reading) = { reads }.find(|(_, reading)| *reading != Reading::Open).unwrap();
        // 0.3 s after the first bad byte
        assert_eq!(at_ns, 325 * MS);
        assert_eq!(reading, Reading::Garbled { bytes: 13 * 122, lasted: Duration::from_millis(300) });
    }

    #[test]
    fn one_damaged_line_of_a_slow_stream_is_not_a_garbled_session() {
        let mut health = Health::new(Seen::default());
        let mut good = 0;
        // lines a second apart in two reads each, one of three damaged
        for line in 0..30 {
            let at_ns = line * 1000 * MS;
            assert_eq!(health.read(at_ns, 62, lines(good)), Reading::Open);
            good += u64::from(line % 3 > 0);
            let whole = health.read(at_ns + 6 * MS, 60, lines(good));
            assert_eq!(whole, if line % 3 > 0 { Reading::Good } else { Reading::Open });
        }
    }

    #[test]
    fn silence_is_a_few_periods_of_the_stream() {
        let mut health = Health::new(Seen::default());
        assert_eq!(health.silent_after(), SILENT_UNKNOWN);
        (0..100).for_each(|line| _ = health.read(line * 200 * MS, 122, lines(line as u64 + 1)));
        assert_eq!(health.silent_after(), Duration::from_secs(1));
        // eight lines a read, 200 Hz
        let mut health = Health::new(Seen::default());
        (0..100).for_each(|read| _ = health.read(read * 40 * MS, 976, lines(8 * (read as u64 + 1))));
        assert_eq!(health.silent_after(), SILENT_AT_LEAST);
    }

    #[test]
    fn answers_tell_nothing_of_the_period() {
        let mut health = Health::new(Seen::default());
        for answer in 0..10 {
            assert_eq!(
                health.read(answer * 20 * MS, 20, Seen { understood: answer as u64 + 1, unasked: 0 }),
                Reading::Good
            );
        }
        assert_eq!(health.silent_after(), SILENT_UNKNOWN);
    }
}

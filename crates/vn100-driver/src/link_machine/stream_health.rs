//! Whether an open link still carries the frames of a sensor, judged by the arrival of its bytes.

use std::time::Duration;

/// Bytes that arrive for this long without a good frame are garbled: the baud rate is wrong, or
/// the receiver of the host flips bits until the port is opened again.
const GARBLED_AFTER: Duration = Duration::from_millis(300);

/// Fewer bytes than this may be single damaged frames: four of the usual ones.
const GARBLED_BYTES: u64 = 512;

/// A stream is silent after so many of its own periods, and not before the usual pauses of an
/// adapter and of a busy machine.
const SILENT_PERIODS: u32 = 5;
const SILENT_AT_LEAST: Duration = Duration::from_millis(250);

/// The timeout of a stream whose period is not known: three periods of the slowest output.
const SILENT_UNKNOWN: Duration = Duration::from_secs(3);

/// Weight of a new period in the estimate: a read may bring one frame more or less.
const PERIOD_SMOOTHING: f64 = 1.0 / 8.0;

/// How many frames with a right checksum a stream has carried so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct FrameCounts {
    /// All of them.
    pub(super) good: u64,
    /// Those that are not replies: the output that the sensor sends by itself.
    pub(super) output: u64,
}

/// The recent past of one connection.
#[derive(Debug, Clone)]
pub(super) struct StreamHealth {
    /// At the last read.
    counts: FrameCounts,
    /// When the first byte arrived that no good frame followed; `None` right behind a good one.
    bad_since_ns: Option<i64>,
    bad_bytes: u64,
    last_output_ns: Option<i64>,
    period_s: Option<f64>,
}

impl StreamHealth {
    /// At the start of a connection; `counts` are those of the connections before.
    pub(super) fn new(counts: FrameCounts) -> Self {
        Self { counts, bad_since_ns: None, bad_bytes: 0, last_output_ns: None, period_s: None }
    }

    /// Judges a read by its time, its length and the frames carried up to its end.
    pub(super) fn handle_read(&mut self, at_ns: i64, length: usize, counts: FrameCounts) -> Reading {
        let before = std::mem::replace(&mut self.counts, counts);
        if counts.output > before.output {
            self.update_period(at_ns, counts.output - before.output);
        }
        if counts.good > before.good {
            (self.bad_since_ns, self.bad_bytes) = (None, 0);
            return Reading::Good;
        }
        let since_ns = *self.bad_since_ns.get_or_insert(at_ns);
        self.bad_bytes += length as u64;
        let lasted = duration_ns(at_ns, since_ns);
        if self.bad_bytes >= GARBLED_BYTES && lasted >= GARBLED_AFTER {
            Reading::Garbled { bytes: self.bad_bytes, lasted }
        } else {
            Reading::Undecided
        }
    }

    /// How long after its last frame the output counts as silent.
    pub(super) fn silence_timeout(&self) -> Duration {
        match self.period_s {
            Some(period_s) => Duration::from_secs_f64(period_s)
                .saturating_mul(SILENT_PERIODS)
                .clamp(SILENT_AT_LEAST, SILENT_UNKNOWN * 2),
            None => SILENT_UNKNOWN,
        }
    }

    fn update_period(&mut self, at_ns: i64, frames: u64) {
        if let Some(last_ns) = self.last_output_ns.replace(at_ns) {
            let seen_s = duration_ns(at_ns, last_ns).as_secs_f64() / frames as f64;
            let before_s = self.period_s.unwrap_or(seen_s);
            self.period_s = Some(before_s + (seen_s - before_s) * PERIOD_SMOOTHING);
        }
    }
}

/// What a read says of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// It brought a good frame.
    Good,
    /// It did not, which a single damaged or incomplete frame explains.
    Undecided,
    /// No frame has been good for too long.
    Garbled { bytes: u64, lasted: Duration },
}

fn duration_ns(later_ns: i64, earlier_ns: i64) -> Duration {
    Duration::from_nanos(later_ns.saturating_sub(earlier_ns).try_into().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn lines(count: u64) -> FrameCounts {
        FrameCounts { good: count, output: count }
    }

    #[test]
    fn a_garbled_stream_is_detected_within_a_third_of_a_second() {
        let mut health = StreamHealth::new(lines(7));
        assert_eq!(health.handle_read(0, 122, lines(8)), Reading::Good);
        let reads = (1..).map(|line| (line * 25 * MS, health.handle_read(line * 25 * MS, 122, lines(8))));
        let (at_ns, reading) = { reads }.find(|(_, reading)| *reading != Reading::Undecided).unwrap();
        // 0.3 s after the first bad byte
        assert_eq!(at_ns, 325 * MS);
        assert_eq!(reading, Reading::Garbled { bytes: 13 * 122, lasted: Duration::from_millis(300) });
    }

    #[test]
    fn a_damaged_frame_of_a_slow_stream_is_not_a_garbled_stream() {
        let mut health = StreamHealth::new(FrameCounts::default());
        let mut good = 0;
        // lines a second apart in two reads each, one of three damaged
        for line in 0..30 {
            let at_ns = line * 1000 * MS;
            assert_eq!(health.handle_read(at_ns, 62, lines(good)), Reading::Undecided);
            good += u64::from(line % 3 > 0);
            let whole = health.handle_read(at_ns + 6 * MS, 60, lines(good));
            assert_eq!(whole, if line % 3 > 0 { Reading::Good } else { Reading::Undecided });
        }
    }

    #[test]
    fn the_silence_timeout_is_a_few_periods() {
        let mut health = StreamHealth::new(FrameCounts::default());
        assert_eq!(health.silence_timeout(), SILENT_UNKNOWN);
        (0..100).for_each(|line| _ = health.handle_read(line * 200 * MS, 122, lines(line as u64 + 1)));
        assert_eq!(health.silence_timeout(), Duration::from_secs(1));
        // eight lines a read, 200 Hz
        let mut health = StreamHealth::new(FrameCounts::default());
        (0..100).for_each(|read| _ = health.handle_read(read * 40 * MS, 976, lines(8 * (read as u64 + 1))));
        assert_eq!(health.silence_timeout(), SILENT_AT_LEAST);
    }

    #[test]
    fn replies_do_not_change_the_period() {
        let mut health = StreamHealth::new(FrameCounts::default());
        for answer in 0..10 {
            assert_eq!(
                health.handle_read(answer * 20 * MS, 20, FrameCounts { good: answer as u64 + 1, output: 0 }),
                Reading::Good
            );
        }
        assert_eq!(health.silence_timeout(), SILENT_UNKNOWN);
    }
}

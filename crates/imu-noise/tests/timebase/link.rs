//! A sensor, the path of its lines to the host, and the results of the time base.

use std::time::Duration;

use imu_noise::timebase::{GapDetector, GapEvent, NominalRate, TimebaseSummary};

pub(crate) const RATES_HZ: [f64; 11] = [1.0, 2.0, 4.0, 5.0, 10.0, 20.0, 25.0, 40.0, 50.0, 100.0, 200.0];

/// SplitMix64 (Steele, Lea, Flood 2014): the same streams everywhere.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A uniform number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A sensor and the path of its lines to the host.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) rate_hz: f64,
    pub(crate) clock_ppm: f64,
    /// Each line is late by up to this time.
    pub(crate) jitter_s: f64,
    /// The host reads at multiples of this time; 0 for reads at once.
    pub(crate) read_s: f64,
    /// Time of the first line, so that reads fall at any place among the lines.
    pub(crate) start_s: f64,
    pub(crate) seed: u64,
}

impl Link {
    pub(crate) const fn steady(rate_hz: f64) -> Self {
        Self { rate_hz, clock_ppm: 0.0, jitter_s: 0.0, read_s: 0.0, start_s: 0.5, seed: 1 }
    }

    /// Stamps of `lines` lines, in order.
    pub(crate) fn stamps(self, lines: u64) -> impl Iterator<Item = f64> {
        let period_s = 1.0 / (self.rate_hz * (1.0 + self.clock_ppm * 1e-6));
        let mut random = Random(self.seed);
        let mut previous_s = 0.0_f64;
        (0..lines).map(move |line| {
            let sent_s = self.start_s + line as f64 * period_s + self.jitter_s * random.unit();
            let read_s = if self.read_s > 0.0 { (sent_s / self.read_s).ceil() * self.read_s } else { sent_s };
            previous_s = previous_s.max(read_s);
            previous_s
        })
    }
}

/// The stamps of a link that loses this share of its lines at random, and the number of lost lines
/// between the first and the last kept one.
pub(crate) fn losing(link: Link, lost_share: f64, lines: u64) -> (Vec<f64>, u64) {
    let mut random = Random(link.seed);
    let (mut kept, mut last) = (Vec::new(), 0);
    for (line, stamp_s) in (0..).zip(link.stamps(lines)) {
        if line == 0 || random.unit() >= lost_share {
            kept.push(stamp_s);
            last = line;
        }
    }
    let lost = last + 1 - kept.len() as u64;
    (kept, lost)
}

/// The stamps of a reader that takes each line as it comes, but is away for up to `stalled_s`
/// before this share of them.
pub(crate) fn stalling(rate_hz: f64, stall_share: f64, stalled_s: f64, seed: u64) -> Vec<f64> {
    let mut random = Random(seed);
    let mut reads_at_s = 0.0_f64;
    let sent = Link { jitter_s: 0.02 / rate_hz, seed, ..Link::steady(rate_hz) }.stamps(20_000);
    let read = sent.map(|sent_s| {
        if random.unit() < stall_share {
            reads_at_s = reads_at_s.max(sent_s + stalled_s * random.unit());
        }
        reads_at_s = reads_at_s.max(sent_s);
        reads_at_s
    });
    read.collect()
}

/// Decisions with the number of kept lines before each, and the summary.
pub(crate) fn place(stamps_s: impl IntoIterator<Item = f64>) -> (Vec<(u64, GapEvent)>, TimebaseSummary) {
    place_with(GapDetector::new(&RATES_HZ, None), stamps_s)
}

pub(crate) fn place_with(
    mut timebase: GapDetector,
    stamps_s: impl IntoIterator<Item = f64>,
) -> (Vec<(u64, GapEvent)>, TimebaseSummary) {
    let (mut events, mut placed, mut pushed) = (Vec::new(), 0, 0);
    let mut take = |timebase: &mut GapDetector, pushed: u64| {
        while let Some(decision) = timebase.poll() {
            match decision {
                GapEvent::Samples(lines) => placed += lines,
                // a measured rate becomes more exact
                GapEvent::Rate(rate) => {
                    assert!(placed == 0 || matches!(rate, NominalRate::Measured(_)), "{rate:?} after {placed}")
                }
                GapEvent::Refused(_) => {}
                other => events.push((placed, other)),
            }
        }
        assert!(placed <= pushed);
        placed
    };
    for stamp_s in stamps_s {
        timebase.push(Duration::from_secs_f64(stamp_s), None);
        pushed += 1;
        take(&mut timebase, pushed);
    }
    timebase.finish();
    assert_eq!(take(&mut timebase, pushed), pushed, "every line is placed once");
    (events, timebase.summary().unwrap())
}

pub(crate) fn gap(missing: u64) -> GapEvent {
    GapEvent::Missing(missing)
}

//! Lines through a USB serial adapter, which sends a packet of 62 bytes when it is full, and
//! otherwise its pending bytes when its latency timer expires (FTDI application note AN232B-04).
//! The tail of a line may wait for the next line.

use imu_noise::timebase::GapDetector;

use crate::link::{RATES_HZ, Random, place_with};

/// Bytes per line of `$VNYMR`, `$VNIMU`, `$VNMAR` and `$VNQMR`.
const LINE_BYTES: [u64; 4] = [122, 112, 95, 135];

const PACKET_BYTES: u64 = 62;

/// The latency timer at its factory default, and at its shortest.
const TIMERS_S: [f64; 2] = [0.016, 0.001];

/// The largest share of the baud rate that a sensor uses.
const MOST_LOAD: f64 = 0.95;

#[derive(Clone, Copy, Debug)]
struct Adapter {
    rate_hz: f64,
    baud: f64,
    line_bytes: u64,
    timer_s: f64,
    clock_ppm: f64,
    /// The share of bytes that are lost before the adapter.
    lost_share: f64,
    seed: u64,
}

impl Adapter {
    /// The stamps of the lines without a lost byte that arrive while the sensor sends this many,
    /// and the number of other lines between the first and the last of them.
    fn stamps(self, lines: u64) -> (Vec<f64>, u64) {
        let mut random = Random::new(self.seed);
        let mut last_packet_s = 1.0 - self.timer_s * random.unit();
        let mut waiting_bytes = 0;
        let (mut waiting, mut arrived) = (Vec::new(), Vec::new());
        for line in 0..lines {
            let start_s = 1.0 + line as f64 / (self.rate_hz * (1.0 + self.clock_ppm * 1e-6));
            let mut is_whole = true;
            for byte in 1..=self.line_bytes {
                let at_s = start_s + byte as f64 * 10.0 / self.baud;
                let timers = ((at_s - last_packet_s) / self.timer_s).floor();
                if timers > 0.0 {
                    arrived.extend(waiting.drain(..).map(|line| (line, last_packet_s + self.timer_s)));
                    waiting_bytes = 0;
                    // an empty packet restarts the timer as well
                    last_packet_s += timers * self.timer_s;
                }
                if random.unit() < self.lost_share {
                    is_whole = false;
                    continue;
                }
                waiting_bytes += 1;
                if byte == self.line_bytes && is_whole {
                    waiting.push(line);
                }
                if waiting_bytes == PACKET_BYTES {
                    arrived.extend(waiting.drain(..).map(|line| (line, at_s)));
                    waiting_bytes = 0;
                    last_packet_s = at_s;
                }
            }
        }
        let sent = arrived.last().unwrap().0 + 1 - arrived[0].0;
        let lost = sent - arrived.len() as u64;
        (arrived.into_iter().map(|(_, at_s)| at_s).collect(), lost)
    }
}

/// Each message at each rate and each sufficient baud rate, with each timer.
fn adapters() -> Vec<Adapter> {
    let mut adapters = Vec::new();
    for line_bytes in LINE_BYTES {
        for rate_hz in [40.0, 50.0, 100.0, 200.0] {
            for baud in [57_600.0, 115_200.0, 230_400.0, 460_800.0, 921_600.0] {
                if rate_hz * line_bytes as f64 * 10.0 < MOST_LOAD * baud {
                    adapters.extend(TIMERS_S.map(|timer_s| Adapter {
                        rate_hz,
                        baud,
                        line_bytes,
                        timer_s,
                        clock_ppm: 0.0,
                        lost_share: 0.0,
                        seed: 1,
                    }));
                }
            }
        }
    }
    adapters
}

fn detector(adapter: Adapter, is_known: bool) -> GapDetector {
    GapDetector::new(&RATES_HZ, is_known.then_some(adapter.rate_hz))
}

#[test]
fn a_tail_that_waits_for_the_next_line_is_no_loss() {
    for adapter in adapters() {
        for (is_known, clock_ppm) in [(false, 0.0), (true, 0.0), (true, 300.0), (true, -300.0)] {
            let adapter = Adapter { clock_ppm, ..adapter };
            let (stamps_s, _) = adapter.stamps(3000);
            let (events, summary) = place_with(detector(adapter, is_known), stamps_s);
            assert_eq!(events, [], "{adapter:?}");
            let offset_ppm = summary.offset_ppm.unwrap();
            assert!((offset_ppm - clock_ppm).abs() < 50.0, "{offset_ppm} ppm of {adapter:?}");
        }
    }
}

#[test]
fn lines_that_lose_a_byte_are_counted() {
    let mut unknown = 0;
    for adapter in adapters() {
        for (is_known, seed) in [(false, 1), (true, 2), (true, 3)] {
            let adapter = Adapter { lost_share: 1e-4, seed, ..adapter };
            let (stamps_s, lost) = adapter.stamps(3000);
            let (_, summary) = place_with(detector(adapter, is_known), stamps_s);
            if summary.refusal.is_some() {
                // lines may be lost in the seconds of the search
                assert!(!is_known, "{adapter:?}");
                unknown += 1;
                continue;
            }
            assert!(summary.missing.abs_diff(lost) <= 3, "{} of {lost}: {adapter:?}", summary.missing);
        }
    }
    assert!(unknown <= 8, "{unknown} rates unknown");
}

#[test]
fn a_few_lines_at_once_are_no_earlier_phase() {
    // Replies between the lines, and a sensor that pauses, shift the packets.
    let at_once = [17, 111, 21, 29, 40, 46, 193, 202, 206, 275, 343, 354, 364, 370, 383, 388, 509];
    let soon = [101, 190, 500];
    for is_known in [false, true] {
        let stamps = (0..1000).map(|line| {
            let late_s = if at_once.contains(&line) {
                0.0013
            } else if soon.contains(&line) {
                0.006
            } else {
                0.0104
            };
            1.0 + 0.01 * f64::from(line) + late_s
        });
        let timebase = GapDetector::new(&RATES_HZ, is_known.then_some(100.0));
        assert_eq!(place_with(timebase, stamps).0, []);
    }
}

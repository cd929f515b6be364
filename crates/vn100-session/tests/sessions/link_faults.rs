//! Each fault of a link, on an emulated sensor and a clock in memory: its cost at 40 and at 200 Hz,
//! and no other cost.

use std::{collections::VecDeque, io, time::Duration};

use tokio_util::sync::CancellationToken;
use vn100_analysis::{Analysis, MissingFrom, Settings, Snapshot};
use vn100_capture::{Event, Source, read_samples};
use vn100_protocol::stream::{Chunk, ReadOptions, StreamInput};
use vn100_protocol::{Decoder, Item, Options, xor8};
use vn100_sim::{Device, DeviceConfig, wire::Wire};

/// Both rates, with a sufficient baud rate.
const RATES: [(u32, u32); 2] = [(40, 115_200), (200, 921_600)];

/// The sensor is up, and its port is opened.
const START: Duration = Duration::from_secs(3);

const SECONDS: u64 = 12;

const LINE: &[u8] = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

/// The results for the bytes of a link.
struct Measured {
    rows: Vec<Vec<i32>>,
    snapshot: Snapshot,
    /// The bytes that the link delivered.
    bytes: Vec<u8>,
}

/// Reads of a link, in sequence.
struct Reads(VecDeque<Chunk>);

impl Source for Reads {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        Ok(self.0.pop_front().map(StreamInput::from))
    }
}

/// Twelve seconds of a sensor at this rate with these faults of the link; read at once, or at
/// intervals.
fn measured(plan: &str, rate: (u32, u32), every: Option<Duration>) -> Measured {
    measured_for(SECONDS, Settings::default(), plan, rate, every)
}

fn measured_for(
    seconds: u64,
    settings: Settings,
    plan: &str,
    (rate_hz, baud): (u32, u32),
    every: Option<Duration>,
) -> Measured {
    let speed = |baud: u32| baud.try_into().unwrap();
    let plan = plan.parse().unwrap();
    let mut wire = Wire::new(Device::new(DeviceConfig::default()), &plan, 1, speed(115_200));
    for (setting, host_baud) in [(format!("VNWRG,05,{baud}"), 115_200), (format!("VNWRG,07,{rate_hz}"), baud)] {
        let now = START - Duration::from_secs(1);
        wire.set_host_baud(speed(host_baud));
        wire.write(format!("${setting}*{:02X}\r\n", xor8(setting.as_bytes())).as_bytes(), now);
        _ = wire.poll(now + Duration::from_millis(100));
    }
    wire.set_host_baud(speed(baud));
    let end = START + Duration::from_secs(seconds);
    let (mut now, mut reads) = (START, VecDeque::new());
    let mut waiting = wire.open(now);
    loop {
        waiting.extend(wire.poll(now));
        if !waiting.is_empty() {
            let at_ns = Some(now.as_nanos().try_into().unwrap());
            reads.push_back(Chunk { bytes: std::mem::take(&mut waiting).into(), at_ns });
        }
        if now == end {
            break;
        }
        now = every.map_or(wire.next_wakeup(now), |every| now + every).min(end);
    }
    let bytes = reads.iter().flat_map(|read| &read.bytes[..]).copied().collect();
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let mut analysis = Analysis::new(settings);
    let mut rows = Vec::new();
    runtime.block_on(async {
        let mut events = read_samples(Reads(reads), ReadOptions::default(), CancellationToken::new());
        while let Some(event) = events.recv().await {
            if let Event::Batch(batch) = event {
                rows.extend(batch.rows().map(<[i32]>::to_vec));
                analysis.absorb(&batch);
            }
        }
    });
    analysis.finish();
    Measured { rows, snapshot: analysis.snapshot(), bytes }
}

/// The number of sent lines that did not arrive complete, from `$` to the last check digit. No two
/// lines are equal, because they contain noise.
fn struck(sent: &[u8], came: &[u8]) -> u64 {
    let (mut count, mut came) = (0, came);
    for line in sent.split(|byte| *byte == b'\n').filter_map(|line| line.strip_suffix(b"\r")) {
        match came.windows(line.len()).position(|bytes| bytes == line) {
            Some(at) => came = &came[at + line.len()..],
            None => count += 1,
        }
    }
    count
}

/// Checks that a link with this fault delivers all lines except the damaged ones; returns the
/// measurement.
fn assert_costs(plan: &str, rate: (u32, u32), lost: impl Fn(u64) -> bool) -> Measured {
    let clean = measured("", rate, None);
    let faulty = measured(plan, rate, None);
    let sent = clean.rows.len() as u64;
    assert!(sent.abs_diff(SECONDS * u64::from(rate.0)) <= 1, "{sent} lines at {rate:?}");
    // the samples were sent in this order: no value is corrupt, and no line occurs twice
    let mut all = clean.rows.iter();
    assert!(faulty.rows.iter().all(|row| all.any(|sent| sent == row)), "{plan} at {rate:?}: a row that was not sent");
    let cost = sent - faulty.rows.len() as u64;
    assert!(lost(cost), "{plan} at {rate:?} costs {cost} lines");
    assert_eq!(cost, struck(&clean.bytes, &faulty.bytes), "{plan} at {rate:?}: lines lost, and lines struck");
    let timing = faulty.snapshot.timing;
    assert_eq!(timing.samples + timing.excluded, faulty.rows.len() as u64, "{plan} at {rate:?}");
    assert_eq!(timing.samples + timing.missing, sent, "{plan} at {rate:?}: {timing:?}");
    assert_eq!(faulty.snapshot.link.bytes(), faulty.bytes.len() as u64, "{plan} at {rate:?}");
    faulty
}

#[test]
fn a_lost_byte_costs_its_line() {
    for rate in RATES {
        assert_costs("drop@8.003s", rate, |lost| lost == 1);
    }
}

#[test]
fn bytes_lost_for_a_while_cost_the_lines_of_that_while() {
    for rate in RATES {
        let second = u64::from(rate.0);
        assert_costs("drop@8s+1s", rate, |lost| lost.abs_diff(second) <= 1);
    }
}

#[test]
fn bytes_lost_by_chance_cost_their_lines() {
    for rate in RATES {
        let measured = assert_costs("drop@0.02%", rate, |lost| lost > 0);
        assert!(measured.snapshot.timing.gaps > 0);
    }
}

#[test]
fn a_flipped_bit_costs_its_line() {
    for rate in RATES {
        assert_costs("flip@8.003s", rate, |lost| lost == 1);
    }
}

#[test]
fn bits_flipped_by_chance_cost_their_lines() {
    for rate in RATES {
        assert_costs("flip@0.02%", rate, |lost| lost > 0);
    }
}

#[test]
fn lines_of_which_most_are_damaged_are_counted_where_the_rate_is_known() {
    for (rate, seconds) in RATES.into_iter().flat_map(|rate| [2, 4, SECONDS].map(|seconds| (rate, seconds))) {
        let known = Settings { rate_hz: Some(rate.0.into()), ..Settings::default() };
        let sent = measured_for(seconds, known.clone(), "", rate, None).rows.len() as u64;
        for plan in ["flip@0.75%", "flip@1%"] {
            let timing = measured_for(seconds, known.clone(), plan, rate, None).snapshot.timing;
            let case = format!("{plan} for {seconds} s at {rate:?}: {timing:?} of {sent}");
            assert!(2 * timing.samples < sent, "{case}");
            assert_eq!(timing.missing_from, MissingFrom::Arrival, "{case}");
            // lines before the first good one and after the last one are not counted
            assert!((sent - 12..=sent).contains(&(timing.samples + timing.missing)), "{case}");
        }
    }
}

#[test]
fn a_splice_costs_both_of_its_lines() {
    for rate in RATES {
        assert_costs("splice@8.003s", rate, |lost| lost == 2);
    }
}

#[test]
fn old_bytes_at_the_beginning_cost_nothing() {
    for rate in RATES {
        let measured = assert_costs("stale", rate, |lost| lost == 0);
        assert_eq!(measured.bytes.len() as u64, measured.snapshot.link.tally.valid_sentence_bytes + 40);
    }
}

#[test]
fn a_stall_costs_nothing() {
    for rate in RATES {
        let measured = assert_costs("stall@8s+2s", rate, |lost| lost == 0);
        assert_eq!(measured.snapshot.timing.segments, 1);
    }
}

#[test]
fn lines_that_come_in_bursts_cost_nothing() {
    for rate in RATES {
        let clean = measured("", rate, None);
        for every_ms in [16, 250, 1000] {
            let bursts = measured("", rate, Some(Duration::from_millis(every_ms)));
            let timing = bursts.snapshot.timing;
            assert!(bursts.rows == clean.rows, "{rate:?} every {every_ms} ms");
            assert_eq!((timing.missing, timing.segments), (0, 1), "{rate:?} every {every_ms} ms: {timing:?}");
        }
    }
}

#[test]
fn a_line_without_end_is_bounded_and_costs_itself() {
    let mut decoder = Decoder::new(Options::default());
    let endless = [b"$VNYMR,", &b"+000.000,".repeat(500_000)[..]].concat();
    let (mut samples, mut bad) = (0, 0);
    let mut count = |item: Item<'_>| match item {
        Item::Sample(_) => samples += 1,
        _ => bad += 1,
    };
    for piece in [LINE, &endless, LINE].concat().chunks(997) {
        decoder.push(piece, &mut count);
        assert!(decoder.tally().buffered_bytes <= 850);
    }
    assert_eq!((samples, bad), (2, 1));
}

#[test]
fn a_text_capture_cut_at_any_byte_gives_its_whole_lines() {
    let capture = LINE.repeat(3);
    for cut in 0..=capture.len() {
        let mut decoder = Decoder::new(Options::default());
        decoder.push(&capture[..cut], |_| {});
        decoder.finish(|_| {});
        let tally = decoder.tally();
        // a line is complete up to its last check digit
        let whole = (cut + 2) / LINE.len();
        assert_eq!((tally.samples, tally.bytes()), (whole as u64, cut as u64), "cut at {cut}");
    }
}

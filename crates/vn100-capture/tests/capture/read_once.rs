//! A table that can be read but once, as on standard input, and the same as a file.

use std::io::{self, Read};

use proptest::prelude::*;
use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, CaptureOptions, Event};
use vn100_protocol::{
    Channel,
    stream::{CsvReport, FileReport, ReadOptions},
};

/// Hands out its bytes in pieces of the given sizes, over and over.
struct Pieces {
    bytes: io::Cursor<Vec<u8>>,
    sizes: std::iter::Cycle<std::vec::IntoIter<usize>>,
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let size = self.sizes.next().unwrap_or(1).min(buffer.len());
        self.bytes.by_ref().take(size as u64).read(buffer)
    }
}

/// All of a capture that counts.
#[derive(Debug, PartialEq)]
struct Told {
    channels: Vec<Channel>,
    counts: Vec<i32>,
    times_ns: Vec<i64>,
    report: CsvReport,
}

impl Told {
    /// The values of a channel, in the units of the file.
    fn values(&self, slot: usize) -> Vec<f64> {
        let channel = &self.channels[slot];
        self.counts.chunks(self.channels.len()).map(|row| channel.value(row[slot])).collect()
    }
}

/// What a capture tells behind the last time that it began again, and how often it did.
fn told(capture: Capture) -> (Told, u32) {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let (mut channels, mut counts, mut times_ns, mut again) = (Vec::new(), Vec::new(), Vec::new(), 0);
    let mut report = runtime.block_on(async {
        let mut events = capture.read(ReadOptions::default(), CancellationToken::new()).unwrap();
        loop {
            match events.recv().await.unwrap() {
                Event::Batch(batch) => {
                    assert_eq!(counts.len(), (batch.link.tally.samples as usize - batch.row_count()) * channels.len());
                    channels = batch.layout.as_ref().unwrap().channels.to_vec();
                    counts.extend(&batch.counts);
                    times_ns.extend(batch.arrivals.iter().map(|arrival| arrival.at_ns));
                }
                Event::ReadAgain => {
                    again += 1;
                    (counts, times_ns) = (Vec::new(), Vec::new());
                }
                Event::Link(event) => panic!("{event:?}"),
                Event::End(end) => match end.report {
                    Some(FileReport::Csv(report)) if end.error.is_none() => break report,
                    _ => panic!("{end:?}"),
                },
            }
        }
    });
    assert_eq!(std::mem::take(&mut report.read_again), again);
    (Told { channels, counts, times_ns, report }, again)
}

fn options() -> CaptureOptions {
    CaptureOptions {
        columns: Some("gyro_x=a:deg/s,accel_x=b:g,t=t:s".parse().unwrap()),
        topic: None,
        ..CaptureOptions::default()
    }
}

fn as_file(text: &str) -> Told {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    std::fs::write(&path, text).unwrap();
    let (told, again) = told(Capture::open(path, &options()).unwrap());
    assert_eq!(again, 0);
    told
}

fn as_stream(text: &str, sizes: Vec<usize>) -> (Told, u32) {
    let pieces = Pieces { bytes: io::Cursor::new(text.into()), sizes: sizes.into_iter().cycle() };
    told(Capture::from_reader(pieces, &options()).unwrap())
}

fn table(rows: impl Iterator<Item = (String, String)>) -> String {
    let rows = rows.enumerate().map(|(row, (a, b))| format!("{:.3},{a},{b}\n", 0.01 * row as f64));
    "t,a,b\n".to_owned() + &rows.collect::<String>()
}

/// Numbers of any magnitude, as scripts print them.
fn number() -> impl Strategy<Value = String> {
    let float = (-1.0..1.0_f64, -12_i32..12).prop_map(|(mantissa, exponent)| mantissa * 10_f64.powi(exponent));
    prop_oneof![
        8 => float.clone().prop_map(|value| format!("{value}")),
        4 => float.clone().prop_map(|value| format!("{:.3}", value % 10.0)),
        2 => float.prop_map(|value| format!("{value:e}")),
        1 => Just("nan".to_owned()),
        1 => Just("0".to_owned()),
        1 => Just("1e300".to_owned()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_table_read_once_tells_what_the_file_tells(
        parts in proptest::collection::vec((proptest::collection::vec((number(), number()), 1..8), 1_usize..400), 1..8),
        sizes in proptest::collection::vec(1_usize..20_000, 1..6),
    ) {
        // each part is a pattern that comes over and over
        let rows = parts.iter().flat_map(|(pattern, times)| pattern.iter().cycle().take(pattern.len() * times)).cloned();
        let text = table(rows);
        prop_assert_eq!(as_stream(&text, sizes).0, as_file(&text));
    }
}

/// Noise of about this deviation.
fn noise(row: usize, deviation: f64) -> f64 {
    let uniform = |seed: u64| (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 / (1_u64 << 53) as f64;
    let sum: f64 = (0..12).map(|part| uniform(((12 * row + part) as u64).wrapping_mul(0xd134_2543_de82_ef95))).sum();
    (sum - 6.0) * deviation
}

#[test]
fn values_that_grow_cost_no_row_and_no_digit() {
    // quiet for longer than the rows that decide first, then a thousand million times as large
    let value = |row: usize| noise(row, 1e-4) * if row < 3000 { 1.0 } else { 1e9 };
    let text = table((0..5000).map(|row| (format!("{}", value(row)), format!("{:.2}", 1.0 + noise(row, 0.1)))));
    let (told, again) = as_stream(&text, vec![777]);
    assert!((1..=12).contains(&again), "{again}");
    assert_eq!((told.report.rows, &told.report.absent[..]), (5000, &[][..]));
    let largest = (0..5000).map(|row| value(row).abs()).fold(0.0, f64::max);
    let to_file_units = 180.0 / std::f64::consts::PI;
    for (row, read) in told.values(1).into_iter().enumerate() {
        let error = (read * to_file_units - value(row)).abs();
        assert!(error <= largest * 2_f64.powi(-31) + 1e-12 * largest, "row {row}: {error}");
    }
}

#[test]
fn digits_that_come_late_are_kept() {
    let text = table((0..3000).map(|row| {
        let a = if row < 1500 { format!("{:.1}", noise(row, 1.0)) } else { format!("{:.6}", noise(row, 1.0)) };
        (a, "1.0".to_owned())
    }));
    let (told, again) = as_stream(&text, vec![4096]);
    assert_eq!((again, told.report.rounded.len()), (1, 0));
    let decimals = |told: &Told| told.channels.iter().map(|channel| channel.decimals).collect::<Vec<_>>();
    assert_eq!(decimals(&told), decimals(&as_file(&text)));
}

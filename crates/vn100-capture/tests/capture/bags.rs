//! Bags that Python's `rosbags` 0.11.9 wrote: 60 messages of a seeded generator, with the numbers in
//! `tests/bags/rows.txt`, in each form and compression; and damaged ones.
//!
//! `sentences.bag` and `sentences_mcap` have messages with arrays of messages and texts of varying
//! length, then a sentence and an `Imu` with an empty header.

use std::{
    fs,
    io::{Cursor, Write},
    path::{Path, PathBuf},
    sync::{Arc, atomic::Ordering},
};

use tokio_util::sync::CancellationToken;
use vn100_capture::{BagForm, Capture, CaptureOptions, End, Event, Format, OpenError, OpenHint};
use vn100_protocol::stream::{BagReport, Batch, FileReport, ReadOptions, StampSource};

const FIRST_NS: i64 = 1_700_000_000_000_000_000;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bags").join(name)
}

pub(crate) fn options(topic: Option<&str>, columns: Option<&str>) -> CaptureOptions {
    CaptureOptions {
        topic: topic.map(Into::into),
        columns: columns.map(|map| map.parse().unwrap()),
        ..CaptureOptions::default()
    }
}

/// The result of a capture: rows of values, their times, and the counts of the messages.
pub(crate) struct Read {
    pub(crate) names: Vec<String>,
    pub(crate) rows: Vec<Vec<f64>>,
    pub(crate) times_ns: Vec<i64>,
    pub(crate) end: End,
    last: Option<Batch>,
}

impl Read {
    pub(crate) fn of(capture: Capture) -> Self {
        Self::with(capture, ReadOptions::default())
    }

    fn with(capture: Capture, options: ReadOptions) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let (mut names, mut rows, mut times_ns, mut last) = (Vec::new(), Vec::new(), Vec::new(), None);
        runtime.block_on(async {
            let mut events = capture.read(options, CancellationToken::new()).unwrap();
            loop {
                match events.recv().await.unwrap() {
                    Event::Batch(batch) => {
                        if let Some(layout) = &batch.layout {
                            let channels = &layout.channels;
                            names = channels.iter().map(|channel| channel.name.to_string()).collect();
                            let value = |(place, count): (usize, &i32)| channels[place].value(*count);
                            rows.extend(batch.rows().map(|row| row.iter().enumerate().map(value).collect::<Vec<_>>()));
                            times_ns.extend(batch.arrivals.iter().map(|arrival| arrival.at_ns));
                        }
                        last = Some(*batch);
                    }
                    event @ Event::Link(_) => panic!("{event:?}"),
                    Event::End(end) => return Self { names, rows, times_ns, end, last },
                }
            }
        })
    }

    pub(crate) fn report(&self) -> &BagReport {
        match &self.end.report {
            Some(FileReport::Bag(report)) => report,
            other => panic!("{other:?}"),
        }
    }
}

/// The numbers that were written: angular rates, then accelerations.
fn written() -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path("rows.txt")).unwrap();
    text.lines().map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect()
}

/// Half of a count of the rates and of the accelerations.
const HALF_COUNTS: [f64; 2] = [0.5 / (1 << 25) as f64, 0.5 / (1 << 23) as f64];

fn assert_written(read: &Read, name: &str) {
    assert_eq!(read.names, ["accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"], "{name}");
    let written = written();
    assert_eq!(read.rows.len(), written.len(), "{name}");
    for (row, written) in read.rows.iter().zip(&written) {
        for axis in 0..3 {
            assert!((row[3 + axis] - written[axis]).abs() <= HALF_COUNTS[0], "{name}");
            assert!((row[axis] - written[3 + axis]).abs() <= HALF_COUNTS[1], "{name}");
        }
    }
    let expected = (0..60).map(|row| FIRST_NS + 10_000_000 * row);
    assert!(read.times_ns.iter().copied().eq(expected), "{name}: {:?}", read.times_ns);
}

const FORMS: [(&str, BagForm, u64); 9] = [
    ("imu_none.bag", BagForm::Ros1, 0),
    ("imu_bz2.bag", BagForm::Ros1, 0),
    ("imu_lz4.bag", BagForm::Ros1, 0),
    ("db3", BagForm::Db3, 0),
    ("db3_message_zstd", BagForm::Db3, 0),
    ("db3_file_zstd", BagForm::Db3, 49_152),
    ("mcap", BagForm::Mcap, 0),
    ("mcap_storage_zstd", BagForm::Mcap, 0),
    ("mcap_swapped", BagForm::Mcap, 0),
];

#[test]
fn every_form_and_compression_gives_the_numbers_written() {
    for (name, form, unpacked_bytes) in FORMS {
        let capture = Capture::open(path(name), &CaptureOptions::default()).unwrap();
        assert_eq!((capture.format, capture.topic.as_deref()), (Format::Bag(form), Some("/imu/data")));
        let mut read = Read::of(capture);
        if name == "mcap_swapped" {
            let mut rows: Vec<_> = read.times_ns.iter().copied().zip(read.rows).collect();
            assert!(!rows.is_sorted_by_key(|(at_ns, _)| *at_ns));
            rows.sort_by_key(|(at_ns, _)| *at_ns);
            (read.times_ns, read.rows) = rows.into_iter().unzip();
        }
        assert_written(&read, name);
        let report = read.report();
        assert_eq!((report.messages, report.used), (60, 60), "{name}");
        assert_eq!(report.stamps, StampSource::Field("header.stamp".into()));
        assert_eq!(report.unpacked_bytes, unpacked_bytes, "{name}");
        assert!(read.end.error.is_none());
        let tally = read.last.unwrap().link.tally;
        assert_eq!(tally.samples, 60);
        assert!((60 * 300..60 * 340).contains(&tally.valid_sentence_bytes), "{name}: {tally:?}");
    }
}

#[test]
fn a_bag_read_from_a_stream_or_line_by_line_gives_the_same() {
    for name in ["imu_lz4.bag", "mcap/mcap.mcap", "db3/db3.db3"] {
        let bytes = fs::read(path(name)).unwrap();
        let length = bytes.len() as u64;
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&bytes).unwrap();
        for bytes in [bytes, packed.finish().unwrap()] {
            let stored = bytes.len() as u64;
            let capture = Capture::from_reader(Cursor::new(bytes), &CaptureOptions::default()).unwrap();
            let stored_read = Arc::clone(&capture.stored_bytes_read);
            let read = Read::of(capture);
            assert_written(&read, name);
            // read while it was unpacked, and not again
            assert_eq!(stored_read.load(Ordering::Relaxed), stored);
            assert_eq!(read.report().unpacked_bytes, length);
        }
        let capture = Capture::open(path(name), &CaptureOptions::default()).unwrap();
        let read = Read::with(capture, ReadOptions { line_by_line: true, ..ReadOptions::default() });
        assert_written(&read, name);
    }
}

#[test]
fn a_packed_bag_that_was_cut_gives_what_came_before() {
    let bytes = fs::read(path("imu_none.bag")).unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&bytes).unwrap();
    let packed = packed.finish().unwrap();
    for (kept, rows) in [(packed.len() - 1, 60), (packed.len() / 2, 1)] {
        let cut = Cursor::new(packed[..kept].to_vec());
        let read = Read::of(Capture::from_reader(cut, &CaptureOptions::default()).unwrap());
        assert!(read.end.error.is_some() && read.rows.len() >= rows, "{} of {kept}", read.rows.len());
    }
}

#[test]
fn topics_of_rates_and_of_accelerations_are_two_streams() {
    let folder = path("db3_two");
    let streams = Capture::streams(&folder, &CaptureOptions::default());
    assert_eq!(streams, ["/camera/gyro/sample", "/camera/accel/sample"].map(|name| Some(name.to_owned())));
    let written = written();
    for (topic, first, step) in [("/camera/gyro/sample", 0, 1), ("camera/accel/sample", 3, 2)] {
        let read = Read::of(Capture::open(&folder, &options(Some(topic), None)).unwrap());
        assert_eq!(read.names.len(), 3);
        assert_eq!(read.rows.len(), 60 / step);
        for (row, written) in read.rows.iter().zip(written.iter().step_by(step)) {
            let near = |axis: usize| (row[axis] - written[first + axis]).abs() <= HALF_COUNTS[1];
            assert!((0..3).all(near));
        }
        assert_eq!(read.report().other_messages, 90 - 60 / step as u64);
    }
    let Err(OpenError::Unusable { problem, .. }) = Capture::open(&folder, &CaptureOptions::default()) else { panic!() };
    assert!(matches!(problem.hint(), Some(OpenHint::Topic(topics)) if topics.len() == 2), "{problem}");
    assert!(problem.to_string().contains("/camera/gyro/sample (sensor_msgs/Imu, 60 messages, 100.0000 Hz)"));
}

#[test]
fn sentences_and_numbers_inside_of_other_messages_are_found() {
    for name in ["sentences.bag", "sentences_mcap"] {
        let read = Read::of(Capture::open(path(name), &CaptureOptions::default()).unwrap());
        let report = read.report();
        assert_eq!((report.messages, report.used, report.other_messages), (40, 40, 4));
        assert_eq!((&report.stamps, &*report.type_name), (&StampSource::Recorded, "imu_driver/Vectornav"));
        assert_eq!((read.names.len(), read.rows.len()), (12, 40));
        let mapped = "gyro_x=imu.angular_velocity.x:rad/s,accel_z=imu.linear_acceleration.z:m/s^2";
        let numbers = Read::of(Capture::open(path(name), &options(None, Some(mapped))).unwrap());
        assert_eq!(numbers.report().stamps, StampSource::Recorded);
        assert_eq!(numbers.names, ["accel_z", "gyro_x"]);
        for (numbers, sentence) in numbers.rows.iter().zip(&read.rows) {
            assert!((numbers[0] - sentence[8]).abs() < 1e-6 && (numbers[1] - sentence[9]).abs() < 1e-7);
        }
        let expected = (0..40).map(|row| FIRST_NS + 25_000_000 * row);
        assert!(read.times_ns.iter().copied().eq(expected.clone()) && numbers.times_ns.iter().copied().eq(expected));
    }
}

#[test]
fn units_are_converted_and_a_series_is_as_fine_as_its_largest_value_allows() {
    let written = written();
    let read = |map: &str| Read::of(Capture::open(path("db3"), &options(None, Some(map))).unwrap());
    let degrees = read("gyro_y=angular_velocity.y:deg/s");
    for (row, written) in degrees.rows.iter().zip(&written) {
        let expected = written[1].to_radians();
        assert!((row[0] - expected).abs() <= 1e-7_f64.to_radians() * 10.0, "{} {expected}", row[0]);
    }
    let series = read("value=angular_velocity.y:rad/s");
    let largest = written.iter().map(|row| row[1].abs()).fold(0.0, f64::max);
    for (row, written) in series.rows.iter().zip(&written) {
        assert!((row[0] - written[1]).abs() <= largest / f64::from(1 << 30), "{} {}", row[0], written[1]);
    }
}

#[test]
fn missing_topics_are_named_with_the_existing_ones() {
    let problem = |name: &str, options: &CaptureOptions| match Capture::open(path(name), options) {
        Err(OpenError::Unusable { problem, .. }) => problem,
        _ => panic!("{name} was opened"),
    };
    let no_topic = problem("db3", &options(Some("/imu"), None));
    assert!(matches!(no_topic.hint(), Some(OpenHint::Topic(_))), "{no_topic}");
    assert!(no_topic.to_string().contains("60 messages"), "{no_topic}");
    let no_field = problem("db3", &options(None, Some("gyro_x=angular_velocity.q:rad/s")));
    assert!(no_field.to_string().contains("no number \"angular_velocity.q\"; they have"), "{no_field}");
    assert!(no_field.to_string().contains("angular_velocity.x"));
    let no_sensor = problem("sentences.bag", &options(Some("/chatter"), None));
    assert_eq!(no_sensor.hint(), Some(&OpenHint::ColumnsOfTopic), "{no_sensor}");
    let no_time = problem("db3", &options(None, Some("gyro_x=angular_velocity.x:rad/s,t=header.frame:s")));
    assert!(no_time.to_string().contains("no time \"header.frame\"; they have header.stamp"), "{no_time}");
    let folder = tempfile::tempdir().unwrap();
    let open = |path: &Path| Capture::open(path, &CaptureOptions::default()).err().map(|error| error.to_string());
    assert!(open(folder.path()).unwrap().contains("folder without files of a bag"));
    let database = folder.path().join("a.db3");
    fs::copy(path("db3/db3.db3"), &database).unwrap();
    assert_eq!(open(&database), None);
    fs::write(folder.path().join("a.db3-wal"), "pages").unwrap();
    assert!(open(&database).unwrap().contains("wal_checkpoint"), "{:?}", open(&database));
}

/// The rows of a damaged file, the same line by line; none if it is rejected.
fn rows_of(folder: &Path, bytes: &[u8]) -> Option<(Vec<Vec<f64>>, bool)> {
    let file = folder.join("damaged");
    fs::write(&file, bytes).unwrap();
    let read = |line_by_line| {
        let capture = Capture::open(&file, &CaptureOptions::default()).ok()?;
        let read = Read::with(capture, ReadOptions { line_by_line, ..ReadOptions::default() });
        Some((read.rows, read.end.error.is_some()))
    };
    let whole = read(false);
    assert_eq!(read(true), whole);
    whole
}

#[test]
fn a_bag_that_was_cut_gives_what_came_before() {
    let folder = tempfile::tempdir().unwrap();
    let packed = "mcap_storage_zstd/mcap_storage_zstd.mcap";
    for name in ["imu_none.bag", "imu_bz2.bag", "imu_lz4.bag", "mcap/mcap.mcap", packed, "db3/db3.db3"] {
        let bytes = fs::read(path(name)).unwrap();
        let (whole, _) = rows_of(folder.path(), &bytes).unwrap();
        let mut most = 0;
        for cut in (0..bytes.len()).step_by(bytes.len() / 60) {
            let Some((rows, has_failed)) = rows_of(folder.path(), &bytes[..cut]) else { continue };
            assert!(rows[..] == whole[..rows.len()], "{name} at {cut}");
            // before its first topic the file may be of any kind
            assert!(
                rows.is_empty() || rows.len() == whole.len() || has_failed,
                "{name} at {cut} ends well with {} rows",
                rows.len()
            );
            most = most.max(if rows.len() < whole.len() { rows.len() } else { 0 });
        }
        let is_streamed = matches!(name, "imu_none.bag" | "mcap/mcap.mcap");
        assert!(most > 30 || !is_streamed, "{name}: {most}");
    }
}

#[test]
fn an_unindexed_bag_is_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = fs::read(path("imu_none.bag")).unwrap();
    let whole = rows_of(folder.path(), &bytes).unwrap();
    let at = bytes.windows(10).position(|window| window == b"index_pos=").unwrap() + 10;
    let index = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    bytes[at..at + 8].fill(0);
    bytes.truncate(index);
    assert_eq!(rows_of(folder.path(), &bytes), Some((whole.0, false)));
}

#[test]
fn wrong_lengths_end_with_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["imu_none.bag", "imu_lz4.bag", "db3/db3.db3", "mcap/mcap.mcap"] {
        let bytes = fs::read(path(name)).unwrap();
        for at in (0..bytes.len() - 4).step_by(bytes.len() / 200) {
            let mut damaged = bytes.clone();
            damaged[at..at + 4].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f]);
            // no panic, and no more rows than messages
            if let Some((rows, _)) = rows_of(folder.path(), &damaged) {
                assert!(rows.len() <= 60, "{name} at {at}: {} rows", rows.len());
            }
        }
    }
}

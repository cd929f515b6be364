//! Any bytes as a file: refused with a reason, or read to an end; every byte and every sample
//! counted, for any division of the file into reads.

use std::{
    fs,
    io::{self, Cursor, Read},
};

use tokio_util::sync::CancellationToken;
use vn100_analysis::{Analysis, Assessment, Settings};
use vn100_capture::{Capture, CaptureOptions, Event, Format, OpenError};
use vn100_protocol::stream::{FileReport, MeasuredFrames, ReadOptions, StreamCounts};

/// The content of a capture, for any batches.
#[derive(Debug, Default, PartialEq)]
struct Told {
    format: Option<Format>,
    rows: Vec<Vec<i32>>,
    /// Marks, each with the number of rows before it.
    marks: Vec<(usize, String)>,
    link_events: Vec<(usize, String)>,
    counts: StreamCounts,
    report: Option<FileReport>,
    error: Option<String>,
}

/// The first byte sets the options, the second the size of the reads.
pub(crate) fn check(input: &[u8]) {
    let [options, size, bytes @ ..] = input else { return };
    let map = (options & 4 == 4).then(|| "gyro_x=1:deg/s,accel_z=az:g,t=t:ns".parse().unwrap());
    let topic = (options & 48 == 48).then(|| "gyro".to_owned());
    let capture_options = CaptureOptions { columns: map, topic, ..CaptureOptions::default() };
    let open = |piece| Capture::from_reader(Dribble { bytes: Cursor::new(bytes.to_vec()), piece }, &capture_options);
    let line_by_line = options & 2 == 2;
    let read = |piece, line_by_line| {
        open(piece).map_err(|error| error.to_string()).map(|capture| {
            told(
                capture,
                ReadOptions {
                    accept_unchecked: options & 1 == 1,
                    line_by_line,
                    diagnostics: options & 8 == 8,
                    measured: [MeasuredFrames::First, MeasuredFrames::Sentences, MeasuredFrames::Packets]
                        [usize::from(options >> 4) % 3],
                },
                (!is_packed(bytes)).then_some(bytes.len()),
            )
        })
    };
    let whole = read(usize::MAX, false);
    let pieces = read(usize::from(*size) + 1, line_by_line);
    // the format of a stream is decided as soon as its first bytes show it, so that a live one is not delayed. Raw
    // bytes are never refused, so an error belongs to another format
    let differ = match (&whole, &pieces) {
        (Ok(whole), Ok(pieces)) => whole.format != pieces.format,
        // a stream of a table is refused in a format that has one
        (Ok(read), Err(text)) | (Err(text), Ok(read)) => {
            read.format == Some(Format::Raw) || text.contains("it has one stream")
        }
        // columns are refused with the name of the format
        (Err(one), Err(other)) => [one, other].iter().all(|text| text.contains("it is of the format")),
    };
    if differ {
        return;
    }
    // an unpacker that meets damage keeps its output from the same read: the amount depends on the read
    let is_fault = |told: &Result<Told, String>| told.as_ref().map_or(true, |told| told.error.is_some());
    if !(is_compressed(bytes) && (is_fault(&whole) || is_fault(&pieces))) {
        assert_eq!(pieces, whole);
    }
}

/// Like [`check`]; the bytes before the first zero are the times of the reads of the rest.
pub(crate) fn check_with_sidecar(input: &[u8]) {
    let end = input.iter().position(|&byte| byte == 0).unwrap_or(input.len());
    let (timing, bytes) = (&input[..end], input.get(end + 1..).unwrap_or_default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c");
    fs::write(&path, bytes).unwrap();
    fs::write(folder.path().join("c.timing"), timing).unwrap();
    let read = |line_by_line| {
        let opened: Result<_, OpenError> = Capture::open(&path, &CaptureOptions::default());
        let all = (!is_packed(bytes)).then_some(bytes.len());
        opened
            .map_err(|error| error.to_string())
            .map(|capture| told(capture, ReadOptions { line_by_line, ..ReadOptions::default() }, all))
    };
    assert_eq!(read(false), read(true));
}

/// Whether the bytes differ from those that are read, as in a container.
fn is_packed(bytes: &[u8]) -> bool {
    is_compressed(bytes) || [&b"\x89MCAP"[..], b"#ROSBAG", b"SQLite"].iter().any(|magic| bytes.starts_with(magic))
}

fn is_compressed(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b") || bytes.starts_with(b"\x28\xb5\x2f\xfd")
}

/// Reads and measures a capture. `length` is the number of its bytes, if they are all read.
fn told(capture: Capture, options: ReadOptions, length: Option<usize>) -> Told {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let mut told = Told { format: Some(capture.format), ..Told::default() };
    let mut analysis = Analysis::new(Settings::default());
    runtime.block_on(async {
        let mut events = capture.read(options, CancellationToken::new()).unwrap();
        let mut has_ended = false;
        while let Some(event) = events.recv().await {
            assert!(!has_ended, "nothing follows an end");
            match event {
                Event::Batch(batch) => {
                    let before = told.rows.len();
                    told.marks
                        .extend(batch.marks.iter().map(|mark| (before + mark.before_row, format!("{:?}", mark.kind))));
                    told.rows.extend(batch.rows().map(<[i32]>::to_vec));
                    told.counts = batch.link;
                    assert_eq!(batch.link.samples(), told.rows.len() as u64);
                    analysis.absorb(&batch);
                }
                Event::Link(event) => {
                    analysis.take_link_event(&event);
                    told.link_events.push((told.rows.len(), format!("{event:?}")));
                }
                Event::End(end) => {
                    has_ended = true;
                    told.error = end.error.map(|error| error.to_string());
                    told.report = end.report;
                }
            }
        }
        assert!(has_ended, "the reader has died");
    });
    assert_counted(&told, length);
    analysis.finish();
    let snapshot = analysis.snapshot();
    let left_out = snapshot.timing.excluded + snapshot.false_times + snapshot.repeated_rows;
    let counted = snapshot.timing.samples + left_out;
    assert_eq!(counted, told.rows.len() as u64);
    if snapshot.timing.samples > 0 {
        _ = Assessment::new(&snapshot, 0.95);
    }
    told
}

fn assert_counted(told: &Told, length: Option<usize>) {
    let (counts, tally) = (&told.counts, &told.counts.tally);
    let sentences = counts.samples() - tally.measured_packets.samples;
    assert_eq!(tally.valid_sentences(), sentences + tally.replies + counts.other_messages());
    if let (Some(length), None) = (length, &told.error) {
        assert_eq!(counts.bytes(), length as u64);
    }
    match (&told.report, told.format) {
        (None, _) => assert!(!matches!(told.format, Some(Format::Csv | Format::Bag(_)))),
        (Some(FileReport::Csv(csv)), format) => {
            assert_eq!(format, Some(Format::Csv));
            let rejected: u64 = csv.rejected.iter().map(|rows| rows.count).sum();
            let others = csv.other_stream_rows.unwrap_or_default();
            assert_eq!(csv.lines, csv.rows + csv.skipped_lines + rejected + others);
        }
        (Some(FileReport::Bag(bag)), format) => {
            assert!(matches!(format, Some(Format::Bag(_))));
            assert_eq!(bag.messages, bag.used + bag.without_sample + bag.unreadable);
        }
    }
}

/// Returns at most this many bytes at a time.
struct Dribble {
    bytes: Cursor<Vec<u8>>,
    piece: usize,
}

impl Read for Dribble {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = self.piece.min(buffer.len());
        self.bytes.read(&mut buffer[..most])
    }
}

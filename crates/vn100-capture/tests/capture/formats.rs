//! The detected formats of files and the samples in them, through [`Capture`] alone.

use std::{
    collections::BTreeMap,
    io::{self, Cursor, Read, Write},
};

use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, CaptureOptions, End, Event, Format, OpenError, OpenHint, RecordingWriter};
use vn100_protocol::stream::{Batch, Chunk, FileReport, MarkKind, ReadOptions, RejectedRow, StreamInput};

/// A line of the sensor's manual.
const SENTENCE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63";

pub(crate) fn open(bytes: impl AsRef<[u8]>) -> Result<Capture, OpenError> {
    Capture::from_reader(Cursor::new(bytes.as_ref().to_vec()), &CaptureOptions::default())
}

/// A CSV file with a stamp and two channels.
fn csv(rows: usize) -> String {
    let rows = (0..rows).map(|row| format!("{:.3},{:.6},9.{:03}\n", 0.025 * row as f64, 1e-6 * row as f64, row % 7));
    "t,gyro_x,accel_x\n".to_owned() + &rows.collect::<String>()
}

/// The events of a capture.
pub(crate) fn read(capture: Capture, options: ReadOptions) -> (Vec<Batch>, End) {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(async {
        let mut events = capture.read(options, CancellationToken::new()).unwrap();
        let mut batches = Vec::new();
        loop {
            match events.recv().await.unwrap() {
                Event::Batch(batch) => batches.push(*batch),
                event @ Event::Link(_) => panic!("{event:?}"),
                Event::End(end) => return (batches, end),
            }
        }
    })
}

/// The rejected rows of a CSV file by reason, and the number of good ones.
fn rows(bytes: impl AsRef<[u8]>) -> (u64, Vec<(String, u64)>) {
    let capture = open(bytes).unwrap();
    assert_eq!(capture.format, Format::Csv);
    let report = read(capture, ReadOptions::default()).1.report;
    let Some(FileReport::Csv(report)) = report else { panic!("{report:?}") };
    (report.rows, report.rejected.into_iter().map(|rows| (rows.reason.to_string(), rows.count)).collect())
}

#[test]
fn damaged_and_foreign_bytes_leave_a_csv_file_one() {
    let mut zero = csv(100).into_bytes();
    let at = zero.len() - 10;
    zero[at] = 0;
    assert_eq!(rows(zero), (99, vec![("number".into(), 1)]));
    // a superscript two in Latin-1
    let mut latin = csv(100).replace("t,gyro_x", "note [m/s#],gyro_x").into_bytes();
    let at = latin.iter().position(|&byte| byte == b'#').unwrap();
    latin[at] = 0xb2;
    assert_eq!(rows(&latin), (100, vec![]));
    // no known name: the error says so, and the file is not read as a port at the wrong rate
    let unknown = String::from_utf8_lossy(&latin).replace("gyro_x,accel_x", "Rate,Kraft");
    let unknown: Vec<u8> = unknown.chars().map(|c| if c == '\u{fffd}' { 0xb2 } else { c as u8 }).collect();
    assert!(matches!(open(unknown), Err(OpenError::Unusable { .. })));
}

#[test]
fn a_file_gives_the_same_as_a_stream_of_its_bytes() {
    for (between, format) in [("", Format::Text), ("\0", Format::Raw)] {
        let bytes = format!("{between}{SENTENCE}\r\n").repeat(1000);
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes.as_bytes()).unwrap();
        let rows = |capture: Capture| {
            assert_eq!(capture.format, format);
            read(capture, ReadOptions::default()).0.iter().map(Batch::row_count).sum::<usize>()
        };
        let of_file = rows(Capture::open(file.path(), &CaptureOptions::default()).unwrap());
        assert_eq!((of_file, rows(open(&bytes).unwrap())), (1000, 1000));
    }
}

#[test]
fn old_line_ends_are_read() {
    assert_eq!(rows(csv(100).replace('\n', "\r")), (100, vec![]));
}

#[test]
fn bytes_that_are_no_csv_file_keep_their_format() {
    let utf_16: Vec<u8> = csv(100).replace("t,", "n,").bytes().flat_map(|byte| [byte, 0]).collect();
    assert_eq!(open(&utf_16).unwrap().format, Format::Raw);
    assert_eq!(open([b"\xff\xfe", &*utf_16].concat()).unwrap().format, Format::Csv);
    let noise: Vec<u8> = (0..5000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    assert_eq!(open(&noise).unwrap().format, Format::Raw);
    assert_eq!(open([b"\0,\n", SENTENCE.as_bytes(), b"\r\n"].concat()).unwrap().format, Format::Raw);
    assert!(matches!(open([0; 5000]), Err(OpenError::NotACapture { .. })));
    // a table and sentences after the first bytes of other kinds of files
    assert_eq!(rows("MATLAB log\n".to_owned() + &csv(100)), (100, vec![]));
    for (begin, format) in [("MATLAB", Format::Text), ("MATLAB \0", Format::Raw)] {
        assert_eq!(open(format!("{begin} log\r\n{SENTENCE}\r\n")).unwrap().format, format);
    }
}

#[test]
fn a_live_stream_that_begins_within_a_sentence_is_known_by_its_first_whole_one() {
    /// Two lines, and then no data without an end.
    struct Live(Cursor<Vec<u8>>);
    impl Read for Live {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let n = self.0.read(buffer)?;
            assert!(n > 0, "waits for more than it needs");
            Ok(n)
        }
    }
    for (begin, format) in [("0.000391*63", Format::Text), ("\0", Format::Raw)] {
        let bytes = format!("{begin}\r\n{SENTENCE}\r\n").into_bytes();
        assert_eq!(Capture::from_reader(Live(Cursor::new(bytes)), &CaptureOptions::default()).unwrap().format, format);
    }
}

#[test]
fn sentences_with_stamps_of_an_uncertain_unit_are_not_read_without_them() {
    let rows = (0..50).map(|row| format!("{row},{SENTENCE}\n"));
    let error = open("t,raw\n".to_owned() + &rows.collect::<String>()).err().unwrap();
    let OpenError::Unusable { problem, .. } = error else { panic!("{error}") };
    assert_eq!(problem.hint(), Some(&OpenHint::StampUnit("t=t:ms".into())));
}

#[test]
fn every_byte_of_a_csv_file_is_of_a_row_or_skipped() {
    let row = |row: i32, text: &str| format!("{:.3},{text}\n", 0.025 * f64::from(row));
    let rows = |text: &str| (0..20).map(|index| row(index, text)).collect::<String>();
    for (head, good) in [("# by hand\n\nt,raw\n", SENTENCE), ("# by hand\n\nt,gyro_x\n", "0.000001")] {
        let text = format!("{head}{}later,{good}\n{}", rows(good), row(20, good));
        for line_by_line in [false, true] {
            let (batches, _) = read(open(&text).unwrap(), ReadOptions { line_by_line, ..ReadOptions::default() });
            let link = batches.last().unwrap().link;
            let bytes = (link.tally.valid_sentence_bytes, link.tally.rejected_sentence_bytes, link.tally.skipped_bytes);
            let expected = (21 * row(0, good).len(), "later,\n".len() + good.len(), head.len());
            assert_eq!(bytes, (expected.0 as u64, expected.1 as u64, expected.2 as u64), "{head:?}");
            assert_eq!((link.samples(), link.tally.rejected.grammar), (21, 1));
            assert_eq!(link.rejected_rows.unwrap().iter().collect::<Vec<_>>(), [(RejectedRow::Stamp, 1)]);
            let marks = batches.iter().flat_map(|batch| &batch.marks);
            assert_eq!(marks.filter(|mark| mark.kind == MarkKind::Rejected).count(), 1);
        }
    }
}

#[test]
fn line_by_line_gives_each_row_of_a_file_the_bytes_up_to_its_end() {
    let text = csv(3).replace("0.050,", "soon,0.1,9.1\n0.050,");
    let options = ReadOptions { line_by_line: true, ..ReadOptions::default() };
    let (batches, _) = read(open(&text).unwrap(), options);
    let told = batches.iter().filter(|batch| batch.row_count() > 0).map(|batch| batch.link.tally.bytes());
    let line = "0.000,0.000000,9.000\n".len() as u64;
    let (header, rejected) = ("t,gyro_x,accel_x\n".len() as u64, "soon,0.1,9.1\n".len() as u64);
    assert_eq!(told.collect::<Vec<_>>(), [header + line, header + 2 * line, header + rejected + 3 * line]);
}

/// A reader whose every other call is interrupted by a signal, and returns nothing.
struct Interrupted {
    bytes: Cursor<Vec<u8>>,
    is_interrupted: bool,
}

impl Read for Interrupted {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.is_interrupted = !self.is_interrupted;
        if self.is_interrupted { Err(io::ErrorKind::Interrupted.into()) } else { self.bytes.read(buffer) }
    }
}

#[test]
fn an_interrupted_read_is_tried_again() {
    let text = format!("{SENTENCE}\r\n").repeat(50).into_bytes();
    let mut recording = RecordingWriter::new(Vec::new(), &BTreeMap::new()).unwrap();
    recording.write(&StreamInput::Chunk(Chunk { bytes: text.clone().into(), at_ns: Some(1) })).unwrap();
    for bytes in [text, csv(50).into_bytes(), recording.finish(None).unwrap()] {
        let reader = Interrupted { bytes: Cursor::new(bytes), is_interrupted: false };
        let (batches, end) =
            read(Capture::from_reader(reader, &CaptureOptions::default()).unwrap(), ReadOptions::default());
        assert!(end.error.is_none(), "{:?}", end.error);
        assert_eq!(batches.iter().map(Batch::row_count).sum::<usize>(), 50);
    }
}

#[test]
fn files_of_other_programs_are_named() {
    let random: Vec<u8> = (0..4096_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    // scipy.io.savemat(..., {'g': ...}, format='4') of 500 rows of 6
    let matlab_4 = [&[0, 0, 0, 0, 0xf4, 1, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, b'g', 0][..], &random].concat();
    for (head, named) in [
        (&b"MATLAB 5.0 MAT-file, Platform: posix\0\0\0\x01IM"[..], "writematrix"),
        (&matlab_4, "writematrix"),
        (b"\x89HDF\r\n\x1a\n\0", "h5py"),
        (b"\x93NUMPY\x01\0", "numpy.load"),
        (b"RDX3\nX\n\0\0\0\x03", "write.csv"),
        (b"X\n\0\0\0\x03", "readRDS"),
        (b"PAR1", "read_parquet"),
        (b"ARROW1\0\0", "read_feather"),
        (b"\x80\x04\x95", "read_pickle"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "Microsoft Office"),
    ] {
        let refused = open([head, &random].concat()).err().unwrap().to_string();
        assert!(refused.contains(named), "{refused}");
    }
    assert!(open("RDA3\nA\n3\n262146\n").err().unwrap().to_string().contains("write.csv"));
    // a port at the wrong baud rate sends any bytes
    for rows in [0_u8, 9] {
        let bytes = [&[0, 0, 0, 0, rows, 0, 0, 0, 0, 0, 0, 0][..], &random].concat();
        assert_eq!(open(bytes).unwrap().format, Format::Raw);
    }
}

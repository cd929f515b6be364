//! Raw captures and text, with the times of their reads if `NAME.timing` has a row `t_ns,offset`
//! for each read.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, ErrorKind, Read},
    path::{Path, PathBuf},
};

use crate::{
    read_samples::{Event, FileReader},
    source::READ_BYTES,
};
use vn100_protocol::stream::{Batch, FileReport, ReadOptions, SampleReader};

/// Longest line of a sidecar in bytes, comments included.
const LONGEST_LINE: usize = 1024;

/// The last read of the port is assumed to be no longer than this, unless an earlier one was.
const PORT_READ_BYTES: u64 = 4096;

/// The rows of a sidecar, read as they are needed.
pub(crate) struct Sidecar {
    path: PathBuf,
    file: BufReader<File>,
    /// Lines read.
    line: usize,
    last_offset: Option<u64>,
    longest_read: u64,
}

/// One read of the port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ReadStamp {
    /// The time when it returned, in nanoseconds from the recorder's origin.
    at_ns: i64,
    /// The offset of its first byte in the capture.
    offset: u64,
}

impl Sidecar {
    /// The sidecar of a capture; `None` if there is none.
    pub(crate) fn beside(capture: &Path) -> io::Result<Option<Self>> {
        let mut path = capture.as_os_str().to_owned();
        path.push(".timing");
        let path = PathBuf::from(path);
        match File::open(&path) {
            Ok(file) => {
                let file = BufReader::new(file);
                Ok(Some(Self { path, file, line: 0, last_offset: None, longest_read: 0 }))
            }
            // a name too long for a sidecar has none
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::InvalidFilename) => Ok(None),
            Err(error) => Err(io::Error::new(error.kind(), format!("{}: {error}", path.display()))),
        }
    }

    /// The next row. Comments, blank lines and a header are skipped; offsets must not decrease.
    fn next(&mut self) -> io::Result<Option<ReadStamp>> {
        let mut text = Vec::new();
        loop {
            text.clear();
            let mut line = (&mut self.file).take(LONGEST_LINE as u64 + 1);
            match line.read_until(b'\n', &mut text) {
                Ok(0) => return Ok(None),
                Ok(_) => self.line += 1,
                Err(error) => return Err(self.fault(error.kind(), &error.to_string())),
            }
            let row = text.trim_ascii();
            let is_header = self.line == 1 && row.first().is_some_and(u8::is_ascii_alphabetic);
            let is_passed_over = row.is_empty() || row.starts_with(b"#") || is_header;
            if is_passed_over && text.len() <= LONGEST_LINE {
                continue;
            }
            let before = self.last_offset.unwrap_or_default();
            let stamp = ReadStamp::parse(row).filter(|stamp| stamp.offset >= before && text.len() <= LONGEST_LINE);
            let Some(stamp) = stamp else {
                let problem = "is not a row \"nanoseconds,offset\" whose offset is at least that of the row before";
                return Err(self.fault(ErrorKind::InvalidData, &format!("line {} {problem}", self.line)));
            };
            self.longest_read = self.longest_read.max(stamp.offset - before);
            self.last_offset = Some(stamp.offset);
            return Ok(Some(stamp));
        }
    }

    /// The end of the part of the capture that the rows cover, after the last row. The last read is
    /// not longer than the longest read before it or than a usual read of a port; any bytes after
    /// it were read later.
    fn reach(&self) -> u64 {
        let last_read = self.longest_read.max(PORT_READ_BYTES);
        self.last_offset.map_or(0, |offset| offset.saturating_add(last_read))
    }

    /// The error if the capture continues after that end.
    fn ends_early(&self) -> io::Error {
        let problem = match self.last_offset {
            Some(offset) => format!("the rows end at line {} with offset {offset}", self.line),
            None => "there is no row".into(),
        };
        let excluded = format!("but the capture is longer: it is excluded from byte {} on", self.reach());
        self.fault(ErrorKind::UnexpectedEof, &format!("{problem}, {excluded}"))
    }

    /// The error if the capture ends before the read at `offset`.
    fn outlasts(&self, offset: u64, capture_bytes: u64) -> io::Error {
        let problem =
            format!("line {} is a read at byte {offset}, but the capture was cut at byte {capture_bytes}", self.line);
        self.fault(ErrorKind::UnexpectedEof, &problem)
    }

    fn fault(&self, kind: ErrorKind, problem: &str) -> io::Error {
        let path = self.path.display();
        io::Error::new(
            kind,
            format!("{path}: {problem}; move that file away to read the capture without arrival times"),
        )
    }
}

impl ReadStamp {
    fn parse(row: &[u8]) -> Option<Self> {
        let (at_ns, offset) = std::str::from_utf8(row).ok()?.split_once(',')?;
        Some(Self { at_ns: at_ns.trim().parse().ok()?, offset: offset.trim().parse().ok()? })
    }
}

/// Reads and decodes a file on one thread: handing its bytes over to another thread takes longer than
/// decoding them. One batch is for many reads of the port, because a read may have only a few bytes.
pub(crate) struct BytesReader<R> {
    reader: BufReader<R>,
    sidecar: Option<Sidecar>,
    samples: SampleReader,
    /// Bytes of the capture that were read.
    offset: u64,
    /// Arrival time of the current read.
    at_ns: Option<i64>,
    next: Option<ReadStamp>,
    /// Bytes since the last batch.
    unsent: usize,
}

impl<R: Read> BytesReader<R> {
    pub(crate) fn new(reader: R, sidecar: Option<Sidecar>, options: ReadOptions) -> Self {
        let reader = BufReader::with_capacity(READ_BYTES, reader);
        Self { reader, sidecar, samples: SampleReader::new(options), offset: 0, at_ns: None, next: None, unsent: 0 }
    }
}

impl<R: Read + Send + 'static> FileReader for BytesReader<R> {
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        while let Some(sidecar) = &mut self.sidecar {
            if self.next.is_none() {
                self.next = sidecar.next()?;
            }
            match self.next.take_if(|stamp| stamp.offset <= self.offset) {
                Some(stamp) => self.at_ns = Some(stamp.at_ns),
                None => break,
            }
        }
        let buffered = match self.reader.fill_buf() {
            Ok([]) => {
                let lost = self.sidecar.as_ref().zip(self.next);
                return lost.map_or(Ok(None), |(sidecar, read)| Err(sidecar.outlasts(read.offset, self.offset)));
            }
            Ok(buffered) => buffered,
            Err(error) if error.kind() == ErrorKind::Interrupted => return Ok(Some(Vec::new())),
            Err(error) => return Err(error),
        };
        let mut taken = buffered.len();
        if let Some(sidecar) = &self.sidecar {
            let end_of_read = self.next.map_or_else(|| sidecar.reach(), |stamp| stamp.offset);
            let of_read = end_of_read.saturating_sub(self.offset);
            if of_read == 0 {
                return Err(sidecar.ends_early());
            }
            taken = taken.min(usize::try_from(of_read).unwrap_or(usize::MAX));
        }
        self.samples.push(&buffered[..taken], self.at_ns);
        self.reader.consume(taken);
        self.offset += taken as u64;
        self.unsent += taken;
        if self.unsent < READ_BYTES {
            return Ok(Some(Vec::new()));
        }
        self.unsent = 0;
        Ok(Some(self.samples.take_batches().into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        (self.samples.finish(), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_samples::FileEvents;

    /// A line of the sensor's manual, with its line end.
    const LINE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

    fn rows(text: impl AsRef<[u8]>) -> Vec<Result<(i64, u64), String>> {
        let folder = tempfile::tempdir().unwrap();
        let capture = folder.path().join("capture.bin");
        std::fs::write(folder.path().join("capture.bin.timing"), text).unwrap();
        let mut sidecar = Sidecar::beside(&capture).unwrap().unwrap();
        let mut rows = Vec::new();
        loop {
            match sidecar.next() {
                Ok(Some(stamp)) => rows.push(Ok((stamp.at_ns, stamp.offset))),
                Ok(None) => return rows,
                Err(error) => {
                    rows.push(Err(error.to_string()));
                    return rows;
                }
            }
        }
    }

    fn assert_refused(text: impl AsRef<[u8]>, line: u64) {
        let rows = rows(&text);
        let error = rows.last().unwrap().as_ref().unwrap_err();
        assert!(error.contains(&format!("capture.bin.timing: line {line} ")), "{error}");
    }

    /// The stamps of the samples, and the error at the end.
    fn stamped(capture: &str, timing: &str) -> (Vec<i64>, Option<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("capture.bin");
        std::fs::write(folder.path().join("capture.bin.timing"), timing).unwrap();
        let sidecar = Sidecar::beside(&path).unwrap().unwrap();
        let bytes = io::Cursor::new(capture.as_bytes().to_vec());
        let reader = BytesReader::new(bytes, Some(sidecar), ReadOptions::default());
        let mut events = FileEvents::new(Box::new(reader));
        let mut stamps = Vec::new();
        loop {
            match events.next().unwrap() {
                Event::Batch(batch) => {
                    let mut arrivals = batch.arrivals.iter().peekable();
                    for row in 0..batch.row_count() {
                        let at_ns = arrivals.next_if(|arrival| arrival.from_row <= row).map(|arrival| arrival.at_ns);
                        stamps.extend(at_ns.or(stamps.last().copied()));
                    }
                }
                event @ Event::Link(_) => panic!("{event:?}"),
                Event::End(end) => return (stamps, end.error.map(|error| error.to_string())),
            }
        }
    }

    #[test]
    fn a_read_begins_with_the_byte_at_its_offset() {
        // the CR is byte 120 of a line, and completes it
        for (offset, expected) in [(119, 20), (120, 20), (121, 10), (122, 10)] {
            assert_eq!(stamped(LINE, &format!("10,0\n20,{offset}\n")), (vec![expected], None), "{offset}");
        }
        // for several reads at one offset, which returned nothing, the last counts
        assert_eq!(stamped(&LINE.repeat(2), "10,0\n20,122\n30,122\n"), (vec![10, 30], None));
        // a read after the end is lost
        for offset in ["123", "500", "18446744073709551615"] {
            let (stamps, error) = stamped(LINE, &format!("10,0\n20,122\n30,{offset}\n"));
            let lost = format!("line 3 is a read at byte {offset}, but the capture was cut at byte 122");
            assert!(stamps == [10] && error.is_some_and(|error| error.contains(&lost)), "{offset}");
        }
    }

    #[test]
    fn samples_are_given_while_a_long_capture_is_read() {
        let lines = 4 * READ_BYTES / LINE.len();
        let bytes = io::Cursor::new(LINE.repeat(lines).into_bytes());
        let mut events = FileEvents::new(Box::new(BytesReader::new(bytes, None, ReadOptions::default())));
        let Event::Batch(first) = events.next().unwrap() else { panic!("no batch") };
        assert!((1..=lines / 2).contains(&first.row_count()), "{}", first.row_count());
    }

    #[test]
    fn too_few_rows_report_their_end() {
        let capture = LINE.repeat(100);
        // the last row covers 4096 bytes, to within line 34
        let (stamps, error) = stamped(&capture, "10,0\n20,122\n# cut\n");
        assert_eq!(stamps.len(), (122 + 4096) / LINE.len());
        let error = error.unwrap();
        assert!(error.contains("the rows end at line 3 with offset 122"), "{error}");
        assert!(error.contains("excluded from byte 4218 on"), "{error}");
        // it covers as much as the longest read before
        let (stamps, error) = stamped(&capture, "10,0\n20,6100\n");
        assert_eq!((stamps.len(), error), (100, None));
        for empty in ["", "# t_ns,offset\n"] {
            let (stamps, error) = stamped(&capture, empty);
            assert!(stamps.is_empty() && error.unwrap().contains("there is no row"), "{empty:?}");
        }
        assert_eq!(stamped("", ""), (vec![], None));
    }

    #[test]
    fn any_stamp_of_64_bits_is_one() {
        let timing = format!("{},0\n{},122\n-1,244\n", i64::MIN, i64::MAX);
        assert_eq!(stamped(&LINE.repeat(3), &timing), (vec![i64::MIN, i64::MAX, -1], None));
    }

    #[test]
    fn comments_blank_lines_and_a_header_are_passed_over() {
        let expected = [Ok((1_171_022, 0)), Ok((1_381_745, 20)), Ok((1_500_000, 20))];
        assert_eq!(rows("# t_ns,offset\n1171022,0\n1381745,20\r\n\n1500000,20\n"), expected);
        assert_eq!(rows("t_ns,offset\n1171022,0\n1381745,20\n1500000,20\n"), expected);
    }

    #[test]
    fn the_first_line_that_is_no_row_is_named() {
        for (text, line) in
            [("1,0\n2;5\n", 2), ("5\n", 1), ("1,0\n2,9\n3,8\n", 3), ("1,-4\n", 1), ("1,0\nt,offset\n", 2)]
        {
            assert_refused(text, line);
        }
        assert_refused(b"# \xe9t\xe9\n1,0\n2\xb2,5\n", 3);
        assert_refused(&*format!("1,0\n2,{}\n", "0".repeat(LONGEST_LINE)), 2);
        assert_refused(&*format!("1,0\n{}\n", " ".repeat(100_000)), 2);
        assert_refused("9223372036854775808,0\n", 1);
    }

    #[test]
    fn a_name_without_room_for_a_sidecar_has_none() {
        assert!(Sidecar::beside(Path::new(&"x".repeat(250))).unwrap().is_none());
    }
}

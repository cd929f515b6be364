//! Raw captures with the times of their reads: beside the bytes, `NAME.timing` has a row `t_ns,offset` for each read of the port.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, ErrorKind, Lines, Read},
    path::{Path, PathBuf},
    thread,
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use crate::{
    event::{End, Event},
    read_samples::{Parser, ReadOptions, WAITING_BATCHES},
    source::READ_BYTES,
};

/// The rows of a sidecar, read as they are needed.
pub(crate) struct Sidecar {
    path: PathBuf,
    lines: Lines<BufReader<File>>,
    line: usize,
    last_offset: u64,
}

/// One read of the port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ReadStamp {
    /// When it returned, in nanoseconds from the recorder's origin.
    at_ns: i64,
    /// Where its first byte stands in the capture.
    offset: u64,
}

impl Sidecar {
    /// The stamps beside a capture; `None` where there are none.
    pub(crate) fn beside(capture: &Path) -> io::Result<Option<Self>> {
        let mut path = capture.as_os_str().to_owned();
        path.push(".timing");
        let path = PathBuf::from(path);
        match File::open(&path) {
            Ok(file) => Ok(Some(Self { path, lines: BufReader::new(file).lines(), line: 0, last_offset: 0 })),
            // a name too long for a sidecar has none
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::InvalidFilename) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The next row. Comments, blank lines and a header are passed over; offsets must not go back.
    fn next(&mut self) -> io::Result<Option<ReadStamp>> {
        for text in self.lines.by_ref() {
            let text = text?;
            self.line += 1;
            let row = text.trim();
            let is_header = self.line == 1 && row.starts_with(|c: char| c.is_ascii_alphabetic());
            if row.is_empty() || row.starts_with('#') || is_header {
                continue;
            }
            let stamp = row.split_once(',').and_then(|(at_ns, offset)| {
                Some(ReadStamp { at_ns: at_ns.trim().parse().ok()?, offset: offset.trim().parse().ok()? })
            });
            let Some(stamp) = stamp.filter(|stamp| stamp.offset >= self.last_offset) else {
                return Err(io::Error::new(
                    ErrorKind::InvalidData,
                    format!(
                        "line {} of {} is not a row \"nanoseconds,offset\" whose offset is at least that of the row before; move the \
                         file away to read the capture without arrival times",
                        self.line,
                        self.path.display()
                    ),
                ));
            };
            self.last_offset = stamp.offset;
            return Ok(Some(stamp));
        }
        Ok(None)
    }
}

/// Starts a thread that reads a capture with its stamps to the end, or until `stop`; tells as
/// [`read_samples`](crate::read_samples) does, but with one batch for many reads: a recorded read can bring a few bytes.
pub(crate) fn read_timed(
    reader: impl Read + Send + 'static,
    sidecar: Sidecar,
    options: ReadOptions,
    stop: CancellationToken,
) -> io::Result<mpsc::Receiver<Event>> {
    let (events, inbox) = mpsc::channel(WAITING_BATCHES);
    let work = move || {
        let mut parser = Parser::new(options);
        let reader = BufReader::with_capacity(READ_BYTES, reader);
        let error = match read(reader, sidecar, &mut parser, &events, &stop) {
            Ok(Flow::Ended) => None,
            Ok(Flow::NobodyListens) => return,
            Err(error) => Some(error),
        };
        for batch in parser.finish() {
            // a receiver that left has no use for the end either
            let _ = events.blocking_send(Event::Batch(batch));
        }
        let _ = events.blocking_send(Event::End(End { error, csv: None }));
    };
    // ends with the capture, with `stop`, or when the inbox is dropped
    thread::Builder::new().name("capture-reader".into()).spawn(work)?;
    Ok(inbox)
}

enum Flow {
    Ended,
    NobodyListens,
}

fn read(
    mut reader: impl BufRead,
    mut sidecar: Sidecar,
    parser: &mut Parser,
    events: &mpsc::Sender<Event>,
    stop: &CancellationToken,
) -> io::Result<Flow> {
    let mut offset = 0;
    let mut at_ns = None;
    let mut next = sidecar.next()?;
    let mut unsent = 0;
    while !stop.is_cancelled() {
        while let Some(stamp) = next.filter(|stamp| stamp.offset <= offset) {
            at_ns = Some(stamp.at_ns);
            next = sidecar.next()?;
        }
        let buffered = match reader.fill_buf() {
            Ok([]) => break,
            Ok(buffered) => buffered,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        let to_next_read = next.map_or(u64::MAX, |stamp| stamp.offset - offset);
        let taken = buffered.len().min(usize::try_from(to_next_read).unwrap_or(usize::MAX));
        parser.push(&buffered[..taken], at_ns);
        reader.consume(taken);
        offset += taken as u64;
        unsent += taken;
        if unsent >= READ_BYTES {
            unsent = 0;
            for batch in parser.take_batches() {
                if events.blocking_send(Event::Batch(batch)).is_err() {
                    return Ok(Flow::NobodyListens);
                }
            }
        }
    }
    Ok(Flow::Ended)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<Result<(i64, u64), String>> {
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
            let rows = rows(text);
            let error = rows.last().unwrap().as_ref().unwrap_err();
            assert!(error.contains(&format!("line {line} of ")), "{text}: {error}");
        }
    }

    #[test]
    fn a_name_without_room_for_a_sidecar_has_none() {
        assert!(Sidecar::beside(Path::new(&"x".repeat(250))).unwrap().is_none());
    }
}

//! The seam between whatever delivers bytes and everything that reads them.

use std::{
    future::Future,
    io::{self, Read},
    thread,
};

use bytes::{Bytes, BytesMut};
use tokio::sync::mpsc;
use vn100_protocol::DeviceError;

use crate::clock::Clock;

/// Bytes of one read. Large enough that waking the parser for each costs nothing per line, small
/// enough for the second-level cache.
pub(crate) const READ_BYTES: usize = 128 * 1024;

/// Bytes of one read of a live stream, which brings a few lines.
const LIVE_READ_BYTES: usize = 4096;

/// Chunks that may wait between the reading thread and the parser. When they are full the reading
/// thread waits: a capture can.
const WAITING_CHUNKS: usize = 2;

/// Bytes as one read returned them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// The bytes; never empty.
    pub bytes: Bytes,
    /// When the read returned, in nanoseconds from an origin of the source's choice; `None` where
    /// it does not know, as for a plain file.
    pub at_ns: Option<i64>,
}

/// What a source delivers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// What a read brought.
    Chunk(Chunk),
    /// Something befell the link, at this place among the bytes.
    Link(LinkEvent),
}

impl From<Chunk> for Input {
    fn from(chunk: Chunk) -> Self {
        Self::Chunk(chunk)
    }
}

/// What befell the link to a live sensor, or the one that a recording was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkEvent {
    /// When, in nanoseconds from the origin of the [`Chunk`]s' times.
    pub at_ns: i64,
    /// What.
    pub kind: LinkEventKind,
}

/// What a [`LinkEvent`] is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkEventKind {
    /// The sensor can be heard; samples follow, of a new segment.
    Up {
        /// The port by its name, such as `/dev/ttyUSB0`.
        port: String,
        /// Speed of the line in baud; `None` where the link has none, as over TCP.
        baud: Option<u32>,
    },
    /// The sensor is not heard any more; a line that was under way is cut off.
    Down {
        /// What happened, in words.
        cause: String,
    },
    /// Bytes that came while the speed of the line was looked for. No line is searched in them.
    Probed {
        /// How many.
        bytes: u64,
    },
    /// Bytes were lost between the port and this program, because it did not take them in time.
    Overrun {
        /// How many.
        bytes: u64,
    },
    /// The sensor refused a command that did not come from here. Errors that it never tells but
    /// unasked stand in the stream and have no such event.
    UnaskedError {
        /// What it said.
        error: DeviceError,
    },
    /// The output of the sensor had been paused by somebody else, and was made to go on from here.
    OutputResumed,
    /// It was paused again when the link was stopped, as it had been found.
    OutputPaused,
}

/// Anything that delivers bytes: a capture, a port, an emulated sensor, a script in a test.
pub trait Source: Send + 'static {
    /// What comes next, or `None` at the end of the data. Dropping the future loses nothing.
    ///
    /// # Errors
    /// The error of the read that failed; the stream has then ended.
    fn next_input(&mut self) -> impl Future<Output = io::Result<Option<Input>>> + Send;
}

/// A blocking reader on a thread of its own, as fast as its bytes are taken.
#[derive(Debug)]
pub struct ReaderSource {
    // the reading thread holds the other end and stops when this one is dropped
    chunks: mpsc::Receiver<io::Result<Chunk>>,
}

impl ReaderSource {
    /// Starts reading `reader` to its end.
    ///
    /// # Errors
    /// When no thread can be started.
    pub fn spawn(reader: impl Read + Send + 'static) -> io::Result<Self> {
        Self::start(reader, READ_BYTES, None)
    }

    /// Starts reading a live stream, such as the output of another program on standard input; each
    /// read is stamped where it returns.
    ///
    /// A stream that brings nothing keeps its thread until it ends: a blocking read cannot be
    /// called off.
    ///
    /// # Errors
    /// When no thread can be started.
    pub fn spawn_live(reader: impl Read + Send + 'static, clock: Clock) -> io::Result<Self> {
        Self::start(reader, LIVE_READ_BYTES, Some(clock))
    }

    fn start(reader: impl Read + Send + 'static, read_bytes: usize, clock: Option<Clock>) -> io::Result<Self> {
        let (sender, chunks) = mpsc::channel(WAITING_CHUNKS);
        let work = move || read_to_end(reader, read_bytes, clock, &sender);
        thread::Builder::new().name("capture-reader".into()).spawn(work)?;
        Ok(Self { chunks })
    }
}

impl Source for ReaderSource {
    async fn next_input(&mut self) -> io::Result<Option<Input>> {
        Ok(self.chunks.recv().await.transpose()?.map(Input::Chunk))
    }
}

fn read_to_end(
    mut reader: impl Read,
    read_bytes: usize,
    clock: Option<Clock>,
    chunks: &mpsc::Sender<io::Result<Chunk>>,
) {
    loop {
        let mut buffer = BytesMut::zeroed(read_bytes);
        let chunk = match reader.read(&mut buffer) {
            Ok(0) => return,
            Ok(n) => {
                let at_ns = clock.map(|clock| clock.now_ns());
                buffer.truncate(n);
                Ok(Chunk { bytes: buffer.freeze(), at_ns })
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => Err(error),
        };
        let failed = chunk.is_err();
        if chunks.blocking_send(chunk).is_err() || failed {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn only_a_live_stream_is_stamped() {
        for (clock, stamped) in [(None, false), (Some(Clock::start()), true)] {
            let mut source = match clock {
                Some(clock) => ReaderSource::spawn_live(&b"$VNYMR"[..], clock).unwrap(),
                None => ReaderSource::spawn(&b"$VNYMR"[..]).unwrap(),
            };
            let Some(Input::Chunk(chunk)) = source.next_input().await.unwrap() else { panic!("no chunk") };
            assert_eq!((&chunk.bytes[..], chunk.at_ns.is_some()), (&b"$VNYMR"[..], stamped));
            assert_eq!(source.next_input().await.unwrap(), None);
        }
    }
}

//! The seam between whatever delivers bytes and everything that reads them.

use std::{
    future::Future,
    io::{self, Read, Take},
    thread,
};

use bytes::{Bytes, BytesMut};
use tokio::sync::mpsc;

/// Bytes of one read. Large enough that waking the parser for each costs nothing per line, small enough for the second-level cache.
const READ_BYTES: usize = 256 * 1024;

/// Chunks that may wait between the reading thread and the parser. When they are full the reading thread waits: a capture can.
const WAITING_CHUNKS: usize = 2;

/// Bytes as one read returned them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// The bytes; never empty.
    pub bytes: Bytes,
    /// When the read returned, in nanoseconds from an origin of the source's choice; `None` where it does not know, as for a plain
    /// file.
    pub at_ns: Option<i64>,
}

/// Anything that delivers chunks: a capture, a port, an emulated sensor, a script in a test.
pub trait Source: Send + 'static {
    /// The next chunk, or `None` at the end of the data. Dropping the future loses nothing.
    ///
    /// # Errors
    /// The error of the read that failed; the stream has then ended.
    fn next_chunk(&mut self) -> impl Future<Output = io::Result<Option<Chunk>>> + Send;
}

/// A blocking reader on a thread of its own, as fast as its bytes are taken.
#[derive(Debug)]
pub struct ReaderSource {
    // the reading thread holds the other end and stops when this one is dropped
    chunks: mpsc::Receiver<io::Result<Chunk>>,
}

impl ReaderSource {
    /// Starts reading `reader` to its end: in pieces that each bring so many bytes with one stamp, then what is left without one.
    pub(crate) fn spawn(
        mut reader: impl Read + Send + 'static,
        pieces: impl Iterator<Item = (u64, Option<i64>)> + Send + 'static,
    ) -> io::Result<Self> {
        let (sender, chunks) = mpsc::channel(WAITING_CHUNKS);
        let read_all = move || {
            for (bytes, at_ns) in pieces.chain([(u64::MAX, None)]) {
                if read_piece(reader.by_ref().take(bytes), at_ns, &sender).is_err() {
                    return;
                }
            }
        };
        thread::Builder::new().name("capture-reader".into()).spawn(read_all)?;
        Ok(Self { chunks })
    }
}

impl Source for ReaderSource {
    async fn next_chunk(&mut self) -> io::Result<Option<Chunk>> {
        self.chunks.recv().await.transpose()
    }
}

/// There is nothing more to read, or nobody to read for.
struct Ended;

fn read_piece(
    mut reader: Take<impl Read>,
    at_ns: Option<i64>,
    chunks: &mpsc::Sender<io::Result<Chunk>>,
) -> Result<(), Ended> {
    while reader.limit() > 0 {
        let wanted = usize::try_from(reader.limit()).map_or(READ_BYTES, |limit| limit.min(READ_BYTES));
        let mut buffer = BytesMut::zeroed(wanted);
        let chunk = match reader.read(&mut buffer) {
            Ok(0) => return Err(Ended),
            Ok(n) => {
                buffer.truncate(n);
                Ok(Chunk { bytes: buffer.freeze(), at_ns })
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => Err(error),
        };
        let failed = chunk.is_err();
        if chunks.blocking_send(chunk).is_err() || failed {
            return Err(Ended);
        }
    }
    Ok(())
}

//! The seam between whatever delivers bytes and everything that reads them.

use std::{
    future::Future,
    io::{self, Read},
    thread,
};

use bytes::{Bytes, BytesMut};
use tokio::sync::mpsc;

/// Bytes of one read. Large enough that waking the parser for each costs nothing per line, small enough for the second-level cache.
pub(crate) const READ_BYTES: usize = 256 * 1024;

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
    /// Starts reading `reader` to its end.
    ///
    /// # Errors
    /// When no thread can be started.
    pub fn spawn(reader: impl Read + Send + 'static) -> io::Result<Self> {
        let (sender, chunks) = mpsc::channel(WAITING_CHUNKS);
        thread::Builder::new().name("capture-reader".into()).spawn(move || read_to_end(reader, &sender))?;
        Ok(Self { chunks })
    }
}

impl Source for ReaderSource {
    async fn next_chunk(&mut self) -> io::Result<Option<Chunk>> {
        self.chunks.recv().await.transpose()
    }
}

fn read_to_end(mut reader: impl Read, chunks: &mpsc::Sender<io::Result<Chunk>>) {
    loop {
        let mut buffer = BytesMut::zeroed(READ_BYTES);
        let chunk = match reader.read(&mut buffer) {
            Ok(0) => return,
            Ok(n) => {
                buffer.truncate(n);
                Ok(Chunk { bytes: buffer.freeze(), at_ns: None })
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

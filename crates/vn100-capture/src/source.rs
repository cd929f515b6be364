//! The seam between whatever delivers bytes and everything that reads them.

use std::{
    future::Future,
    io::{self, Read},
    thread,
};

use bytes::BytesMut;
use tokio::sync::mpsc;
use vn100_protocol::stream::{Chunk, StreamInput};

use crate::clock::Clock;

/// Bytes of one read. Large enough that waking the parser for each costs nothing per line, small
/// enough for the second-level cache.
pub(crate) const READ_BYTES: usize = 128 * 1024;

/// Bytes of one read of a live stream, which brings a few lines.
const LIVE_READ_BYTES: usize = 4096;

/// Chunks that may wait between the reading thread and the parser. When they are full the reading
/// thread waits: a capture can.
const WAITING_CHUNKS: usize = 2;

/// Anything that delivers bytes: a capture, a port, an emulated sensor, a script in a test.
pub trait Source: Send + 'static {
    /// What comes next, or `None` at the end of the data. Dropping the future loses nothing.
    ///
    /// # Errors
    /// The error of the read that failed; the stream has then ended.
    fn next_input(&mut self) -> impl Future<Output = io::Result<Option<StreamInput>>> + Send;
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
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        Ok(self.chunks.recv().await.transpose()?.map(StreamInput::Chunk))
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
            let Some(StreamInput::Chunk(chunk)) = source.next_input().await.unwrap() else { panic!("no chunk") };
            assert_eq!((&chunk.bytes[..], chunk.at_ns.is_some()), (&b"$VNYMR"[..], stamped));
            assert_eq!(source.next_input().await.unwrap(), None);
        }
    }
}

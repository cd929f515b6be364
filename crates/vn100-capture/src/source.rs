//! Sources of bytes for all readers, and the clock for their times.

use std::{
    future::Future,
    io::{self, Read},
    thread,
    time::{Duration, SystemTime},
};

use bytes::BytesMut;
#[cfg(target_os = "linux")]
use rustix::time::{ClockId, clock_gettime};
use tokio::sync::mpsc;
use vn100_protocol::stream::{Chunk, StreamInput};

/// Bytes of one read: many lines for each wake-up of the parser, within the second-level cache.
pub(crate) const READ_BYTES: usize = 128 * 1024;

/// Bytes of one read of a live stream, which brings a few lines.
const LIVE_READ_BYTES: usize = 4096;

/// Chunks that may wait for the parser; after that the reading thread waits.
const WAITING_CHUNKS: usize = 2;

/// Anything that delivers bytes: a capture, a port, an emulated sensor, a script in a test.
pub trait Source: Send + 'static {
    /// The next input; `None` at the end of the data. Dropping the future loses nothing.
    ///
    /// # Errors
    /// The error of a failed read, which ends the stream.
    fn next_input(&mut self) -> impl Future<Output = io::Result<Option<StreamInput>>> + Send;
}

/// A blocking reader on a thread of its own, which reads as fast as its bytes are consumed.
#[derive(Debug)]
pub struct ReaderSource {
    // the reading thread holds the other end and stops when this one is dropped
    chunks: mpsc::Receiver<io::Result<Chunk>>,
}

impl ReaderSource {
    /// Starts to read `reader` to its end. With a clock it is a live stream, such as the output of
    /// another program on standard input: each input has a few lines at most, with the time when
    /// its read returned. Without a clock the bytes have no time.
    ///
    /// A stream that delivers nothing keeps its thread until the stream ends: a blocking read
    /// cannot be cancelled.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn spawn(reader: impl Read + Send + 'static, clock: Option<Clock>) -> io::Result<Self> {
        let (sender, chunks) = mpsc::channel(WAITING_CHUNKS);
        let work = move || read_to_end(reader, clock, &sender);
        thread::Builder::new().name("capture-reader".into()).spawn(work)?;
        Ok(Self { chunks })
    }
}

impl Source for ReaderSource {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        Ok(self.chunks.recv().await.transpose()?.map(StreamInput::Chunk))
    }
}

fn read_to_end(mut reader: impl Read, clock: Option<Clock>, chunks: &mpsc::Sender<io::Result<Chunk>>) {
    let read_bytes = if clock.is_some() { LIVE_READ_BYTES } else { READ_BYTES };
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

/// Unix time that runs evenly: the wall clock at the start, plus the time elapsed since.
///
/// Steps of the wall clock do not affect it. On Linux the time of a suspend counts; on other
/// systems this depends on the system.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    wall_at_start: Duration,
    /// The reading of the steady clock at the start.
    start: Duration,
}

impl Clock {
    /// A clock that agrees with the wall clock at this moment.
    pub fn start() -> Self {
        // a machine whose clock is not set may have a time before 1970; its stamps then count from 1970
        let wall_at_start = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Self { wall_at_start, start: steady() }
    }

    /// Nanoseconds since 1970-01-01 00:00 UTC.
    pub fn now_ns(&self) -> i64 {
        nanoseconds(self.wall_at_start.saturating_add(steady().saturating_sub(self.start)))
    }
}

/// The nanoseconds; the last year is 2262.
fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

/// The reading of a clock that is never set. The standard library's stops during suspend.
#[cfg(target_os = "linux")]
fn steady() -> Duration {
    clock_gettime(ClockId::Boottime).try_into().unwrap_or_default()
}

#[cfg(not(target_os = "linux"))]
fn steady() -> Duration {
    static FIRST: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    FIRST.elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn only_a_live_stream_is_stamped() {
        for (clock, stamped) in [(None, false), (Some(Clock::start()), true)] {
            let mut source = ReaderSource::spawn(&b"$VNYMR"[..], clock).unwrap();
            let Some(StreamInput::Chunk(chunk)) = source.next_input().await.unwrap() else { panic!("no chunk") };
            assert_eq!((&chunk.bytes[..], chunk.at_ns.is_some()), (&b"$VNYMR"[..], stamped));
            assert_eq!(source.next_input().await.unwrap(), None);
        }
    }

    #[test]
    fn it_starts_at_the_wall_clock_and_never_goes_back() {
        let before = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap();
        let clock = Clock::start();
        let mut last = clock.now_ns();
        assert!(last >= nanoseconds(before));
        for _ in 0..1000 {
            let now = clock.now_ns();
            assert!(now >= last);
            last = now;
        }
    }

    #[test]
    fn only_what_passes_after_the_start_moves_it() {
        // as after a step of the wall clock: the start shows another year, the steady clock continues
        let stepped = Clock { wall_at_start: Duration::from_secs(7), start: steady() };
        let now = stepped.now_ns();
        assert!((7_000_000_000..7_000_000_000 + 3_600_000_000_000).contains(&now), "{now}");
        assert_eq!(nanoseconds(Duration::MAX), i64::MAX);
    }
}

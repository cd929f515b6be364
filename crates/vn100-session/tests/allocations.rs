//! Memory is allocated per read, and per stretch of 256 rows whose windows are planned at once, but
//! not per line. The allocations are counted from the bytes of a chunk to the sums of every channel.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::{io, time::Duration};

use bytes::Bytes;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Settings, SourceFacts};
use vn100_capture::{Source, read_samples};
use vn100_protocol::stream::{Chunk, ReadOptions, StreamInput};
use vn100_session::Session;

/// The same chunk of whole lines, this many times.
struct Again {
    bytes: Bytes,
    left: usize,
}

impl Source for Again {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        self.left = match self.left.checked_sub(1) {
            None => return Ok(None),
            Some(left) => left,
        };
        Ok(Some(StreamInput::Chunk(Chunk { bytes: self.bytes.clone(), at_ns: None })))
    }
}

const LINE: &[u8] = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

/// The number of allocations while this many chunks of this many lines pass through reading,
/// parsing and analysis.
fn allocations(chunks: usize, lines: usize) -> u64 {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
    let source = Again { bytes: LINE.repeat(lines).into(), left: chunks };
    let counted = allocation_counter::measure(|| {
        let outcome = runtime.block_on(async {
            let events = read_samples(source, ReadOptions::default(), CancellationToken::new());
            // no snapshots by the clock, because their number depends on the machine
            let settings = Settings { watch_every: Duration::from_secs(3600), ..Settings::default() };
            Session::of_events(SourceFacts::default(), events, settings).result.await.unwrap()
        });
        assert_eq!(outcome.measured.timing.samples, (chunks * lines) as u64);
    });
    counted.count_total
}

#[test]
fn lines_need_no_allocation() {
    // the first read of a size allocates room; after that a further line costs nothing, and a further chunk a few
    // allocations
    let few = allocations(50, 100);
    // the result of a longer record has a few more octaves
    let hundred_times_the_lines = allocations(50, 10_000);
    let ten_times_the_chunks = allocations(500, 100);
    let extra_lines = 50 * 9900;
    let per_line = hundred_times_the_lines.saturating_sub(few) as f64 / f64::from(extra_lines);
    // the plan of a stretch has fewer than ten
    assert!(per_line < 10.0 / 256.0, "{few} allocations for 5 000 lines, {hundred_times_the_lines} for 500 000");
    let per_chunk = ten_times_the_chunks.saturating_sub(few) as f64 / 450.0;
    assert!(per_chunk < 12.0, "{per_chunk} allocations for each chunk");
}

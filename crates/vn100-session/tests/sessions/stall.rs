//! A live link that stalls for two seconds, from its bytes to the snapshot: no sample is counted as
//! missing, and none is left out.

use std::{io, time::Duration};

use bytes::Bytes;
use tokio::time::{Instant, sleep_until};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Analysis, Settings};
use vn100_capture::{Event, Source};
use vn100_driver::{Connect, ConnectError, Connection, LinkOptions, open_link};
use vn100_protocol::stream::{Chunk, LinkEventKind, StreamInput};

const LINE: &[u8] = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

const STALL_AT: Duration = Duration::from_secs(9);
const STALL: Duration = Duration::from_secs(2);
const LINES_S: u32 = 15;

/// A sensor that sends its output and answers no command, since the start.
#[derive(Clone, Copy)]
struct Sensor {
    start: Instant,
    rate_hz: u32,
    sent: u32,
}

impl Connect for Sensor {
    type Connection = Self;

    const HAS_BAUD: bool = false;

    async fn open(&mut self, _baud: u32) -> Result<Self, ConnectError> {
        Ok(*self)
    }

    fn now_ns(&self) -> i64 {
        i64::try_from(self.start.elapsed().as_nanos()).unwrap()
    }

    fn name(&self) -> String {
        "a sensor".into()
    }
}

impl Source for Sensor {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        if self.sent == LINES_S * self.rate_hz {
            return Ok(None);
        }
        let due = Duration::from_secs(1) * (self.sent + 1) / self.rate_hz;
        let stalled = due > STALL_AT && due < STALL_AT + STALL;
        sleep_until(self.start + if stalled { STALL_AT + STALL } else { due }).await;
        self.sent += 1;
        Ok(Some(Chunk { bytes: Bytes::from_static(LINE), at_ns: Some(self.now_ns()) }.into()))
    }
}

impl Connection for Sensor {
    fn name(&self) -> &str {
        "a sensor"
    }

    fn set_baud(&mut self, _baud: u32) -> io::Result<()> {
        Ok(())
    }

    async fn write(&mut self, _bytes: &[u8]) -> io::Result<()> {
        Ok(())
    }

    async fn close(self) -> Vec<StreamInput> {
        Vec::new()
    }
}

#[tokio::test(start_paused = true)]
async fn a_stall_of_two_seconds_of_a_live_link_is_no_loss() {
    for rate_hz in [40, 200] {
        let sensor = Sensor { start: Instant::now(), rate_hz, sent: 0 };
        let stop = CancellationToken::new();
        let (_link, mut events) = open_link(sensor, LinkOptions::default(), stop.clone());
        let mut analysis = Analysis::new(Settings::default());
        let mut lost = 0;
        while let Some(event) = events.recv().await {
            match event {
                Event::Batch(batch) => analysis.absorb(&batch),
                Event::Link(event) => {
                    analysis.take_link_event(&event);
                    if matches!(event.kind, LinkEventKind::Down { .. }) {
                        lost += 1;
                        // all lines have come; without this the link would reopen the port forever
                        stop.cancel();
                    }
                }
                Event::End(_) => {}
            }
        }
        analysis.finish();
        let timing = analysis.snapshot().timing;
        assert_eq!((timing.samples, lost), (u64::from(LINES_S * rate_hz), 1), "{timing:?}");
        assert_eq!((timing.missing, timing.excluded, timing.segments), (0, 0, 1), "{timing:?}");
    }
}

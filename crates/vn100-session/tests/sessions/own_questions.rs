//! Questions at other speeds than the sensor's reach it as junk; its errors about them are not
//! reported as answers to another program.

use std::{
    io,
    num::NonZeroU32,
    sync::{Arc, Mutex},
    time::Duration,
};

use tokio::time::{Instant, sleep_until, timeout_at};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Event, Source};
use vn100_driver::{BAUD_RATES, Connect, ConnectError, Connection, LinkOptions, open_link};
use vn100_protocol::stream::{Chunk, Diagnostic, LinkEventKind, ReadOptions, StreamCounts, StreamInput};
use vn100_protocol::{Register, xor8};
use vn100_sim::{Device, DeviceConfig, wire::Wire};

/// The sensor is up, and its port has not been opened.
const START: Duration = Duration::from_secs(2);

/// The sensor changes its speed, and the port disappears for a moment.
const CHANGE: Duration = Duration::from_secs(8);

fn speed(baud: u32) -> NonZeroU32 {
    baud.try_into().unwrap()
}

/// An emulated sensor on a wire, on the paused clock.
#[derive(Clone)]
struct Bench {
    wire: Arc<Mutex<Wire>>,
    start: Instant,
    /// One line at another speed, as the sensor receives it.
    junk: &'static [u8],
    /// The number of such lines that it processes only with the next line at its own speed: its
    /// errors about them arrive then.
    waiting: Arc<Mutex<u32>>,
    /// The speed of the port.
    baud: Arc<Mutex<u32>>,
    /// Whether the port has disappeared for a moment, which happens once.
    was_gone: Arc<Mutex<bool>>,
}

impl Bench {
    /// A sensor that sends five lines per second at this speed.
    fn new(baud: u32, faults: &str, junk: &'static [u8]) -> Self {
        let mut wire = Wire::new(Device::new(DeviceConfig::default()), &faults.parse().unwrap(), 1, speed(115_200));
        for setting in ["VNWRG,07,5".to_owned(), format!("VNWRG,05,{baud}")] {
            wire.write(
                format!("${setting}*{:02X}\r\n", xor8(setting.as_bytes())).as_bytes(),
                START - Duration::from_millis(500),
            );
        }
        Self {
            wire: Arc::new(Mutex::new(wire)),
            start: Instant::now(),
            junk,
            waiting: Arc::default(),
            baud: Arc::default(),
            was_gone: Arc::default(),
        }
    }

    fn now(&self) -> Duration {
        START + self.start.elapsed()
    }
}

impl Connect for Bench {
    type Connection = Self;

    const HAS_BAUD: bool = true;

    async fn open(&mut self, baud: u32) -> Result<Self, ConnectError> {
        let mut wire = self.wire.lock().unwrap();
        wire.set_host_baud(speed(baud));
        *self.baud.lock().unwrap() = baud;
        _ = wire.open(self.now());
        Ok(self.clone())
    }

    fn now_ns(&self) -> i64 {
        self.now().as_nanos() as i64
    }

    fn name(&self) -> String {
        "/dev/imu".into()
    }
}

impl Source for Bench {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        loop {
            let wake = {
                let (mut wire, now) = (self.wire.lock().unwrap(), self.now());
                _ = wire.poll_plug(now);
                if now >= CHANGE && !std::mem::replace(&mut *self.was_gone.lock().unwrap(), true) {
                    return Err(io::ErrorKind::BrokenPipe.into());
                }
                let bytes = wire.poll(now);
                if !bytes.is_empty() {
                    return Ok(Some(Chunk { bytes: bytes.into(), at_ns: Some(self.now_ns()) }.into()));
                }
                wire.next_wakeup(now)
            };
            // timers of tokio count in milliseconds
            sleep_until((self.start + (wake - START)).max(Instant::now() + Duration::from_millis(1))).await;
        }
    }
}

impl Connection for Bench {
    fn name(&self) -> &str {
        "/dev/imu"
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.wire.lock().unwrap().set_host_baud(speed(baud));
        *self.baud.lock().unwrap() = baud;
        Ok(())
    }

    async fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let (mut wire, mut waiting) = (self.wire.lock().unwrap(), self.waiting.lock().unwrap());
        if *self.baud.lock().unwrap() != wire.device().baud() {
            *waiting += 1;
            return Ok(());
        }
        for _ in 0..std::mem::take(&mut *waiting) {
            wire.write(self.junk, self.now());
        }
        wire.write(bytes, self.now());
        Ok(())
    }

    async fn close(self) -> Vec<StreamInput> {
        let now = self.now();
        self.wire.lock().unwrap().close(now);
        Vec::new()
    }
}

/// The events of a link in this many seconds.
#[derive(Default)]
struct Told {
    counts: StreamCounts,
    /// The total number of errors that the sensor answered.
    errors: usize,
    /// Refusals that are reported as those of another program.
    foreign: usize,
    ups: usize,
    /// The number of times that the sensor sent its rate.
    rates: usize,
}

async fn told(bench: Bench, seconds: u64) -> Told {
    let options =
        LinkOptions { read: ReadOptions { diagnostics: true, ..ReadOptions::default() }, ..LinkOptions::default() };
    let (_handle, mut events) = open_link(bench, options, CancellationToken::new());
    let end = Instant::now() + Duration::from_secs(seconds);
    let mut told = Told::default();
    while let Ok(Some(event)) = timeout_at(end, events.recv()).await {
        match event {
            Event::Batch(batch) => {
                told.counts = batch.link;
                let is_error = |diagnostic: &&Diagnostic| diagnostic.to_string().contains("reply $VNERR");
                told.errors += batch.diagnostics.iter().filter(is_error).count();
                told.rates += batch.registers.iter().filter(|value| value.register == Register::ASYNC_RATE).count();
            }
            Event::Link(event) => {
                told.ups += usize::from(matches!(event.kind, LinkEventKind::Up { .. }));
                told.foreign += usize::from(matches!(event.kind, LinkEventKind::UnsolicitedError { .. }));
            }
            Event::End(_) => break,
        }
    }
    told
}

#[tokio::test(start_paused = true)]
async fn what_the_baud_scan_provokes_is_not_reported_as_errors_of_another_program() {
    let mut provoked = 0;
    // a wrong checksum; an unknown command
    for junk in [&b"$\xf8\r\n"[..], b"$VNJNK*XX\r\n"] {
        for first in BAUD_RATES {
            for then in BAUD_RATES.into_iter().filter(|then| *then != first) {
                let told = told(Bench::new(first, &format!("baud@8s:{then}"), junk), 12).await;
                assert_eq!(told.ups, 2, "{first} {then}");
                assert_eq!(told.foreign + told.counts.unsolicited_errors.iter().count(), 0, "{first} {then}");
                assert!(told.rates >= 2, "{first} {then}: {} times", told.rates);
                provoked += told.errors;
            }
        }
    }
    assert!(provoked > 700, "{provoked} errors");
}

//! An emulated sensor on a port in memory, on tokio's clock. A session opens it by the same link as a
//! serial port, on every system. With a paused clock a session of hours takes seconds, and a test
//! controls the host and the sensor at each moment.

use std::{
    io,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use tokio::time::{Instant, sleep_until};
use vn100_analysis::protocol::stream::{Chunk, StreamInput};
use vn100_capture::Source;
use vn100_driver::{Connect, ConnectError, Connection, PortProblem};
use vn100_sim::{fault::PlugEvent, wire::Wire};

/// The timers of tokio count in milliseconds.
const TICK: Duration = Duration::from_millis(1);

/// The port of an emulated sensor; clones are the same port. The sensor is switched on when the port
/// is made, and runs as long as a clone is kept.
///
/// One connection at a time is open. Bytes that come while the host does not read are kept: unlike
/// the buffer of a system, the buffer of the port is unbounded.
#[derive(Debug, Clone)]
pub struct EmulatedPort(Arc<Mutex<Cable>>);

#[derive(Debug)]
struct Cable {
    wire: Wire,
    switched_on: Instant,
    on_for: Duration,
    origin_ns: i64,
    is_plugged_in: bool,
    /// Number of times that it was plugged in; a connection is valid only for the count at its opening.
    plug_ins: u64,
    is_open: bool,
    /// Whether it returned as another port.
    has_other_name: bool,
}

impl EmulatedPort {
    /// A sensor that has been switched on for `on_for` already; the times of faults count from its
    /// power-up. `origin_ns` is the present time in nanoseconds from the origin of the arrival times,
    /// such as 1970.
    ///
    /// # Panics
    /// With a paused clock, if called outside a tokio runtime.
    pub fn new(wire: Wire, on_for: Duration, origin_ns: i64) -> Self {
        Self(Arc::new(Mutex::new(Cable {
            wire,
            switched_on: Instant::now(),
            on_for,
            origin_ns,
            is_plugged_in: true,
            plug_ins: 1,
            is_open: false,
            has_other_name: false,
        })))
    }

    fn cable(&self) -> MutexGuard<'_, Cable> {
        // after a panic with the lock held, the wire can be polled again
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Cable {
    fn now(&self) -> Duration {
        self.on_for + self.switched_on.elapsed()
    }

    fn now_ns(&self) -> i64 {
        let elapsed = i64::try_from(self.switched_on.elapsed().as_nanos()).unwrap_or(i64::MAX);
        self.origin_ns.saturating_add(elapsed)
    }

    /// Applies the changes of the fault plan to the link up to now.
    fn follow_plug(&mut self) {
        let now = self.now();
        while let Some(event) = self.wire.poll_plug(now) {
            match event {
                PlugEvent::Unplugged => {
                    self.is_plugged_in = false;
                    self.wire.close(now);
                    self.is_open = false;
                }
                PlugEvent::Replugged { other_name } => {
                    self.is_plugged_in = true;
                    self.plug_ins += 1;
                    self.has_other_name |= other_name;
                }
            }
        }
    }

    fn name(&self) -> &'static str {
        if self.has_other_name { "emulated port 2" } else { "emulated port" }
    }
}

impl Connect for EmulatedPort {
    type Connection = EmulatedConnection;

    const HAS_BAUD: bool = true;

    async fn open(&mut self, baud: u32) -> Result<EmulatedConnection, ConnectError> {
        let mut cable = self.cable();
        cable.follow_plug();
        let problem = match baud.try_into() {
            _ if !cable.is_plugged_in => PortProblem::NotFound(Vec::new()),
            _ if cable.is_open => PortProblem::Busy(Some("another connection of this program".into())),
            Err(_) => PortProblem::Other(io::ErrorKind::InvalidInput.into()),
            Ok(speed) => {
                let now = cable.now();
                cable.wire.set_host_baud(speed);
                cable.is_open = true;
                let (name, plug_in, old) = (cable.name(), cable.plug_ins, cable.wire.open(now));
                return Ok(EmulatedConnection { port: self.clone(), name, plug_in, old });
            }
        };
        Err(ConnectError::Port { port: self.name(), baud, problem })
    }

    fn now_ns(&self) -> i64 {
        self.cable().now_ns()
    }

    fn name(&self) -> String {
        "emulated port".into()
    }
}

/// An open port; dropping it closes it.
#[derive(Debug)]
pub struct EmulatedConnection {
    port: EmulatedPort,
    name: &'static str,
    plug_in: u64,
    /// Bytes that were in the adapter when it was opened.
    old: Vec<u8>,
}

impl EmulatedConnection {
    /// The cable, if the port has not been replaced since it was opened.
    fn cable(&self) -> io::Result<MutexGuard<'_, Cable>> {
        let mut cable = self.port.cable();
        cable.follow_plug();
        match cable.is_plugged_in && cable.plug_ins == self.plug_in {
            true => Ok(cable),
            false => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn received(&mut self) -> io::Result<Option<StreamInput>> {
        let mut bytes = std::mem::take(&mut self.old);
        let mut cable = self.cable()?;
        let now = cable.now();
        bytes.extend(cable.wire.poll(now));
        Ok((!bytes.is_empty()).then(|| Chunk { bytes: bytes.into(), at_ns: Some(cable.now_ns()) }.into()))
    }
}

impl Source for EmulatedConnection {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        loop {
            if let Some(input) = self.received()? {
                return Ok(Some(input));
            }
            let wait = {
                let cable = self.cable()?;
                let now = cable.now();
                cable.wire.next_wakeup(now).saturating_sub(now)
            };
            sleep_until(Instant::now() + wait.max(TICK)).await;
        }
    }
}

impl Connection for EmulatedConnection {
    fn name(&self) -> &str {
        self.name
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        let speed = baud.try_into().map_err(|_| io::Error::from(io::ErrorKind::InvalidInput))?;
        self.old.clear();
        let mut cable = self.cable()?;
        let now = cable.now();
        // as for a serial port, bytes at the former speed are not read
        _ = cable.wire.poll(now);
        cable.wire.set_host_baud(speed);
        Ok(())
    }

    async fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut cable = self.cable()?;
        let now = cable.now();
        cable.wire.write(bytes, now);
        Ok(())
    }

    async fn close(mut self) -> Vec<StreamInput> {
        // a port that has disappeared leaves no bytes
        self.received().ok().flatten().into_iter().collect()
    }
}

impl Drop for EmulatedConnection {
    fn drop(&mut self) {
        if let Ok(mut cable) = self.cable() {
            let now = cable.now();
            cable.wire.close(now);
            cable.is_open = false;
        }
    }
}

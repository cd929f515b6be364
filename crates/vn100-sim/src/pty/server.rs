//! The thread that connects an emulated sensor and its pseudo-terminal.

use std::{
    collections::VecDeque,
    io,
    num::NonZeroU32,
    os::fd::OwnedFd,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use rustix::{
    event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll},
    io::{Errno, write},
};

use super::{
    PtyOptions, PtyStats,
    port::{HostChange, Outbox, PseudoTerminal, SymbolicLink, with_suffix},
};
use crate::{device::Device, fault::PlugEvent, wire::Wire};

/// The number of former ports that are kept. A host that looks for the baud rate opens the link again and
/// again, and may be a few openings behind.
const MOST_FORMER: usize = 4;

/// The longest wait at the end for a host that still reads.
const LINGER: Duration = Duration::from_secs(1);

/// The interval for checking whether the host has read all bytes.
const LINGER_STEP: Timespec = Timespec { tv_sec: 0, tv_nsec: 2_000_000 };

/// A sensor that is connected until this handle is dropped or stopped.
#[derive(Debug)]
pub struct PtySensor {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

#[derive(Debug)]
struct Shared {
    stop: AtomicBool,
    waker: OwnedFd,
    state: Mutex<SharedState>,
}

#[derive(Debug, Default)]
struct SharedState {
    path: PathBuf,
    stats: PtyStats,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, SharedState> {
        // numbers and a path are never half changed
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Connects a sensor and switches it on.
///
/// # Errors
/// If the machine has no pseudo-terminal left, or the link cannot be made.
pub fn serve(device: Device, options: PtyOptions) -> io::Result<PtySensor> {
    let waker = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
    let shared = Arc::new(Shared { stop: AtomicBool::new(false), waker, state: Mutex::default() });
    let baud = host_baud(&device);
    let mut server = Server {
        wire: Wire::new(device, &options.faults, options.seed, baud),
        port: None,
        former: VecDeque::new(),
        outbox: Outbox::default(),
        link: None,
        link_path: options.link,
        switched_on: Instant::now(),
        on_for: options.on_for,
        shared: Arc::clone(&shared),
    };
    server.plug_in(false)?;
    let thread = thread::Builder::new().name("vn100-sim".to_owned()).spawn(move || server.run());
    Ok(PtySensor { shared, thread: Some(thread?) })
}

impl PtySensor {
    /// The path for a host to open: the link if there is one. Without a link the path changes
    /// when a host closes the port; while the sensor is unplugged it is the last path.
    pub fn path(&self) -> PathBuf {
        self.shared.state().path.clone()
    }

    /// Byte counts so far.
    pub fn stats(&self) -> PtyStats {
        self.shared.state().stats
    }

    /// Unplugs the sensor once the host has read all bytes sent to it, or after a second.
    ///
    /// # Errors
    /// If the thread of the sensor had ended before.
    pub fn stop(mut self) -> io::Result<PtyStats> {
        self.end()?;
        Ok(self.stats())
    }

    fn end(&mut self) -> io::Result<()> {
        self.shared.stop.store(true, Ordering::Release);
        // a counter that is full wakes as well
        _ = write(&self.shared.waker, &1_u64.to_ne_bytes());
        let Some(thread) = self.thread.take() else { return Ok(()) };
        thread.join().unwrap_or_else(|_| Err(io::Error::other("internal error in the emulated sensor")))
    }
}

impl Drop for PtySensor {
    fn drop(&mut self) {
        // the receiver was dropped
        _ = self.end();
    }
}

struct Server {
    wire: Wire,
    /// `None` while it is unplugged.
    port: Option<PseudoTerminal>,
    /// The latest ports before this one: a host that looked up the name of one of them just before finds a
    /// sensor there, and not a port that is hung up.
    former: VecDeque<PseudoTerminal>,
    outbox: Outbox,
    link: Option<SymbolicLink>,
    link_path: Option<PathBuf>,
    switched_on: Instant,
    on_for: Duration,
    shared: Arc<Shared>,
}

impl Server {
    fn run(mut self) -> io::Result<()> {
        while !self.shared.stop.load(Ordering::Acquire) {
            let now = self.now();
            self.follow_plug(now)?;
            self.follow_host(now)?;
            self.exchange(now)?;
            self.sleep(self.wire.next_wakeup(now).saturating_sub(self.now()))?;
        }
        self.linger()
    }

    /// Time since power-up.
    fn now(&self) -> Duration {
        self.on_for + self.switched_on.elapsed()
    }

    fn follow_plug(&mut self, now: Duration) -> io::Result<()> {
        while let Some(event) = self.wire.poll_plug(now) {
            match event {
                PlugEvent::Unplugged => {
                    self.hang_up(now);
                    self.link = None;
                    self.port = None;
                    self.former.clear();
                }
                PlugEvent::Replugged { other_name } => self.plug_in(other_name)?,
            }
        }
        Ok(())
    }

    fn follow_host(&mut self, now: Duration) -> io::Result<()> {
        let Some(port) = &mut self.port else { return Ok(()) };
        match port.host_change()? {
            None => {}
            Some(HostChange::Opened) => self.open(now)?,
            Some(HostChange::Reopened) => {
                self.hang_up(now);
                self.open(now)?;
            }
            Some(HostChange::Left) => {
                self.hang_up(now);
                self.replace_port()?;
            }
        }
        self.follow_former(now)
    }

    fn open(&mut self, now: Duration) -> io::Result<()> {
        self.shared.state().stats.openings += 1;
        let stale = self.wire.open(now);
        self.give(&stale)
    }

    fn exchange(&mut self, now: Duration) -> io::Result<()> {
        if let Some(port) = &self.port {
            if let Some(baud) = port.host_baud()? {
                self.wire.set_host_baud(baud);
            }
            let written = port.read()?;
            if !written.is_empty() {
                // a host that has written has opened the port: otherwise the wire would drop the replies as
                // if no host were there
                self.follow_host(now)?;
                self.wire.write(&written, now);
            }
        }
        let bytes = self.wire.poll(now);
        self.give(&bytes)
    }

    /// Writes bytes for the host, after the pending ones.
    fn give(&mut self, bytes: &[u8]) -> io::Result<()> {
        let Some(port) = &self.port else { return Ok(()) };
        let dropped = self.outbox.push(bytes);
        let sent = self.outbox.forward(port)?;
        let mut state = self.shared.state();
        state.stats.bytes_sent += sent as u64;
        state.stats.bytes_dropped += dropped as u64;
        Ok(())
    }

    /// The host has closed the port: pending bytes are dropped.
    fn hang_up(&mut self, now: Duration) {
        self.wire.close(now);
        self.shared.state().stats.bytes_unread += self.outbox.clear() as u64;
    }

    fn plug_in(&mut self, other_name: bool) -> io::Result<()> {
        let port = PseudoTerminal::new(host_baud(self.wire.device()))?;
        let path = match &self.link_path {
            None => port.path.clone(),
            Some(link) => {
                let link = if other_name { with_suffix(link, "-1") } else { link.clone() };
                self.link = Some(SymbolicLink::make(&link, &port.path)?);
                link
            }
        };
        self.shared.state().path = path;
        self.port = Some(port);
        Ok(())
    }

    /// A host has left: the next one finds a new port.
    fn replace_port(&mut self) -> io::Result<()> {
        let fresh = PseudoTerminal::new(host_baud(self.wire.device()))?;
        self.lead_to(&fresh.path)?;
        self.former.extend(self.port.replace(fresh));
        if self.former.len() > MOST_FORMER {
            self.former.pop_front();
        }
        Ok(())
    }

    /// Returns to a former port if a host has opened that one, and none this one.
    fn follow_former(&mut self, now: Duration) -> io::Result<()> {
        for former in &mut self.former {
            former.host_change()?;
        }
        if self.port.as_ref().is_some_and(|port| !port.host_is_there)
            && let Some(place) = self.former.iter().position(|former| former.host_is_there)
            && let Some(port) = self.former.remove(place)
        {
            self.lead_to(&port.path)?;
            self.former.extend(self.port.replace(port));
            self.open(now)?;
        }
        Ok(())
    }

    fn lead_to(&self, port: &Path) -> io::Result<()> {
        match &self.link {
            Some(link) => link.turn(port)?,
            None => self.shared.state().path = port.to_owned(),
        }
        Ok(())
    }

    fn sleep(&self, time: Duration) -> io::Result<()> {
        let timeout = Timespec::try_from(time).unwrap_or(Timespec { tv_sec: 1, tv_nsec: 0 });
        match &self.port {
            Some(port) => port.wait(&self.shared.waker, &self.former, !self.outbox.is_empty(), &timeout),
            None => match poll(&mut [PollFd::new(&self.shared.waker, PollFlags::IN)], Some(&timeout)) {
                Ok(_) | Err(Errno::INTR) => Ok(()),
                Err(error) => Err(error.into()),
            },
        }
    }

    /// Waits for the host, because bytes that it has not read are lost when the port is removed.
    fn linger(mut self) -> io::Result<()> {
        let since = Instant::now();
        loop {
            self.give(&[])?;
            let Some(port) = &mut self.port else { break };
            let left = port.host_change()? == Some(HostChange::Left);
            let in_terminal = port.unread()?;
            if left || (self.outbox.is_empty() && in_terminal == 0) || since.elapsed() > LINGER {
                let mut state = self.shared.state();
                state.stats.bytes_sent = state.stats.bytes_sent.saturating_sub(in_terminal);
                state.stats.bytes_unread += in_terminal;
                break;
            }
            // the waker is readable now, so this waits only for the time
            poll(&mut [], Some(&LINGER_STEP))?;
        }
        self.shared.state().stats.bytes_unread += self.outbox.clear() as u64;
        Ok(())
    }
}

/// The rate at which a host finds the port.
fn host_baud(device: &Device) -> NonZeroU32 {
    NonZeroU32::new(device.baud()).unwrap_or(NonZeroU32::MIN)
}

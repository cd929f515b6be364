//! A recorded link that is unplugged and plugged in again a thousand times leaves no thread, no
//! open file and no memory. The test is alone in its process, in order to count them.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod support;

use std::{
    collections::BTreeMap,
    fs,
    io::Write,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    time::Duration,
};

use serialport::{SerialPort, TTYPort};
use support::{LINE, Sensor, packet};
use tokio::{
    runtime::{Builder, Runtime},
    sync::{mpsc, watch},
    task::{JoinHandle, JoinSet},
    time::interval,
};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Clock, Event, Recorder};
use vn100_driver::{LinkHandle, LinkOptions, LinkState, SerialPorts, open_link};
use vn100_protocol::stream::{Chunk, LinkEventKind};

const PORTS: usize = 50;
/// The first rounds bring everything to its usual size, later ones must not increase it. On a busy
/// machine this may take longer, but with a leak the growth does not end.
const ROUNDS: usize = 10;
const MOST_ROUNDS: usize = 50;
const ROUNDS_IN_MEMORY: usize = 5_000;

fn count(folder: &str) -> usize {
    fs::read_dir(folder).unwrap().count()
}

/// Anonymous memory of this process in bytes.
fn memory() -> usize {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let kib = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).unwrap();
    kib.trim().trim_end_matches(" kB").parse::<usize>().unwrap() * 1024
}

#[test]
fn a_thousand_unplugs_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    // one thread opens ports, and it stays
    let runtime = |builder: &mut Builder| -> Runtime {
        let builder = builder.enable_all().max_blocking_threads(1).thread_keep_alive(Duration::from_secs(3600));
        builder.build().unwrap()
    };
    // before the ports, because they leave free memory that would hide growth
    for (sensor, frame_length) in sensors() {
        let unplugged = unplug_in_memory(folder.path(), sensor, frame_length);
        runtime(Builder::new_current_thread().start_paused(true)).block_on(unplugged);
    }
    let live = runtime(&mut Builder::new_current_thread());
    live.block_on(async { tokio::task::spawn_blocking(|| ()).await }).unwrap();
    live.block_on(unplug_ports(folder.path()));
}

/// A sensor of sentences at 200 Hz, and one of packets at 800 Hz.
fn sensors() -> [(Sensor, usize); 2] {
    let sensor_of_packets = Sensor::new(921_600, 800);
    // acceleration, angular rate and temperature
    let packet = packet(&[4, 0x1C, 0x00], 28);
    sensor_of_packets.world().packet = Some(packet);
    sensor_of_packets.world().registers.insert(75, "1,1,04,001C".into());
    [(Sensor::new(921_600, 200), LINE.len()), (sensor_of_packets, packet.len())]
}

async fn unplug_in_memory(folder: &Path, sensor: Sensor, frame_length: usize) {
    let (files, threads) = (count("/proc/self/fd"), count("/proc/self/task"));
    let recorder = Recorder::create(folder.join(format!("memory-{frame_length}.mcap")), &BTreeMap::new()).unwrap();
    let waiting = recorder.inputs();
    let mut link = sensor.link(LinkOptions { recording: Some(waiting.clone()), ..LinkOptions::default() });
    let period = sensor.world().period;
    let mut used = 0;
    for round in 0..ROUNDS_IN_MEMORY {
        link.until_up().await;
        link.run(20 * period).await;
        sensor.world().cut_at = Some(round % frame_length);
        link.until_down().await;
        sensor.world().plugged = true;
        // the log of the test grows as well
        sensor.world().written.clear();
        sensor.world().opened.clear();
        link.told.link.clear();
        link.told.registers.clear();
        // the thread that writes is slower than virtual time, so its queue would grow as well
        while waiting.capacity() < waiting.max_capacity() {
            std::thread::yield_now();
        }
        if round == ROUNDS_IN_MEMORY / 10 {
            used = memory();
        }
    }
    let grown = memory().saturating_sub(used);
    assert!(grown < ROUNDS_IN_MEMORY * 32, "{grown} bytes more");
    drop(waiting);
    let told = link.stop().await;
    assert_eq!(told.counts.connects, ROUNDS_IN_MEMORY as u64);
    // every complete line is a row; so is a sentence that only lacks its line end
    let whole = sensor.world().lines;
    assert!((whole..whole + ROUNDS_IN_MEMORY as u64 / 50).contains(&told.rows), "{} rows of {whole}", told.rows);
    recorder.finish("stopped").await;
    settle(files, threads).await;
}

async fn unplug_ports(folder: &Path) {
    let (files_before, threads_before) = (count("/proc/self/fd"), count("/proc/self/task"));
    let mut ports: Vec<_> =
        JoinSet::from_iter((0..PORTS).map(|number| Port::new(folder.into(), number))).join_all().await;
    let (mut files, mut threads, mut used, mut grown, mut unplugs) = (0, 0, 0, usize::MAX, 0);
    for round in 0..=MOST_ROUNDS {
        ports = JoinSet::from_iter(ports.into_iter().map(Port::bring_up)).join_all().await;
        if round == 0 {
            // the search for other programs on the ports has ended
            tokio::task::spawn_blocking(|| ()).await.unwrap();
            (files, threads) = (count("/proc/self/fd"), count("/proc/self/task"));
            // the thread that reads and the one that records
            assert_eq!(threads, threads_before + 2 * PORTS);
        }
        settle(files, threads).await;
        if round > 0 && round % ROUNDS == 0 {
            let before = std::mem::replace(&mut used, memory());
            if round > ROUNDS {
                grown = used.saturating_sub(before);
            }
            if grown < ROUNDS * PORTS * 640 || round == MOST_ROUNDS {
                break;
            }
        }
        ports = JoinSet::from_iter(ports.into_iter().map(Port::unplug)).join_all().await;
        unplugs += 1;
    }
    assert!(grown < ROUNDS * PORTS * 640, "{grown} bytes more after {} unplugs", ROUNDS * PORTS);
    for port in ports {
        assert_eq!(port.close().await, 1 + unplugs, "it was brought up at first and after each unplug");
    }
    settle(files_before, threads_before).await;
}

/// Waits for threads and files that remain only for a moment: a thread is done with everything before
/// the system takes it off its list, and the search for other programs on a port reads folders.
async fn settle(files: usize, threads: usize) {
    while count("/proc/self/fd") > files || count("/proc/self/task") > threads {
        tokio::task::yield_now().await;
    }
}

/// A port that can be unplugged, with a recorded link on it.
struct Port {
    name: PathBuf,
    sensor: TTYPort,
    state: watch::Receiver<LinkState>,
    stop: CancellationToken,
    recorder: Recorder,
    /// The number of connects.
    ups: JoinHandle<usize>,
}

impl Port {
    async fn new(folder: PathBuf, number: usize) -> Self {
        let name = folder.join(format!("imu-{number}"));
        let sensor = plug_in(&name);
        let recorder = Recorder::create(folder.join(format!("{number}.mcap")), &BTreeMap::new()).unwrap();
        // its buffers reach their full size with the first 64 KiB
        for _ in 0..100 {
            recorder.inputs().send(Chunk { bytes: vec![b'x'; 1024].into(), at_ns: Some(0) }.into()).await.unwrap();
        }
        let options = LinkOptions { baud: Some(115_200), recording: Some(recorder.inputs()), ..LinkOptions::default() };
        let stop = CancellationToken::new();
        let ports = SerialPorts::new(name.to_str().unwrap(), Clock::start());
        let (handle, events) = open_link(ports, options, stop.clone());
        Self { name, sensor, state: handle.state(), stop, recorder, ups: tokio::spawn(count_ups(events, handle)) }
    }

    /// Sends lines until the link is up.
    async fn bring_up(mut self) -> Self {
        let mut lines = interval(Duration::from_millis(10));
        loop {
            tokio::select! {
                up = self.state.wait_for(|state| matches!(state, LinkState::Up(_))) => {
                    up.unwrap();
                    break;
                }
                // until the port is opened there is no receiver
                _ = lines.tick() => drop(self.sensor.write_all(LINE.as_bytes())),
            }
        }
        // the back-off is reset by a good line
        self.sensor.write_all(LINE.as_bytes()).unwrap();
        self
    }

    /// Removes the port and creates another of the same name, for which the link then searches.
    async fn unplug(mut self) -> Self {
        self.sensor = plug_in(&self.name);
        self.state.wait_for(|state| matches!(state, LinkState::Down { .. })).await.unwrap();
        self
    }

    async fn close(self) -> usize {
        let Self { mut state, stop, recorder, ups, .. } = self;
        stop.cancel();
        // a link that has ended has no state any more
        let _ = state.wait_for(|state| matches!(state, LinkState::Closed { .. })).await;
        let ended = recorder.finish("stopped").await;
        assert!(ended.error.is_none(), "{ended:?}");
        ups.await.unwrap()
    }
}

/// The sensor's end of a new port.
fn plug_in(name: &Path) -> TTYPort {
    let (sensor, ours) = TTYPort::pair().unwrap();
    let fresh = name.with_extension("new");
    symlink(ours.name().unwrap(), &fresh).unwrap();
    fs::rename(fresh, name).unwrap();
    sensor
}

async fn count_ups(mut events: mpsc::Receiver<Event>, _link: LinkHandle) -> usize {
    let mut ups = 0;
    while let Some(event) = events.recv().await {
        ups += usize::from(matches!(event, Event::Link(event) if matches!(event.kind, LinkEventKind::Up { .. })));
    }
    ups
}

//! The emulated sensor on a real pseudo-terminal, opened as a plain file.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Write},
    os::unix::fs::OpenOptionsExt,
    path::{Path, PathBuf},
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    fs::OFlags,
    termios::{OptionalActions, tcgetattr, tcsetattr},
};
use tempfile::TempDir;
use vn100_protocol::{Decoder, Item, Options};
use vn100_sim::{
    Device, DeviceConfig,
    pty::{PtyOptions, PtySensor, serve},
};

/// Far longer than any step of these tests.
const PATIENCE: Duration = Duration::from_secs(10);

/// A sensor that has been on for two seconds, with a link of its own.
fn connected(faults: &str) -> (TempDir, PathBuf, PtySensor) {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("sensor");
    let options = PtyOptions {
        link: Some(link.clone()),
        faults: faults.parse().unwrap(),
        on_for: Duration::from_secs(2),
        ..PtyOptions::default()
    };
    let sensor = serve(Device::new(DeviceConfig::default()), options).unwrap();
    assert_eq!(sensor.path(), link);
    (folder, link, sensor)
}

struct Host {
    port: File,
    read: Vec<u8>,
}

impl Host {
    fn open(path: &Path) -> Self {
        Self::try_open(path).unwrap()
    }

    fn try_open(path: &Path) -> io::Result<Self> {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits();
        let port = OpenOptions::new().read(true).write(true).custom_flags(flags.try_into().unwrap()).open(path)?;
        Ok(Self { port, read: Vec::new() })
    }

    fn set_baud(&self, baud: u32) {
        let mut settings = tcgetattr(&self.port).unwrap();
        settings.set_speed(baud).unwrap();
        tcsetattr(&self.port, OptionalActions::Now, &settings).unwrap();
    }

    /// Reads until enough has come; an error if the port is hung up.
    fn read_until(&mut self, enough: impl Fn(&[u8]) -> bool) -> io::Result<()> {
        let since = Instant::now();
        while !enough(&self.read) {
            assert!(since.elapsed() < PATIENCE, "read only {:?}", String::from_utf8_lossy(&self.read));
            let mut fds = [PollFd::new(&self.port, PollFlags::IN)];
            poll(&mut fds, Some(&Timespec { tv_sec: 1, tv_nsec: 0 })).unwrap();
            let mut piece = [0; 4096];
            match self.port.read(&mut piece) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.read.extend(&piece[..count]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn ask(&mut self, command: &str, answer: &str) {
        self.port.write_all(format!("${command}*XX\r\n").as_bytes()).unwrap();
        self.read_until(|read| read.windows(answer.len()).any(|bytes| bytes == answer.as_bytes())).unwrap();
    }
}

fn valid_sentences(bytes: &[u8]) -> usize {
    let mut lines = 0;
    Decoder::new(Options::default()).push(bytes, |item| lines += usize::from(matches!(item, Item::Sample(_))));
    lines
}

fn wait_until(met: impl Fn() -> bool) {
    let since = Instant::now();
    while !met() {
        assert!(since.elapsed() < PATIENCE);
        poll(&mut [], Some(&Timespec { tv_sec: 0, tv_nsec: 1_000_000 })).unwrap();
    }
}

#[test]
fn a_program_that_opens_the_link_reads_lines_and_is_answered() {
    let (_folder, link, sensor) = connected("");
    let mut host = Host::open(&link);
    host.read_until(|read| valid_sentences(read) >= 3).unwrap();
    host.ask("VNRRG,01", "$VNRRG,01,VN-100S-CR*35\r\n");
    // the terminal changes no byte and echoes none
    assert!(!host.read.windows(2).any(|pair| pair == b"\n\n"));
    let stats = sensor.stop().unwrap();
    assert_eq!(stats.openings, 1);
    assert!(!link.exists() && !link.is_symlink());
}

#[test]
fn the_next_host_finds_a_new_port_without_old_bytes() {
    let (_folder, link, sensor) = connected("");
    let mut target = fs::read_link(&link).unwrap();
    for openings in 1..=3 {
        let mut host = Host::open(&link);
        host.read_until(|read| !read.is_empty()).unwrap();
        assert_eq!(sensor.stats().openings, openings);
        drop(host);
        wait_until(|| fs::read_link(&link).unwrap() != target);
        target = fs::read_link(&link).unwrap();
    }
}

#[test]
fn a_host_that_returns_at_once_is_served() {
    let (_folder, link, _sensor) = connected("");
    for _ in 0..50 {
        Host::open(&link).ask("VNRRG,04", "$VNRRG,04,3.1.0.0*77\r\n");
    }
}

/// As on a busy machine, the program opens a former target of the link later.
#[test]
fn a_host_that_looked_up_a_former_port_is_served_there() {
    let (_folder, link, sensor) = connected("");
    let first = fs::read_link(&link).unwrap();
    let leave = |port: &Path, target: &Path| {
        Host::open(port).ask("VNRRG,04", "$VNRRG,04,3.1.0.0*77\r\n");
        wait_until(|| fs::read_link(&link).unwrap() != target);
        fs::read_link(&link).unwrap()
    };
    let second = leave(&link, &first);
    let third = leave(&first, &first);
    let mut host = Host::open(&second);
    host.ask("VNRRG,04", "$VNRRG,04,3.1.0.0*77\r\n");
    assert_eq!((fs::read_link(&link).unwrap(), sensor.stats().openings), (second.clone(), 3));
    assert!(third != first && third != second);
}

#[test]
fn a_host_at_another_rate_reads_junk_and_gets_no_reply() {
    let (_folder, link, _sensor) = connected("");
    let mut host = Host::open(&link);
    host.set_baud(57_600);
    host.port.write_all(b"$VNASY,0*4F\r\n").unwrap();
    host.read_until(|read| read.len() > 400).unwrap();
    assert_eq!(valid_sentences(&host.read[122..]), 0);
    host.set_baud(115_200);
    host.read_until(|read| valid_sentences(read) >= 2).unwrap();
}

#[test]
fn an_unplugged_sensor_removes_its_port_and_returns() {
    let (folder, link, _sensor) = connected("unplug@2.2s+200ms:other");
    let mut host = Host::open(&link);
    host.read_until(|_| false).unwrap_err();
    assert!(!link.is_symlink());
    let other = folder.path().join("sensor-1");
    wait_until(|| other.exists());
    let mut host = Host::open(&other);
    host.read_until(|read| valid_sentences(read) >= 1).unwrap();
}

#[test]
fn bytes_that_are_not_read_are_dropped_and_counted() {
    let (_folder, link, sensor) = connected("");
    let mut host = Host::open(&link);
    host.ask("VNWRG,06,0", "$VNWRG,06,0*6C\r\n");
    host.ask("VNWRG,05,921600", "$VNWRG,05,921600*53\r\n");
    host.set_baud(921_600);
    // 46 000 bytes per second
    host.ask("VNWRG,75,1,1,01,0601", "$VNWRG,75,1,1,01,0601*");
    wait_until(|| sensor.stats().bytes_dropped > 0);
    // a host that reads again is served again
    let more = host.read.len() + 50_000;
    host.read_until(|read| read.len() > more).unwrap();
    host.ask("VNWRG,75,0,1,01,0601", "$VNWRG,75,0,1,01,0601*");
}

#[test]
fn a_sensor_that_is_stopped_waits_for_its_reader() {
    let (_folder, link, sensor) = connected("");
    let mut host = Host::open(&link);
    wait_until(|| sensor.stats().bytes_sent > 500);
    let (reads, reading) = mpsc::channel();
    let reader = thread::spawn(move || {
        _ = host.read_until(|read| !read.is_empty());
        reads.send(()).unwrap();
        _ = host.read_until(|_| false);
        host.read.len()
    });
    reading.recv().unwrap();
    let stats = sensor.stop().unwrap();
    // a reader that stands still for longer than the sensor waits reads the rest, or finds it removed
    let read = reader.join().unwrap() as u64;
    assert!(
        (stats.bytes_sent..=stats.bytes_sent + stats.bytes_unread).contains(&read),
        "{read} bytes read of {stats:?}"
    );
}

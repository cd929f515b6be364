//! One pseudo-terminal, from the side of the sensor; its pending bytes, and the symbolic link to
//! it.

use std::{
    collections::VecDeque,
    ffi::{OsStr, OsString},
    fs, io,
    mem::MaybeUninit,
    num::NonZeroU32,
    os::{
        fd::OwnedFd,
        unix::{ffi::OsStrExt, fs::symlink},
    },
    path::{Path, PathBuf},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    fs::{Mode, OFlags, fcntl_setfl, inotify, open},
    io::{Errno, ioctl_fionread, read, write},
    pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, ptsname, unlockpt},
    termios::{OptionalActions, tcgetattr, tcsetattr},
};

const SLAVE_FLAGS: OpenptFlags = OpenptFlags::RDWR.union(OpenptFlags::NOCTTY).union(OpenptFlags::CLOEXEC);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HostChange {
    Opened,
    /// It closed the port, and has opened it again.
    Reopened,
    Left,
}

/// A pseudo-terminal that a host can open by its path.
#[derive(Debug)]
pub(super) struct PseudoTerminal {
    master: OwnedFd,
    /// Our own open handle of the host's side. Without it the port would be reported as hung up
    /// until the first host comes, and the number of unread bytes would be unknown.
    slave: Option<OwnedFd>,
    /// Reports openings and closings.
    watch: OwnedFd,
    pub(super) path: PathBuf,
    pub(super) host_is_there: bool,
}

impl PseudoTerminal {
    /// A raw terminal at this baud rate, as left by an earlier program.
    pub(super) fn new(baud: NonZeroU32) -> io::Result<Self> {
        let master = openpt(SLAVE_FLAGS)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        fcntl_setfl(&master, OFlags::NONBLOCK)?;
        let path = PathBuf::from(OsStr::from_bytes(ptsname(&master, Vec::new())?.as_bytes()));
        let slave = ioctl_tiocgptpeer(&master, SLAVE_FLAGS)?;
        // before any byte is written: a cooked terminal would echo it
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        settings.set_speed(baud.get())?;
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        let watch = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK)?;
        inotify::add_watch(&watch, &path, inotify::WatchFlags::OPEN | inotify::WatchFlags::CLOSE)?;
        Ok(Self { master, slave: Some(slave), watch, path, host_is_there: false })
    }

    /// Sleeps until a host acts, here or at a `former` port, there is room (with `for_room`), `waker` is
    /// readable, or the time is over.
    pub(super) fn wait(
        &self,
        waker: &OwnedFd,
        former: &VecDeque<Self>,
        for_room: bool,
        timeout: &Timespec,
    ) -> io::Result<()> {
        let events = if for_room { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
        let mut fds = vec![PollFd::new(waker, PollFlags::IN), PollFd::new(&self.master, events)];
        let ports = std::iter::once(self).chain(former);
        fds.extend(ports.map(|port| PollFd::new(&port.watch, PollFlags::IN)));
        match poll(&mut fds, Some(timeout)) {
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    pub(super) fn host_change(&mut self) -> io::Result<Option<HostChange>> {
        let (closed, open) = self.read_watch()?;
        let before = self.host_is_there;
        if closed {
            // only without our own handle does the port show whether others have one
            self.slave = None;
        }
        if self.slave.is_none() {
            let there = !self.is_hung_up()?;
            self.host_is_there = there;
            return Ok(match (before, there) {
                (_, false) => Some(HostChange::Left),
                (true, true) if closed && open => Some(HostChange::Reopened),
                (true, true) => None,
                (false, true) => Some(HostChange::Opened),
            });
        }
        self.host_is_there |= open;
        Ok((open && !before).then_some(HostChange::Opened))
    }

    /// Whether no one has the port open, ourselves included.
    fn is_hung_up(&self) -> io::Result<bool> {
        let mut fds = [PollFd::new(&self.master, PollFlags::empty())];
        poll(&mut fds, Some(&Timespec::default()))?;
        Ok(fds[0].revents().contains(PollFlags::HUP))
    }

    /// Whether there was a closing, and whether the latest event was an opening.
    fn read_watch(&self) -> io::Result<(bool, bool)> {
        let (mut closed, mut open) = (false, false);
        let mut buffer = [MaybeUninit::uninit(); 1024];
        let mut events = inotify::Reader::new(&self.watch, &mut buffer);
        loop {
            match events.next() {
                Ok(event) => {
                    open = event.events().contains(inotify::ReadFlags::OPEN);
                    closed |= !open;
                }
                Err(Errno::AGAIN) => return Ok((closed, open)),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// The rate that the host has set; `None` for a rate of zero, which hangs up a telephone.
    pub(super) fn host_baud(&self) -> io::Result<Option<NonZeroU32>> {
        Ok(NonZeroU32::new(tcgetattr(&self.master)?.output_speed()))
    }

    pub(super) fn read(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut piece = [0; 512];
        loop {
            match read(&self.master, &mut piece) {
                Ok(0) | Err(Errno::AGAIN) => return Ok(bytes),
                // hung up: there are no more bytes
                Err(Errno::IO) => return Ok(bytes),
                Ok(count) => bytes.extend(&piece[..count]),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Writes bytes for the host; returns the number for which there was room.
    pub(super) fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        let mut written = 0;
        while written < bytes.len() {
            match write(&self.master, &bytes[written..]) {
                Ok(count) => written += count,
                Err(Errno::AGAIN | Errno::IO) => break,
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(written)
    }

    /// Bytes that the host has not read; 0 if a host with exclusive access prevents the query.
    pub(super) fn unread(&self) -> io::Result<u64> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let opened = if self.slave.is_none() { open(&self.path, flags, Mode::empty()).ok() } else { None };
        let Some(slave) = self.slave.as_ref().or(opened.as_ref()) else { return Ok(0) };
        // a poll makes the system pass on the bytes that are on their way between the two sides: otherwise they are not counted
        poll(&mut [PollFd::new(slave, PollFlags::IN)], Some(&Timespec::default()))?;
        Ok(ioctl_fionread(slave)?)
    }
}

/// A terminal holds some 4 KiB, and a stall that delays two seconds of stream causes 48 KiB at 200
/// Hz.
const ROOM: usize = 64 * 1024;

/// The bytes that the terminal did not accept at once, in order.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    waiting: VecDeque<u8>,
}

impl Outbox {
    /// Queues bytes, and returns the number of bytes that did not fit and are lost.
    pub(super) fn push(&mut self, bytes: &[u8]) -> usize {
        let taken = bytes.len().min(ROOM - self.waiting.len());
        self.waiting.extend(&bytes[..taken]);
        bytes.len() - taken
    }

    /// Forwards as many bytes as the terminal has room for, and returns their number.
    pub(super) fn forward(&mut self, port: &PseudoTerminal) -> io::Result<usize> {
        let sent = port.write(self.waiting.make_contiguous())?;
        self.waiting.drain(..sent);
        Ok(sent)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Discards the pending bytes and returns their number.
    pub(super) fn clear(&mut self) -> usize {
        let left = self.waiting.len();
        self.waiting.clear();
        left
    }
}

/// A symbolic link to the current port; removed when it is dropped.
#[derive(Debug)]
pub(super) struct SymbolicLink {
    path: PathBuf,
}

impl SymbolicLink {
    /// Creates the link, or changes the target of the existing one.
    pub(super) fn make(path: &Path, target: &Path) -> io::Result<Self> {
        // if it has a target, it may belong to another sensor
        if fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink())
            && let Ok(leads_to) = fs::canonicalize(path)
        {
            let (path, leads_to) = (path.display(), leads_to.display());
            let text = "end that program, or choose another place for the link";
            return Err(io::Error::other(format!("{path} already leads to {leads_to}: {text}")));
        }
        lead(path, target)?;
        Ok(Self { path: path.to_owned() })
    }

    /// Changes the target. A program that opens the path meanwhile finds either target.
    pub(super) fn turn(&self, target: &Path) -> io::Result<()> {
        lead(&self.path, target)
    }
}

impl Drop for SymbolicLink {
    fn drop(&mut self) {
        // a link that another program has removed is gone as well
        _ = fs::remove_file(&self.path);
    }
}

fn lead(path: &Path, target: &Path) -> io::Result<()> {
    if fs::symlink_metadata(path).is_ok_and(|found| !found.is_symlink()) {
        let text = "exists and is not a symbolic link: remove it, or choose another place for the link";
        return Err(io::Error::other(format!("{} {text}", path.display())));
    }
    let fresh = with_suffix(path, &format!(".{}", std::process::id()));
    let turned = symlink(target, &fresh).and_then(|()| fs::rename(&fresh, path));
    turned.map_err(|error| io::Error::other(format!("cannot make the link {}: {error}", path.display())))
}

/// The same path with more text at its end.
pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut text = OsString::from(path);
    text.push(suffix);
    PathBuf::from(text)
}

#[cfg(test)]
mod tests {
    use std::{
        fs::OpenOptions,
        io::{ErrorKind, Read},
        os::unix::fs::OpenOptionsExt,
    };

    use super::*;

    #[test]
    fn a_burst_arrives_as_far_as_there_is_room_for_it() -> io::Result<()> {
        let port = PseudoTerminal::new(NonZeroU32::MIN)?;
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().try_into().unwrap();
        let mut host = OpenOptions::new().read(true).write(true).custom_flags(flags).open(&port.path)?;
        let burst: Vec<u8> = (0..ROOM + 100).map(|index| (index % 251) as u8).collect();
        let mut outbox = Outbox::default();
        assert_eq!(outbox.push(&burst), 100);
        let at_once = outbox.forward(&port)?;
        assert!(at_once > 0 && !outbox.is_empty(), "{at_once} bytes at once: a terminal of that size tests nothing");
        let (mut read, mut piece) = (Vec::<u8>::new(), [0; 1000]);
        while read.len() < ROOM {
            match host.read(&mut piece) {
                Ok(count) => read.extend(&piece[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    let ready =
                        poll(&mut [PollFd::new(&host, PollFlags::IN)], Some(&Timespec { tv_sec: 9, tv_nsec: 0 }))?;
                    assert_eq!(ready, 1, "nothing more came behind {} bytes", read.len());
                }
                Err(error) => return Err(error),
            }
            outbox.forward(&port)?;
        }
        assert!(read == burst[..ROOM] && outbox.is_empty());
        assert_eq!((outbox.push(b"late"), outbox.clear(), outbox.is_empty()), (0, 4, true));
        Ok(())
    }

    #[test]
    fn a_host_is_there_from_its_opening_to_its_end() -> io::Result<()> {
        let mut port = PseudoTerminal::new(NonZeroU32::MIN)?;
        assert_eq!(port.host_change()?, None);
        let flags = OFlags::NOCTTY.bits().try_into().unwrap();
        let host = OpenOptions::new().read(true).write(true).custom_flags(flags).open(&port.path)?;
        assert_eq!([port.host_change()?, port.host_change()?], [Some(HostChange::Opened), None]);
        drop(host);
        assert_eq!(port.host_change()?, Some(HostChange::Left));
        Ok(())
    }

    #[test]
    fn a_link_changes_its_target_and_is_removed() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("sensor");
        let link = SymbolicLink::make(&path, Path::new("one")).unwrap();
        assert_eq!(fs::read_link(&path)?, Path::new("one"));
        link.turn(Path::new("other")).unwrap();
        assert_eq!(fs::read_link(&path)?, Path::new("other"));
        drop(link);
        assert_eq!(fs::read_dir(folder.path())?.count(), 0);
        Ok(())
    }

    #[test]
    fn a_remaining_link_is_changed_and_a_file_is_not() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("sensor");
        symlink("dead", &path)?;
        drop(SymbolicLink::make(&path, Path::new("one")).unwrap());
        fs::write(&path, "precious")?;
        let error = SymbolicLink::make(&path, Path::new("one")).unwrap_err().to_string();
        assert!(
            error
                .ends_with("sensor exists and is not a symbolic link: remove it, or choose another place for the link")
        );
        assert_eq!(fs::read_to_string(&path)?, "precious");
        Ok(())
    }

    #[test]
    fn a_link_with_a_target_is_not_replaced() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let (path, port) = (folder.path().join("sensor"), folder.path().join("port"));
        fs::write(&port, "")?;
        let link = SymbolicLink::make(&path, &port).unwrap();
        let error = SymbolicLink::make(&path, Path::new("other")).unwrap_err();
        assert!(error.to_string().contains("already leads"), "{error}");
        assert_eq!(fs::read_link(&path)?, port);
        drop(link);
        Ok(())
    }

    #[test]
    fn a_link_into_nowhere_names_its_path() {
        let error = SymbolicLink::make(Path::new("/nowhere/sensor"), Path::new("one")).unwrap_err().to_string();
        assert!(error.starts_with("cannot make the link /nowhere/sensor: "), "{error}");
    }
}

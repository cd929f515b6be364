//! One pseudo-terminal, from the side of the sensor.

use std::{
    ffi::OsStr,
    io,
    mem::MaybeUninit,
    num::NonZeroU32,
    os::{fd::OwnedFd, unix::ffi::OsStrExt},
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

/// What a host has done.
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
    /// Our own hold on the side of the host. Without it the port reads as hung up until the first
    /// host comes, and how much a host has not read yet would be unknown.
    slave: Option<OwnedFd>,
    /// Reports openings and closings; `None` when our hold is gone, from when on a hang-up reports
    /// the end.
    watch: Option<OwnedFd>,
    path: PathBuf,
    host_is_there: bool,
}

impl PseudoTerminal {
    /// Raw, and left at a rate, as by an earlier program.
    pub(super) fn new(baud: NonZeroU32) -> io::Result<Self> {
        let master = openpt(SLAVE_FLAGS)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        fcntl_setfl(&master, OFlags::NONBLOCK)?;
        let path = PathBuf::from(OsStr::from_bytes(ptsname(&master, Vec::new())?.as_bytes()));
        let slave = ioctl_tiocgptpeer(&master, SLAVE_FLAGS)?;
        // before any byte is written: a cooked terminal would send it back
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        settings.set_speed(baud.get())?;
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        let watch = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK)?;
        inotify::add_watch(&watch, &path, inotify::WatchFlags::OPEN | inotify::WatchFlags::CLOSE)?;
        Ok(Self { master, slave: Some(slave), watch: Some(watch), path, host_is_there: false })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Sleeps until a host does something, there is room if that is `for_room`, `waker` is
    /// readable, or the time is over.
    pub(super) fn wait(&self, waker: &OwnedFd, for_room: bool, timeout: &Timespec) -> io::Result<()> {
        let events = if for_room { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
        let mut fds = vec![PollFd::new(waker, PollFlags::IN), PollFd::new(&self.master, events)];
        fds.extend(self.watch.as_ref().map(|watch| PollFd::new(watch, PollFlags::IN)));
        match poll(&mut fds, Some(timeout)) {
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// The latest change since the last call.
    pub(super) fn host_change(&mut self) -> io::Result<Option<HostChange>> {
        let (closed, open) = self.read_watch()?;
        let before = self.host_is_there;
        if closed {
            // only without a hold of our own does the port show whether others have one; from here on it shows their end
            self.watch = None;
            self.slave = None;
        }
        if self.watch.is_none() {
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
        let Some(watch) = &self.watch else { return Ok((closed, open)) };
        let mut buffer = [MaybeUninit::uninit(); 1024];
        let mut events = inotify::Reader::new(watch, &mut buffer);
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

    /// The rate the host has set; `None` for a rate of zero, which hangs up a telephone.
    pub(super) fn host_baud(&self) -> io::Result<Option<NonZeroU32>> {
        Ok(NonZeroU32::new(tcgetattr(&self.master)?.output_speed()))
    }

    /// What the host has written.
    pub(super) fn read(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut piece = [0; 512];
        loop {
            match read(&self.master, &mut piece) {
                Ok(0) | Err(Errno::AGAIN) => return Ok(bytes),
                // hung up: there is nothing more
                Err(Errno::IO) => return Ok(bytes),
                Ok(count) => bytes.extend(&piece[..count]),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Gives bytes to the host; returns how many there was room for.
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

    /// Bytes the host has not read; 0 where a host with exclusive access lets no one ask.
    pub(super) fn unread(&self) -> io::Result<u64> {
        match &self.slave {
            Some(slave) => Ok(ioctl_fionread(slave)?),
            None => match open(&self.path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()) {
                Ok(slave) => Ok(ioctl_fionread(slave)?),
                Err(_) => Ok(0),
            },
        }
    }
}

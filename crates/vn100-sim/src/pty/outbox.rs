//! What a terminal does not take at once: it waits here until there is room.

use std::{collections::VecDeque, io};

use super::port::PseudoTerminal;

/// A terminal takes some 4 KiB at once, and two seconds of stream that a stall held back are 48 KiB
/// at 200 Hz.
const ROOM: usize = 64 * 1024;

/// The bytes on their way to a host, in order.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    waiting: VecDeque<u8>,
}

impl Outbox {
    /// Takes bytes behind those that wait: how many found no room and are lost.
    pub(super) fn push(&mut self, bytes: &[u8]) -> usize {
        let taken = bytes.len().min(ROOM - self.waiting.len());
        self.waiting.extend(&bytes[..taken]);
        bytes.len() - taken
    }

    /// Forwards what the terminal has room for: how many.
    pub(super) fn forward(&mut self, port: &PseudoTerminal) -> io::Result<usize> {
        let sent = port.write(self.waiting.make_contiguous())?;
        self.waiting.drain(..sent);
        Ok(sent)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Gives up what waits: how many.
    pub(super) fn clear(&mut self) -> usize {
        let left = self.waiting.len();
        self.waiting.clear();
        left
    }
}

#[cfg(test)]
mod tests {
    use std::{
        fs::OpenOptions,
        io::{ErrorKind, Read},
        num::NonZeroU32,
        os::unix::fs::OpenOptionsExt,
    };

    use rustix::{
        event::{PollFd, PollFlags, Timespec, poll},
        fs::OFlags,
    };

    use super::*;

    #[test]
    fn a_burst_comes_whole_as_far_as_there_is_room_for_it() -> io::Result<()> {
        let port = PseudoTerminal::new(NonZeroU32::MIN)?;
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().try_into().unwrap();
        let mut host = OpenOptions::new().read(true).write(true).custom_flags(flags).open(port.path())?;
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
}

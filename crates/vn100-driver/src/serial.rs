//! A serial port: a thread of its own blocks in `read`, stamps the bytes and forwards whole frames.

use std::{
    fmt,
    io::{self, ErrorKind, Read, Write},
    path::Path,
    sync::{Arc, Mutex, PoisonError},
    thread,
    time::Duration,
};

use bytes::Bytes;
use serialport::{ClearBuffer, SerialPort};
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::{CancellationToken, DropGuard};

use crate::{
    connect::{Connect, ConnectError, Connection, PortProblem},
    lossy_sender::LossySender,
    ports::{LatencyTimer, PortAddress, PortEntry, list_ports, shorten_latency},
};
use vn100_capture::{Clock, Source};
use vn100_protocol::{
    Framer, Options,
    stream::{Chunk, StreamInput},
};

/// The timeout of a read, after which the thread checks whether to stop; this takes 0.01 % of a
/// core. If a frame is not continued in this time, its part is forwarded.
const READ_TIMEOUT: Duration = Duration::from_millis(50);

/// The most bytes that are forwarded together, more than the longest packet has, and the number of
/// such pieces that may wait: 2.5 s of 800 packets per second. Further bytes are dropped and
/// counted, because a port cannot wait.
const READ_BYTES: usize = 1024;
const WAITING_INPUTS: usize = 2048;

/// The longest wait of closing for the reading thread, which checks for a stop every [`READ_TIMEOUT`].
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// A serial port, by name. It is opened exclusively, with 8N1 and without flow control.
///
/// When the port is opened again, it is found by its stable name, by its own name, and by the
/// serial number of its USB adapter. Clones share the knowledge about the adapter.
#[derive(Clone)]
pub struct SerialPorts {
    address: Arc<Mutex<PortAddress>>,
    list: Arc<dyn Fn() -> Vec<PortEntry> + Send + Sync>,
    clock: Clock,
}

impl SerialPorts {
    /// The port named `name`, such as `/dev/ttyUSB0`; nothing is opened yet.
    pub fn new(name: &str, clock: Clock) -> Self {
        Self::among(name, clock, list_ports)
    }

    /// The port named `name` among those that `list` returns at each opening, the likely ones
    /// first, each by the name of the device and not of a symlink: for ports that [`list_ports`]
    /// does not find.
    pub fn among(name: &str, clock: Clock, list: impl Fn() -> Vec<PortEntry> + Send + Sync + 'static) -> Self {
        Self { address: Arc::new(Mutex::new(PortAddress::new(name))), list: Arc::new(list), clock }
    }

    fn address(&self) -> PortAddress {
        // the value is replaced as a whole, so that a panic leaves a consistent one
        self.address.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Opens the first port that one of its names refers to.
    fn open_now(&self, baud: u32) -> Result<SerialConnection, ConnectError> {
        let (mut address, ports) = (self.address(), (self.list)());
        let given = address.given.clone();
        let mut failure = None;
        for name in address.candidates(&ports) {
            let error = match SerialConnection::open(&name, baud, self.clock) {
                Ok(connection) => {
                    address.learn(&name, &ports);
                    *self.address.lock().unwrap_or_else(PoisonError::into_inner) = address;
                    return Ok(connection);
                }
                Err(error) => ConnectError::of_port(&given, &name, baud, error, ports.clone()),
            };
            // the error of an existing port that cannot be opened explains more than that of a
            // dangling name
            if failure.as_ref().is_none_or(is_not_found) {
                failure = Some(error);
            }
        }
        let is_taken = address.belongs_to_another_port(&given, &ports);
        let failure = failure.filter(|failure| !(is_taken && is_not_found(failure)));
        let problem = if is_taken { PortProblem::AnotherAdapter } else { PortProblem::NotFound }(ports);
        Err(failure.unwrap_or(ConnectError::Port { port: given, baud, problem }))
    }
}

fn is_not_found(error: &ConnectError) -> bool {
    matches!(error, ConnectError::Port { problem: PortProblem::NotFound(_), .. })
}

impl fmt::Debug for SerialPorts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SerialPorts").field("address", &self.address()).finish_non_exhaustive()
    }
}

impl Connect for SerialPorts {
    type Connection = SerialConnection;

    const HAS_BAUD: bool = true;

    async fn open(&mut self, baud: u32) -> Result<SerialConnection, ConnectError> {
        let ports = self.clone();
        // listing the ports of the system and opening one may block
        let opening = tokio::task::spawn_blocking(move || ports.open_now(baud));
        opening.await.unwrap_or_else(|error| {
            let problem = PortProblem::Other(error.into());
            Err(ConnectError::Port { port: self.name(), baud, problem })
        })
    }

    fn now_ns(&self) -> i64 {
        self.clock.now_ns()
    }

    fn name(&self) -> String {
        self.address().given
    }
}

/// An open serial port. Dropping it closes it within 50 ms; [`close`](Connection::close) waits
/// until it is closed.
pub struct SerialConnection {
    name: String,
    port: Box<dyn SerialPort>,
    inputs: mpsc::Receiver<StreamInput>,
    end: oneshot::Receiver<io::Error>,
    /// Stops the reading thread when the connection is dropped.
    stop: DropGuard,
    latency_timer: Option<LatencyTimer>,
}

impl SerialConnection {
    fn open(name: &str, baud: u32, clock: Clock) -> serialport::Result<Self> {
        let port = serialport::new(name, baud).timeout(READ_TIMEOUT).open()?;
        // bytes from before the baud rate was set are garbled
        port.clear(ClearBuffer::Input)?;
        let latency_timer = shorten_latency(Path::new(name));
        let reading = port.try_clone()?;
        let stop = CancellationToken::new();
        let (inputs_sender, inputs) = mpsc::channel(WAITING_INPUTS);
        let (end_sender, end) = oneshot::channel();
        let inputs_sender = LossySender::new(inputs_sender);
        let reader = Reader { inputs: inputs_sender, end: end_sender, clock, stop: stop.clone() };
        thread::Builder::new().name("serial-reader".into()).spawn(move || reader.run(reading))?;
        Ok(Self { name: name.into(), port, inputs, end, stop: stop.drop_guard(), latency_timer })
    }
}

impl Source for SerialConnection {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        match self.inputs.recv().await {
            Some(input) => Ok(Some(input)),
            // the reading thread sends the reason before it drops the channel, unless it was
            // stopped
            None => self.end.try_recv().map_or(Ok(None), Err),
        }
    }
}

impl Connection for SerialConnection {
    fn name(&self) -> &str {
        &self.name
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.port.set_baud_rate(baud)?;
        Ok(self.port.clear(ClearBuffer::Input)?)
    }

    // a command is far shorter than the buffer of the system, so the write does not wait; if the
    // buffer is full, the write fails after 50 ms
    async fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    async fn close(self) -> Vec<StreamInput> {
        let Self { port, mut inputs, stop, .. } = self;
        drop((port, stop));
        let mut left = Vec::new();
        // the reading thread closes the port before the channel
        let drain = async {
            while let Some(input) = inputs.recv().await {
                left.push(input);
            }
        };
        let _ = tokio::time::timeout(CLOSE_TIMEOUT, drain).await;
        left
    }

    fn device_file(&self) -> Option<&Path> {
        Some(Path::new(&self.name))
    }

    fn latency_timer(&self) -> Option<&LatencyTimer> {
        self.latency_timer.as_ref()
    }
}

struct Reader {
    inputs: LossySender,
    end: oneshot::Sender<io::Error>,
    clock: Clock,
    stop: CancellationToken,
}

impl Reader {
    /// Reads until it is stopped or the port is unplugged. The port is closed before the channel:
    /// when the channel ends, the receiver knows that the port is closed.
    ///
    /// An adapter delivers a line or a packet in up to a dozen pieces, and waking the reading task
    /// for each costs far more than processing them. So pieces are kept until a frame or a line of
    /// other text ends, because they cannot be used before. Their time is that of the last read, in
    /// which the frame ended.
    fn run(mut self, mut port: impl Read) {
        let mut buffer = [0; READ_BYTES];
        let mut length = 0;
        let mut at_ns = 0;
        let mut framer = Framer::new(Options::default());
        let error = loop {
            if self.stop.is_cancelled() {
                break None;
            }
            match port.read(&mut buffer[length..]) {
                // readable without a byte: the port was unplugged
                Ok(0) => break Some(ErrorKind::BrokenPipe.into()),
                Ok(n) => {
                    at_ns = self.clock.now_ns();
                    length += n;
                    let ended = ended_frames(&mut framer, &buffer[..length]);
                    let done = if ended == 0 && length == buffer.len() { length } else { ended };
                    self.forward(&buffer[..done], at_ns);
                    buffer.copy_within(done..length, 0);
                    length -= done;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::TimedOut => {
                    self.forward(&buffer[..length], at_ns);
                    length = 0;
                    self.inputs.send_waiting();
                }
                Err(error) => break Some(error),
            }
        };
        drop(port);
        self.forward(&buffer[..length], at_ns);
        // no more bytes can arrive
        self.inputs.send_waiting_blocking();
        if let Some(error) = error {
            // a receiver that was dropped does not need the error
            let _ = self.end.send(error);
        }
    }

    fn forward(&mut self, bytes: &[u8], at_ns: i64) {
        if !bytes.is_empty() {
            let chunk = Chunk { bytes: Bytes::copy_from_slice(bytes), at_ns: Some(at_ns) };
            self.inputs.send(chunk.into(), at_ns);
        }
    }
}

/// The number of bytes at the head of `input` up to the end of a whole frame with its line end, or
/// of a line that is no frame; zero if nothing has ended yet.
fn ended_frames(framer: &mut Framer, input: &[u8]) -> usize {
    let (mut at, mut ended) = (0, 0);
    loop {
        let (done, frame) = framer.next(&input[at..], false);
        at += done;
        if frame.is_none() {
            // the end of the line before is no line
            let rest = input[ended..at.max(ended)].trim_ascii_start();
            return if rest.contains(&b'\n') { at } else { ended };
        }
        ended = at + input[at..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
    }
}

#[cfg(test)]
mod tests {
    use std::{collections::VecDeque, sync::Mutex};

    use super::*;
    use vn100_protocol::stream::{LinkEvent, LinkEventKind};

    /// Returns its pieces one by one, then hangs up.
    struct Port(VecDeque<Result<&'static [u8], ErrorKind>>);

    impl Read for Port {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let Some(piece) = self.0.pop_front() else { return Err(ErrorKind::BrokenPipe.into()) };
            let piece = piece?;
            let length = piece.len().min(buffer.len());
            buffer[..length].copy_from_slice(&piece[..length]);
            if length < piece.len() {
                self.0.push_front(Ok(&piece[length..]));
            }
            Ok(length)
        }
    }

    fn reader(room: usize) -> (Reader, mpsc::Receiver<StreamInput>, oneshot::Receiver<io::Error>) {
        let (sender, inputs) = mpsc::channel(room);
        let (end_sender, end) = oneshot::channel();
        let stop = CancellationToken::new();
        (Reader { inputs: LossySender::new(sender), end: end_sender, clock: Clock::start(), stop }, inputs, end)
    }

    /// The lengths of forwarded inputs, and the number of bytes reported lost.
    fn received(mut inputs: mpsc::Receiver<StreamInput>) -> (Vec<usize>, u64) {
        let (mut lengths, mut lost) = (Vec::new(), 0);
        while let Some(input) = inputs.blocking_recv() {
            match input {
                StreamInput::Chunk(chunk) => lengths.push(chunk.bytes.len()),
                StreamInput::Link(LinkEvent { kind: LinkEventKind::Overrun { bytes }, .. }) => lost += bytes,
                StreamInput::Link(other) => panic!("{other:?}"),
            }
        }
        (lengths, lost)
    }

    /// The lengths of the inputs forwarded for these pieces.
    fn forwarded(pieces: impl IntoIterator<Item = Result<&'static [u8], ErrorKind>>) -> Vec<usize> {
        let (reader, inputs, mut end) = reader(100);
        reader.run(Port(pieces.into_iter().collect()));
        assert_eq!(end.try_recv().unwrap().kind(), ErrorKind::BrokenPipe);
        let (lengths, lost) = received(inputs);
        assert_eq!(lost, 0);
        lengths
    }

    #[test]
    fn pieces_are_forwarded_when_a_line_ends_or_nothing_follows() {
        let pieces = [
            Ok(&b"$VN"[..]),
            Err(ErrorKind::Interrupted),
            Ok(b"YMR\r\n"),
            Err(ErrorKind::TimedOut),
            // the end of a line and the beginning of the next
            Ok(b"$VNYMR\r\n$VN"),
            Ok(b"YMR"),
            Err(ErrorKind::TimedOut),
            // a line end without a line waits for the next frame
            Ok(b"\r"),
            Ok(b"\n"),
            Ok(b"starting\r\n$VN"),
            // no lines at all: they end the sentence before
            Ok(&[0xF8; READ_BYTES]),
            Ok(b"$VN"),
        ];
        assert_eq!(forwarded(pieces), [8, 8, 6, 12, 3, READ_BYTES, 3]);
    }

    /// The packet may contain any bytes, including a line end, and be cut in any way.
    #[test]
    fn a_packet_is_forwarded_when_it_is_whole() {
        let packet = |number: u8| {
            let mut packet = vec![0xFA, 0x01, 0x08, 0x00, number, b'\n', b'\r', b'\n', 4, 5, 6, 7, 8, 9, 10, 11];
            packet.extend(vn100_protocol::crc16(&packet[1..]).to_be_bytes());
            packet
        };
        let stream: &'static [u8] = (0..9).flat_map(packet).collect::<Vec<u8>>().leak();
        for cut in 1..=18 {
            assert_eq!(forwarded(stream.chunks(cut).map(Ok)), [18; 9], "pieces of {cut} bytes");
        }
        // with bytes that may be the beginning of a sentence of another device, printable to its end
        for at in 5..16 {
            let packet = |first: u8| {
                let mut packet = [&[0xFA, 0x01, 0x08, 0x00, first][..], &[b'B'; 11]].concat();
                packet[at] = b'$';
                packet.extend(vn100_protocol::crc16(&packet[1..]).to_be_bytes());
                packet
            };
            let is_printable = |packet: &Vec<u8>| packet[at + 1..].iter().all(|byte| (b'0'..=b'z').contains(byte));
            let packet = (0..=u8::MAX).map(packet).find(is_printable).unwrap();
            assert_eq!(ended_frames(&mut Framer::new(Options::default()), &packet), 18, "$ at {at}");
        }
        // two and a half at a time
        assert_eq!(forwarded(stream.chunks(45).map(Ok)), [36, 54, 36, 36]);
        // a line between two of them
        let mixed: &'static [u8] = [&stream[..18], b"$VNYMR\r\n", &stream[18..36]].concat().leak();
        assert_eq!(forwarded([Ok(mixed)]), [44]);
        assert_eq!(forwarded(mixed.chunks(4).map(Ok)), [18, 8, 18]);
    }

    #[test]
    fn the_time_is_that_of_the_last_piece() {
        struct Waiting(Port, Arc<Mutex<Vec<i64>>>, Clock);
        impl Read for Waiting {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                self.1.lock().unwrap().push(self.2.now_ns());
                self.0.read(buffer)
            }
        }
        let (reader, mut inputs, _end) = reader(100);
        let reads = Arc::new(Mutex::new(Vec::new()));
        let port = Port([Ok(&b"$VN"[..]), Ok(b"YMR\n"), Ok(b"$VN"), Err(ErrorKind::TimedOut)].into());
        let clock = reader.clock;
        reader.run(Waiting(port, Arc::clone(&reads), clock));
        let reads = reads.lock().unwrap();
        for (read, next) in [(1, 2), (2, 3)] {
            let Some(StreamInput::Chunk(chunk)) = inputs.blocking_recv() else { panic!("no bytes") };
            assert!((reads[read]..=reads[next]).contains(&chunk.at_ns.unwrap()));
        }
    }

    #[test]
    fn bytes_that_do_not_fit_are_dropped_and_counted() {
        let (reader, mut inputs, _end) = reader(5);
        // it ends only when the report of the loss is taken, and drops the rest before
        let thread = thread::spawn(move || reader.run(Port([Ok(&b"$VNYMR..\r\n"[..]); 32].into())));
        while inputs.len() < 5 {
            thread::yield_now();
        }
        assert!(matches!(inputs.blocking_recv(), Some(StreamInput::Chunk(_))));
        let (lengths, lost) = received(inputs);
        assert_eq!(lengths.iter().sum::<usize>() as u64 + 10 + lost, 320);
        thread.join().unwrap();
    }
}

//! A sensor on a port, in memory and on tokio's paused clock.
#![allow(
    dead_code,
    clippy::panic,
    clippy::unwrap_used,
    reason = "each test target uses its part of it; a test fails by panicking"
)]

mod link;

use std::{
    collections::{BTreeMap, VecDeque},
    io,
    sync::{Arc, Mutex, MutexGuard},
    time::Duration,
};

use bytes::Bytes;
pub(crate) use link::{Link, Told};
use tokio::time::{Instant, sleep_until};
use tokio_util::sync::CancellationToken;
use vn100_capture::Source;
use vn100_driver::{Connect, ConnectError, Connection, LinkOptions, PortProblem, open_link};
use vn100_protocol::stream::{Chunk, StreamInput};

pub(crate) const LINE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
pub(crate) const OTHER_LINE: &str = "$VNYPR,-129.867,-000.355,-000.296*61\r\n";
pub(crate) const QUESTION: &[u8] = b"$VNRRG,01*72\r\n";

/// The sensor, the cable and a log of their use.
pub(crate) struct World {
    pub(crate) baud: u32,
    pub(crate) period: Duration,
    /// The line that it sends.
    pub(crate) line: &'static str,
    /// The packet that it sends instead if register 75 sends packets to this port.
    pub(crate) packet: Option<&'static [u8]>,
    /// Whether it sends lines.
    pub(crate) streams: bool,
    /// Whether the port exists.
    pub(crate) plugged: bool,
    /// Whether bit 6 of every byte is flipped, until the port is opened again.
    pub(crate) garbled: bool,
    /// The number of further garbled openings.
    pub(crate) bad_openings: u32,
    /// Bytes in the adapter that come next.
    pub(crate) stray: Vec<u8>,
    /// Cuts the next line after this many bytes and hangs up after it.
    pub(crate) cut_at: Option<usize>,
    /// The written bytes, each with the baud rate of the port at that time.
    pub(crate) written: Vec<(u32, Vec<u8>)>,
    /// The times of openings since the start, with success or without.
    pub(crate) opened: Vec<(Duration, bool)>,
    /// Its registers and their contents.
    pub(crate) registers: BTreeMap<u8, String>,
    /// A register that cannot be written.
    pub(crate) read_only: Option<u8>,
    /// A register whose writes are answered but not kept.
    pub(crate) forgets: Option<u8>,
    pub(crate) answers: bool,
    /// The delay of an answer.
    pub(crate) answers_after: Duration,
    /// Whether each answer comes in two reads.
    pub(crate) answers_in_two: bool,
    /// Whether each answer comes in one read with the next line, if it sends lines after it.
    pub(crate) answers_with_output: bool,
    /// A register whose reads are not answered.
    pub(crate) mute_of: Option<u8>,
    /// The end of a stall, during which its bytes are delayed.
    pub(crate) stalled_until: Option<Instant>,
    pub(crate) echoes: bool,
    /// The body of its next unsolicited sentence.
    pub(crate) says: Option<&'static str>,
    /// Bytes delivered.
    pub(crate) bytes: u64,
    /// Whole good lines delivered at the correct baud rate.
    pub(crate) lines: u64,
    start: Instant,
}

impl World {
    /// Whether its messages would fit the line after this write.
    fn fits(&self, register: u8, written: &str) -> bool {
        let value = |wanted: u8| if register == wanted { written } else { &self.registers[&wanted] };
        let number = |wanted| value(wanted).parse::<u32>().unwrap();
        LINE.len() as u32 * number(7) <= number(5) / 10
    }

    /// The frame that it sends by itself.
    fn frame(&self) -> &'static [u8] {
        let is_of_packets = self.registers.get(&75).is_some_and(|output| output.starts_with("1,"));
        self.packet.filter(|_| is_of_packets).unwrap_or(self.line.as_bytes())
    }

    /// Executes a command and answers it.
    fn carry_out(&mut self, body: &str) -> Vec<u8> {
        let mut fields = body.splitn(3, ',');
        let (name, number) = (fields.next().unwrap(), fields.next());
        let register: u8 = number.and_then(|number| number.parse().ok()).unwrap_or_default();
        let known = self.registers.contains_key(&register);
        let answer = match (name, fields.next()) {
            ("VNRRG", None) if known => format!("VNRRG,{register:02},{}", self.registers[&register]),
            ("VNWRG", Some(_)) if self.read_only == Some(register) => "VNERR,09".into(),
            ("VNWRG", Some(written)) if known && !self.fits(register, written) => "VNERR,0C".into(),
            ("VNWRG", Some(_)) if self.forgets == Some(register) => body.into(),
            ("VNWRG", Some(written)) if known => {
                self.registers.insert(register, written.into());
                match register {
                    5 => self.baud = written.parse().unwrap(),
                    7 => self.period = Duration::from_secs(1) / written.parse::<u32>().unwrap(),
                    _ => {}
                }
                body.into()
            }
            ("VNRRG" | "VNWRG", _) => "VNERR,08".into(),
            ("VNASY", None) => {
                self.streams = register == 1;
                body.into()
            }
            _ => "VNERR,04".into(),
        };
        sentence(&answer)
    }
}

/// A packet with these groups and fields, whose payload is of zeros.
pub(crate) fn packet(fields: &[u8], payload_bytes: usize) -> &'static [u8] {
    let mut packet = [&[0xFA], fields, &vec![0; payload_bytes]].concat();
    let crc = vn100_protocol::crc16(&packet[1..]);
    packet.extend(crc.to_be_bytes());
    packet.leak()
}

/// The sentence with its checksum and line end.
pub(crate) fn sentence(body: &str) -> Vec<u8> {
    let check = body.bytes().fold(0, |xor, byte| xor ^ byte);
    format!("${body}*{check:02X}\r\n").into_bytes()
}

#[derive(Clone)]
pub(crate) struct Sensor(Arc<Mutex<World>>);

impl Sensor {
    pub(crate) fn new(baud: u32, rate_hz: u32) -> Self {
        Self(Arc::new(Mutex::new(World {
            baud,
            period: Duration::from_secs(1) / rate_hz,
            line: LINE,
            streams: true,
            plugged: true,
            garbled: false,
            bad_openings: 0,
            stray: Vec::new(),
            cut_at: None,
            written: Vec::new(),
            registers: [(1, "VN-100S-CR".into()), (5, baud.to_string()), (6, "14".into()), (7, rate_hz.to_string())]
                .into(),
            read_only: None,
            forgets: None,
            answers: true,
            answers_after: Duration::from_millis(20),
            answers_in_two: false,
            answers_with_output: false,
            mute_of: None,
            packet: None,
            stalled_until: None,
            echoes: false,
            says: None,
            opened: Vec::new(),
            bytes: 0,
            lines: 0,
            start: Instant::now(),
        })))
    }

    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        self.0.lock().unwrap()
    }

    pub(crate) fn link(&self, options: LinkOptions) -> Link {
        let stop = CancellationToken::new();
        let (handle, events) = open_link(self.clone(), options, stop.clone());
        Link { handle, events, stop, told: Told::default() }
    }
}

impl Connect for Sensor {
    type Connection = Port;

    const HAS_BAUD: bool = true;

    async fn open(&mut self, baud: u32) -> Result<Port, ConnectError> {
        let mut world = self.world();
        let (at, plugged) = (world.start.elapsed(), world.plugged);
        world.opened.push((at, plugged));
        if !plugged {
            return Err(ConnectError::Port { port: self.name(), baud, problem: PortProblem::NotFound(Vec::new()) });
        }
        Ok(Port {
            sensor: self.clone(),
            bauds: vec![(Instant::now(), baud)],
            next_line: Instant::now() + world.period / 2,
            echoes: VecDeque::new(),
            replies: VecDeque::new(),
            rest: None,
        })
    }

    fn now_ns(&self) -> i64 {
        self.world().start.elapsed().as_nanos() as i64
    }

    fn name(&self) -> String {
        "/dev/imu".into()
    }
}

pub(crate) struct Port {
    sensor: Sensor,
    /// Its baud rates, each with its start: a receiver reads a byte at the baud rate at its
    /// arrival, even if the byte is delivered later.
    bauds: Vec<(Instant, u32)>,
    next_line: Instant,
    echoes: VecDeque<Vec<u8>>,
    replies: VecDeque<(Instant, String)>,
    /// The second half of an answer.
    rest: Option<Vec<u8>>,
}

impl Port {
    /// The present baud rate.
    fn baud(&self) -> u32 {
        self.bauds.last().unwrap().1
    }

    /// The bytes that are due now.
    fn due(&mut self) -> Option<io::Result<Vec<u8>>> {
        let now = Instant::now();
        let mut world = self.sensor.world();
        if !world.plugged {
            return Some(Err(io::ErrorKind::BrokenPipe.into()));
        }
        if let Some(echo) = self.echoes.pop_front() {
            return Some(Ok(echo));
        }
        if let Some(rest) = self.rest.take() {
            return Some(Ok(rest));
        }
        // delayed bytes come in their order
        if self.replies.front().is_some_and(|(at, _)| *at <= now && *at <= self.next_line) {
            let (_, command) = self.replies.pop_front()?;
            let mut answer = world.carry_out(&command);
            if world.answers_with_output && world.streams {
                answer.extend(world.frame());
                world.lines += 1;
            }
            self.rest = world.answers_in_two.then(|| answer.split_off(answer.len() / 2));
            return Some(Ok(answer));
        }
        if !world.stray.is_empty() {
            return Some(Ok(std::mem::take(&mut world.stray)));
        }
        if let Some(says) = world.says.take() {
            return Some(Ok(sentence(says)));
        }
        if self.next_line > now {
            return None;
        }
        let at = self.next_line;
        self.next_line += world.period;
        if !world.streams {
            return None;
        }
        if let Some(cut_at) = world.cut_at.take() {
            world.plugged = false;
            return Some(Ok(world.frame()[..cut_at].to_vec()));
        }
        let baud = self.bauds.iter().rfind(|(since, _)| *since <= at).unwrap_or(&self.bauds[0]).1;
        if world.baud != baud {
            // as many as fit into the time of a line, and none equal to a sent one
            let length = LINE.len() * baud as usize / world.baud as usize;
            return Some(Ok(vec![0xf8; length.clamp(1, 512)]));
        }
        let flip = if world.garbled { 0x40 } else { 0 };
        world.lines += u64::from(!world.garbled);
        Some(Ok(world.frame().iter().map(|byte| byte ^ flip).collect()))
    }
}

impl Source for Port {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        loop {
            let stalled_until = self.sensor.world().stalled_until.filter(|until| *until > Instant::now());
            if let Some(until) = stalled_until {
                sleep_until(until).await;
                continue;
            }
            if let Some(due) = self.due() {
                let bytes = due?;
                self.sensor.world().bytes += bytes.len() as u64;
                return Ok(Some(Chunk { bytes: Bytes::from(bytes), at_ns: Some(self.sensor.now_ns()) }.into()));
            }
            let reply = self.replies.front().map(|(at, _)| *at);
            sleep_until(reply.map_or(self.next_line, |at| at.min(self.next_line))).await;
        }
    }
}

impl Connection for Port {
    fn name(&self) -> &str {
        "/dev/imu"
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.bauds.push((Instant::now(), baud));
        Ok(())
    }

    async fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut world = self.sensor.world();
        let baud = self.baud();
        world.written.push((baud, bytes.to_vec()));
        if world.echoes {
            self.echoes.push_back(bytes.to_vec());
        }
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        let body = text.strip_prefix('$').and_then(|text| text.split_once('*')).unwrap().0;
        if world.baud == baud && world.answers {
            assert_eq!(sentence(body), bytes);
            if world.mute_of.is_none_or(|register| body != format!("VNRRG,{register:02}")) {
                self.replies.push_back((Instant::now() + world.answers_after, body.into()));
            }
        }
        Ok(())
    }

    async fn close(self) -> Vec<StreamInput> {
        // the next session of the receiver is another one
        let mut world = self.sensor.world();
        world.garbled = world.bad_openings > 0;
        world.bad_openings = world.bad_openings.saturating_sub(1);
        Vec::new()
    }
}

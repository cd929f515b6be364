//! A session and a sensor on the two ends of a line that loses, damages, delays and repeats lines
//! as the test prescribes.

use std::{collections::VecDeque, time::Duration};

use vn100_protocol::{
    Check, Decoder, Item, Options, Register, Reply, RequestFailure, RequestId, RequestQueue, Response, SensorCommand,
};
use vn100_sim::{Device, DeviceConfig};

pub(crate) const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// The fate of one line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fate {
    /// The number of copies that arrive; 0 for a lost line.
    pub(crate) copies: usize,
    /// A bit that is inverted, counted around its length.
    pub(crate) flipped: Option<usize>,
    /// How much later it arrives, together with all lines after it.
    pub(crate) late: Duration,
}

impl Fate {
    pub(crate) const WHOLE: Self = Self { copies: 1, flipped: None, late: Duration::ZERO };
    pub(crate) const LOST: Self = Self { copies: 0, ..Self::WHOLE };
    pub(crate) const TWICE: Self = Self { copies: 2, ..Self::WHOLE };

    pub(crate) const fn late(by: Duration) -> Self {
        Self { late: by, ..Self::WHOLE }
    }

    pub(crate) const fn flipped(bit: usize) -> Self {
        Self { flipped: Some(bit), ..Self::WHOLE }
    }
}

/// The line in one direction: first in, first out.
#[derive(Debug, Default)]
pub(crate) struct Direction {
    /// The fates of the next lines; later lines are undamaged.
    pub(crate) fates: VecDeque<Fate>,
    under_way: VecDeque<(Duration, Vec<u8>)>,
}

impl Direction {
    fn put(&mut self, mut line: Vec<u8>, now: Duration) {
        let fate = self.fates.pop_front().unwrap_or(Fate::WHOLE);
        if let Some(bit) = fate.flipped {
            let bit = bit % (8 * line.len());
            line[bit / 8] ^= 1 << (bit % 8);
        }
        self.pass(&line, now, fate);
    }

    /// Sends a line with its final bytes.
    fn pass(&mut self, line: &[u8], now: Duration, fate: Fate) {
        let before = self.under_way.back().map_or(now, |(at, _)| *at);
        for _ in 0..fate.copies {
            self.under_way.push_back((before.max(now + fate.late), line.to_vec()));
        }
    }

    fn take_due(&mut self, now: Duration) -> Option<Vec<u8>> {
        let is_due = self.next().is_some_and(|at| at <= now);
        if is_due { self.under_way.pop_front().map(|(_, line)| line) } else { None }
    }

    fn next(&self) -> Option<Duration> {
        self.under_way.front().map(|(at, _)| *at)
    }
}

/// The result of a request, and its time.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) id: RequestId,
    pub(crate) at: Duration,
    pub(crate) result: Result<Response, RequestFailure>,
}

pub(crate) struct Link {
    pub(crate) device: Device,
    pub(crate) session: RequestQueue,
    pub(crate) now: Duration,
    pub(crate) commands: Direction,
    /// The line from the sensor; measurements are undamaged except for `flips`.
    pub(crate) answers: Direction,
    /// Bits of the next measurements that are inverted.
    pub(crate) flips: VecDeque<usize>,
    /// The commands sent, with `$` and checksum, and their times.
    pub(crate) sent: Vec<(Duration, String)>,
    pub(crate) outcomes: Vec<Outcome>,
    decoder: Decoder,
    /// The sent part of the sensor's next line.
    begun: Vec<u8>,
}

impl Link {
    /// A link to a sensor with factory defaults, which has sent 40 lines per second for 0.75 s.
    pub(crate) fn new() -> Self {
        let mut link = Self {
            device: Device::new(DeviceConfig::default()),
            session: RequestQueue::new(Check::Xor8),
            now: ms(2000),
            commands: Direction::default(),
            answers: Direction::default(),
            flips: VecDeque::new(),
            sent: Vec::new(),
            outcomes: Vec::new(),
            decoder: Decoder::new(Options::default()),
            begun: Vec::new(),
        };
        // earlier output was not received
        link.device.poll_bytes(link.now, |_| {});
        link
    }

    pub(crate) fn wait(&mut self, time: Duration) {
        self.run(self.now + time, usize::MAX);
    }

    /// Lets time pass until `end`, or this many requests have ended.
    pub(crate) fn run(&mut self, end: Duration, outcomes: usize) {
        loop {
            let ended = std::iter::from_fn(|| self.session.poll_completion());
            self.outcomes.extend(ended.map(|(id, result)| Outcome { id, at: self.now, result }));
            // at this point nothing of the next request has been sent
            if self.outcomes.len() >= outcomes {
                return;
            }
            self.transmit();
            if self.now >= end {
                return;
            }
            let others = [self.session.poll_timeout(), self.commands.next(), self.answers.next(), Some(end)];
            let next = others.into_iter().flatten().fold(self.device.next_wakeup(), Duration::min);
            assert!(next > self.now, "the clock stands still at {next:?}");
            self.now = next;
            self.listen();
            self.session.handle_timeout(self.now);
        }
    }

    /// The contents of a register in the sensor at this moment, independent of the session.
    pub(crate) fn truth(&self, register: Register) -> String {
        let mut device = self.device.clone();
        let mut now = self.now;
        let mut text = String::new();
        // a boot or a flash write may have to end first
        for command in [SensorCommand::Async(false), SensorCommand::ReadRegister(register)] {
            now += ms(1500);
            let _ = device.poll_output(now);
            device.receive(line(&command).as_bytes(), now);
            now += ms(200);
            text = String::from_utf8(device.poll_output(now)).unwrap();
        }
        let (_, fields) = text.rsplit_once(&format!("$VNRRG,{register},")).unwrap();
        fields.split_once('*').unwrap().0.to_owned()
    }

    fn transmit(&mut self) {
        while let Some(line) = self.session.poll_transmit(self.now) {
            self.sent.push((self.now, String::from_utf8(line.clone()).unwrap()));
            self.commands.put(line, self.now);
            self.deliver_commands();
        }
    }

    fn deliver_commands(&mut self) {
        while let Some(line) = self.commands.take_due(self.now) {
            self.device.receive(&line, self.now);
        }
    }

    /// Takes the output of the sensor and the lines that have arrived by now.
    fn listen(&mut self) {
        self.deliver_commands();
        let mut sent = Vec::new();
        self.device.poll_bytes(self.now, |byte| sent.push(byte));
        for byte in sent {
            self.begun.push(byte.byte);
            if self.begun.ends_with(b"\n") {
                let mut line = std::mem::take(&mut self.begun);
                if line.windows(7).any(|bytes| bytes == b"$VNYMR,") {
                    if let Some(bit) = self.flips.pop_front() {
                        let bit = bit % (8 * line.len());
                        line[bit / 8] ^= 1 << (bit % 8);
                    }
                    self.answers.pass(&line, self.now, Fate::WHOLE);
                } else {
                    self.answers.put(line, self.now);
                }
            }
        }
        while let Some(line) = self.answers.take_due(self.now) {
            self.decoder.push(&line, |item| {
                if let Item::Reply(sentence) = item {
                    self.session.handle_reply(&Reply::parse(&sentence).unwrap(), self.now);
                }
            });
        }
    }
}

pub(crate) fn line(command: &SensorCommand) -> String {
    command.sentence(Check::Xor8)
}

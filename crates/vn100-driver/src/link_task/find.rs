//! Opens the link and looks for the sensor on it, at the speed it had and at all others.

use std::{collections::VecDeque, time::Duration};

use tokio::time::Instant;
use vn100_protocol::{BaudRate, DeviceError, Register, RequestFailure};

use super::LinkTask;
use crate::{
    autobaud::BAUD_RATES, autobaud::Listener, autobaud::QUESTION, autobaud::Trial, autobaud::drain, connect::Connect,
    connect::Connection, link_output::NobodyListens, link_state::LinkState, link_state::Up, set_again::set_again,
    set_again::set_speed, trouble::Trouble,
};
use vn100_protocol::stream::{Input, LinkEventKind};

/// How long a sensor that says nothing is waited for at the first speed: longer than it boots,
/// which takes 1.25 s.
const BOOT: Duration = Duration::from_secs(2);

/// How long what comes is put aside before a speed is looked at again: longer than an adapter holds
/// bytes of the speed before, 16 ms unless it is set otherwise.
const SETTLE: Duration = Duration::from_millis(100);

/// So few bytes, less than a line, are no sign of a sensor that sends: they may have lain in the
/// adapter, or be of a line that was cut.
const STRAY: u64 = 100;

/// Makes the sensor send again.
const RESUME: &[u8] = b"$VNASY,1*4E\r\n";

/// One speed to try.
#[derive(Clone, Copy)]
struct Look {
    /// `None` where the link has none.
    baud: Option<u32>,
    /// For how long what comes first is put aside.
    settle: Duration,
}

impl<C: Connect> LinkTask<C> {
    /// Opens the link and finds the sensor on it: the connection, and what came of the first good
    /// line or packet on. A sensor that comes back is set as it was.
    pub(super) async fn find(&mut self) -> Result<(C::Connection, Up, Vec<Input>), Trouble> {
        self.state.send_replace(LinkState::Opening);
        let rates = self.rates();
        let first = rates.first().copied().flatten().unwrap_or_default();
        let opened = self.stop.run_until_cancelled(self.connect.open(first)).await;
        let mut connection = opened.ok_or(Trouble::Stopped)??;
        let mut found = self.sweep(&mut connection, &rates).await;
        if let Ok((baud, held)) = &mut found
            && self.was_up
            && let Err(trouble) = self.resume(&mut connection, baud, held).await
        {
            let held = std::mem::take(held);
            found = Err(self.set_aside(held).await.err().map_or(trouble, Trouble::from));
        }
        match found {
            Ok((baud, held)) => {
                self.last_baud = baud;
                let up = Up {
                    port: connection.name().to_owned(),
                    baud,
                    since_ns: self.connect.now_ns(),
                    latency_timer: connection.latency_timer().cloned(),
                    restarted: None,
                    output_resumed: false,
                };
                Ok((connection, up, held))
            }
            Err(trouble) => Err(self.close(connection).await.err().map_or(trouble, Trouble::from)),
        }
    }

    /// Makes sure that it is the same sensor that is back, and sets it as it was.
    async fn resume(
        &mut self,
        connection: &mut C::Connection,
        baud: &mut Option<u32>,
        held: &mut Vec<Input>,
    ) -> Result<(), Trouble> {
        self.check_known(connection, held).await?;
        self.set_again(connection, baud, held).await
    }

    /// Sets a sensor that is back at the speed `baud` as it was; what it sent before that is no
    /// part of the measurement. Where it was on a faster line, that is not of its settings at
    /// power-up, and needs it, it is set to that too.
    async fn set_again(
        &mut self,
        connection: &mut C::Connection,
        baud: &mut Option<u32>,
        held: &mut Vec<Input>,
    ) -> Result<(), Trouble> {
        let changes = self.keep.iter().filter(|change| change.register != Register::BAUD_RATE);
        let changes: Vec<_> = changes.cloned().collect();
        if changes.is_empty() {
            return Ok(());
        }
        let output = &mut self.output;
        let faster =
            self.last_baud.filter(|last| C::HAS_BAUD && *last > baud.unwrap_or_default()).and_then(BaudRate::new);
        let setting = async {
            let mut sent = |line: &[u8]| output.note_sent(line);
            match (set_again(connection, &changes, held, &mut sent).await, faster) {
                (Err(Trouble::NotSet(failure)), Some(faster)) if is_too_much(&failure) => {
                    set_speed(connection, faster, held, &mut sent).await?;
                    *baud = Some(faster.bits_per_s());
                    set_again(connection, &changes, held, &mut sent).await
                }
                (set, _) => set,
            }
        };
        let set = self.stop.run_until_cancelled(setting).await;
        self.set_aside(std::mem::take(held)).await?;
        let Some(set) = set else {
            // its output may be paused; whoever stops has no more use for the answer
            connection.write(RESUME).await?;
            self.output.note_sent(RESUME);
            return Err(Trouble::Stopped);
        };
        set
    }

    /// The speeds to try, in order; one that is none where the link has none.
    fn rates(&self) -> Vec<Option<u32>> {
        if !C::HAS_BAUD {
            return vec![None];
        }
        if self.fixed_baud.is_some() {
            return vec![self.fixed_baud];
        }
        let others = BAUD_RATES.into_iter().map(Some).filter(|baud| *baud != self.last_baud);
        self.last_baud.map(Some).into_iter().chain(others).collect()
    }

    /// Tries the speeds one after the other. At the first one a sensor that is silent is waited
    /// for: one that was just switched on boots.
    ///
    /// Where it was silent at the speed it had, an adapter may have held back what came at that
    /// speed, answers too: it hands that on all at once, perhaps while another speed is tried. So
    /// what is good then is put aside, and only what comes behind it is believed, looked for at the
    /// speed it had before all.
    async fn sweep(
        &mut self,
        connection: &mut C::Connection,
        rates: &[Option<u32>],
    ) -> Result<(Option<u32>, Vec<Input>), Trouble> {
        let mut tried = Vec::new();
        let (mut bytes, mut echoes) = (0, 0);
        let begin = Instant::now();
        let mut looks = VecDeque::from_iter(rates.iter().map(|&baud| Look { baud, settle: Duration::ZERO }));
        let mut is_first = true;
        let mut may_be_held = false;
        while let Some(look) = looks.pop_front() {
            let baud = look.baud;
            if !is_first && let Some(baud) = baud {
                // a speed that this port does not have is not the one it is used at
                if connection.set_baud(baud).is_err() {
                    continue;
                }
                let mut drained = Vec::new();
                let end = drain(connection, look.settle, &mut drained).await;
                bytes += self.set_aside(drained).await?;
                end?;
            }
            tried.extend(baud.filter(|baud| !tried.contains(baud)));
            self.state.send_replace(LinkState::Probing { port: connection.name().to_owned(), baud });
            let trial = Trial { baud, listen_only: self.listen_only };
            loop {
                let (output, conversation) = (&mut self.output, &mut self.conversation);
                let sent = |line: &[u8]| {
                    output.note_sent(line);
                    conversation.expect_junk_answers();
                };
                let mut listener = Listener::new(self.accept_unchecked);
                let ended = self.stop.run_until_cancelled(trial.run(connection, &mut listener, sent)).await;
                let ended = ended.ok_or(Trouble::Stopped).and_then(|found_at| Ok(found_at?));
                let heard = listener.heard(ended.as_ref().ok().copied().flatten());
                let came = self.set_aside(heard.before).await?;
                ended?;
                (bytes, echoes) = (bytes + came, echoes + heard.echoes);
                if let Some(inputs) = heard.sensor {
                    if !may_be_held {
                        return Ok((baud, inputs));
                    }
                    bytes += self.set_aside(inputs).await?;
                    may_be_held = false;
                    if !is_first {
                        looks.push_front(look);
                    }
                    looks.push_front(Look { baud: self.last_baud, settle: SETTLE });
                    break;
                }
                let is_silent = came <= heard.echoes * QUESTION.len() as u64 + STRAY;
                may_be_held |= is_first && is_silent && self.last_baud.is_some();
                if !is_first || !is_silent || begin.elapsed() >= BOOT {
                    break;
                }
            }
            is_first = false;
        }
        Err(Trouble::Unheard { port: self.connect.name(), tried, bytes, echoes, asked: !self.listen_only })
    }

    /// Takes what is no part of the measurement: how many bytes. All of it is recorded, also where
    /// the events are not received any more.
    pub(super) async fn set_aside(&mut self, inputs: Vec<Input>) -> Result<u64, NobodyListens> {
        let (mut bytes, mut received) = (0, Ok(()));
        for input in inputs {
            match input {
                Input::Chunk(chunk) => bytes += chunk.bytes.len() as u64,
                Input::Link(event) => received = received.and(self.tell(event.kind).await),
            }
        }
        if bytes > 0 {
            received = received.and(self.tell(LinkEventKind::DiscardedDuringBaudScan { bytes }).await);
        }
        received.map(|()| bytes)
    }

    /// Closes the connection. What was read from it and not taken is no part of the measurement.
    pub(super) async fn close(&mut self, connection: C::Connection) -> Result<(), NobodyListens> {
        let left = connection.close().await;
        self.set_aside(left).await.map(drop)
    }
}

/// Whether the sensor refused an output that its line is too slow for.
fn is_too_much(failure: &RequestFailure) -> bool {
    matches!(failure, RequestFailure::Device { error: DeviceError::InsufficientBaudRate, .. })
}

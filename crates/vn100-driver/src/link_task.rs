//! The one owner of a live link: opens it, finds the sensor, passes on what comes, and begins again
//! when the link is lost.

mod find;
mod resumed;
mod silence;
mod watched;

use std::{convert::Infallible, io, pin::pin, time::Duration};

use tokio::{
    select,
    sync::{mpsc, watch},
    time::{Instant, sleep_until},
};
use tokio_util::sync::CancellationToken;
use vn100_protocol::{BaudRate, Options};

use self::{silence::Silence, watched::Watch};
use crate::{
    back_off::BackOff, connect::Connect, connect::Connection, conversation::Consequence, conversation::Conversation,
    conversation::Request, health::Health, health::Reading, link_options::LinkOptions, link_output::LinkOutput,
    link_output::NobodyListens, link_state::LinkState, link_state::Up, output_plan::Change, trouble::Trouble,
};
use vn100_capture::Source;
use vn100_protocol::stream::{Input, LinkEvent, LinkEventKind};

/// How often all speeds are tried before a link that never was up is given up: a sensor that was
/// just switched on says nothing for 1.25 s.
const FIRST_SWEEPS: u32 = 2;

/// The same where bytes come at every speed and make no line: the receiver of the host may flip
/// bits until it is opened anew.
const FIRST_SWEEPS_OF_JUNK: u32 = 5;

/// How long a silence lasts, at least, before a sensor that does not answer is taken for gone: a
/// machine or an adapter that stands still for two seconds hands on all that came meanwhile, and
/// the answer with it.
const STALL: Duration = Duration::from_millis(2500);

pub(crate) struct LinkTask<C> {
    connect: C,
    /// The speed to try alone; `None` for all.
    fixed_baud: Option<u32>,
    /// The speed the sensor was last heard at.
    last_baud: Option<u32>,
    /// Whether a sensor was heard at all.
    was_up: bool,
    /// The serial number of the sensor, once it has told it. Nothing comes of another one.
    serial: Option<String>,
    /// Another one that it told last.
    strange_serial: Option<String>,
    listen_only: bool,
    accept_unchecked: bool,
    /// Set again when the sensor comes back.
    keep: Vec<Change>,
    stop: CancellationToken,
    output: LinkOutput,
    state: watch::Sender<LinkState>,
    back_off: BackOff,
    requests: mpsc::Receiver<Request>,
    conversation: Conversation,
    /// Whether an output that was found paused is so again.
    is_paused_again: bool,
    /// Origin of the conversation's times.
    start: Instant,
}

impl<C: Connect> LinkTask<C> {
    pub(crate) fn new(
        connect: C,
        options: LinkOptions,
        stop: CancellationToken,
        output: LinkOutput,
        state: watch::Sender<LinkState>,
        requests: mpsc::Receiver<Request>,
    ) -> Self {
        Self {
            connect,
            fixed_baud: options.baud,
            last_baud: None,
            was_up: false,
            serial: options.known_serial,
            strange_serial: None,
            listen_only: options.listen_only,
            accept_unchecked: options.read.accept_unchecked,
            keep: if options.listen_only { Vec::new() } else { options.desired_settings },
            stop,
            output,
            state,
            back_off: BackOff::new(),
            requests,
            conversation: Conversation::new(options.listen_only, options.poll_temperature),
            is_paused_again: false,
            start: Instant::now(),
        }
    }

    pub(crate) async fn run(mut self) {
        let error = match self.follow().await {
            Trouble::Stopped | Trouble::NobodyListens => None,
            trouble => Some(io::Error::other(trouble.to_string())),
        };
        self.output.finish(error).await;
        let paused_again = self.conversation.owes_pause().then_some(self.is_paused_again);
        self.state.send_replace(LinkState::Closed { paused_again });
    }

    /// Keeps the link until there is no point in it any more: why.
    async fn follow(&mut self) -> Trouble {
        let mut sweeps = 0;
        loop {
            let trouble = match self.find().await {
                Ok((mut connection, up, mut held)) => {
                    let trouble = match self.meet_first(&mut connection, &mut held).await {
                        Ok(()) => self.attend(&mut connection, up, held).await,
                        Err(trouble) => trouble,
                    };
                    self.close(connection).await.err().map_or(trouble, Trouble::from)
                }
                Err(trouble) => trouble,
            };
            sweeps += 1;
            let was_up = self.was_up;
            let again = match &trouble {
                Trouble::Stopped | Trouble::NobodyListens | Trouble::Another { .. } => false,
                Trouble::Refused(error) => was_up && error.is_passing(),
                Trouble::Unheard { tried, bytes, echoes: 0, .. } if tried.len() > 1 && *bytes > 0 => {
                    was_up || sweeps < FIRST_SWEEPS_OF_JUNK
                }
                Trouble::Unheard { .. } => was_up || sweeps < FIRST_SWEEPS,
                Trouble::Lost(_)
                | Trouble::Garbled { .. }
                | Trouble::Closed
                | Trouble::Silent
                | Trouble::Restarted(_)
                | Trouble::Returned
                | Trouble::NotSet(_) => was_up,
            };
            if !again {
                return trouble;
            }
            if let Err(stopped) = self.wait(&trouble).await {
                return stopped;
            }
        }
    }

    async fn tell(&mut self, kind: LinkEventKind) -> Result<(), NobodyListens> {
        let at_ns = self.connect.now_ns();
        self.output.put(Input::Link(LinkEvent { at_ns, kind }), at_ns).await
    }

    /// Attends to a link that is up until it is not any more: why.
    async fn attend(&mut self, connection: &mut C::Connection, up: Up, held: Vec<Input>) -> Trouble {
        let trouble = match self.pass_on(connection, up, held).await {
            Ok(never) => match never {},
            Err(trouble) => trouble,
        };
        self.conversation.link_down();
        // whoever stops has not lost the link
        if matches!(trouble, Trouble::Stopped | Trouble::NobodyListens) {
            if self.conversation.owes_pause() {
                self.pause_again(connection).await;
            }
        } else if self.tell(LinkEventKind::Down { cause: trouble.to_string() }).await.is_err() {
            return Trouble::NobodyListens;
        }
        trouble
    }

    async fn pass_on(
        &mut self,
        connection: &mut C::Connection,
        up: Up,
        held: Vec<Input>,
    ) -> Result<Infallible, Trouble> {
        if let Err(unheard) = self.greet(&up).await {
            self.set_aside(held).await?;
            return Err(unheard.into());
        }
        let health = Health::new(self.output.seen());
        let mut watch = Watch { up, health, heard: Instant::now(), silence: None, is_restarting: false };
        let mut held = held.into_iter();
        while let Some(input) = held.next() {
            if let Err(trouble) = self.take(input, &mut watch.health).await {
                self.set_aside(held.collect()).await?;
                return Err(trouble);
            }
        }
        // what was answered here was the question by which it was found
        self.output.take_replies();
        // kept from line to line: to begin to wait costs more than to look
        let stop = self.stop.clone();
        let mut stopped = pin!(stop.cancelled());
        let mut nobody_listens = pin!(self.output.nobody_listens());
        let mut timer = pin!(sleep_until(watch.heard));
        loop {
            while let Some(line) = self.conversation.next_line(self.start.elapsed(), watch.up.baud) {
                connection.write(&line).await?;
                self.output.note_sent(&line);
            }
            let silence = watch.next_look();
            let wake = self.conversation.wake_at().map(|wake| self.start + wake);
            let due = wake.unwrap_or(silence).min(silence);
            // silence is put off by every line; to wake once too early now and then costs less than to set the timer each time
            if due < timer.deadline() || timer.is_elapsed() {
                timer.as_mut().reset(due);
            }
            let input = select! {
                // checked first: a link that always has data must not outrun the request to stop
                biased;
                () = &mut stopped => return Err(Trouble::Stopped),
                () = &mut nobody_listens => return Err(Trouble::NobodyListens),
                Some(request) = self.requests.recv() => {
                    self.conversation.ask(request);
                    None
                }
                input = connection.next_input() => Some(input?.ok_or(Trouble::Closed)?),
                () = &mut timer => None,
            };
            if let Some(input) = input {
                if watch.silence.as_mut().is_some_and(|silence| silence.ends_with(&input)) {
                    let held = self.meet_again(connection, input).await?;
                    self.hear_all(connection, held, &mut watch).await?;
                } else {
                    self.hear(connection, input, &mut watch).await?;
                }
            } else if Instant::now() >= silence {
                if self.listen_only && watch.silence.is_some() {
                    return Err(Trouble::Silent);
                }
                if !self.listen_only {
                    self.ask_presence(&watch);
                }
                let options = Options { accept_unchecked: self.accept_unchecked };
                watch.silence.get_or_insert_with(|| Silence::begin(options)).looked = Instant::now();
                self.state.send_replace(LinkState::Silent(watch.up.clone()));
            }
            let consequence = self.conversation.handle_timeout(self.start.elapsed());
            self.follow_up(connection, consequence, &mut watch).await?;
        }
    }

    /// Takes inputs that were held. When the link is lost amid them, the others are no part of the
    /// measurement.
    async fn hear_all(
        &mut self,
        connection: &mut C::Connection,
        held: Vec<Input>,
        watch: &mut Watch,
    ) -> Result<(), Trouble> {
        let mut inputs = held.into_iter();
        while let Some(input) = inputs.next() {
            if let Err(trouble) = self.hear(connection, input, watch).await {
                self.set_aside(inputs.collect()).await?;
                return Err(trouble);
            }
        }
        Ok(())
    }

    /// Takes one input of a link that is up, and what the sensor answers in it.
    async fn hear(&mut self, connection: &mut C::Connection, input: Input, watch: &mut Watch) -> Result<(), Trouble> {
        let before = self.output.seen();
        self.take(input, &mut watch.health).await?;
        let replies = self.output.take_replies();
        let seen = self.output.seen();
        // an answer is no sign that the output goes on; nor does what nobody understands end a silence
        if seen.unasked > before.unasked || watch.silence.is_none() && seen.understood == before.understood {
            watch.heard = Instant::now();
            if watch.silence.take().is_some() {
                self.state.send_replace(LinkState::Up(watch.up.clone()));
                // it may have been switched off and on meanwhile
                self.conversation.meet(self.start.elapsed());
            }
        }
        if seen.unasked > before.unasked && std::mem::take(&mut watch.is_restarting) {
            self.greet(&watch.up).await?;
        }
        for reply in replies {
            self.recognise(&reply)?;
            let consequences = self.conversation.take_reply(&reply, self.start.elapsed());
            self.follow_up(connection, consequences, watch).await?;
        }
        if seen.unasked > before.unasked && self.conversation.sends() {
            self.tell_resumed(&mut watch.up).await?;
        }
        Ok(())
    }

    fn ask_presence(&mut self, watch: &Watch) {
        self.conversation.ask_presence(watch.heard - self.start, self.start.elapsed());
    }

    async fn follow_up(
        &mut self,
        connection: &mut C::Connection,
        consequences: impl IntoIterator<Item = Consequence>,
        watch: &mut Watch,
    ) -> Result<(), Trouble> {
        for consequence in consequences {
            match consequence {
                Consequence::Baud(baud) => self.change_baud(connection, &mut watch.up, baud)?,
                Consequence::Absent => match &watch.silence {
                    Some(silence) if silence.since.elapsed() < STALL => self.ask_presence(watch),
                    Some(_) => return Err(Trouble::Silent),
                    None => {}
                },
                Consequence::Unasked(error) => self.tell(LinkEventKind::UnsolicitedError { error }).await?,
                Consequence::Restarted(error) if !self.keep.is_empty() => return Err(Trouble::Restarted(error)),
                Consequence::Restarted(error) => {
                    self.tell(LinkEventKind::Down { cause: error.to_string() }).await?;
                    watch.up.since_ns = self.connect.now_ns();
                    watch.up.restarted = Some(error);
                    self.state.send_replace(LinkState::Up(watch.up.clone()));
                    // it boots, and answers nothing: it is back with its next line
                    watch.is_restarting = true;
                }
            }
        }
        Ok(())
    }

    /// Tells that a sensor is there, and asks it who it is.
    async fn greet(&mut self, up: &Up) -> Result<(), NobodyListens> {
        self.state.send_replace(LinkState::Up(up.clone()));
        self.conversation.meet(self.start.elapsed());
        self.tell(LinkEventKind::Up { port: up.port.clone(), baud: up.baud }).await
    }

    /// Follows the sensor to another speed.
    fn change_baud(&mut self, connection: &mut C::Connection, up: &mut Up, baud: BaudRate) -> Result<(), Trouble> {
        if !C::HAS_BAUD {
            return Ok(());
        }
        let baud = baud.bits_per_s();
        connection.set_baud(baud)?;
        up.baud = Some(baud);
        self.last_baud = Some(baud);
        self.fixed_baud = self.fixed_baud.map(|_| baud);
        self.state.send_replace(LinkState::Up(up.clone()));
        Ok(())
    }

    /// Takes one input of a link that is up, and judges by it whether it still is.
    async fn take(&mut self, input: Input, health: &mut Health) -> Result<(), Trouble> {
        let now_ns = self.connect.now_ns();
        let read = match &input {
            Input::Chunk(chunk) => Some((chunk.at_ns.unwrap_or(now_ns), chunk.bytes.len())),
            Input::Link(_) => None,
        };
        self.output.put(input, now_ns).await?;
        let Some((at_ns, length)) = read else { return Ok(()) };
        self.conversation.read(length);
        match health.read(at_ns, length, self.output.seen()) {
            Reading::Good => self.back_off.reset(),
            Reading::Open => {}
            Reading::Garbled { bytes, lasted } => return Err(Trouble::Garbled { bytes, ms: lasted.as_millis() }),
        }
        Ok(())
    }

    /// Waits before the next attempt.
    async fn wait(&mut self, trouble: &Trouble) -> Result<(), Trouble> {
        let retry_in = self.back_off.wait();
        self.state.send_replace(LinkState::Down {
            was_up: self.was_up,
            cause: trouble.to_string(),
            needs_help: trouble.needs_help(),
            retry_in,
        });
        let end = Instant::now() + retry_in;
        loop {
            select! {
                () = self.stop.cancelled() => return Err(Trouble::Stopped),
                () = self.output.nobody_listens() => return Err(Trouble::NobodyListens),
                Some(request) = self.requests.recv() => {
                    self.conversation.ask(request);
                    self.conversation.link_down();
                }
                () = sleep_until(end) => return Ok(()),
            }
        }
    }
}

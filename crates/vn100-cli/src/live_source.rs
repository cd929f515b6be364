//! Live sources by their names on the command line: opened to be measured, or for a few commands.

use std::{
    fmt,
    future::{self, Future},
    io,
};

use anyhow::{Context, Result, bail};
use tokio::{
    sync::{mpsc, watch},
    task,
    time::Duration,
};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Clock, Event, ReaderSource, Source, read_samples};
use vn100_driver::{Change, LinkHandle, LinkHint, LinkOptions, LinkState, SerialPorts, TcpServer, open_link};
use vn100_protocol::stream::{Input, ReadOptions};

use crate::{
    args::{Baud, LinkArgs, SourceName},
    emulated_port::EmulatedPort,
    log::Entries,
};

/// How often register 54 is read where the temperature is asked for.
const TEMPERATURE_PERIOD: Duration = Duration::from_secs(10);

/// A source that can be opened. While it is there an emulated sensor stays on.
pub(crate) struct LiveSource {
    name: SourceName,
    link: LinkArgs,
    log: Entries,
    /// Nothing is asked or measured of a sensor with another serial number.
    known_serial: Option<String>,
    /// The port, of which each opening knows what the others have learned; `None` where it is none.
    ports: Option<SerialPorts>,
    _emulated: Option<EmulatedPort>,
}

/// Waits until a link whose events nobody takes any more has let go of its port: whether an output
/// that was found paused is so again.
pub(crate) async fn closed(link: &LinkHandle) -> Option<bool> {
    // a link that is gone has no state any more
    match link.state().wait_for(|state| matches!(state, LinkState::Closed { .. })).await.as_deref() {
        Ok(LinkState::Closed { paused_again }) => *paused_again,
        _ => None,
    }
}

/// Waits until the state of a link changes; for ever where there is none.
pub(crate) async fn changed(state: &mut Option<watch::Receiver<LinkState>>) {
    let changed = match state {
        Some(state) => state.changed().await.is_ok(),
        None => false,
    };
    if !changed {
        future::pending::<()>().await;
    }
}

/// A source that is being opened; what comes of that, the events tell.
pub(crate) struct Opened {
    /// `None` for a stream that is no link.
    pub(crate) link: Option<LinkHandle>,
    pub(crate) events: mpsc::Receiver<Event>,
}

impl LiveSource {
    /// Makes a source ready: starts the emulated sensor.
    pub(crate) fn new(name: SourceName, link: LinkArgs, log: Entries) -> Result<Self> {
        let clock = Clock::start();
        let emulated = (name == SourceName::Sim).then(|| EmulatedPort::start(&link.sim)).transpose()?;
        let ports = match (&name, &emulated) {
            (SourceName::Tcp(_) | SourceName::Stdin, _) => None,
            (_, Some(emulated)) => Some(emulated.ports(clock)),
            (name, None) => Some(SerialPorts::new(&name.to_string(), clock)),
        };
        Ok(Self { name, link, log, known_serial: None, ports, _emulated: emulated })
    }

    /// For the sensor with this serial number alone, where there is one.
    pub(crate) fn with_known_serial(self, known_serial: Option<&str>) -> Self {
        Self { known_serial: known_serial.map(str::to_owned), ..self }
    }

    /// Its form, as documents name it.
    pub(crate) fn kind(&self) -> &'static str {
        self.name.kind()
    }

    /// Begins to open it for measuring. What it delivers is stamped, and goes to the recording too;
    /// `keep` is set again on a sensor that comes back.
    pub(crate) fn open(
        &self,
        read: ReadOptions,
        temperature: bool,
        keep: Vec<Change>,
        recording: Option<mpsc::Sender<Input>>,
        stop: CancellationToken,
    ) -> Result<Opened> {
        let read = self.log.asked(read);
        if self.name == SourceName::Stdin {
            if temperature {
                bail!("standard input cannot be asked for the temperature: name a port");
            }
            let source = ReaderSource::spawn_live(io::stdin(), Clock::start()).context("cannot start to read")?;
            let events = read_samples(Recorded { source, recording }, read, stop);
            return Ok(Opened { link: None, events: self.watched(events) });
        }
        let poll_temperature = temperature.then_some(TEMPERATURE_PERIOD);
        let (link, events) = self.open_link(
            LinkOptions { read, recording, poll_temperature, desired_settings: keep, ..LinkOptions::default() },
            stop,
        )?;
        Ok(Opened { link: Some(link), events: self.watched(events) })
    }

    fn watched(&self, events: mpsc::Receiver<Event>) -> mpsc::Receiver<Event> {
        self.log.watch(&self.name.to_string(), events)
    }

    /// Opens it for commands: waits until the sensor is heard or until `stop`, does `work`, and
    /// closes it again. Once begun, `work` looks after `stop` itself: it may have something to put
    /// back.
    pub(crate) async fn ask<T, F: Future<Output = Result<T>>>(
        &self,
        stop: &CancellationToken,
        work: impl FnOnce(LinkHandle) -> F,
    ) -> Result<T> {
        let closing = CancellationToken::new();
        let read = self.log.asked(ReadOptions::default());
        let (link, events) = self.open_link(LinkOptions { read, ..LinkOptions::default() }, closing.clone())?;
        let mut events = self.watched(events);
        // the link waits for whoever takes its events
        let ended = task::spawn(async move {
            let mut error = None;
            while let Some(event) = events.recv().await {
                if let Event::End(end) = event {
                    error = end.error;
                }
            }
            error
        });
        let mut state = link.state();
        let heard =
            state.wait_for(|state| matches!(state, LinkState::Up(_) | LinkState::Silent(_) | LinkState::Closed { .. }));
        let is_up = stop
            .run_until_cancelled(heard)
            .await
            .is_some_and(|heard| heard.is_ok_and(|state| !matches!(*state, LinkState::Closed { .. })));
        let answer = match is_up {
            true => Some(work(link).await),
            false => None,
        };
        closing.cancel();
        let error = ended.await.context("the link stopped by a fault of this program")?;
        match (answer, error) {
            (Some(answer), _) => answer,
            (None, Some(error)) => Err(Unheard(error).into()),
            (None, None) => Err(Interrupted.into()),
        }
    }

    fn open_link(&self, options: LinkOptions, stop: CancellationToken) -> Result<(LinkHandle, mpsc::Receiver<Event>)> {
        let baud = match self.link.baud {
            Baud::Auto => None,
            Baud::Fixed(baud) => Some(baud),
        };
        let known_serial = self.known_serial.clone();
        let hint_text = Some(link_hint as fn(LinkHint) -> &'static str);
        let options = LinkOptions { baud, listen_only: self.link.listen_only, known_serial, hint_text, ..options };
        Ok(match (&self.ports, &self.name) {
            (Some(ports), _) => open_link(ports.clone(), options, stop),
            (None, SourceName::Tcp(address)) => open_link(TcpServer::new(address, Clock::start())?, options, stop),
            (None, _) => bail!("standard input cannot be asked anything: name a port"),
        })
    }
}

/// A hint of the link in the terms of the command line.
fn link_hint(hint: LinkHint) -> &'static str {
    match hint {
        LinkHint::AskSensor => {
            "its output may be paused, which cannot be told without asking it: leave --listen-only out, or check the cable and the power \
             of the sensor"
        }
        LinkHint::CheckBaudRate => "check the cable, the power of the sensor and --baud",
        hint => hint.text(),
    }
}

/// The source cannot be opened, or no sensor is heard on it.
#[derive(Debug)]
pub(crate) struct Unheard(io::Error);

impl fmt::Display for Unheard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Unheard {}

/// It was told to stop before a sensor was heard.
#[derive(Debug)]
pub(crate) struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("interrupted")
    }
}

impl std::error::Error for Interrupted {}

/// A source that can wait, with a copy of all its inputs for a recording.
struct Recorded<S> {
    source: S,
    recording: Option<mpsc::Sender<Input>>,
}

impl<S: Source> Source for Recorded<S> {
    async fn next_input(&mut self) -> io::Result<Option<Input>> {
        let input = self.source.next_input().await?;
        if let (Some(recording), Some(input)) = (&self.recording, &input) {
            // a recording that has stopped says so itself
            let _ = recording.send(input.clone()).await;
        }
        Ok(input)
    }
}

//! A live source before it is opened.

use std::{
    future::Future,
    io::{self, Read},
    sync::{Mutex, PoisonError},
};

use tokio::{sync::mpsc, task};
use tokio_util::sync::CancellationToken;
use vn100_analysis::protocol::stream::StreamInput;
use vn100_capture::{Clock, Event, ReaderSource, Source, read_samples};
use vn100_driver::{Connect, LinkHandle, LinkOptions, LinkState, open_link};

use crate::{channels::EventObserver, start_error::LiveError};

/// A source that can be opened: more than once if it is a link, once if it is a stream.
pub struct LiveSource {
    input: LiveInput,
    /// The options for opening and reading the source. A session itself sets line-by-line reading,
    /// the recording, the poll of the temperature, the desired settings and the serial number.
    pub options: LinkOptions,
    /// Called with every event; `None` for no observer.
    pub observer: Option<EventObserver>,
}

enum LiveInput {
    /// Opens a link. Each opening has a clone of the connector, which shares the knowledge of earlier
    /// ones about the port.
    Link(Box<dyn Fn(LinkOptions, CancellationToken) -> (LinkHandle, mpsc::Receiver<Event>) + Send + Sync>),
    /// A stream without a way to send; `None` once it is taken.
    Stream(Mutex<Option<Box<dyn Read + Send>>>),
}

impl LiveSource {
    /// A sensor on a link that accepts commands.
    pub fn link(connect: impl Connect + Clone + Sync) -> Self {
        Self::new(LiveInput::Link(Box::new(move |options, stop| open_link(connect.clone(), options, stop))))
    }

    /// The output of a sensor on a stream, such as standard input. Bytes are stamped when they are
    /// read.
    pub fn stream(reader: impl Read + Send + 'static) -> Self {
        Self::new(LiveInput::Stream(Mutex::new(Some(Box::new(reader)))))
    }

    fn new(input: LiveInput) -> Self {
        Self { input, options: LinkOptions::default(), observer: None }
    }

    /// Opens the link for commands: waits until the sensor is connected or until `stop`, does
    /// `work`, and closes the link. Once begun, `work` handles `stop` itself: it may have settings
    /// to restore. If a serial number is given, a sensor with another one counts as not connected.
    ///
    /// # Errors
    /// [`LiveError`] if no sensor is connected; else the error of `work`.
    pub async fn with_link<T, E, F>(
        &self,
        known_serial: Option<&str>,
        stop: &CancellationToken,
        work: impl FnOnce(LinkHandle) -> F,
    ) -> Result<T, E>
    where
        F: Future<Output = Result<T, E>>,
        E: From<LiveError>,
    {
        let closing = CancellationToken::new();
        let LiveInput::Link(open) = &self.input else { return Err(LiveError::NoCommands.into()) };
        let options = LinkOptions { known_serial: known_serial.map(str::to_owned), ..self.options.clone() };
        let (link, mut events) = open(options, closing.clone());
        let observer = self.observer.clone();
        // the link waits until its events are taken
        let ended = task::spawn(async move {
            let mut error = None;
            while let Some(event) = events.recv().await {
                observer.iter().for_each(|observe| observe(&event));
                if let Event::End(end) = event {
                    error = end.error;
                }
            }
            error
        });
        let mut state = link.state();
        let is_decided = |state: &LinkState| state.up().is_some() || matches!(state, LinkState::Closed { .. });
        let decided = stop.run_until_cancelled(state.wait_for(is_decided)).await;
        let is_up = decided.is_some_and(|state| state.is_ok_and(|state| state.up().is_some()));
        let answer = if is_up { Some(work(link).await) } else { None };
        closing.cancel();
        let error = ended.await.map_err(LiveError::from)?;
        match (answer, error) {
            (Some(answer), _) => answer,
            (None, Some(error)) => Err(LiveError::NoSensor(error).into()),
            (None, None) => Err(LiveError::Stopped.into()),
        }
    }

    /// Opens the source for a measurement; the events report the outcome. The link is `None` for a
    /// stream.
    pub(crate) fn open(
        &self,
        options: LinkOptions,
        stop: CancellationToken,
    ) -> Result<(Option<LinkHandle>, mpsc::Receiver<Event>), LiveError> {
        match &self.input {
            LiveInput::Link(open) => {
                let (link, events) = open(options, stop);
                Ok((Some(link), events))
            }
            LiveInput::Stream(_) if options.poll_temperature.is_some() => Err(LiveError::NoTemperature),
            LiveInput::Stream(stream) => {
                let reader = stream.lock().unwrap_or_else(PoisonError::into_inner).take();
                let reader = reader.unwrap_or_else(|| Box::new(io::empty()));
                let source = ReaderSource::spawn(reader, Some(Clock::start())).map_err(LiveError::Read)?;
                Ok((None, read_samples(Tee { source, recording: options.recording }, options.read, stop)))
            }
        }
    }
}

/// A source that can wait and that copies all its inputs to a recording.
struct Tee<S> {
    source: S,
    recording: Option<mpsc::Sender<StreamInput>>,
}

impl<S: Source> Source for Tee<S> {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        let input = self.source.next_input().await?;
        if let (Some(recording), Some(input)) = (&self.recording, &input) {
            // a recording that has ended reports the reason
            let _ = recording.send(input.clone()).await;
        }
        Ok(input)
    }
}

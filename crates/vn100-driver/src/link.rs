//! A live link to a sensor, for whoever uses it: what to ask for, what to watch, what comes.

use std::sync::{Arc, atomic::Ordering};

use tokio::sync::{mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use vn100_protocol::{Answer, AsyncType, Command, DeviceError, Register, RegisterContents, RequestFailure};

use crate::{
    command_error::CommandError, connect::Connect, conversation::Request, link_options::LinkOptions,
    link_output::Counters, link_output::LinkOutput, link_state::LinkState, link_task::LinkTask,
};
use vn100_capture::{Event, WAITING_BATCHES};

/// Requests that may wait to be taken by the link; whoever asks then waits.
const WAITING_REQUESTS: usize = 16;

/// A link, as long as it lasts.
#[derive(Debug, Clone)]
pub struct LinkHandle {
    state: watch::Receiver<LinkState>,
    requests: mpsc::Sender<Request>,
    counters: Arc<Counters>,
}

impl LinkHandle {
    /// Asks the sensor for something. Samples keep flowing meanwhile, and the answer is also among
    /// them.
    ///
    /// Commands are sent one at a time, in the order they are asked for; those that do no harm
    /// twice are sent up to three times. While the speed of the line is looked for, they wait.
    ///
    /// # Errors
    /// When it refuses, or does not answer, or the link is lost, closed, or only listened to.
    pub async fn request(&self, command: Command) -> Result<Answer, CommandError> {
        let (answer, answered) = oneshot::channel();
        let request = Request { command, answer: Some(answer) };
        self.requests.send(request).await.map_err(|_| CommandError::LinkClosed)?;
        answered.await.unwrap_or(Err(CommandError::LinkClosed))
    }

    /// Reads a register; `None` where the sensor has none such, as registers differ with model and
    /// firmware.
    ///
    /// # Errors
    /// As [`request`](Self::request).
    pub async fn read(&self, register: Register) -> Result<Option<RegisterContents>, CommandError> {
        match self.request(Command::ReadRegister(register)).await {
            Ok(Answer::Register(contents)) => Ok(Some(contents)),
            Ok(Answer::Done)
            | Err(CommandError::Failed(RequestFailure::Device { error: DeviceError::InvalidRegister, .. })) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Good lines of this message that the sensor has sent by itself so far.
    #[must_use]
    pub fn lines(&self, message: AsyncType) -> u64 {
        self.counters.lines(message)
    }

    /// Good lines that the sensor has sent by itself so far.
    pub(crate) fn lines_of_all(&self) -> u64 {
        self.counters.lines_of_all()
    }

    /// What the link is doing, now and whenever that changes.
    #[must_use]
    pub fn state(&self) -> watch::Receiver<LinkState> {
        self.state.clone()
    }

    /// Bytes that the recording did not take in time.
    #[must_use]
    pub fn unrecorded_bytes(&self) -> u64 {
        self.counters.unrecorded_bytes.load(Ordering::Relaxed)
    }
}

/// Opens a link and keeps it: looks for the sensor's speed, hands out what it sends, and opens the
/// link again when it is lost.
///
/// The events are those of [`read_samples`](vn100_capture::read_samples), with one [`Event::Link`] for each
/// thing that befell the link. They end on `stop`, and with an error when the link cannot be opened
/// in the first place or no sensor is heard on it: no link that never was up is waited for.
///
/// When the events are not taken, the link waits; a port then loses bytes, which are counted.
///
/// # Panics
/// Outside a tokio runtime.
#[must_use]
pub fn open_link(
    connect: impl Connect,
    mut options: LinkOptions,
    stop: CancellationToken,
) -> (LinkHandle, mpsc::Receiver<Event>) {
    let (events_sender, events) = mpsc::channel(WAITING_BATCHES);
    let (state_sender, state) = watch::channel(LinkState::Opening);
    let (requests_sender, requests) = mpsc::channel(WAITING_REQUESTS);
    let counters = Arc::new(Counters::default());
    let output = LinkOutput::new(options.read, options.recording.take(), events_sender, Arc::clone(&counters));
    let task = LinkTask::new(connect, options, stop, output, state_sender, requests);
    // ends on `stop`, with the events' receiver, or when the link cannot be opened
    tokio::spawn(task.run());
    (LinkHandle { state, requests: requests_sender, counters }, events)
}

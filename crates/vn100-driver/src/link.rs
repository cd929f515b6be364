//! A live link to a sensor, as its user sees it: options, commands, events.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use thiserror::Error;
use tokio::sync::{mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Event, LossySender, WAITING_BATCHES};
use vn100_protocol::stream::{ReadOptions, StreamInput};
use vn100_protocol::{
    AsyncType, DeviceError, QueueFull, Register, RegisterContents, RequestFailure, Response, SensorCommand,
};

use crate::{
    connect::Connect, link_error::LinkHint, link_state::LinkState, link_task::LinkTask, link_task::Outputs,
    link_task::Request, output_plan::Change,
};

/// Requests that may wait to be taken by the link; then the callers wait.
const WAITING_REQUESTS: usize = 16;

/// How a link is opened and read.
#[derive(Debug, Default)]
pub struct LinkOptions {
    /// The baud rate; `None` to try all that the sensor has.
    pub baud: Option<u32>,
    /// Send nothing, as on a line that others listen to. The baud scan then takes up to 12 s.
    pub listen_only: bool,
    /// How the bytes are read.
    pub read: ReadOptions,
    /// Where a copy of everything that is received is sent, in order. What it does not take at once
    /// is dropped and reported in it as
    /// [`Overrun`](vn100_protocol::stream::LinkEventKind::Overrun): recording never delays
    /// measuring.
    pub recording: Option<mpsc::Sender<StreamInput>>,
    /// Read the temperature and the uncompensated measurements (register 54) this often between the
    /// lines, where the line has room for it. The answers are among the
    /// [`registers`](vn100_protocol::stream::Batch::registers) of the batches.
    pub poll_temperature: Option<Duration>,
    /// What [`configure`](crate::configure()) has changed. It is written again after a reconnect,
    /// before the link is up: the sensor may have lost its power, and with it all that was not
    /// saved. The baud rate is not written again: the sensor is found at the one it has. Ignored
    /// where the link only listens.
    pub desired_settings: Vec<Change>,
    /// The serial number of the sensor, where it is known: another sensor ends the link, as it does
    /// after a reconnect. Ignored where the link only listens.
    pub known_serial: Option<String>,
    /// The words of a hint in the texts of errors and states; those of [`LinkHint::text`] where
    /// `None`.
    pub hint_text: Option<fn(LinkHint) -> &'static str>,
}

/// Why a command has no good answer.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The sensor refused it or did not answer, or the link was lost before it did.
    #[error(transparent)]
    Failed(#[from] RequestFailure),
    /// Too many commands wait.
    #[error(transparent)]
    QueueFull(#[from] QueueFull),
    /// The link was opened to send nothing.
    #[error("nothing is sent on this link: it was opened to listen only")]
    ListenOnly,
    /// The link is closed for good.
    #[error("the link to the sensor is closed; open it again")]
    LinkClosed,
}

/// A link, as long as it lasts.
#[derive(Debug, Clone)]
pub struct LinkHandle {
    state: watch::Receiver<LinkState>,
    requests: mpsc::Sender<Request>,
    counters: Arc<Counters>,
}

impl LinkHandle {
    /// Sends a command and waits for the reply. Samples keep flowing meanwhile, and the reply is
    /// also among them.
    ///
    /// Commands are sent one at a time, in the order of the calls; those that do no harm twice are
    /// sent up to three times. They wait during a baud scan.
    ///
    /// # Errors
    /// When the sensor refuses or does not answer, or the link is lost, closed, or only listens.
    pub async fn request(&self, command: SensorCommand) -> Result<Response, CommandError> {
        let (answer, answered) = oneshot::channel();
        let request = Request { command, answer };
        self.requests.send(request).await.map_err(|_| CommandError::LinkClosed)?;
        answered.await.unwrap_or(Err(CommandError::LinkClosed))
    }

    /// Reads a register; `None` where the sensor has none such, as registers differ with model and
    /// firmware.
    ///
    /// # Errors
    /// As [`request`](Self::request).
    pub async fn read(&self, register: Register) -> Result<Option<RegisterContents>, CommandError> {
        match self.request(SensorCommand::ReadRegister(register)).await {
            Ok(Response::Register(contents)) => Ok(Some(contents)),
            Ok(Response::Done)
            | Err(CommandError::Failed(RequestFailure::Device { error: DeviceError::InvalidRegister, .. })) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Good frames of this message that the sensor has sent by itself so far.
    #[must_use]
    pub fn lines(&self, message: AsyncType) -> u64 {
        self.counters.lines(message)
    }

    /// Good frames that the sensor has sent by itself so far.
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

/// Counts that a [`LinkHandle`] reads at any time.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    /// Bytes that the recording did not take in time.
    pub(crate) unrecorded_bytes: AtomicU64,
    /// Valid sentences so far, by the code of their message.
    lines: Mutex<BTreeMap<u8, u64>>,
}

impl Counters {
    /// Valid sentences of this message so far; for one without a name all that have none.
    pub(crate) fn lines(&self, message: AsyncType) -> u64 {
        let message = if message.header().is_some() { message } else { AsyncType::OFF };
        self.all_lines().get(&message.0).copied().unwrap_or_default()
    }

    /// Valid sentences so far, whatever their message.
    pub(crate) fn lines_of_all(&self) -> u64 {
        self.all_lines().values().sum()
    }

    /// Sets the counts of these messages.
    pub(crate) fn update(&self, lines: impl Iterator<Item = (u8, u64)>) {
        self.all_lines().extend(lines);
    }

    fn all_lines(&self) -> MutexGuard<'_, BTreeMap<u8, u64>> {
        // a panic leaves whole counts behind
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Opens a link and keeps it: scans the baud rates for the sensor, hands out what it sends, and
/// reconnects when the link is lost.
///
/// The events are those of [`read_samples`](vn100_capture::read_samples), with one [`Event::Link`]
/// for each change of the link. They end on `stop`, and with an error when the first connection
/// fails: a link that never was up is not retried for long.
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
    let (stream, events) = mpsc::channel(WAITING_BATCHES);
    let (state_sender, state) = watch::channel(LinkState::Opening);
    let (requests, requests_receiver) = mpsc::channel(WAITING_REQUESTS);
    let counters = Arc::new(Counters::default());
    let recording = options.recording.take().map(LossySender::new);
    let outputs = Outputs { stream, recording, counters: Arc::clone(&counters), state: state_sender };
    let task = LinkTask::new(connect, options, stop, requests_receiver, outputs);
    // ends on `stop`, when the receiver of the events is dropped, or when the link fails for good
    tokio::spawn(task.run());
    (LinkHandle { state, requests, counters }, events)
}

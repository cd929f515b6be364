//! A live link to a sensor, as seen by its user: options, commands, states, events.

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
use vn100_protocol::stream::{FrameKind, ReadOptions, StreamInput};
use vn100_protocol::{
    AsyncType, DeviceError, QueueFull, Register, RegisterContents, RequestFailure, Response, SensorCommand,
};

use crate::{link_error::LinkHint, output_plan::Change, ports::LatencyTimer};

/// Options for opening and reading a link.
#[derive(Debug, Clone, Default)]
pub struct LinkOptions {
    /// The baud rate; `None` to scan all rates of the sensor.
    pub baud: Option<u32>,
    /// Send nothing, as on a line with other listeners. The baud scan then takes up to 12 s.
    pub listen_only: bool,
    /// The options for reading the bytes.
    pub read: ReadOptions,
    /// The receiver of a copy of all received bytes, in order; `None` for no recording. Recording
    /// never delays measuring: bytes that do not fit into the channel are dropped, and reported in
    /// the recording as [`Overrun`](vn100_protocol::stream::LinkEventKind::Overrun).
    pub recording: Option<mpsc::Sender<StreamInput>>,
    /// The interval between two reads of register 54, which contains the temperature; `None` for no
    /// reads. Reads are skipped if the line has no room for them. The answers are in
    /// [`Batch::registers`](vn100_protocol::stream::Batch::registers).
    pub poll_temperature: Option<Duration>,
    /// The changes made by [`configure`](crate::configure()). These registers are written again after
    /// a reconnect, before the link is up, because the sensor may have lost its power. The baud rate
    /// is not written again, because the baud scan finds it. Ignored if the link only listens.
    pub desired_settings: Vec<Change>,
    /// The serial number of the sensor, if it is known: another sensor on the port ends the
    /// link, during a reconnect as well. Ignored if the link only listens.
    pub known_serial: Option<String>,
    /// The words of a hint in errors and states; `None` for the text of [`LinkHint::text`].
    pub hint_text: Option<fn(LinkHint) -> &'static str>,
}

/// The state of a link.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkState {
    /// The port is being opened.
    Opening,
    /// A baud scan searches the sensor.
    Probing {
        /// The port by its name.
        port: String,
        /// The baud rate of this attempt; `None` if the link has none.
        baud: Option<u32>,
    },
    /// The sensor is connected.
    Up(Up),
    /// The port is open, but the output of the sensor has been silent for several of its periods.
    Silent(Up),
    /// The link is lost, or cannot be connected; another attempt follows.
    Down {
        /// Whether the sensor was connected before; if not, the link was never up.
        was_up: bool,
        /// The reason, in words.
        cause: String,
        /// Whether the next attempt will fail as well, unless the user does something.
        needs_help: bool,
        /// The delay before the next attempt.
        retry_in: Duration,
        /// Failed attempts since the sensor was last connected, or since the link began.
        attempts: u32,
    },
    /// The link has ended; the last event gives the reason.
    Closed {
        /// Whether an output that was found paused by another program, and was resumed, is paused
        /// again; `None` if the output was not found paused.
        paused_again: Option<bool>,
    },
}

impl LinkState {
    /// The facts about the link while its port is open and the sensor is connected, silent or not;
    /// `None` in all other states.
    pub fn up(&self) -> Option<&Up> {
        if let Self::Up(up) | Self::Silent(up) = self { Some(up) } else { None }
    }
}

/// The facts about a connected link.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Up {
    /// The port by its name, such as `/dev/ttyUSB0`.
    pub port: String,
    /// The baud rate; `None` if the link has none.
    pub baud: Option<u32>,
    /// The start of this connection, in nanoseconds from the origin of the arrival times.
    pub since_ns: i64,
    /// The latency timer of the adapter; `None` if the adapter has none.
    pub latency_timer: Option<LatencyTimer>,
    /// The error that the sensor reported at a restart, if the link is up again because of it;
    /// `None` if the sensor did not restart.
    pub restarted: Option<DeviceError>,
    /// Whether the output was found paused by another program, and was resumed. The output is
    /// paused again when the link is stopped, unless a command of the user has resumed it as well.
    pub output_resumed: bool,
}

/// The reason why a command failed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The sensor refused the command or did not answer it, or the link was lost before an answer.
    #[error(transparent)]
    Failed(#[from] RequestFailure),
    /// The sensor sent its output meanwhile, but no reply.
    #[error(
        "no reply to {line} in {:.1} s, though the sensor sends: check the wire from the host to the sensor (its RX); with error mode 0 \
         (register 30) the sensor does not report refused commands", .after.as_secs_f64()
    )]
    OneWay {
        /// The command.
        line: String,
        /// The time from the first transmission of the command to the end of the wait.
        after: Duration,
    },
    /// Too many commands wait.
    #[error(transparent)]
    QueueFull(#[from] QueueFull),
    /// The link was opened to send nothing.
    #[error("this link is listen-only: nothing is sent")]
    ListenOnly,
    /// The link is closed finally.
    #[error("the link to the sensor is closed; open it again")]
    LinkClosed,
}

/// A handle on a link; clones share the link. The link itself ends with its `stop` or its events.
#[derive(Debug, Clone)]
pub struct LinkHandle {
    pub(crate) state: watch::Receiver<LinkState>,
    pub(crate) commands: mpsc::Sender<SubmittedCommand>,
    pub(crate) marks: mpsc::Sender<String>,
    pub(crate) counters: Arc<Counters>,
}

impl LinkHandle {
    /// Sends a command and waits for the reply. Samples keep arriving meanwhile, and the reply is
    /// also in their batches.
    ///
    /// Commands are sent one at a time, in the order of the calls; a command that may safely be
    /// executed twice is sent up to three times. Commands wait during a baud scan.
    ///
    /// # Errors
    /// If the sensor refuses or does not answer, or if the link is lost, closed, or only listens.
    pub async fn request(&self, command: SensorCommand) -> Result<Response, CommandError> {
        let (result, received) = oneshot::channel();
        let frames_before = self.frames_of_all();
        self.commands.send((command, result)).await.map_err(|_| CommandError::LinkClosed)?;
        match received.await.unwrap_or(Err(CommandError::LinkClosed)) {
            Err(CommandError::Failed(RequestFailure::Timeout { line, after, .. }))
                if self.frames_of_all() > frames_before =>
            {
                Err(CommandError::OneWay { line, after })
            }
            result => result,
        }
    }

    /// Reads a register; `None` if the sensor does not have the register, which depends on model
    /// and firmware.
    ///
    /// # Errors
    /// As for [`request`](Self::request).
    pub async fn read(&self, register: Register) -> Result<Option<RegisterContents>, CommandError> {
        match self.request(SensorCommand::ReadRegister(register)).await {
            Ok(Response::Register(contents)) => Ok(Some(contents)),
            Ok(Response::Done)
            | Err(CommandError::Failed(RequestFailure::Device { error: DeviceError::InvalidRegister, .. })) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Marks this place of the stream, and of the recording, with a text. Returns `false` if the
    /// link does not accept the mark, because it is closed or four marks are waiting.
    pub fn mark(&self, text: String) -> bool {
        self.marks.try_send(text).is_ok()
    }

    /// Number of valid frames of this kind that the sensor has sent by itself so far. Sentences
    /// whose code has no known header are counted together.
    pub fn frames(&self, kind: FrameKind) -> u64 {
        let kind = match kind {
            FrameKind::Sentence(message) if message.header().is_none() => FrameKind::Sentence(AsyncType::OFF),
            kind => kind,
        };
        self.counters.frames().get(&kind).copied().unwrap_or_default()
    }

    pub(crate) fn frames_of_all(&self) -> u64 {
        self.counters.frames().values().sum()
    }

    /// The state of the link; the receiver is notified of each change.
    pub fn state(&self) -> watch::Receiver<LinkState> {
        self.state.clone()
    }

    /// Number of bytes that were dropped because the recording was too slow.
    pub fn unrecorded_bytes(&self) -> u64 {
        self.counters.unrecorded_bytes.load(Ordering::Relaxed)
    }
}

pub(crate) type SubmittedCommand = (SensorCommand, oneshot::Sender<Result<Response, CommandError>>);

#[derive(Debug, Default)]
pub(crate) struct Counters {
    pub(crate) unrecorded_bytes: AtomicU64,
    frames: Mutex<BTreeMap<FrameKind, u64>>,
}

impl Counters {
    pub(crate) fn frames(&self) -> MutexGuard<'_, BTreeMap<FrameKind, u64>> {
        // a panic with the lock held leaves consistent counts
        self.frames.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

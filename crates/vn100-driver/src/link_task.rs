//! The task that owns a live link: it performs the actions of the [`LinkMachine`], and reports
//! their outcome.

use std::{
    collections::BTreeMap,
    future::{pending, ready},
    pin::pin,
    sync::{Arc, atomic::Ordering},
    time::Duration,
};

use tokio::{
    select,
    sync::{mpsc, oneshot, watch},
    time::{Instant, sleep_until, timeout},
};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Event as StreamEvent, WAITING_BATCHES};
use vn100_protocol::Response;

use crate::{
    connect::{Connect, Connection},
    link::{CommandError, Counters, LinkHandle, LinkOptions, LinkState, SubmittedCommand},
    link_error::LinkError,
    link_machine::{Input, LinkMachine, LinkOutput, OpenPort, PortAction},
    lossy_sender::LossySender,
    shared_port::SharedPort,
};

/// The longest wait for a full recording to make room for the last link events.
const LAST_EVENTS: Duration = Duration::from_secs(1);

/// Commands that may wait for the link; further callers wait.
const WAITING_COMMANDS: usize = 16;

/// Opens a link and keeps it: scans the baud rates for the sensor, forwards the output of the
/// sensor, and reconnects when the link is lost.
///
/// The events are those of [`read_samples`](vn100_capture::read_samples), with one
/// [`Event::Link`](vn100_capture::Event::Link) for each change of the link. They end on `stop`, and
/// with an error if the first connection fails: a link that was never connected is tried only a few
/// times.
///
/// While the events are not received, the link waits; a port then loses bytes, which are counted.
///
/// # Panics
/// If called outside a tokio runtime.
pub fn open_link<C: Connect>(
    connect: C,
    mut options: LinkOptions,
    stop: CancellationToken,
) -> (LinkHandle, mpsc::Receiver<StreamEvent>) {
    let (stream, events) = mpsc::channel(WAITING_BATCHES);
    let (state_sender, state) = watch::channel(LinkState::Opening);
    let (commands_sender, commands) = mpsc::channel(WAITING_COMMANDS);
    let (marks_sender, marks) = mpsc::channel(WAITING_MARKS);
    let counters = Arc::new(Counters::default());
    let task = LinkTask {
        recording: options.recording.take().map(LossySender::new),
        machine: LinkMachine::new(connect.name(), C::HAS_BAUD, options),
        connect,
        connection: None,
        shared_port: SharedPort::default(),
        stop,
        commands,
        marks,
        open_commands: BTreeMap::new(),
        command_count: 0,
        stream,
        counters: Arc::clone(&counters),
        state: state_sender,
        closed: None,
    };
    // ends on `stop`, when the receiver of the events is dropped, or when the link fails finally
    tokio::spawn(task.run());
    (LinkHandle { state, commands: commands_sender, marks: marks_sender, counters }, events)
}

struct LinkTask<C: Connect> {
    machine: LinkMachine,
    connect: C,
    connection: Option<C::Connection>,
    shared_port: SharedPort,
    stop: CancellationToken,
    commands: mpsc::Receiver<SubmittedCommand>,
    marks: mpsc::Receiver<String>,
    /// The receivers of the results of the open commands, by their numbers.
    open_commands: BTreeMap<u64, oneshot::Sender<Result<Response, CommandError>>>,
    command_count: u64,
    stream: mpsc::Sender<StreamEvent>,
    recording: Option<LossySender>,
    counters: Arc<Counters>,
    state: watch::Sender<LinkState>,
    /// The last state, which is published after all else.
    closed: Option<LinkState>,
}

impl<C: Connect> LinkTask<C> {
    async fn run(mut self) {
        self.drive().await;
        drop(self.stream);
        if let Some(mut recording) = self.recording {
            let _ = timeout(LAST_EVENTS, recording.send_waiting_async()).await;
        }
        if let Some(closed) = self.closed {
            self.state.send_replace(closed);
        }
    }

    async fn drive(&mut self) {
        // one timer for all inputs, because starting a wait costs more than checking the timer
        let stop = self.stop.clone();
        let mut stopped = pin!(stop.cancelled());
        let stream = self.stream.clone();
        let mut receiver_dropped = pin!(stream.closed());
        let mut timer = pin!(sleep_until(Instant::now()));
        let mut is_stopping = false;
        loop {
            self.perform().await;
            if self.machine.is_closed() {
                return;
            }
            if let Some(due) = self.machine.poll_timeout() {
                let due = Instant::now() + due.saturating_sub(self.now());
                // an occasional early wake-up costs less than setting the timer at each input
                if due < timer.deadline() || timer.is_elapsed() {
                    timer.as_mut().reset(due);
                }
            }
            let input = select! {
                // those after the stop wait for it: a link that always has data must not delay it
                biased;
                Some(text) = self.marks.recv() => {
                    let now = self.now();
                    self.machine.mark(now, text);
                    continue;
                }
                () = &mut stopped, if !is_stopping => Input::Stop,
                () = &mut receiver_dropped, if !is_stopping => Input::Stop,
                Some((command, result)) = self.commands.recv(), if self.machine.accepts_commands() => {
                    self.command_count += 1;
                    self.open_commands.insert(self.command_count, result);
                    Input::Command { id: self.command_count, command }
                }
                program = self.shared_port.found() => {
                    let now = self.now();
                    program.into_iter().for_each(|program| self.machine.report_shared_port(now, program));
                    continue;
                }
                input = next_input(&mut self.connection) => input,
                () = &mut timer => {
                    let now = self.now();
                    self.machine.handle_timeout(now);
                    continue;
                }
            };
            is_stopping |= matches!(input, Input::Stop);
            self.handle(input);
        }
    }

    async fn perform(&mut self) {
        loop {
            self.forward_events().await;
            if let Some(action) = self.machine.poll_port() {
                match action {
                    PortAction::Open { baud } => self.open(baud).await,
                    PortAction::SetBaud(baud) => self.set_baud(baud).await,
                    PortAction::Close => self.close().await,
                }
                continue;
            }
            let now = self.now();
            let Some(line) = self.machine.poll_transmit(now) else { return };
            if let Some(connection) = &mut self.connection
                && let Err(error) = connection.write(&line).await
            {
                self.handle(Input::Lost(error.into()));
            }
        }
    }

    async fn open(&mut self, baud: u32) {
        let opened = self.stop.run_until_cancelled(self.connect.open(baud)).await;
        let input = match opened {
            Some(Ok(connection)) => {
                let name = connection.name().to_owned();
                let port = OpenPort { name, latency_timer: connection.latency_timer().cloned() };
                self.shared_port.search(connection.device_file());
                self.connection = Some(connection);
                Input::Opened(port)
            }
            Some(Err(error)) => Input::OpenFailed(error),
            None => Input::Stop,
        };
        self.handle(input);
    }

    async fn set_baud(&mut self, baud: u32) {
        let Some(connection) = &mut self.connection else { return };
        let result = connection.set_baud(baud);
        // bytes that have arrived already were received at the former baud rate
        loop {
            let input = select! {
                biased;
                input = next_input(&mut self.connection) => input,
                () = ready(()) => break,
            };
            let is_last = !matches!(input, Input::Received(_));
            self.handle(input);
            if is_last {
                break;
            }
        }
        self.handle(Input::BaudSet { baud, result });
    }

    async fn close(&mut self) {
        let unread = if let Some(connection) = self.connection.take() { connection.close().await } else { Vec::new() };
        self.handle(Input::PortClosed { unread });
    }

    /// Forwards all events of the machine. If a receiver does not take them, the link waits.
    async fn forward_events(&mut self) {
        while let Some(event) = self.machine.poll_event() {
            match event {
                LinkOutput::Recorded(input) => {
                    if let Some(recording) = &mut self.recording {
                        recording.send(input, self.connect.now_ns());
                        self.counters.unrecorded_bytes.store(recording.lost_bytes(), Ordering::Relaxed);
                    }
                }
                LinkOutput::Stream(event) => {
                    if let StreamEvent::Batch(batch) = &event {
                        let device_file = self.connection.as_ref().and_then(Connection::device_file);
                        self.shared_port.handle_batch(batch, device_file);
                    }
                    self.counters.frames().extend(self.machine.frames());
                    // if the receiver was dropped, the loop notices this while it waits for inputs
                    let _ = self.stream.send(event).await;
                }
                LinkOutput::State(state @ LinkState::Closed { .. }) => self.closed = Some(state),
                LinkOutput::State(state) => _ = self.state.send_replace(state),
            }
        }
        while let Some((id, result)) = self.machine.poll_answer() {
            // the user may have stopped waiting
            let _ = self.open_commands.remove(&id).map(|receiver| receiver.send(result));
        }
    }

    fn handle(&mut self, input: Input) {
        let now = self.now();
        self.machine.handle_input(now, input);
    }

    /// The time since the origin of the times of the stream.
    fn now(&self) -> Duration {
        Duration::from_nanos(self.connect.now_ns().try_into().unwrap_or_default())
    }
}

/// Marks that may wait; further ones are refused.
const WAITING_MARKS: usize = 4;

/// The next input from a connection; waits forever without one.
async fn next_input(connection: &mut Option<impl Connection>) -> Input {
    let Some(connection) = connection else { return pending().await };
    match connection.next_input().await {
        Ok(Some(input)) => Input::Received(input),
        Ok(None) => Input::Lost(LinkError::Disconnected),
        Err(error) => Input::Lost(error.into()),
    }
}

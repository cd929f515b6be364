//! The task that owns a live link: it performs what the [`LinkMachine`] asks for, and reports to it
//! what comes of that.

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
use vn100_capture::{Event as StreamEvent, LossySender};
use vn100_protocol::{Response, SensorCommand};

use crate::{
    connect::Connect,
    connect::Connection,
    link::{CommandError, Counters, LinkOptions},
    link_machine::{Event, Input, LinkMachine, OpenPort, PortAction},
    link_state::LinkState,
};

/// How long a recording that is full may take to make room for the last link events.
const LAST_EVENTS: Duration = Duration::from_secs(1);

/// A command of the user, and where its result goes.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) command: SensorCommand,
    pub(crate) answer: oneshot::Sender<Result<Response, CommandError>>,
}

/// Where the events of a link go.
pub(crate) struct Outputs {
    pub(crate) stream: mpsc::Sender<StreamEvent>,
    pub(crate) recording: Option<LossySender>,
    pub(crate) counters: Arc<Counters>,
    pub(crate) state: watch::Sender<LinkState>,
}

pub(crate) struct LinkTask<C: Connect> {
    machine: LinkMachine,
    connect: C,
    connection: Option<C::Connection>,
    stop: CancellationToken,
    requests: mpsc::Receiver<Request>,
    /// Where the results of the open requests go, by their numbers.
    open_requests: BTreeMap<u64, oneshot::Sender<Result<Response, CommandError>>>,
    request_count: u64,
    outputs: Outputs,
    /// The last state, which is published when all else is done.
    closed: Option<LinkState>,
}

impl<C: Connect> LinkTask<C> {
    pub(crate) fn new(
        connect: C,
        options: LinkOptions,
        stop: CancellationToken,
        requests: mpsc::Receiver<Request>,
        outputs: Outputs,
    ) -> Self {
        Self {
            machine: LinkMachine::new(connect.name(), C::HAS_BAUD, options),
            connect,
            connection: None,
            stop,
            requests,
            open_requests: BTreeMap::new(),
            request_count: 0,
            outputs,
            closed: None,
        }
    }

    /// Keeps the link until it is stopped or fails for good.
    pub(crate) async fn run(mut self) {
        self.drive().await;
        let Outputs { stream, recording, state, .. } = self.outputs;
        drop(stream);
        if let Some(mut recording) = recording {
            let _ = timeout(LAST_EVENTS, recording.send_waiting_async()).await;
        }
        if let Some(closed) = self.closed {
            state.send_replace(closed);
        }
    }

    async fn drive(&mut self) {
        // kept from input to input: to begin to wait costs more than to check
        let stop = self.stop.clone();
        let mut stopped = pin!(stop.cancelled());
        let stream = self.outputs.stream.clone();
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
                // to wake once too early now and then costs less than to set the timer for each input
                if due < timer.deadline() || timer.is_elapsed() {
                    timer.as_mut().reset(due);
                }
            }
            let input = select! {
                // checked first: a link that always has data must not outrun the request to stop
                biased;
                () = &mut stopped, if !is_stopping => Input::Stop,
                () = &mut receiver_dropped, if !is_stopping => Input::Stop,
                Some(request) = self.requests.recv(), if self.machine.accepts_requests() => {
                    self.request_count += 1;
                    self.open_requests.insert(self.request_count, request.answer);
                    Input::Request { id: self.request_count, command: request.command }
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

    /// Performs all that the machine asks for.
    async fn perform(&mut self) {
        loop {
            self.forward_events().await;
            if let Some(action) = self.machine.poll_port() {
                match action {
                    PortAction::Open { baud } => self.open(baud).await,
                    PortAction::SetBaud(baud) => self.set_baud(baud).await,
                    PortAction::Close => self.close().await,
                }
            } else if let Some(line) = self.poll_transmit() {
                if let Some(connection) = &mut self.connection
                    && let Err(error) = connection.write(&line).await
                {
                    self.handle(Input::Failed(error));
                }
            } else {
                return;
            }
        }
    }

    async fn open(&mut self, baud: u32) {
        let opened = self.stop.run_until_cancelled(self.connect.open(baud)).await;
        let input = match opened {
            Some(Ok(connection)) => {
                let name = connection.name().to_owned();
                let port = OpenPort { name, latency_timer: connection.latency_timer().cloned() };
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
        // what is there already was received at the baud rate before
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
        let unread = match self.connection.take() {
            Some(connection) => connection.close().await,
            None => Vec::new(),
        };
        self.handle(Input::PortClosed { unread });
    }

    /// Forwards all events of the machine. While a receiver does not take them, the link waits.
    async fn forward_events(&mut self) {
        while let Some(event) = self.machine.poll_event() {
            match event {
                Event::Recorded(input) => {
                    if let Some(recording) = &mut self.outputs.recording {
                        recording.send(input, self.connect.now_ns());
                        self.outputs.counters.unrecorded_bytes.store(recording.lost_bytes(), Ordering::Relaxed);
                    }
                }
                Event::Stream(event) => {
                    self.outputs.counters.update(self.machine.frames_by_message());
                    // the machine learns of a receiver that was dropped when it waits for inputs
                    let _ = self.outputs.stream.send(event).await;
                }
                Event::Answered { id, result } => {
                    if let Some(answer) = self.open_requests.remove(&id) {
                        // the user may have stopped waiting
                        let _ = answer.send(result);
                    }
                }
                Event::State(state @ LinkState::Closed { .. }) => self.closed = Some(state),
                Event::State(state) => _ = self.outputs.state.send_replace(state),
            }
        }
    }

    fn poll_transmit(&mut self) -> Option<Vec<u8>> {
        let now = self.now();
        self.machine.poll_transmit(now)
    }

    fn handle(&mut self, input: Input) {
        let now = self.now();
        self.machine.handle_input(now, input);
    }

    /// The time since the origin of the stamps.
    fn now(&self) -> Duration {
        Duration::from_nanos(self.connect.now_ns().try_into().unwrap_or_default())
    }
}

/// The next input from a connection; never without one.
async fn next_input(connection: &mut Option<impl Connection>) -> Input {
    let Some(connection) = connection else { return pending().await };
    match connection.next_input().await {
        Ok(Some(input)) => Input::Received(input),
        Ok(None) => Input::Disconnected,
        Err(error) => Input::Failed(error),
    }
}

//! The request machine on a clock that is a number.

use core::time::Duration;

use vn100_protocol::{
    AsyncRate, Check, Handled, Register, RequestFailure, RequestId, RequestQueue, Response, SensorCommand,
};

use super::reply;

pub(crate) const READ_RATE: SensorCommand = SensorCommand::ReadRegister(Register::ASYNC_RATE);
pub(crate) const READ_MODEL: SensorCommand = SensorCommand::ReadRegister(Register::MODEL);

pub(crate) fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

pub(crate) fn write_rate(hz: u32) -> SensorCommand {
    SensorCommand::write(&AsyncRate::new(hz).unwrap())
}

/// A session with a clock.
pub(crate) struct Bench {
    pub(crate) session: RequestQueue,
    pub(crate) now: Duration,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self { session: RequestQueue::new(Check::Xor8), now: ms(1_000_000) }
    }

    pub(crate) fn submit(&mut self, command: SensorCommand) -> RequestId {
        self.session.submit(command).unwrap()
    }

    /// The lines to send now, without CR and LF.
    pub(crate) fn sent(&mut self) -> Vec<String> {
        core::iter::from_fn(|| self.session.poll_transmit(self.now))
            .map(|bytes| String::from_utf8(bytes).unwrap().strip_suffix("\r\n").unwrap().to_owned())
            .collect()
    }

    pub(crate) fn hear(&mut self, body: &str) -> Handled {
        self.session.handle_reply(&reply(body), self.now)
    }

    pub(crate) fn wait(&mut self, milliseconds: u64) {
        self.now += ms(milliseconds);
        self.session.handle_timeout(self.now);
    }

    /// The time until the next timeout.
    pub(crate) fn due(&self) -> Option<Duration> {
        self.session.poll_timeout().map(|at| at - self.now)
    }

    pub(crate) fn answer(&mut self, id: RequestId) -> Response {
        let (ended, result) = self.session.poll_completion().unwrap();
        assert_eq!(ended, id);
        result.unwrap()
    }

    pub(crate) fn value(&mut self, id: RequestId) -> String {
        match self.answer(id) {
            Response::Register(contents) => contents.fields.to_string(),
            Response::Done => panic!("no value"),
        }
    }

    pub(crate) fn failure(&mut self, id: RequestId) -> RequestFailure {
        let (ended, result) = self.session.poll_completion().unwrap();
        assert_eq!(ended, id);
        result.unwrap_err()
    }
}

//! Commands and their answers among everything else that a sensor sends: one at a time on the wire. Pure; time is an argument, counted
//! from any origin.

use std::{collections::VecDeque, time::Duration};

use crate::command::{Answer, Command, CommandError, is_unasked};

/// How often a command is sent that does no harm twice.
const ATTEMPTS: u32 = 3;

/// The code by which the sensor says that a command came damaged.
const DAMAGED: u8 = 3;

/// Each command goes in with a token, and comes out exactly once with the token and what became of it.
#[derive(Debug)]
pub(crate) struct Exchange<T> {
    queue: VecDeque<(Command, T)>,
    open: Option<Open<T>>,
    done: VecDeque<(T, Command, Result<Answer, CommandError>)>,
}

#[derive(Debug)]
struct Open<T> {
    command: Command,
    token: T,
    /// How often it has been sent.
    attempts: u32,
    /// When the next attempt is made, or it is given up; `None` while it is to be sent.
    deadline: Option<Duration>,
}

impl<T> Exchange<T> {
    pub(crate) fn new() -> Self {
        Self { queue: VecDeque::new(), open: None, done: VecDeque::new() }
    }

    /// Takes a command to be sent behind those before it.
    pub(crate) fn submit(&mut self, command: Command, token: T) {
        if command.is_well_formed() {
            self.queue.push_back((command, token));
        } else {
            let error = CommandError::Malformed { command: command.to_string() };
            self.done.push_back((token, command, Err(error)));
        }
    }

    /// Whether nothing is under way.
    pub(crate) fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.open.is_none() && self.done.is_empty()
    }

    /// What is to be sent now.
    pub(crate) fn poll_transmit(&mut self, now: Duration) -> Option<String> {
        if self.open.is_none() {
            let (command, token) = self.queue.pop_front()?;
            self.open = Some(Open { command, token, attempts: 0, deadline: None });
        }
        let open = self.open.as_mut().filter(|open| open.deadline.is_none())?;
        open.attempts += 1;
        open.deadline = Some(now + open.command.patience());
        Some(open.command.line())
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    pub(crate) fn poll_timeout(&self) -> Option<Duration> {
        self.open.as_ref()?.deadline
    }

    /// Sends again, or gives up, what has waited too long. May be called at any time.
    pub(crate) fn handle_timeout(&mut self, now: Duration) {
        let Some(open) = self.open.take_if(|open| open.deadline.is_some_and(|deadline| deadline <= now)) else {
            return;
        };
        self.repeat_or(open, |open| CommandError::NoAnswer {
            command: open.command.to_string(),
            attempts: open.attempts,
            patience: open.command.patience(),
        });
    }

    /// Takes the body of an answer, `VNERR` included. One to no open command is let pass.
    pub(crate) fn take_answer(&mut self, body: &str) {
        // before it was sent nothing can be an answer to it
        let Some(open) = self.open.take_if(|open| open.deadline.is_some()) else { return };
        if let Some(code) = error_code(body).filter(|code| !is_unasked(*code)) {
            let refused = |open: &Open<T>| CommandError::Refused { command: open.command.to_string(), code };
            if code == DAMAGED {
                self.repeat_or(open, refused);
            } else {
                let error = refused(&open);
                self.done.push_back((open.token, open.command, Err(error)));
            }
            return;
        }
        match open.command.answer(body) {
            Some(result) => self.done.push_back((open.token, open.command, result)),
            None => self.open = Some(open),
        }
    }

    /// The link is down: nothing under way will be answered.
    pub(crate) fn handle_link_down(&mut self) {
        let open = self.open.take().map(|open| (open.command, open.token));
        let lost = open.into_iter().chain(self.queue.drain(..));
        self.done.extend(lost.map(|(command, token)| (token, command, Err(CommandError::LinkDown))));
    }

    /// What became of a command.
    pub(crate) fn poll_done(&mut self) -> Option<(T, Command, Result<Answer, CommandError>)> {
        self.done.pop_front()
    }

    fn repeat_or(&mut self, open: Open<T>, error: impl FnOnce(&Open<T>) -> CommandError) {
        if open.command.is_repeatable() && open.attempts < ATTEMPTS {
            self.open = Some(Open { deadline: None, ..open });
        } else {
            let error = error(&open);
            self.done.push_back((open.token, open.command, Err(error)));
        }
    }
}

/// The code of a `VNERR` line: two hexadecimal digits.
pub(crate) fn error_code(body: &str) -> Option<u8> {
    u8::from_str_radix(body.strip_prefix("VNERR,")?, 16).ok()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    fn sent(exchange: &mut Exchange<u32>, now: u64) -> Option<String> {
        exchange.poll_transmit(ms(now))
    }

    #[test]
    fn one_command_at_a_time_in_order() {
        let mut exchange = Exchange::new();
        exchange.submit(Command::ReadRegister(6), 1);
        exchange.submit(Command::ReadRegister(7), 2);
        assert_eq!(sent(&mut exchange, 0).as_deref(), Some("$VNRRG,06*75\r\n"));
        assert_eq!(sent(&mut exchange, 1), None);
        exchange.take_answer("VNRRG,07,40");
        assert_eq!(exchange.poll_done(), None, "of another register");
        exchange.take_answer("VNRRG,06,14");
        let (token, _, result) = exchange.poll_done().unwrap();
        assert_eq!((token, result.unwrap().fields.as_str()), (1, "14"));
        assert_eq!(sent(&mut exchange, 2).as_deref(), Some("$VNRRG,07*74\r\n"));
        exchange.take_answer("VNERR,08");
        let refused = CommandError::Refused { command: "VNRRG,07".into(), code: 8 };
        assert_eq!(exchange.poll_done().unwrap().2, Err(refused));
        assert!(exchange.is_idle());
    }

    #[test]
    fn what_does_no_harm_is_sent_again() {
        for (command, attempts) in [(Command::ReadRegister(6), 3), (Command::SaveSettings, 1)] {
            let patience = command.patience();
            let mut exchange = Exchange::new();
            exchange.submit(command.clone(), 1);
            let mut now = Duration::ZERO;
            for _ in 0..attempts {
                assert!(exchange.poll_transmit(now).is_some());
                assert_eq!(exchange.poll_timeout(), Some(now + patience));
                exchange.handle_timeout(now + patience - ms(1));
                assert!(exchange.poll_done().is_none() && exchange.poll_transmit(now).is_none());
                now += patience;
                exchange.handle_timeout(now);
            }
            assert!(exchange.poll_transmit(now).is_none());
            let error = CommandError::NoAnswer { command: command.to_string(), attempts, patience };
            assert_eq!(exchange.poll_done().unwrap().2, Err(error));
        }
    }

    #[test]
    fn damaged_commands_are_repeated_and_unasked_errors_answer_nothing() {
        let mut exchange = Exchange::new();
        exchange.submit(Command::Output(false), 1);
        assert!(sent(&mut exchange, 0).is_some());
        exchange.take_answer("VNERR,0A");
        assert!(exchange.poll_done().is_none() && sent(&mut exchange, 0).is_none());
        exchange.take_answer("VNERR,03");
        assert_eq!(sent(&mut exchange, 1).as_deref(), Some("$VNASY,0*4F\r\n"));
        exchange.take_answer("VNASY,0");
        assert_eq!(exchange.poll_done().unwrap().2, Ok(Answer::default()));
    }

    proptest! {
        #[test]
        fn every_command_comes_out_once(steps in prop::collection::vec(0..8_u8, 0..200)) {
            let mut exchange = Exchange::new();
            let (mut submitted, mut done, mut saved) = (0, Vec::new(), 0);
            let mut now = Duration::ZERO;
            for step in steps.into_iter().chain([7]) {
                now += ms(200);
                match step {
                    0 => exchange.submit(Command::ReadRegister(6), submitted),
                    1 => exchange.submit(Command::SaveSettings, submitted),
                    2 => exchange.take_answer("VNRRG,06,14"),
                    3 => exchange.take_answer("VNERR,03"),
                    4 => exchange.take_answer("VNWNV"),
                    5 => exchange.handle_timeout(now),
                    6 => saved += u32::from(exchange.poll_transmit(now).is_some_and(|line| line.contains("WNV"))),
                    _ => exchange.handle_link_down(),
                }
                submitted += u32::from(step < 2);
                done.extend(std::iter::from_fn(|| exchange.poll_done()).map(|(token, ..)| token));
            }
            done.sort_unstable();
            prop_assert_eq!(done, (0..submitted).collect::<Vec<_>>());
            prop_assert!(saved <= submitted && exchange.is_idle());
        }
    }
}

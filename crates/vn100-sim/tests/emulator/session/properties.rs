//! Any faults in any order: each request ends once and in time, only repeatable commands are sent
//! twice, and the results are true.

use std::time::Duration;

use proptest::{collection::vec, option, prelude::*, sample::select};
use vn100_protocol::{AsyncRate, Register, RegisterFields, Response, SensorCommand};

use super::link::{Fate, Link, line, ms};

const ABSENT: Register = Register(99);

/// The largest additional delay of answers: longer than all attempts of a request.
const LATEST: Duration = ms(1700);

fn command() -> impl Strategy<Value = SensorCommand> {
    let write_rate = |hz| SensorCommand::write(&AsyncRate::new(hz).unwrap());
    let write_tag =
        |tag| SensorCommand::WriteRegister { register: Register(0), fields: RegisterFields::new(tag).unwrap() };
    let registers = vec![Register(0), Register::MODEL, Register::ASYNC_RATE, Register::IMU_FILTER, ABSENT];
    prop_oneof![
        6 => select(registers).prop_map(SensorCommand::ReadRegister),
        4 => select(vec![10, 20, 25, 40, 50]).prop_map(write_rate),
        3 => select(vec!["one", "two", "three"]).prop_map(write_tag),
        2 => any::<bool>().prop_map(SensorCommand::Async),
        1 => Just(SensorCommand::WriteSettings),
        1 => select(vec![SensorCommand::Reset, SensorCommand::RestoreFactorySettings]),
    ]
}

fn command_fate() -> impl Strategy<Value = Fate> {
    prop_oneof![6 => Just(Fate::WHOLE), 1 => Just(Fate::LOST), 1 => any::<usize>().prop_map(Fate::flipped)]
}

fn answer_fate() -> impl Strategy<Value = Fate> {
    prop_oneof![
        6 => Just(Fate::WHOLE),
        1 => Just(Fate::LOST),
        1 => Just(Fate::TWICE),
        1 => any::<usize>().prop_map(Fate::flipped),
        2 => (0..=LATEST.as_millis() as u64).prop_map(|late| Fate::late(ms(late))),
    ]
}

/// The most times that it may be sent.
fn attempts(command: &SensorCommand) -> u32 {
    match command {
        SensorCommand::ReadRegister(_) | SensorCommand::WriteRegister { .. } | SensorCommand::Async(_) => 3,
        _ => 1,
    }
}

/// The longest time that all attempts take.
fn patience(command: &SensorCommand) -> Duration {
    command.answer_time() * attempts(command)
}

proptest! {
    #[test]
    fn requests_over_a_bad_link(
        commands in vec(command(), 1..12),
        command_fates in vec(command_fate(), 0..40),
        answer_fates in vec(answer_fate(), 0..40),
        flips in vec(any::<usize>(), 0..100),
        power_cut in option::of(0_u64..8000),
    ) {
        let mut link = Link::new();
        link.commands.fates = command_fates.into();
        link.answers.fates = answer_fates.into();
        link.flips = flips.into();
        let mut power_cut = power_cut.map(|after| link.now + ms(after));
        let mut restarted_at = None;
        let ids: Vec<_> = commands.iter().map(|command| link.session.submit(command.clone()).unwrap()).collect();
        let mut free_at = link.now;
        for (index, command) in commands.iter().enumerate() {
            let sent_before = link.sent.len();
            let limit = free_at + patience(command);
            if let Some(at) = power_cut.take_if(|at| *at <= limit) {
                link.run(at, index + 1);
                link.device.power_cycle(link.now);
                restarted_at = Some(link.now);
            }
            link.run(limit, index + 1);
            // one outcome, of this request, in time
            prop_assert_eq!(link.outcomes.len(), index + 1, "{:?} has not ended by {:?}", command, limit);
            let outcome = &link.outcomes[index];
            prop_assert_eq!(outcome.id, ids[index]);
            // the next may have to wait for late answers, or for the sensor
            free_at = outcome.at + patience(command) + command.busy_time();
            // only this command was sent meanwhile, as often as allowed
            let sent = &link.sent[sent_before..];
            prop_assert!(sent.len() <= attempts(command) as usize, "{:?}", sent);
            prop_assert!(sent.iter().all(|(_, sent)| *sent == line(command)), "{:?}", sent);
            if matches!(command, SensorCommand::Reset | SensorCommand::RestoreFactorySettings) {
                restarted_at = Some(outcome.at);
            }
            // the result for a register is of that register, and true
            if let Ok(Response::Register(contents)) = &outcome.result {
                let (SensorCommand::ReadRegister(asked) | SensorCommand::WriteRegister { register: asked, .. }) = command else {
                    panic!("{command:?} was answered with {contents:?}");
                };
                prop_assert_eq!(contents.register, *asked);
                // an answer from before a restart also answers an equal request
                if restarted_at.is_none_or(|at| sent[0].0 >= at + LATEST) {
                    prop_assert_eq!(contents.fields.as_str(), link.truth(*asked), "{:?}", command);
                }
            }
        }
        let sent = link.sent.len();
        link.wait(ms(5000));
        prop_assert_eq!((link.outcomes.len(), link.sent.len()), (commands.len(), sent), "nothing follows");
    }
}

//! One fault at a time, and its effect on the session.

use std::time::Duration;

use vn100_protocol::{AsyncRate, BaudRate, DeviceError, Register, RegisterFields, RequestFailure, SensorCommand};
use vn100_sim::device::BOOT;

use super::link::{Fate, Link, Outcome, line, ms};

const READ_RATE: SensorCommand = SensorCommand::ReadRegister(Register::ASYNC_RATE);
const READ_ABSENT: SensorCommand = SensorCommand::ReadRegister(Register(99));

fn write_rate(hz: u32) -> SensorCommand {
    SensorCommand::write(&AsyncRate::new(hz).unwrap())
}

fn write(register: Register, fields: &str) -> SensorCommand {
    SensorCommand::WriteRegister { register, fields: RegisterFields::new(fields).unwrap() }
}

fn write_baud(bits_per_s: u32) -> SensorCommand {
    SensorCommand::write(&BaudRate::new(bits_per_s).unwrap())
}

/// The result of each request.
fn told(outcomes: &[Outcome]) -> Vec<&str> {
    outcomes.iter().map(Outcome::told).collect()
}

fn error(outcome: &Outcome) -> DeviceError {
    match outcome.result {
        Err(RequestFailure::Device { error, .. }) => error,
        ref other => panic!("{other:?}"),
    }
}

fn attempts(outcome: &Outcome) -> u32 {
    match outcome.result {
        Err(RequestFailure::Timeout { attempts, .. }) => attempts,
        ref other => panic!("{other:?}"),
    }
}

/// Whether exactly these commands were sent.
fn assert_sent(link: &Link, commands: &[SensorCommand]) {
    let sent: Vec<_> = link.sent.iter().map(|(_, line)| line.as_str()).collect();
    assert_eq!(sent, commands.iter().map(line).collect::<Vec<_>>());
}

#[test]
fn answers_come_between_lines_at_200_hz_and_no_line_is_lost() {
    let mut link = Link::new();
    assert_eq!(told(&link.ask(&[write_baud(921_600)])), ["921600"]);
    link.host_baud = 921_600;
    assert_eq!(told(&link.ask(&[write_rate(200)])), ["200"]);
    // the next of its lines
    link.wait(ms(5));
    let (began, before) = (link.now, link.samples);
    for _ in 0..20 {
        let outcomes = link.ask(&[READ_RATE, SensorCommand::ReadRegister(Register::MODEL), READ_ABSENT]);
        assert_eq!(told(&outcomes[..2]), ["200", "VN-100S-CR"]);
        assert_eq!(error(&outcomes[2]), DeviceError::InvalidRegister);
    }
    link.wait(ms(100) + began - link.now);
    assert_eq!(link.samples - before, 20, "as many as without questions");
    assert_eq!((link.bad, link.sent.len()), (0, 62));
}

#[test]
fn a_lost_request_is_sent_again() {
    let mut link = Link::new();
    link.commands.fates = [Fate::LOST, Fate::LOST].into();
    let outcomes = link.ask(&[READ_RATE]);
    assert_eq!(told(&outcomes), ["40"]);
    assert_sent(&link, &[READ_RATE, READ_RATE, READ_RATE]);
    let at: Vec<_> = link.sent.iter().map(|(at, _)| *at).collect();
    assert_eq!(at, [ms(2000), ms(2500), ms(3000)]);
}

#[test]
fn a_sensor_that_receives_nothing_is_given_up_in_time() {
    let mut link = Link::new();
    link.commands.fates = vec![Fate::LOST; 5].into();
    let outcomes = link.ask(&[READ_RATE, SensorCommand::WriteSettings, SensorCommand::Reset, READ_RATE]);
    assert_eq!((attempts(&outcomes[0]), attempts(&outcomes[1]), attempts(&outcomes[2])), (3, 1, 1));
    assert_eq!(outcomes[3].told(), "40");
    let at: Vec<_> = outcomes[..3].iter().map(|outcome| outcome.at).collect();
    assert_eq!(at, [ms(3500), ms(4700), ms(7200)]);
}

#[test]
fn a_lost_answer_is_requested_again() {
    let mut link = Link::new();
    link.answers.fates = [Fate::LOST].into();
    assert_eq!(told(&link.ask(&[write_rate(20), READ_RATE])), ["20", "20"]);
    assert_sent(&link, &[write_rate(20), write_rate(20), READ_RATE]);
}

#[test]
fn settings_are_not_saved_twice_when_the_answer_is_lost() {
    for once in [SensorCommand::WriteSettings, SensorCommand::Reset, SensorCommand::RestoreFactorySettings] {
        let mut link = Link::new();
        link.answers.fates = [Fate::LOST].into();
        let outcomes = link.ask(&[once.clone(), READ_RATE]);
        assert_eq!((attempts(&outcomes[0]), outcomes[1].told()), (1, "40"));
        assert_sent(&link, &[once, READ_RATE]);
    }
}

#[test]
fn a_late_answer_is_not_taken_for_that_of_the_next_request() {
    // the sensor has answered the first read long before the write; both of its answers come late
    let mut link = Link::new();
    link.answers.fates = [Fate::late(ms(700))].into();
    let outcomes = link.ask(&[READ_RATE, write_rate(20), READ_RATE]);
    assert_eq!(told(&outcomes), ["40", "20", "20"]);
    assert_sent(&link, &[READ_RATE, READ_RATE, write_rate(20), READ_RATE]);
    // the late answer to a write does not count as the answer to the next write
    let mut link = Link::new();
    link.answers.fates = [Fate::late(ms(700))].into();
    assert_eq!(told(&link.ask(&[write_rate(20), write_rate(10), READ_RATE])), ["20", "10", "10"]);
    // an error does not name the request that it answers: the next request waits for the second one
    let mut link = Link::new();
    link.answers.fates = [Fate::late(ms(700)), Fate::late(ms(600))].into();
    let outcomes = link.ask(&[READ_ABSENT, READ_RATE]);
    assert_eq!((error(&outcomes[0]), outcomes[1].told()), (DeviceError::InvalidRegister, "40"));
    assert_eq!(link.session.poll_notice(), None);
}

#[test]
fn an_answer_after_the_end_of_its_request_answers_nothing() {
    let mut link = Link::new();
    link.answers.fates = [Fate::late(ms(3000))].into();
    let outcomes = link.ask(&[SensorCommand::WriteSettings, READ_RATE]);
    assert_eq!(attempts(&outcomes[0]), 1);
    // it was delayed by the late one
    assert_eq!(attempts(&outcomes[1]), 3);
    assert_eq!(told(&link.ask(&[SensorCommand::Async(false), write_rate(20), READ_RATE])), ["Done", "20", "20"]);
    assert_eq!((link.session.poll_notice(), link.outcomes.len()), (None, 5));
    // it does not count as the answer to the next write either
    let mut link = Link::new();
    link.answers.fates = [Fate::late(ms(1600))].into();
    let outcomes = link.ask(&[write_rate(20), write_rate(10), READ_RATE]);
    assert_eq!((attempts(&outcomes[0]), told(&outcomes[1..])), (3, vec!["10", "10"]));
}

#[test]
fn an_answer_that_comes_twice_answers_once() {
    let mut link = Link::new();
    link.answers.fates = vec![Fate::TWICE; 5].into();
    let requests = [READ_RATE, write_rate(20), READ_RATE, write_rate(10), READ_RATE];
    assert_eq!(told(&link.ask(&requests)), ["40", "20", "20", "10", "10"]);
    assert_sent(&link, &requests);
    link.wait(ms(1000));
    assert_eq!((link.outcomes.len(), link.session.poll_notice()), (5, None));
}

#[test]
fn a_refusal_ends_the_request_that_it_answers() {
    let mut link = Link::new();
    let read_only = write(Register::MODEL, "X");
    let odd_rate = write(Register::ASYNC_RATE, "30");
    let too_few = write(Register::IMU_FILTER, "0,4");
    let requests = [READ_ABSENT, read_only, odd_rate, write_rate(200), too_few, SensorCommand::Tare, READ_RATE];
    let outcomes = link.ask(&requests);
    let errors: Vec<_> = outcomes[..6].iter().map(error).collect();
    assert_eq!(
        errors,
        [
            DeviceError::InvalidRegister,
            DeviceError::Unauthorized,
            DeviceError::InvalidParameter,
            DeviceError::InsufficientBaudRate,
            DeviceError::TooFewParameters,
            DeviceError::InvalidCommand,
        ]
    );
    assert_eq!(outcomes[6].told(), "40");
    assert_sent(&link, &requests);
}

#[test]
fn a_flipped_bit_of_a_request_or_an_answer_needs_one_more_attempt() {
    let bits = 8 * line(&READ_RATE).len();
    for bit in 0..bits {
        let mut link = Link::new();
        link.commands.fates = [Fate::flipped(bit)].into();
        assert_eq!(told(&link.ask(&[READ_RATE])), ["40"], "bit {bit} of the request");
        let mut link = Link::new();
        link.answers.fates = [Fate::flipped(bit)].into();
        assert_eq!(told(&link.ask(&[READ_RATE])), ["40"], "bit {bit} of the answer");
    }
}

#[test]
fn a_sensor_that_loses_its_power_is_given_up_and_answers_again_later() {
    let mut link = Link::new();
    link.session.submit(write_rate(20)).unwrap();
    link.session.submit(READ_RATE).unwrap();
    // the answer is in transit
    link.run(link.now, 2);
    link.device.power_cycle(link.now);
    link.run(ms(10_000), 2);
    // all three attempts fell into the boot
    assert_eq!((attempts(&link.outcomes[0]), link.outcomes[1].told()), (3, "40"));
    assert!(link.outcomes[1].at < ms(2000) + ms(1500) + ms(100));
}

#[test]
fn a_fault_of_the_sensor_is_reported_and_answers_nothing() {
    let mut link = Link::new();
    assert_eq!(told(&link.ask(&[write_rate(20)])), ["20"]);
    link.session.submit(READ_RATE).unwrap();
    link.commands.fates = [Fate::LOST].into();
    link.run(link.now, usize::MAX);
    link.device.crash(link.now);
    // a restart takes longer than two attempts
    link.run(ms(10_000), 2);
    assert_eq!(attempts(&link.outcomes[1]), 3);
    assert_eq!((link.session.poll_notice(), link.session.poll_notice()), (Some(DeviceError::HardFault), None));
    assert_eq!(told(&link.ask(&[READ_RATE])), ["40"], "what was not saved is gone");
}

#[test]
fn nothing_is_sent_while_the_sensor_restarts() {
    for restart in [SensorCommand::Reset, SensorCommand::RestoreFactorySettings] {
        let mut link = Link::new();
        let requests = [write_rate(20), restart, READ_RATE];
        let outcomes = link.ask(&requests);
        assert_eq!(told(&outcomes), ["20", "Done", "40"]);
        // a command sent before would have been repeated
        assert_sent(&link, &requests);
        assert_eq!(link.sent[2].0, outcomes[1].at + BOOT);
    }
    let mut link = Link::new();
    let outcomes = link.ask(&[write_rate(20), SensorCommand::WriteSettings, SensorCommand::Reset, READ_RATE]);
    assert_eq!(told(&outcomes), ["20", "Done", "Done", "20"], "what was saved is kept");
}

#[test]
fn the_answer_to_a_change_of_the_baud_rate_comes_at_the_old_one() {
    let mut link = Link::new();
    let outcomes = link.ask(&[write_baud(921_600)]);
    assert_eq!((told(&outcomes), link.sent.len()), (vec!["921600"], 1));
    // a host that stays at the old rate is not heard
    assert_eq!(attempts(&link.ask(&[READ_RATE])[0]), 3);
    link.host_baud = 921_600;
    assert_eq!(told(&link.ask(&[SensorCommand::ReadRegister(Register::BAUD_RATE), READ_RATE])), ["921600", "40"]);
}

#[test]
fn a_lost_answer_to_a_change_of_the_baud_rate_leaves_the_change_unknown() {
    let mut link = Link::new();
    link.answers.fates = [Fate::LOST].into();
    assert_eq!(attempts(&link.ask(&[write_baud(57_600)])[0]), 3, "it is asked again at a rate that it does not hear");
    link.host_baud = 57_600;
    let outcomes = link.ask(&[SensorCommand::ReadRegister(Register::BAUD_RATE)]);
    assert_eq!(told(&outcomes), ["57600"]);
    let took: Duration = outcomes[0].at - link.sent[3].0;
    assert!(took < ms(50), "{took:?}");
}

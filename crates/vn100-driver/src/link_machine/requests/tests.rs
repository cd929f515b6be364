//! The order of commands, and the effects of replies, errors and timeouts.

use vn100_protocol::{RegisterContents, RegisterFields};

use super::*;

const MODEL: &[u8] = b"$VNRRG,01*72\r\n";

fn register(register: Register, fields: &str) -> Reply {
    Reply::Register(RegisterContents { register, fields: RegisterFields::new(fields).unwrap() })
}

const fn s(s: u64) -> Duration {
    Duration::from_secs(s)
}

/// The bytes that a connected link sends.
fn transmit(requests: &mut Requests, now: Duration, baud: Option<u32>) -> Option<Vec<u8>> {
    requests.submit_due_reads(now, baud);
    requests.poll_transmit(now)
}

/// The effects of an error that the sensor reports.
fn reported(requests: &mut Requests, error: DeviceError, now: Duration) -> Vec<RequestEvent> {
    requests.handle_reply(&Reply::Error(error), now);
    requests.events.drain(..).collect()
}

#[test]
fn the_temperature_is_read_if_the_line_has_room() {
    // 94 frames of 122 bytes fill a line of 115 200 baud except for 52 bytes per second
    for (frames_per_s, baud, read) in [(40, Some(115_200), true), (94, Some(115_200), false), (94, None, true)] {
        let mut requests = Requests::new(false, Some(s(10)));
        assert_eq!(requests.next_read_at(), Some(s(10)));
        requests.handle_read(10 * frames_per_s * 122);
        assert_eq!(transmit(&mut requests, s(9), baud), None);
        let sent = transmit(&mut requests, s(10), baud);
        assert_eq!(sent.as_deref(), read.then_some(&b"$VNRRG,54*72\r\n"[..]));
        assert_eq!(transmit(&mut requests, s(11), baud), None);
    }
    assert_eq!(Requests::new(true, Some(s(10))).next_read_at(), None, "a link that only listens");
}

#[test]
fn the_user_does_not_wait_for_the_whole_identification() {
    let mut requests = Requests::new(false, None);
    requests.identify(s(0));
    assert_eq!(transmit(&mut requests, s(0), None).as_deref(), Some(&b"$VNRRG,07*74\r\n"[..]));
    requests.submit_for_user(1, SensorCommand::ReadRegister(Register::IMU));
    requests.handle_reply(&register(Register::ASYNC_RATE, "40"), s(0));
    assert_eq!(requests.poll_event(), None);
    assert_eq!(transmit(&mut requests, s(0), None).as_deref(), Some(&b"$VNRRG,54*72\r\n"[..]));
    requests.handle_reply(&register(Register::IMU, "+21.6"), s(0));
    let Some((1, Ok(Response::Register(contents)))) = requests.answers.pop_front() else { panic!("no answer") };
    assert_eq!(contents.fields.as_str(), "+21.6");
    // the next register waits until the line has made up for the reply
    assert_eq!(transmit(&mut requests, READ_INTERVAL - Duration::from_millis(1), None), None);
    assert_eq!(requests.next_read_at(), Some(READ_INTERVAL));
    assert_eq!(transmit(&mut requests, READ_INTERVAL, None).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
    // a register to be verified comes before the others
    requests.read_next(Register::SERIAL_NUMBER);
    requests.handle_reply(&register(Register::SERIAL_NUMBER, "1"), READ_INTERVAL);
    assert_eq!(transmit(&mut requests, READ_INTERVAL * 2, None).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
}

#[test]
fn a_missing_register_is_skipped_and_a_one_way_cable_ends_the_reads() {
    let mut requests = Requests::new(false, None);
    requests.identify(s(0));
    assert!(transmit(&mut requests, s(0), None).is_some());
    requests.handle_reply(&Reply::Error(DeviceError::InvalidRegister), s(0));
    assert!(transmit(&mut requests, READ_INTERVAL, None).is_some());
    let (mut now, mut sent) = (s(0), 0);
    while let Some(due) = [requests.poll_timeout(), requests.next_read_at()].into_iter().flatten().min() {
        now = due;
        requests.handle_timeout(now);
        sent += u32::from(transmit(&mut requests, now, None).is_some());
    }
    assert_eq!((sent, now), (2, READ_INTERVAL + Duration::from_millis(1500)), "two more attempts of one read");
}

#[test]
fn a_command_of_the_phase_is_sent_before_those_of_the_user() {
    let mut requests = Requests::new(false, None);
    requests.submit_for_user(1, SensorCommand::ReadRegister(Register::IMU));
    requests.submit_for_user(2, SensorCommand::ReadRegister(Register::MODEL));
    assert_eq!(requests.poll_transmit(s(0)).as_deref(), Some(&b"$VNRRG,54*72\r\n"[..]));
    requests.submit_for_phase(SensorCommand::ReadRegister(Register::SERIAL_NUMBER));
    requests.handle_reply(&register(Register::IMU, "1"), s(0));
    assert_eq!(requests.poll_transmit(s(0)).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
    requests.handle_reply(&register(Register::SERIAL_NUMBER, "1"), s(0));
    assert!(matches!(requests.answers.pop_front(), Some((1, Ok(_)))));
    assert!(matches!(requests.poll_event(), Some(RequestEvent::PhaseAnswered(Ok(_)))));
    assert_eq!(requests.poll_transmit(s(0)).as_deref(), Some(MODEL));
    // a lost link ends open commands, and only the user is informed
    requests.submit_for_phase(SensorCommand::ReadRegister(Register::SERIAL_NUMBER));
    requests.handle_link_down();
    assert!(matches!(requests.answers.pop_front(), Some((2, Err(_)))));
    assert_eq!((requests.poll_event(), requests.poll_transmit(s(9))), (None, None));
}

#[test]
fn errors_not_caused_by_this_link_are_events() {
    // a link that only listens has sent nothing
    let mut requests = Requests::new(true, None);
    for (error, expected) in [
        (DeviceError::InvalidCommand, vec![RequestEvent::Unsolicited(DeviceError::InvalidCommand)]),
        (DeviceError::HardFault, vec![RequestEvent::Restarted(DeviceError::HardFault)]),
        (DeviceError::WatchdogReset, vec![RequestEvent::Restarted(DeviceError::WatchdogReset)]),
        // counted in the stream
        (DeviceError::OutputBufferOverflow, vec![]),
    ] {
        assert_eq!(reported(&mut requests, error, s(0)), expected);
    }
    requests.submit_for_user(1, SensorCommand::Async(true));
    assert_eq!(requests.answers.pop_front(), Some((1, Err(CommandError::ListenOnly))));
    requests.identify(s(0));
    requests.read_next(Register::MODEL);
    assert_eq!(transmit(&mut requests, s(0), None), None);
}

#[test]
fn errors_after_a_baud_scan_are_not_taken_for_answers_until_the_first_good_one() {
    let refusal = DeviceError::InvalidCommand;
    let read = |requests: &mut Requests| requests.submit_for_user(1, SensorCommand::ReadRegister(Register::MODEL));
    let mut requests = Requests::new(false, None);
    requests.expect_spurious_errors();
    assert_eq!(reported(&mut requests, refusal, s(0)), [], "before anything is sent");
    read(&mut requests);
    for _ in 0..2 {
        assert!(requests.poll_transmit(s(0)).is_some(), "it is sent again");
        assert_eq!(reported(&mut requests, refusal, s(0)), []);
    }
    assert!(requests.poll_transmit(s(0)).is_some());
    requests.handle_reply(&register(Register::MODEL, "VN-100S-CR"), s(0));
    assert!(matches!(requests.answers.pop_front(), Some((1, Ok(_)))));
    assert_eq!(reported(&mut requests, refusal, s(1)), [RequestEvent::Unsolicited(refusal)]);
    // a sensor that always refuses is not asked without end: one error for each baud rate
    for questions in [1, BAUD_RATES.len() + 3] {
        (0..questions).for_each(|_| requests.expect_spurious_errors());
        read(&mut requests);
        for attempt in 0.. {
            assert!(requests.poll_transmit(s(1)).is_some());
            assert_eq!(reported(&mut requests, refusal, s(1)), []);
            if let Some((1, Err(_))) = requests.answers.pop_front() {
                assert_eq!(attempt, BAUD_RATES.len() + questions - 1);
                break;
            }
        }
    }
}

/// A sensor whose output has been silent for 3 s, and that has answered meanwhile.
fn silent() -> Requests {
    let mut requests = Requests::new(false, None);
    requests.ask_presence(s(0), s(1));
    assert_eq!(requests.poll_transmit(s(1)).as_deref(), Some(MODEL));
    requests.handle_reply(&register(Register::MODEL, "VN-100"), s(1));
    requests
}

#[test]
fn an_output_set_by_the_user_is_unchanged() {
    for on in [false, true] {
        let mut requests = silent();
        requests.submit_for_user(1, SensorCommand::Async(on));
        assert!(requests.poll_transmit(s(2)).is_some());
        requests.handle_reply(&Reply::Echo(format!("VNASY,{}", u8::from(on))), s(2));
        requests.ask_presence(s(0), s(9));
        let question = requests.poll_transmit(s(9));
        assert_eq!(question.as_deref() == Some(MODEL), !on, "a pause that the user wants is kept");
        if on {
            requests.handle_reply(&Reply::Echo("VNASY,1".into()), s(9));
            assert!(requests.detect_resumed_output());
            requests.submit_for_user(2, SensorCommand::Async(true));
            assert!(requests.poll_transmit(s(9)).is_some());
            requests.handle_reply(&Reply::Echo("VNASY,1".into()), s(9));
            assert!(!requests.must_restore_pause());
        }
    }
}

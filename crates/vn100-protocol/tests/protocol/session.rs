//! The request machine, step by step, on a clock that is a number.

use vn100_protocol::{
    BaudRate, DeviceError, Handled, QueueFull, Register, RegisterFields, RequestFailure, RequestQueue, Response,
    SensorCommand,
};

use crate::support::bench::{Bench, READ_MODEL, READ_RATE, ms, write_rate};

#[test]
fn a_read_is_answered_among_other_lines() {
    let mut bench = Bench::new();
    let id = bench.submit(READ_RATE);
    assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    assert_eq!(bench.due(), Some(ms(500)));
    for other in ["VNRRG,06,14", "VNWRG,07,40", "VNASY,1", "VNERR,0B"] {
        assert_eq!(bench.hear(other), Handled::NotMine, "{other}");
    }
    assert_eq!(bench.session.poll_completion(), None);
    assert_eq!(bench.hear("VNRRG,07,40"), Handled::Mine);
    assert_eq!(bench.value(id), "40");
    assert_eq!((bench.due(), bench.sent()), (None, vec![]));
}

#[test]
fn one_request_is_on_the_wire_at_a_time_in_their_order() {
    let mut bench = Bench::new();
    let [rate, model, pause] =
        [READ_RATE, READ_MODEL, SensorCommand::Async(false)].map(|command| bench.submit(command));
    assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    assert_eq!(bench.hear("VNRRG,01,VN-100S-CR"), Handled::NotMine);
    assert_eq!(bench.hear("VNRRG,7,40"), Handled::Mine);
    assert_eq!(bench.sent(), ["$VNRRG,01*72"]);
    assert_eq!(bench.hear("VNRRG,01,VN-100S-CR"), Handled::Mine);
    assert_eq!(bench.sent(), ["$VNASY,0*4F"]);
    assert_eq!(bench.hear("VNASY,1"), Handled::NotMine);
    assert_eq!(bench.hear("VNASY,0"), Handled::Mine);
    assert_eq!(
        (bench.value(rate), bench.value(model), bench.answer(pause)),
        ("40".into(), "VN-100S-CR".into(), Response::Done)
    );
}

#[test]
fn an_urgent_request_is_sent_next_and_one_that_is_cancelled_not_again() {
    let mut bench = Bench::new();
    let [rate, model] = [READ_RATE, READ_MODEL].map(|command| bench.submit(command));
    assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    let pause = bench.session.submit_next(SensorCommand::Async(false)).unwrap();
    bench.session.cancel(rate);
    assert_eq!(bench.sent(), ["$VNASY,0*4F"], "at once");
    bench.session.cancel(model);
    assert_eq!(bench.hear("VNRRG,07,40"), Handled::NotMine);
    assert_eq!(bench.hear("VNASY,0"), Handled::Mine);
    assert_eq!(bench.answer(pause), Response::Done);
    assert_eq!((bench.sent(), bench.due(), bench.session.poll_completion()), (vec![], None, None));
}

#[test]
fn a_read_is_sent_three_times_and_given_up() {
    let mut bench = Bench::new();
    let id = bench.submit(READ_MODEL);
    for _ in 0..RequestQueue::ATTEMPTS {
        assert_eq!(bench.sent(), ["$VNRRG,01*72"]);
        bench.wait(499);
        assert_eq!((bench.sent(), bench.due()), (vec![], Some(ms(1))));
        bench.wait(1);
    }
    let failure = bench.failure(id);
    assert_eq!(failure, RequestFailure::Timeout { line: "$VNRRG,01*72".into(), attempts: 3, after: ms(1500) });
    assert!(failure.to_string().starts_with("no reply to $VNRRG,01*72, sent 3 times in 1.5 s: "));
    assert!(failure.to_string().contains("error mode 0 (register 30)"));
    assert_eq!(bench.hear("VNRRG,01,VN-100S-CR"), Handled::Mine);
    assert_eq!((bench.sent(), bench.session.poll_completion()), (vec![], None));
}

#[test]
fn commands_that_must_not_be_repeated_are_sent_once() {
    use SensorCommand::{Reset, RestoreFactorySettings, SetGyroBias, Tare, WriteSettings};
    for (command, wait) in
        [(WriteSettings, 1200), (RestoreFactorySettings, 2500), (Reset, 2500), (SetGyroBias, 500), (Tare, 500)]
    {
        let mut bench = Bench::new();
        let id = bench.submit(command.clone());
        assert_eq!((bench.sent().len(), bench.due()), (1, Some(ms(wait))), "{command:?}");
        bench.wait(wait);
        assert_eq!(bench.sent(), [""; 0]);
        assert!(matches!(bench.failure(id), RequestFailure::Timeout { attempts: 1, .. }));

        let id = bench.submit(command);
        assert_eq!(bench.sent().len(), 1);
        assert_eq!(bench.hear("VNERR,03"), Handled::Mine);
        assert_eq!(bench.sent(), [""; 0]);
        assert!(matches!(bench.failure(id), RequestFailure::Device { error: DeviceError::InvalidChecksum, .. }));
    }
}

#[test]
fn a_command_damaged_on_its_way_is_sent_again_at_once() {
    let mut bench = Bench::new();
    let id = bench.submit(write_rate(50));
    assert_eq!(bench.sent(), ["$VNWRG,07,50*58"]);
    assert_eq!((bench.hear("VNERR,03"), bench.sent()), (Handled::Mine, vec!["$VNWRG,07,50*58".into()]));
    assert_eq!((bench.hear("VNERR,02"), bench.sent()), (Handled::Mine, vec!["$VNWRG,07,50*58".into()]));
    assert_eq!(bench.hear("VNERR,03"), Handled::Mine);
    let failure = bench.failure(id);
    assert_eq!(
        failure.to_string(),
        "the sensor refused $VNWRG,07,50*58 with VNERR 03: the command arrived with a wrong checksum: pause the output before writing"
    );
}

#[test]
fn an_error_answers_the_request_unless_it_comes_unasked() {
    let mut bench = Bench::new();
    let id = bench.submit(write_rate(200));
    assert_eq!(bench.hear("VNERR,07"), Handled::NotMine, "before it is sent, nothing can be refused");
    bench.sent();
    for unasked in ["VNERR,01", "VNERR,0A", "VNERR,0B", "VNERR,FF"] {
        assert_eq!(bench.hear(unasked), Handled::NotMine);
    }
    assert_eq!(bench.hear("VNERR,0C"), Handled::Mine);
    assert!(matches!(bench.failure(id), RequestFailure::Device { error: DeviceError::InsufficientBaudRate, .. }));
    assert_eq!(bench.hear("VNERR,12"), Handled::NotMine);
    use DeviceError::{ErrorBufferOverflow, HardFault, InvalidParameter, OutputBufferOverflow, Unknown, WatchdogReset};
    let notices: Vec<_> = core::iter::from_fn(|| bench.session.poll_notice()).collect();
    assert_eq!(
        notices,
        [InvalidParameter, HardFault, WatchdogReset, OutputBufferOverflow, ErrorBufferOverflow, Unknown(0x12)]
    );
}

#[test]
fn the_newest_notices_are_kept() {
    let mut bench = Bench::new();
    for code in 0x20..0x20 + RequestQueue::NOTICES + 2 {
        bench.hear(&format!("VNERR,{code:02X}"));
    }
    let notices: Vec<_> = core::iter::from_fn(|| bench.session.poll_notice()).collect();
    assert_eq!((notices.len(), notices[0]), (RequestQueue::NOTICES, DeviceError::Unknown(0x22)));
}

#[test]
fn a_write_is_confirmed_by_its_fields() {
    let mut bench = Bench::new();
    let id = bench.submit(write_rate(50));
    bench.sent();
    assert_eq!(bench.hear("VNWRG,07,50,1"), Handled::Mine);
    assert_eq!(bench.value(id), "50,1");
    let id = bench.submit(write_rate(50));
    assert_eq!(bench.sent().len(), 1);
    assert_eq!(bench.hear("VNWRG,07,40"), Handled::Mine);
    assert_eq!(
        bench.failure(id).to_string(),
        "the reply to $VNWRG,07,50*58 has other fields: requested 50, received 40; read the register to see its value"
    );
    // the reply to a register without a port has no more fields than were written
    let fields = RegisterFields::new("0,1,5").unwrap();
    let id = bench.submit(SensorCommand::WriteRegister { register: Register::HSI_CONTROL, fields });
    bench.sent();
    bench.hear("VNWRG,44,0,1,5,1");
    assert!(matches!(bench.failure(id), RequestFailure::EchoDiffers { .. }));
}

#[test]
fn a_late_error_is_not_taken_for_that_of_the_next_request() {
    let mut bench = Bench::new();
    let first = bench.submit(SensorCommand::ReadRegister(Register(99)));
    let second = bench.submit(READ_RATE);
    bench.sent();
    bench.wait(500);
    assert_eq!(bench.sent(), ["$VNRRG,99*73"]);
    bench.wait(20);
    // the answer to the first line; the answer to the second is still due
    assert_eq!(bench.hear("VNERR,08"), Handled::Mine);
    assert!(matches!(bench.failure(first), RequestFailure::Device { error: DeviceError::InvalidRegister, .. }));
    assert_eq!(bench.sent(), [""; 0]);
    // at most as slow as the first
    assert_eq!(bench.due(), Some(ms(500)));
    bench.wait(30);
    assert_eq!(bench.hear("VNERR,08"), Handled::Mine);
    assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    bench.hear("VNRRG,07,40");
    assert_eq!(bench.value(second), "40");
    assert_eq!(bench.session.poll_notice(), None);
}

#[test]
fn a_damaged_copy_is_not_replaced_while_another_may_be_answered() {
    let mut bench = Bench::new();
    let id = bench.submit(READ_RATE);
    bench.sent();
    bench.wait(500);
    assert_eq!(bench.sent().len(), 1);
    assert_eq!((bench.hear("VNERR,03"), bench.sent()), (Handled::Mine, vec![]));
    assert_eq!(bench.hear("VNRRG,07,40"), Handled::Mine);
    assert_eq!(bench.value(id), "40");
    // no further answer is due, so there is no wait
    bench.submit(READ_MODEL);
    assert_eq!(bench.sent(), ["$VNRRG,01*72"]);
}

#[test]
fn an_error_that_comes_too_late_is_a_notice() {
    let mut bench = Bench::new();
    let id = bench.submit(READ_RATE);
    bench.sent();
    bench.wait(500);
    bench.sent();
    bench.hear("VNRRG,07,40");
    bench.value(id);
    bench.wait(501);
    assert_eq!(bench.hear("VNERR,08"), Handled::NotMine);
    assert_eq!(bench.session.poll_notice(), Some(DeviceError::InvalidRegister));
}

#[test]
fn the_next_request_does_not_wait_forever_for_a_late_answer() {
    let mut bench = Bench::new();
    let first = bench.submit(READ_MODEL);
    bench.submit(READ_RATE);
    bench.sent();
    bench.wait(500);
    bench.sent();
    bench.wait(100);
    bench.hear("VNRRG,01,VN-100S-CR");
    bench.value(first);
    // sent 100 ms ago, and the answer took 600 ms since the first line
    assert_eq!(bench.due(), Some(ms(500)));
    bench.wait(500);
    assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    assert_eq!(bench.hear("VNRRG,01,VN-100S-CR"), Handled::Mine);
    assert_eq!(bench.hear("VNRRG,01,VN-100S-CR"), Handled::NotMine);
}

#[test]
fn a_late_echo_of_an_earlier_write_is_not_taken_for_a_wrong_one() {
    let mut bench = Bench::new();
    let first = bench.submit(write_rate(50));
    let second = bench.submit(write_rate(100));
    for _ in 0..RequestQueue::ATTEMPTS {
        assert_eq!(bench.sent(), ["$VNWRG,07,50*58"]);
        bench.wait(500);
    }
    assert!(matches!(bench.failure(first), RequestFailure::Timeout { .. }));
    assert_eq!(bench.sent(), ["$VNWRG,07,100*6C"]);
    assert_eq!(bench.hear("VNWRG,07,50"), Handled::Mine);
    assert_eq!(bench.session.poll_completion(), None);
    assert_eq!(bench.hear("VNWRG,07,100"), Handled::Mine);
    assert_eq!(bench.value(second), "100");
}

#[test]
fn an_echo_is_excused_by_no_other_late_write() {
    for (late, late_fields) in [(Register(99), "50"), (Register::ASYNC_RATE, "40")] {
        let mut bench = Bench::new();
        let fields = RegisterFields::new(late_fields).unwrap();
        let first = bench.submit(SensorCommand::WriteRegister { register: late, fields });
        let second = bench.submit(write_rate(100));
        for _ in 0..RequestQueue::ATTEMPTS {
            bench.sent();
            bench.wait(500);
        }
        _ = bench.failure(first);
        bench.sent();
        bench.hear("VNWRG,07,50");
        assert!(matches!(bench.failure(second), RequestFailure::EchoDiffers { .. }));
    }
}

#[test]
fn an_answer_that_comes_when_the_line_should_be_repeated_still_counts() {
    let mut bench = Bench::new();
    let id = bench.submit(READ_RATE);
    bench.sent();
    bench.wait(600);
    bench.hear("VNRRG,07,40");
    assert_eq!((bench.value(id), bench.sent()), ("40".into(), vec![]));
}

#[test]
fn nothing_is_sent_while_the_sensor_restarts_or_saves() {
    for (command, echo, busy) in [(SensorCommand::Reset, "VNRST", 1250), (SensorCommand::WriteSettings, "VNWNV", 500)] {
        let mut bench = Bench::new();
        let id = bench.submit(command);
        bench.submit(READ_RATE);
        bench.sent();
        bench.hear(echo);
        assert_eq!(bench.answer(id), Response::Done);
        assert_eq!((bench.sent(), bench.due()), (vec![], Some(ms(busy))));
        bench.wait(busy);
        assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    }
}

#[test]
fn all_requests_end_with_the_link() {
    let mut bench = Bench::new();
    let first = bench.submit(SensorCommand::write(&BaudRate::DEFAULT));
    let second = bench.submit(READ_RATE);
    bench.sent();
    bench.session.handle_link_down();
    assert_eq!(
        bench.failure(first).to_string(),
        "the link disconnected before the reply to $VNWRG,05,115200*58 (sent once)"
    );
    assert_eq!(
        bench.failure(second).to_string(),
        "the link disconnected before the reply to $VNRRG,07*74 (not yet sent)"
    );
    assert_eq!((bench.sent(), bench.due()), (vec![], None));
    let third = bench.submit(READ_MODEL);
    assert_eq!(bench.sent(), ["$VNRRG,01*72"]);
    bench.hear("VNRRG,01,VN-100S-CR");
    bench.value(third);
}

#[test]
fn a_new_link_does_not_wait_for_answers_of_the_old_one() {
    let mut bench = Bench::new();
    bench.submit(SensorCommand::Reset);
    bench.sent();
    bench.hear("VNRST");
    bench.session.handle_link_down();
    bench.submit(READ_RATE);
    assert_eq!(bench.sent(), ["$VNRRG,07*74"]);
    bench.wait(500);
    bench.sent();
    bench.hear("VNRRG,07,40");
    bench.session.handle_link_down();
    bench.submit(READ_MODEL);
    assert_eq!(bench.sent(), ["$VNRRG,01*72"]);
}

#[test]
fn a_full_session_refuses_requests_until_answers_are_collected() {
    let mut bench = Bench::new();
    for _ in 0..RequestQueue::CAPACITY {
        bench.submit(READ_RATE);
    }
    bench.sent();
    assert_eq!(bench.session.submit(READ_RATE), Err(QueueFull));
    bench.hear("VNRRG,07,40");
    assert_eq!(bench.session.submit(READ_RATE), Err(QueueFull));
    assert!(bench.session.poll_completion().is_some());
    bench.submit(READ_RATE);
}

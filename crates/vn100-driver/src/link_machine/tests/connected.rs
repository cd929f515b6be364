//! A connected sensor: its silence, its restarts, commands to it.

use super::*;

#[test]
fn bursts_of_a_server_that_collects_lines_are_reported_as_a_silence_once_at_most() {
    // at 40 Hz
    for lines in [16, 40] {
        let mut bench = Bench::connected(LinkOptions::default());
        let half = FRAME.repeat(lines / 2);
        for _ in 0..100 {
            bench.stream(&half, ms(25 * lines as u64 - 2), 1);
            bench.stream(&half, ms(2), 1);
        }
        let silences = bench.states.iter().filter(|state| matches!(state, LinkState::Silent(_))).count();
        assert!(silences <= 1, "{silences}");
        assert!(bench.sent.iter().filter(|line| *line == ASK_MODEL).count() <= 1, "{:?}", bench.sent);
        bench.assert_ledger();
    }
}

#[test]
fn packets_alone_are_an_output_with_and_without_answers() {
    // time since startup, angular rate and acceleration at 40 Hz
    let packet = |index: u64| {
        let numbers = [0.001_f32, -0.002, 0.0, 0.01, 0.02, -9.8];
        let head = [&[1][..], &0x0121_u16.to_le_bytes(), &(index * 25_000_000).to_le_bytes()].concat();
        let body: Vec<_> = head.into_iter().chain(numbers.into_iter().flat_map(f32::to_le_bytes)).collect();
        [&[0xFA][..], &body, &vn100_protocol::crc16(&body).to_be_bytes()].concat()
    };
    for answers in [true, false] {
        let mut bench = Bench::new(LinkOptions::default());
        for index in 0..400 {
            bench.wait(ms(25));
            let chunk = bench.chunk(&packet(index));
            bench.input(Input::Received(chunk));
            for line in bench.take_sent().into_iter().filter(|_| answers) {
                bench.receive(&sentence(&format!("{},1", &line[1..9])));
            }
        }
        assert_eq!((bench.phase(), bench.ups(), bench.rows, bench.link.len()), ("connected", 1, 400, 1));
        assert!(!bench.states.iter().any(|state| matches!(state, LinkState::Silent(_))));
        bench.assert_ledger();
    }
}

#[test]
fn a_sensor_that_sends_after_a_silence_is_verified() {
    let silent = |options: LinkOptions| {
        let mut bench = Bench::new(LinkOptions { known_serial: Some("7".into()), ..options });
        bench.receive(FRAME);
        bench.receive(&serial("7"));
        bench.receive(&sentence("VNRRG,07,40"));
        bench.wait(ms(3000));
        assert!(matches!(bench.states.last(), Some(LinkState::Silent(_))));
        bench.receive(&sentence("VNRRG,01,VN-100"));
        bench.receive("junk");
        assert_eq!((bench.phase(), bench.rows), ("connected", 1), "neither ends a silence");
        bench.take_sent();
        bench.receive(FRAME);
        assert_eq!((bench.phase(), bench.rows, bench.take_sent()), ("verifying", 1, vec![ASK_SERIAL.to_owned()]));
        bench
    };
    let mut bench = silent(LinkOptions::default());
    bench.receive(FRAME);
    bench.receive(&(serial("7") + &sentence("VNERR,04")));
    assert_eq!((bench.phase(), bench.rows, bench.ups()), ("connected", 3, 1));
    assert!(matches!(bench.states.last(), Some(LinkState::Up(_))));
    assert_eq!(bench.link.last(), Some(&LinkEventKind::UnsolicitedError { error: DeviceError::InvalidCommand }));
    bench.receive(FRAME);
    assert_eq!((bench.phase(), bench.rows), ("connected", 4));
    bench.assert_ledger();

    let mut bench = silent(slowed());
    bench.receive(&serial("7"));
    assert_eq!(bench.take_sent(), ["$VNRRG,07*74"]);
    bench.receive(&sentence("VNRRG,07,20"));
    assert_eq!((bench.phase(), bench.rows), ("connected", 2));
    bench.assert_ledger();

    let mut bench = silent(slowed());
    bench.receive(&serial("7"));
    bench.receive(&sentence("VNRRG,07,40"));
    assert_eq!((bench.phase(), bench.down_cause()), ("backing off", "the sensor was silent, and may have restarted"));
    assert_eq!(bench.rows, 1);
    bench.assert_ledger();

    let mut bench = silent(LinkOptions::default());
    bench.receive(&serial("8"));
    bench.receive(&serial("8"));
    assert_eq!((bench.phase(), bench.rows), ("closed", 1));
    bench.assert_ledger();
}

#[test]
fn a_verification_does_not_wait_for_answers_of_a_silent_sensor() {
    let mut bench = Bench::new(known_serial());
    bench.receive(FRAME);
    bench.receive(&serial("7"));
    // the read of a register and the question whether the sensor is connected
    bench.wait(ms(3010));
    bench.take_sent();
    bench.receive(FRAME);
    assert_eq!(bench.take_sent(), [ASK_SERIAL]);
    bench.receive(&serial("7"));
    assert_eq!((bench.phase(), bench.take_sent()), ("connected", vec!["$VNRRG,07*74".to_owned()]));
    bench.assert_ledger();
}

#[test]
fn a_restart_of_the_sensor_begins_a_new_segment() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.wait(ms(10));
    bench.receive(&sentence("VNERR,0A"));
    assert_eq!((bench.phase(), bench.ups()), ("connected", 1));
    assert_eq!(bench.down_cause(), DeviceError::WatchdogReset.to_string());
    let restarted = |state: Option<&LinkState>| matches!(state, Some(LinkState::Up(up)) if up.restarted == Some(DeviceError::WatchdogReset) && up.since_ns == 10_000_000);
    assert!(restarted(bench.states.last()));
    bench.receive(FRAME);
    assert_eq!((bench.ups(), bench.counts.connects), (2, 2));
    bench.receive(FRAME);
    assert_eq!((bench.ups(), bench.rows), (2, 3));
    bench.assert_ledger();
    // if settings are lost with it, they are written again
    let mut bench = Bench::connected(slowed());
    bench.receive(&sentence("VNERR,01"));
    assert_eq!(bench.phase(), "backing off");
    bench.assert_ledger();
}

#[test]
fn a_garbled_stream_is_opened_again() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.stream(&"x".repeat(122), ms(25), 13);
    assert_eq!(bench.down_cause(), "1586 bytes received in 300 ms contain no valid sentence");
    bench.assert_ledger();
}

#[test]
fn a_paused_output_is_resumed_and_paused_again_at_the_end() {
    for (reply, paused_again) in [("VNASY,0", true), ("VNERR,04", false), ("", false)] {
        let mut bench = Bench::new(LinkOptions::default());
        bench.wait(ms(150));
        bench.receive(&sentence("VNRRG,01,VN-100"));
        // it answers each question, but sends nothing
        while bench.sent.last().unwrap() != RESUME {
            assert!(bench.now < ms(10_000));
            let body = match bench.sent.last().unwrap().as_str() {
                ASK_MODEL => "VNRRG,01,VN-100".to_owned(),
                line => format!("{},1", &line[1..9]),
            };
            bench.receive(&sentence(&body));
            bench.wait(ms(200));
        }
        bench.receive(&sentence("VNASY,1"));
        bench.receive(FRAME);
        assert_eq!((bench.phase(), bench.sent.last().unwrap().as_str()), ("verifying", ASK_SERIAL));
        bench.receive(&serial("1"));
        assert_eq!(bench.link.last(), Some(&LinkEventKind::OutputResumed));
        assert!(matches!(bench.states.last(), Some(LinkState::Up(up)) if up.output_resumed));
        bench.stop();
        assert_eq!((bench.phase(), bench.sent.last().unwrap().as_str()), ("restoring", PAUSE));
        bench.receive(FRAME);
        if reply.is_empty() {
            bench.input(Input::Lost(LinkError::Disconnected));
        } else {
            bench.receive(&sentence(reply));
        }
        assert_eq!(bench.states.last(), Some(&LinkState::Closed { paused_again: Some(paused_again) }));
        assert_eq!(bench.count(|kind| *kind == LinkEventKind::OutputPaused), usize::from(paused_again));
        assert_eq!(bench.error, None);
        bench.assert_ledger();
    }
}

#[test]
fn commands_of_the_user_are_sent_while_connected_and_end_with_the_link() {
    let mut bench = Bench::connected(LinkOptions::default());
    assert!(bench.machine.accepts_commands());
    bench.receive(&sentence("VNRRG,07,40"));
    bench.take_sent();
    bench.input(Input::Command { id: 5, command: SensorCommand::ReadRegister(Register::MODEL) });
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    bench.receive(&sentence("VNRRG,01,VN-100"));
    assert!(matches!(&bench.answers[..], [(5, Ok(Response::Register(_)))]));
    bench.input(Input::Command { id: 6, command: SensorCommand::ReadRegister(Register::MODEL) });
    bench.input(Input::Lost(LinkError::Disconnected));
    assert!(matches!(&bench.answers[1..], [(6, Err(CommandError::Failed(_)))]));
    assert!(bench.machine.accepts_commands(), "while it waits, too");
    bench.input(Input::Command { id: 7, command: SensorCommand::Tare });
    assert!(matches!(&bench.answers[2..], [(7, Err(CommandError::Failed(_)))]));
    bench.wait(ms(100));
    assert!(!bench.machine.accepts_commands(), "they wait while the sensor is searched");
    bench.assert_ledger();
}

#[test]
fn the_port_follows_the_sensor_to_another_baud_rate() {
    let mut bench = Bench::connected(LinkOptions { baud: Some(9600), ..LinkOptions::default() });
    bench.receive(&sentence("VNRRG,07,40"));
    let write = || SensorCommand::WriteRegister {
        register: Register::BAUD_RATE,
        fields: RegisterFields::new("19200").unwrap(),
    };
    bench.input(Input::Command { id: 1, command: write() });
    bench.receive(&sentence("VNWRG,05,19200"));
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(19_200)));
    assert!(matches!(bench.states.last(), Some(LinkState::Up(up)) if up.baud == Some(19_200)));
    bench.input(Input::Lost(LinkError::Disconnected));
    bench.wait(ms(100));
    assert_eq!(bench.port.last(), Some(&PortAction::Open { baud: 19_200 }), "also at the next opening");
    // a server has a baud rate of its own
    let mut bench = Bench::of(false, LinkOptions::default());
    bench.receive(FRAME);
    bench.receive(&sentence("VNRRG,07,40"));
    bench.input(Input::Command { id: 1, command: write() });
    bench.receive(&sentence("VNWRG,05,19200"));
    assert_eq!((bench.answers.len(), bench.port.len()), (1, 1));
}

//! Opening the port, and the baud scan.

use super::*;

#[test]
fn a_port_that_cannot_be_opened_ends_a_first_attempt_and_is_tried_again_after_a_connection() {
    let refusal = || open_failed(PortProblem::NotFound(vec![]));
    let mut first = Bench::new(LinkOptions::default());
    first.machine.phase = Phase::Opening;
    first.input(refusal());
    assert_eq!(first.phase(), "closed");
    assert!(first.error.as_ref().unwrap().starts_with("cannot open imu at 9600 baud"));

    let mut bench = Bench::connected(LinkOptions::default());
    bench.is_port_good = false;
    bench.input(Input::Lost(io::Error::from(io::ErrorKind::BrokenPipe).into()));
    assert_eq!(bench.phase(), "closing");
    bench.input(Input::PortClosed { unread: Vec::new() });
    for (failed, delay) in (0..).zip([100, 200, 400, 800, 1600, 3200, 5000, 5000]) {
        assert_eq!(bench.phase(), "backing off");
        let Some(LinkState::Down { was_up: true, needs_help: false, retry_in, attempts, .. }) = bench.states.last()
        else {
            panic!("{:?}", bench.states)
        };
        assert_eq!((*retry_in, *attempts), (ms(delay), failed));
        bench.wait(ms(delay) - ms(1));
        assert_eq!(bench.phase(), "backing off");
        bench.wait(ms(1));
        assert_eq!(bench.phase(), "opening");
        bench.input(refusal());
    }
    // the delay is reset after a good frame
    bench.wait(ms(5000));
    bench.is_port_good = true;
    bench.input(Input::Opened(OpenPort::default()));
    bench.receive(FRAME);
    bench.input(Input::Lost(LinkError::Disconnected));
    assert!(matches!(bench.states.last(), Some(LinkState::Down { retry_in, attempts: 0, .. }) if *retry_in == ms(100)));
    bench.assert_ledger();
}

#[test]
fn a_file_that_is_no_port_is_not_tried_again() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.is_port_good = false;
    bench.input(Input::Lost(LinkError::Disconnected));
    bench.input(Input::PortClosed { unread: Vec::new() });
    bench.wait(ms(100));
    bench.input(open_failed(PortProblem::NotASerialPort(vec![])));
    assert_eq!(bench.phase(), "closed");
    assert!(bench.error.is_some());
}

#[test]
fn a_scan_begins_at_the_baud_rate_that_was_set() {
    let fields = |text| RegisterFields::new(text).unwrap();
    let set = Change { register: Register::BAUD_RATE, before: fields("115200"), after: fields("460800") };
    let mut bench = Bench::new(LinkOptions { desired_settings: vec![set], ..LinkOptions::default() });
    assert_eq!(bench.port, [PortAction::Open { baud: 460_800 }]);
    bench.receive(FRAME);
    assert_eq!(bench.phase(), "connected");
    bench.assert_ledger();
}

#[test]
fn a_scan_listens_and_asks_at_each_baud_rate() {
    let mut bench = Bench::new(LinkOptions::default());
    assert_eq!(bench.port, [PortAction::Open { baud: 115_200 }]);
    assert_eq!(bench.states.last(), Some(&LinkState::Probing { port: "tty".into(), baud: Some(115_200) }));
    bench.wait(ms(149));
    assert_eq!(bench.sent, [""; 0]);
    bench.wait(ms(1));
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    // garbage: no sensor boots here
    bench.receive(&"x".repeat(101));
    bench.wait(ms(122));
    assert_eq!(bench.port.len(), 1);
    bench.wait(ms(1));
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
    // bytes arrive without a question, perhaps not from a sensor: no further question is sent
    for (tried, baud) in BAUD_RATES.into_iter().enumerate().skip(1) {
        assert_eq!(bench.port.len(), 1 + tried);
        bench.wait(ms(1201 + u64::from(2_560_000 / baud)));
    }
    assert_eq!(bench.sent, [""; 0]);
    let set = bench.port[1..9].iter().map(|action| match action {
        PortAction::SetBaud(baud) => *baud,
        other => panic!("{other:?}"),
    });
    assert_eq!(set.collect::<Vec<_>>(), BAUD_RATES[1..]);
    bench.wait(ms(100));
    assert_eq!(bench.phase(), "scanning", "a second time");
    bench.assert_ledger();
}

#[test]
fn a_silent_sensor_is_waited_for_at_the_first_baud_rate_as_long_as_it_boots() {
    for baud in [None, Some(9600)] {
        let mut bench = Bench::new(LinkOptions { baud, ..LinkOptions::default() });
        bench.wait(ms(1990));
        assert_eq!(bench.port.len(), 1);
        assert!(bench.sent.len() >= 2 && bench.sent.iter().all(|line| line == ASK_MODEL));
        // the rest of a frame is no sign of a sensor that sends
        bench.receive("-00.9");
        bench.wait(ms(500));
        let next = if baud.is_none() { PortAction::SetBaud(921_600) } else { PortAction::Close };
        assert_eq!(bench.port[1], next);
        bench.receive(&sentence("VNRRG,01,VN-100"));
        assert_eq!(bench.phase(), "connected");
        bench.assert_ledger();
    }
}

#[test]
fn a_first_scan_without_a_sensor_is_repeated_once_and_reports_the_received_bytes() {
    let cases = [
        (
            true,
            false,
            "",
            2,
            "no sensor found on imu at 9 baud rates: no data received; check the cable, the power of the sensor and the baud rate",
        ),
        (true, true, "", 2, "show: allow sending, or check the cable and the power of the sensor"),
        (
            true,
            false,
            "junk",
            5,
            "bytes received without a valid sentence; check the cable, the power of the sensor and the baud rate",
        ),
        (
            true,
            false,
            "$VNRRG,01*72\r\n",
            2,
            "the line echoes, and only the sent bytes were received; take a loopback plug off; on RS-485 check",
        ),
        (
            false,
            false,
            "",
            2,
            "no sensor found on imu: no data received; check the cable and the power of the sensor, and the baud rate set on the server",
        ),
    ];
    for (has_baud, listen_only, text, openings, expected) in cases {
        let mut bench = Bench::of(has_baud, LinkOptions { listen_only, ..LinkOptions::default() });
        for _ in 0..1000 {
            bench.wait(ms(130));
            if !text.is_empty() && bench.phase() == "scanning" {
                bench.receive(text);
            }
        }
        assert_eq!(bench.phase(), "closed");
        let error = bench.error.clone().unwrap();
        assert!(error.contains(expected), "{error}");
        let opened = bench.port.iter().filter(|action| matches!(action, PortAction::Open { .. })).count();
        assert_eq!(opened, openings, "{expected}");
        assert_eq!(bench.sent.is_empty(), listen_only);
        bench.assert_ledger();
    }
}

#[test]
fn the_owner_has_its_own_words_for_a_hint() {
    let mut bench = Bench::of(false, LinkOptions { hint_text: Some(|_| "own words"), ..LinkOptions::default() });
    bench.wait(ms(10_000));
    assert_eq!(bench.error.as_deref(), Some("no sensor found on imu: no data received; own words"));
}

#[test]
fn a_baud_rate_that_the_port_does_not_support_is_passed_over() {
    let mut bench = Bench::new(LinkOptions::default());
    bench.receive(&"x".repeat(200));
    bench.is_port_good = false;
    bench.wait(ms(400));
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
    // a frame at the former rate
    bench.receive(FRAME);
    assert_eq!((bench.phase(), bench.machine.poll_timeout()), ("scanning", None));
    bench.input(Input::BaudSet { baud: 921_600, result: Err(io::ErrorKind::InvalidInput.into()) });
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(460_800)));
    bench.receive(FRAME);
    bench.is_port_good = true;
    bench.input(Input::BaudSet { baud: 460_800, result: Ok(()) });
    assert_eq!(bench.states.last(), Some(&LinkState::Probing { port: "tty".into(), baud: Some(460_800) }));
    bench.receive(FRAME);
    assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud: Some(460_800) }));
    bench.assert_ledger();
    assert_eq!(bench.rows, 1, "what was received at the rates before is discarded");
}

#[test]
fn bytes_before_a_refused_baud_rate_are_received_nevertheless() {
    let mut bench = Bench::new(LinkOptions::default());
    for _ in 0..2 {
        bench.wait(ms(1000));
        bench.is_port_good = false;
        bench.wait(ms(1500));
        for baud in &BAUD_RATES[1..] {
            assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(*baud)));
            bench.receive("12345");
            bench.is_port_good = *baud == BAUD_RATES[8];
            bench.input(Input::BaudSet { baud: *baud, result: Err(io::ErrorKind::InvalidInput.into()) });
        }
    }
    let error = bench.error.clone().unwrap();
    assert!(error.contains("40 bytes received without a valid sentence"), "{error}");
    bench.assert_ledger();
}

#[test]
fn a_stray_byte_does_not_hasten_the_next_question() {
    let mut bench = Bench::new(LinkOptions::default());
    bench.wait(ms(300));
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    // from now on a frame per second would come before the next question
    bench.receive("-");
    bench.wait(ms(1100));
    assert_eq!(bench.sent, [""; 0]);
    bench.wait(ms(200));
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    bench.assert_ledger();
}

#[test]
fn a_burst_after_a_stall_does_not_show_the_baud_rate() {
    for again in [false, true] {
        let mut bench = Bench::connected(LinkOptions { baud: None, ..LinkOptions::default() });
        bench.input(Input::Lost(LinkError::Disconnected));
        bench.wait(ms(100));
        // delayed bytes from the former rate, while the next is tried
        bench.wait(ms(2300));
        assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
        bench.receive(FRAME);
        assert_eq!((bench.ups(), bench.port.last()), (1, Some(&PortAction::SetBaud(115_200))));
        bench.wait(ms(99));
        bench.receive(FRAME);
        bench.wait(ms(1));
        assert_eq!(bench.ups(), 1, "still of the burst");
        if again {
            bench.wait(ms(280));
            assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)), "then the rate of the burst");
        }
        bench.receive(FRAME);
        let baud = Some(if again { 921_600 } else { 115_200 });
        assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud }));
        bench.assert_ledger();
        assert_eq!(bench.rows, 2);
    }
}

#[test]
fn another_device_is_named_and_asked_no_more_than_once() {
    let burst = [sentence("GPGGA,123519,4807.038,N"), sentence("GPRMC,123519,A,4807.038,N")].concat();
    for (has_baud, expected) in [
        (
            true,
            "no sensor found on imu at 9600 baud, but a device that sends NMEA sentences, such as a GPS: $GPGGA, $GPRMC; choose the port of the sensor",
        ),
        (
            false,
            "no sensor found on imu, but a device that sends NMEA sentences, such as a GPS: $GPGGA, $GPRMC; choose the port of the server behind which the sensor is",
        ),
    ] {
        let mut bench = Bench::of(has_baud, LinkOptions::default());
        // once a second
        for _ in 0..30 {
            bench.wait(ms(1000));
            let is_at_its_rate = !has_baud || bench.port.last() == Some(&PortAction::SetBaud(9600));
            if bench.phase() == "scanning" {
                bench.receive(&if is_at_its_rate { burst.clone() } else { "x".repeat(120) });
            }
        }
        assert_eq!((bench.phase(), bench.error.as_deref()), ("closed", Some(expected)));
        assert_eq!(bench.sent, [ASK_MODEL]);
        bench.assert_ledger();
    }
}

#[test]
fn a_banner_of_a_server_replaces_neither_the_question_nor_the_sensor() {
    let banner = "Welcome to the port server\r\nConnected to port 3\r\nReady to send\r\n";
    // a sensor that sends nothing by itself
    let mut bench = Bench::of(false, LinkOptions::default());
    bench.receive(banner);
    bench.wait(ms(200));
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    bench.receive(&sentence("VNRRG,01,VN-100"));
    assert_eq!(bench.phase(), "connected");
    bench.assert_ledger();
    // the link waits for a sensor that was measured, for any output of its server
    let mut bench = Bench::connected(LinkOptions::default());
    bench.input(Input::Lost(LinkError::Disconnected));
    for _ in 0..20 {
        bench.wait(ms(1000));
        if bench.phase() == "scanning" {
            bench.receive(banner);
        }
    }
    assert_ne!(bench.phase(), "closed");
    bench.assert_ledger();
}

#[test]
fn an_error_names_another_program_on_the_port() {
    let mut bench = Bench::new(LinkOptions::default());
    bench.machine.report_shared_port(bench.now, "cat (process 7)".into());
    bench.wait(ms(60_000));
    let error = bench.error.clone().unwrap();
    assert!(error.ends_with("no data received; cat (process 7) has the port open too: end that program"), "{error}");
    bench.assert_ledger();
}

#[test]
fn a_sensor_that_shares_its_line_with_another_device_is_connected() {
    let mut bench = Bench::new(LinkOptions::default());
    bench.receive(&sentence("GPGGA,123519,4807.038,N"));
    bench.wait(ms(1000));
    assert_eq!((bench.phase(), bench.sent.len()), ("scanning", 0));
    bench.receive(FRAME);
    assert_eq!(bench.phase(), "connected");
    bench.assert_ledger();
}

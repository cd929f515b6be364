//! The checks and writes before a sensor is measured.

use super::*;

#[test]
fn a_known_sensor_is_verified_before_it_is_measured() {
    for (first, second, phase) in [("7", None, "connected"), ("8", Some("7"), "connected"), ("8", Some("8"), "closed")]
    {
        let mut bench = Bench::new(known_serial());
        bench.receive(FRAME);
        assert_eq!((bench.phase(), bench.take_sent()), ("identifying", vec![ASK_SERIAL.to_owned()]));
        bench.receive(FRAME);
        assert_eq!(bench.rows, 0);
        bench.receive(&serial(first));
        if let Some(second) = second {
            assert_eq!(bench.take_sent(), [ASK_SERIAL], "one reply may be damaged");
            bench.receive(&serial(second));
        }
        assert_eq!(bench.phase(), phase);
        bench.assert_ledger();
        let rows = if phase == "connected" { 2 } else { 0 };
        assert_eq!((bench.rows, bench.ups()), (rows, rows / 2));
        let other = "another sensor is on the port: serial number 8, expected 7";
        assert_eq!(bench.error.as_deref(), (rows == 0).then_some(other));
    }
    // a sensor without a serial number is taken for the known one
    let mut bench = Bench::new(known_serial());
    bench.receive(FRAME);
    bench.wait(ms(1499));
    assert_eq!((bench.phase(), bench.sent.len()), ("identifying", 3));
    bench.wait(ms(1));
    assert_eq!(bench.phase(), "connected");
    bench.assert_ledger();
    // a link that only listens does not ask
    let mut bench = Bench::connected(LinkOptions { listen_only: true, ..known_serial() });
    bench.receive(&serial("8"));
    bench.wait(ms(1000));
    assert_eq!((bench.phase(), &bench.sent[..]), ("connected", &[][..]));
}

#[test]
fn a_serial_number_is_learned_and_one_that_changes_is_read_again() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.receive(&serial("7"));
    bench.receive(&serial("8"));
    assert_eq!(bench.phase(), "connected");
    let reads = |bench: &Bench| bench.sent.iter().filter(|line| *line == ASK_SERIAL).count();
    bench.receive(&sentence("VNRRG,07,40"));
    bench.stream(FRAME, ms(100), 3);
    assert_eq!(reads(&bench), 1);
    bench.receive(&serial("7"));
    bench.receive(&serial("8"));
    assert_eq!(bench.phase(), "connected", "not twice in a row");
    bench.receive(&serial("8"));
    assert_eq!(bench.phase(), "closed");
    bench.assert_ledger();
}

#[test]
fn settings_are_written_again_after_a_reconnect() {
    for refused in [false, true] {
        let mut bench = reconnected();
        let mut answer = |command: &str, reply: &str| {
            assert_eq!(bench.take_sent(), [command]);
            bench.receive(&(sentence(reply) + FRAME));
        };
        answer(ASK_MODEL, "VNRRG,01,VN-100");
        answer(PAUSE, "VNASY,0");
        answer(sentence("VNWRG,07,20").trim_end(), if refused { "VNERR,09" } else { "VNWRG,07,20" });
        answer(RESUME, "VNASY,1");
        assert_eq!(bench.phase(), if refused { "backing off" } else { "connected" });
        assert_eq!(bench.rows, 2, "what was sent before is no part of the measurement");
        if refused {
            let Some(LinkState::Down { cause, needs_help: true, .. }) = bench.states.last() else { panic!() };
            assert!(cause.starts_with(
                "the sensor reconnected, but its settings cannot be reapplied: the sensor refused $VNWRG,07,20"
            ));
        }
        bench.assert_ledger();
    }
}

#[test]
fn the_baud_rate_is_raised_again_if_the_settings_need_it() {
    for is_supported in [true, false] {
        let mut bench = Bench::new(slowed());
        bench.wait(ms(150));
        bench.receive(&"x".repeat(200));
        bench.wait(ms(123));
        bench.receive(FRAME);
        assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud: Some(921_600) }));
        bench.input(Input::Lost(LinkError::Disconnected));
        bench.wait(ms(100 + 150));
        bench.receive(&"x".repeat(200));
        bench.wait(ms(103));
        assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(115_200)));
        bench.take_sent();
        bench.receive(FRAME);
        for reply in ["VNRRG,01,VN-100", "VNASY,0", "VNERR,0C", "VNASY,1"] {
            bench.receive(&sentence(reply));
        }
        assert_eq!(bench.take_sent().last().unwrap(), sentence("VNWRG,05,921600").trim_end());
        bench.is_port_good = false;
        bench.receive(&sentence("VNWRG,05,921600"));
        assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
        let result = if is_supported { Ok(()) } else { Err(io::Error::other("no such rate")) };
        bench.is_port_good = true;
        bench.input(Input::BaudSet { baud: 921_600, result });
        if is_supported {
            for reply in ["VNRRG,01,VN-100", "VNASY,0", "VNWRG,07,20", "VNASY,1"] {
                while bench.take_sent().is_empty() {
                    assert_eq!(bench.phase(), "identifying");
                    bench.wait(ms(10));
                }
                bench.receive(&sentence(reply));
            }
            assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud: Some(921_600) }));
        } else {
            assert_eq!(bench.phase(), "backing off");
        }
        bench.assert_ledger();
    }
}

#[test]
fn a_stop_while_settings_are_written_leaves_the_output_on() {
    let mut bench = reconnected();
    bench.receive(&sentence("VNRRG,01,VN-100"));
    assert_eq!(bench.sent.last().unwrap(), PAUSE);
    bench.stop();
    assert_eq!((bench.phase(), bench.sent.last().unwrap().as_str()), ("restoring", RESUME));
    bench.receive(FRAME);
    bench.stop();
    assert_eq!(bench.phase(), "restoring");
    bench.receive(&sentence("VNASY,1"));
    assert_eq!((bench.phase(), bench.port.last()), ("closed", Some(&PortAction::Close)));
    assert_eq!(bench.error, None);
    bench.assert_ledger();
}

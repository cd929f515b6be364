//! The checks and writes before a sensor is measured.

use super::*;

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

//! The end of a link in each phase.

use super::*;

/// A link in each phase, with bytes pending if the phase has them.
fn phases() -> Vec<Bench> {
    let mut opening = Bench::new(known_serial());
    opening.machine.phase = Phase::Opening;
    let mut scanning = Bench::new(LinkOptions::default());
    scanning.receive("junk");
    let mut identifying = Bench::new(known_serial());
    identifying.receive(FRAME);
    let connected = Bench::connected(LinkOptions::default());
    let mut verifying = Bench::new(known_serial());
    verifying.receive(FRAME);
    verifying.receive(&serial("7"));
    verifying.wait(ms(3000));
    verifying.receive(FRAME);
    let mut restoring = reconnected();
    restoring.receive(&sentence("VNRRG,01,VN-100"));
    restoring.stop();
    restoring.receive(FRAME);
    let mut backing_off = Bench::connected(LinkOptions::default());
    backing_off.input(Input::Lost(LinkError::Disconnected));
    vec![opening, scanning, identifying, connected, verifying, restoring, backing_off]
}

#[test]
fn a_stop_ends_every_phase_and_a_lost_link_every_open_one() {
    let names = ["opening", "scanning", "identifying", "connected", "verifying", "restoring", "backing off"];
    let after_loss = ["opening", "closed", "closed", "backing off", "backing off", "closed", "backing off"];
    for (index, name) in names.into_iter().enumerate() {
        let mut stopped = phases().remove(index);
        assert_eq!(stopped.phase(), name);
        stopped.stop();
        let expected = if name == "restoring" { name } else { "closed" };
        assert_eq!((stopped.phase(), stopped.error.as_deref()), (expected, None));
        stopped.assert_ledger();

        let mut lost = phases().remove(index);
        lost.input(Input::Lost(io::Error::from(io::ErrorKind::BrokenPipe).into()));
        assert_eq!(lost.phase(), after_loss[index], "{name}");
        assert_eq!(lost.error.is_some(), matches!(name, "scanning" | "identifying"), "{name}");
        lost.assert_ledger();
    }
}

#[test]
fn unreported_inputs_of_a_closed_port_are_counted() {
    for mut bench in phases() {
        bench.is_port_good = false;
        let before = bench.port.len();
        bench.stop();
        bench.wait(ms(5000));
        if bench.port.len() > before {
            assert_eq!((bench.phase(), bench.port.last()), ("closing", Some(&PortAction::Close)));
            let unread = vec![bench.chunk(b"not taken"), bench.chunk(FRAME.as_bytes())];
            bench.input(Input::PortClosed { unread });
        }
        bench.assert_ledger();
    }
}

#[test]
fn a_stop_of_a_lost_link_ends_its_down_time() {
    for (index, is_lost) in [(0, false), (1, false), (3, false), (6, true)] {
        let mut bench = phases().remove(index);
        let name = bench.phase();
        bench.stop();
        assert_eq!(bench.count(|kind| *kind == LinkEventKind::Closed), usize::from(is_lost), "{name}");
    }
}

#[test]
fn an_overrun_in_pending_inputs_is_kept() {
    let mut bench = Bench::new(LinkOptions::default());
    let overrun = LinkEvent { at_ns: 0, kind: LinkEventKind::Overrun { bytes: 9 } };
    bench.input(Input::Received(StreamInput::Link(overrun.clone())));
    bench.receive(&("junk".to_owned() + FRAME));
    bench.input(Input::Received(StreamInput::Link(overrun)));
    bench.assert_ledger();
    assert_eq!((bench.counts.overrun_bytes, bench.counts.baud_scan_bytes, bench.rows), (18, 4, 1));
}

#[test]
fn a_stop_while_the_port_is_being_closed_needs_no_further_action() {
    for (index, name) in ["scanning", "identifying", "connected", "verifying", "restoring"].into_iter().enumerate() {
        let mut bench = phases().remove(index + 1);
        assert_eq!(bench.phase(), name);
        bench.is_port_good = false;
        bench.input(Input::Lost(LinkError::Disconnected));
        assert_eq!((bench.phase(), bench.port.last()), ("closing", Some(&PortAction::Close)), "{name}");
        let (asked, sent) = (bench.port.len(), bench.sent.len());
        bench.stop();
        assert_eq!((bench.phase(), bench.port.len(), bench.sent.len()), ("closing", asked, sent), "{name}");
        bench.input(Input::PortClosed { unread: Vec::new() });
        assert_eq!(bench.phase(), "closed", "{name}");
        bench.assert_ledger();
    }
}

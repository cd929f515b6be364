//! Properties of a link under any events.

use proptest::prelude::*;

use super::*;

/// An event that may happen.
#[derive(Debug, Clone)]
enum Happening {
    Receive(String),
    Wait(u64),
    Request,
    Lose,
}

fn happening() -> impl Strategy<Value = Happening> {
    const REPLIES: [&str; 11] = [
        "VNRRG,01,VN-100",
        "VNRRG,03,7",
        "VNRRG,03,8",
        "VNRRG,07,20",
        "VNRRG,07,40",
        "VNWRG,07,20",
        "VNASY,0",
        "VNASY,1",
        "VNERR,04",
        "VNERR,0A",
        "VNRRG,01",
    ];
    prop_oneof![
        6 => Just(Happening::Receive(FRAME.into())),
        4 => prop::sample::select(&REPLIES[..]).prop_map(|body| Happening::Receive(sentence(body))),
        3 => prop::sample::select(&["junk", "$VNYMR,-0", "$VNRRG,03,7*", "\u{7f}\u{7f}", "\r\n"][..]).prop_map(|text| Happening::Receive(text.into())),
        4 => prop::sample::select(&[1, 40, 300, 700, 3500][..]).prop_map(Happening::Wait),
        1 => Just(Happening::Request),
        1 => Just(Happening::Lose),
    ]
}

fn options(case: u8) -> LinkOptions {
    LinkOptions {
        listen_only: case & 1 != 0,
        known_serial: (case & 2 != 0).then(|| "7".into()),
        ..if case & 4 != 0 { slowed() } else { LinkOptions::default() }
    }
}

proptest! {
    #[test]
    fn every_byte_is_counted_and_recorded_and_every_request_answered(case in 0..8_u8, script in prop::collection::vec(happening(), 0..60)) {
        let mut bench = Bench::new(options(case));
        let mut requests = 0;
        for event in script {
            match event {
                Happening::Receive(text) if bench.machine.is_open() => bench.receive(&text),
                Happening::Receive(_) => {}
                Happening::Wait(time) => bench.wait(ms(time)),
                Happening::Request => {
                    requests += 1;
                    bench.input(Input::Command { id: requests, command: SensorCommand::ReadRegister(Register::MODEL) });
                }
                Happening::Lose => bench.input(Input::Lost(LinkError::Disconnected)),
            }
        }
        bench.assert_ledger();
        prop_assert_eq!(bench.answers.len() as u64, requests);
        prop_assert!(bench.sent.is_empty() || case & 1 == 0, "a link that only listens sends nothing");
    }

    #[test]
    fn the_division_of_bytes_into_reads_has_no_effect(texts in prop::collection::vec(happening(), 1..20), cuts in prop::collection::vec(1..200_usize, 1..40)) {
        // a restart and another sensor are handled when the read that reports them is forwarded
        let is_of_read = |text: &str| text.starts_with("$VNERR,0A") || text.starts_with("$VNRRG,03,8");
        let texts: String = texts.into_iter().filter_map(|event| match event {
            Happening::Receive(text) if !is_of_read(&text) => Some(text),
            _ => None,
        }).collect();
        let run = |pieces: &mut dyn Iterator<Item = usize>| {
            let mut bench = Bench::new(LinkOptions::default());
            let mut rest = texts.as_bytes();
            while !rest.is_empty() && bench.machine.is_open() {
                let (piece, behind) = rest.split_at(pieces.next().unwrap_or(rest.len()).min(rest.len()));
                let chunk = bench.chunk(piece);
                bench.input(Input::Received(chunk));
                rest = behind;
            }
            bench.assert_ledger();
            (bench.counts.tally, bench.counts.baud_scan_bytes, bench.counts.connects, bench.rows)
        };
        prop_assert_eq!(run(&mut cuts.iter().copied()), run(&mut std::iter::empty()));
    }
}

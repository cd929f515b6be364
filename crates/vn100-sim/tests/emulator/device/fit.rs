//! The capacity of the line, and settings that are refused.

use super::bench::Bench;

/// Baud, and the highest rate of `$VNYMR` that fits it.
const HIGHEST_RATE_HZ: [(u32, u32); 9] = [
    (9600, 5),
    (19_200, 10),
    (38_400, 25),
    (57_600, 40),
    (115_200, 50),
    (128_000, 100),
    (230_400, 100),
    (460_800, 200),
    (921_600, 200),
];

#[test]
fn the_highest_rate_of_each_baud() {
    for (baud, highest_hz) in HIGHEST_RATE_HZ {
        let mut bench = Bench::quiet();
        bench.set("07,1");
        bench.set(&format!("05,{baud}"));
        for rate_hz in [1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200] {
            if rate_hz <= highest_hz {
                bench.set(&format!("07,{rate_hz}"));
            } else {
                assert_eq!(bench.error(&format!("VNWRG,07,{rate_hz}")), "0C", "{rate_hz} Hz at {baud}");
            }
        }
        assert!(bench.ask("VNRRG,07").starts_with(&format!("$VNRRG,07,{highest_hz}*")));
    }
}

#[test]
fn other_messages_at_the_rate_of_delivery() {
    // number in register 6, and the highest rate at 115200 baud
    for (message, highest_hz) in
        [(1, 200), (2, 200), (8, 50), (10, 200), (11, 200), (12, 200), (13, 100), (19, 100), (30, 100)]
    {
        let mut bench = Bench::quiet();
        bench.set(&format!("06,{message}"));
        bench.set(&format!("07,{highest_hz}"));
        if highest_hz < 200 {
            assert_eq!(bench.error(&format!("VNWRG,07,{}", highest_hz * 2)), "0C", "{message}");
        }
    }
}

#[test]
fn cases_seen_on_real_units() {
    // 4880 + 6000 = 10 880 of 11 520 bytes per second were accepted, 4880 + 7600 = 12 480 refused
    let mut bench = Bench::quiet();
    bench.set("75,1,4,01,0200");
    bench.set("75,0,4,01,0200");
    assert_eq!(bench.error("VNWRG,75,1,4,01,0201"), "0C");
    assert!(bench.ask("VNRRG,75").starts_with("$VNRRG,75,0,4,01,0200*"));
    // 4880 + 1040 at 57600
    let mut bench = Bench::quiet();
    bench.set("05,57600");
    assert_eq!(bench.error("VNWRG,75,1,20,01,0101"), "0C");
    // output of the other port adds no load
    bench.set("75,2,20,01,0101");
    // a baud rate that is too low for the output is refused as well
    assert_eq!(bench.error("VNWRG,05,38400"), "0C");
    assert!(bench.ask("VNRRG,05").starts_with("$VNRRG,05,57600*"));
}

#[test]
fn packets_fit_according_to_their_length() {
    // register 75 after the divisor, and the bytes of a packet
    for (mask, bytes) in [("01,0201", 38), ("06,0001,001C", 44), ("01,0739", 110)] {
        for baud in [57_600, 115_200, 230_400, 460_800, 921_600] {
            let mut bench = Bench::quiet();
            bench.set("06,0");
            bench.set(&format!("05,{baud}"));
            for divisor in [1, 2, 4, 5, 8, 10, 20] {
                let command = format!("75,1,{divisor},{mask}");
                // rates are 800/divisor
                if bytes * 800 <= baud / 10 * divisor {
                    bench.set(&command);
                } else {
                    assert_eq!(bench.error(&format!("VNWRG,{command}")), "0C", "{command} at {baud}");
                }
            }
        }
    }
}

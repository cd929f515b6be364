//! The timing of events: power-up, the rate of the line and its changes, flash and restarts.

use std::time::Duration;

use vn100_sim::{
    Device, DeviceConfig,
    device::{BOOT, SentByte},
};

use super::bench::{BOOT_MS, Bench};

fn sent_until(device: &mut Device, now: Duration) -> Vec<SentByte> {
    let mut sent = Vec::new();
    device.poll_bytes(now, |byte| sent.push(byte));
    sent
}

fn lines(text: &str) -> usize {
    text.matches("$VNYMR").count()
}

#[test]
fn power_up_is_silent_and_then_sends_40_lines_a_second() {
    let mut bench = Bench::switched_on(DeviceConfig::default());
    bench.send("$VNRRG,01*72\r\n");
    assert_eq!(bench.device.next_wakeup(), BOOT);
    assert_eq!(bench.wait_ms(BOOT_MS), "");
    let second = bench.wait_ms(1000);
    assert_eq!(lines(&second), 40);
    assert_eq!(second.len(), 40 * 122);
    assert!(!second.contains("VNRRG"));
    assert_eq!(bench.device.baud(), 115_200);
}

#[test]
fn a_line_takes_its_time_on_the_wire() {
    let mut device = Device::new(DeviceConfig::default());
    let sent = sent_until(&mut device, BOOT + Duration::from_millis(20));
    assert_eq!(sent.len(), 122);
    for (index, byte) in sent.iter().enumerate() {
        let at = BOOT + Duration::from_nanos((index as u64 + 1) * 10_000_000_000 / 115_200);
        assert_eq!((byte.at, byte.baud), (at, 115_200));
    }
    let line = sent[121].at - BOOT;
    assert_eq!(line.as_micros(), 10_590);
}

#[test]
fn polling_often_or_seldom_gives_the_same_bytes_at_the_same_times() {
    let seldom = sent_until(&mut Device::new(DeviceConfig::default()), Duration::from_secs(3));
    let mut device = Device::new(DeviceConfig::default());
    let mut often = Vec::new();
    let mut now = Duration::ZERO;
    let mut pieces = 0;
    while now < Duration::from_secs(3) {
        let piece = sent_until(&mut device, now);
        assert!(piece.len() <= 16);
        often.extend(piece);
        let wakeup = device.next_wakeup();
        assert!(wakeup > now);
        now = wakeup;
        pieces += 1;
    }
    assert!(often.starts_with(&seldom[..seldom.len() - 16]));
    // eight pieces, and the tick of each line
    assert!((70 * 8..71 * 10).contains(&pieces), "{pieces}");
}

#[test]
fn constant_or_decreasing_time_has_no_effect() {
    let mut bench = Bench::quiet();
    bench.send("$VNRRG,06*75\r\n");
    assert_eq!(bench.device.poll_output(Duration::ZERO), b"");
    assert_eq!(bench.wait_ms(0), "");
    assert_eq!(bench.wait_ms(10), "$VNRRG,06,14*5C\r\n");
}

#[test]
fn a_change_of_baud_is_answered_at_the_old_rate() {
    let mut bench = Bench::quiet();
    bench.send("$VNWRG,05,9600*50\r\n$VNASY,1*4E\r\n");
    assert_eq!(bench.device.baud(), 115_200);
    let sent = sent_until(&mut bench.device, bench.now + Duration::from_secs(1));
    assert!(sent.iter().all(|byte| byte.baud == 115_200), "40 lines do not fit 9600 baud");

    let mut bench = Bench::quiet();
    bench.set("07,5");
    bench.send("$VNWRG,05,9600*50\r\n$VNASY,1*4E\r\n");
    assert_eq!(bench.device.baud(), 9600);
    let sent = sent_until(&mut bench.device, bench.now + Duration::from_secs(1));
    let (old, new): (Vec<_>, Vec<_>) = sent.iter().partition(|byte| byte.baud == 115_200);
    let text = |bytes: &[&SentByte]| bytes.iter().map(|sent| char::from(sent.byte)).collect::<String>();
    assert_eq!(text(&old), "$VNWRG,05,9600*50\r\n");
    assert!(text(&new).starts_with("$VNASY,1*4E\r\n$VNYMR"));
    let byte_time = new[1].at - new[0].at;
    assert!((1041..=1042).contains(&byte_time.as_micros()));
}

#[test]
fn writing_the_flash_takes_half_a_second_and_commands_wait() {
    let mut bench = Bench::quiet();
    bench.send("$VNWNV*57\r\n$VNRRG,06*75\r\n");
    assert_eq!(bench.wait_ms(500), "");
    assert_eq!(bench.wait_ms(10), "$VNWNV*57\r\n$VNRRG,06,14*5C\r\n");
    // as many commands as the buffer holds
    bench.send("$VNWNV*57\r\n");
    bench.send(&"$VNRRG,06*75\r\n".repeat(30));
    let overflown = bench.wait_ms(490).matches("$VNERR,02*73").count();
    let answered = bench.wait_ms(300).matches("$VNRRG,06,14").count();
    assert_eq!((answered, overflown), (256 / "VNRRG,06*75".len(), 30 - 256 / "VNRRG,06*75".len()));
}

#[test]
fn commands_that_wait_for_the_flash_wait_for_a_second_write_and_end_with_a_restart() {
    let mut bench = Bench::quiet();
    bench.send("$VNWNV*57\r\n$VNWNV*57\r\n$VNRRG,06*75\r\n");
    assert_eq!(bench.wait_ms(510), "$VNWNV*57\r\n");
    assert_eq!(bench.wait_ms(490), "");
    assert_eq!(bench.wait_ms(10), "$VNWNV*57\r\n$VNRRG,06,14*5C\r\n");
    bench.send("$VNWNV*57\r\n$VNRST*4D\r\n$VNRRG,06*75\r\n");
    assert_eq!(bench.wait_ms(510), "$VNWNV*57\r\n$VNRST*4D\r\n");
    assert_eq!(bench.wait_ms(BOOT_MS - 10), "");
}

#[test]
fn a_restart_forgets_settings_that_were_not_written_to_flash() {
    let mut bench = Bench::quiet();
    bench.set("07,20");
    bench.ask("VNWNV");
    bench.wait_ms(500);
    bench.set("07,10");
    bench.send("$VNRST*4D\r\n");
    assert_eq!(bench.wait_ms(10), "$VNRST*4D\r\n");
    bench.send("$VNRRG,01*72\r\n");
    assert_eq!(bench.wait_ms(BOOT_MS - 10), "");
    // output is on again, because a pause is no setting
    assert_eq!(lines(&bench.wait_ms(1000)), 20);
}

#[test]
fn factory_settings_come_with_their_baud() {
    let mut bench = Bench::quiet();
    bench.set("05,921600");
    bench.set("07,200");
    bench.ask("VNWNV");
    bench.wait_ms(500);
    bench.send("$VNRST*4D\r\n");
    bench.wait_ms(BOOT_MS + 10);
    assert_eq!(bench.device.baud(), 921_600);
    bench.wait_ms(95);
    bench.send("$VNRFS*5F\r\n");
    assert!(bench.wait_ms(4).contains("$VNRFS*5F\r\n"));
    bench.wait_ms(BOOT_MS);
    assert_eq!((bench.device.baud(), lines(&bench.wait_ms(1000))), (115_200, 40));
}

#[test]
fn a_crash_is_reported_and_restarts_the_sensor() {
    let mut bench = Bench::quiet();
    bench.device.crash(bench.now);
    assert_eq!(bench.wait_ms(10), "$VNERR,01*70\r\n");
    assert_eq!(bench.wait_ms(BOOT_MS - 10), "");
    assert_eq!(lines(&bench.wait_ms(1000)), 40);
}

#[test]
fn a_power_failure_loses_unsent_bytes() {
    let mut bench = Bench::switched_on(DeviceConfig::default());
    bench.wait_ms(BOOT_MS + 5);
    bench.device.power_cycle(bench.now);
    assert_eq!(bench.wait_ms(BOOT_MS), "");
    assert!(bench.wait_ms(20).starts_with("$VNYMR"));
}

#[test]
fn messages_that_do_not_fit_the_buffer_are_dropped_and_reported() {
    let mut bench = Bench::quiet();
    bench.set("06,0");
    // 11 600 bytes per second of 11 520 would be refused: this is 97 % of the line, and replies do not count
    bench.set("75,1,4,06,0001,001E");
    bench.send("$VNASY,1*4E\r\n");
    let mut text = Vec::new();
    for _ in 0..100 {
        bench.send(&"$VNRRG,23*72\r\n".repeat(2));
        text.extend(bench.wait(Duration::from_millis(5)));
    }
    text.extend(bench.wait(Duration::from_secs(1)));
    // a reply is complete or absent
    let count = |pattern: &[u8]| text.windows(pattern.len()).filter(|bytes| *bytes == pattern).count();
    let (whole, dropped) = (count(b"$VNRRG,23"), count(b"$VNERR,0B*03\r\n"));
    assert!(whole < 200 && dropped >= 5, "{whole} {dropped}");
    assert_eq!(whole, count(b"$VNRRG,23,1,0,0,0,1,0,0,0,1,0,0,0*73\r\n"));
}

#[test]
fn a_fast_clock_sends_early() {
    let mut bench = Bench::switched_on(DeviceConfig { clock_error_ppm: 1000.0, ..DeviceConfig::default() });
    let sent = sent_until(&mut bench.device, BOOT + Duration::from_secs(101));
    let starts: Vec<_> = sent.iter().filter(|byte| byte.byte == b'$').map(|byte| byte.at).collect();
    let interval = (starts[4000] - starts[0]).as_secs_f64() / 4000.0;
    assert!((interval / 0.025 - 0.999).abs() < 1e-6, "{interval}");
}

#[test]
fn packets_carry_the_time_of_a_fast_clock() {
    let mut bench = Bench::quiet_with(DeviceConfig { clock_error_ppm: 1000.0, ..DeviceConfig::default() });
    bench.set("06,0");
    bench.set("75,1,8,05,0001,001C");
    bench.send("$VNASY,1*XX\r\n");
    let sent = sent_until(&mut bench.device, bench.now + Duration::from_secs(20));
    let is_start = |four: &[SentByte]| four.iter().map(|byte| byte.byte).eq([0xFA, 0x05, 0x01, 0x00]);
    let packets: Vec<(u64, Duration)> = (sent.windows(4).enumerate())
        .filter(|(_, four)| is_start(four))
        .filter_map(|(place, _)| {
            let time: Vec<u8> = sent.get(place + 6..place + 14)?.iter().map(|byte| byte.byte).collect();
            Some((u64::from_le_bytes(time.try_into().ok()?), sent[place].at))
        })
        .collect();
    let (first, last) = (packets[1], packets[packets.len() - 2]);
    let (by_sensor, by_host) = ((last.0 - first.0) as f64 * 1e-9, (last.1 - first.1).as_secs_f64());
    assert!(packets.len() > 1900, "{}", packets.len());
    assert!((by_sensor / by_host - 1.001).abs() < 1e-5, "{by_sensor} {by_host}");
}

//! The planned writes, their order, and impossible settings.

use proptest::{option, prelude::*, sample::select};

use super::*;
use vn100_protocol::PacketHeader;

fn contents(register: Register, fields: &str) -> RegisterContents {
    RegisterContents { register, fields: RegisterFields::new(fields).unwrap() }
}

fn current(baud: u32, code: u8, rate_hz: u32) -> Vec<RegisterContents> {
    vec![
        contents(Register::BAUD_RATE, &baud.to_string()),
        contents(Register::ASYNC_TYPE, &code.to_string()),
        contents(Register::ASYNC_RATE, &rate_hz.to_string()),
        contents(Register::PROTOCOL_CONTROL, "0,0,0,0,1,0,1"),
        contents(Register::SYNC_CONTROL, "3,0,0,0,0,0,0,100000000,0"),
        contents(Register::BINARY_OUTPUT_1, "0,0,00"),
        contents(Register::IMU_FILTER, "0,4,4,4,0,0,3,3,3,0"),
    ]
}

/// The same registers, some with other contents.
fn with(mut current: Vec<RegisterContents>, others: &[(Register, &str)]) -> Vec<RegisterContents> {
    for (register, fields) in others {
        current.retain(|contents| contents.register != *register);
        current.push(contents(*register, fields));
    }
    current
}

fn rate(hz: u32) -> OutputSettings {
    OutputSettings { rate_hz: Some(hz), ..OutputSettings::default() }
}

fn count(count: bool) -> OutputSettings {
    OutputSettings { count: Some(count), ..OutputSettings::default() }
}

/// Each write as received by the sensor.
fn planned(current: &[RegisterContents], settings: &OutputSettings) -> Vec<String> {
    plan(current, settings, true)
        .unwrap()
        .changes
        .iter()
        .map(|change| format!("{},{}", change.register, change.after))
        .collect()
}

fn error(current: &[RegisterContents], settings: &OutputSettings) -> String {
    plan(current, settings, true).unwrap_err().to_string()
}

#[test]
fn a_port_after_a_value_is_no_change() {
    let replies = [(Register::BAUD_RATE, "115200,1"), (Register::ASYNC_TYPE, "14,1"), (Register::ASYNC_RATE, "40,1")];
    let current = with(current(115_200, 14, 40), &replies);
    let settings = OutputSettings { message: Some("VNYMR".into()), baud: Some(115_200), ..rate(40) };
    assert_eq!(planned(&current, &settings), [""; 0]);
    let changes = plan(&current, &rate(20), true).unwrap().changes;
    let [Change { before, after, .. }] = &changes[..] else { panic!("{changes:?}") };
    assert_eq!((before.as_str(), after.as_str()), ("40", "20"));
}

#[test]
fn window_and_count_keep_the_other_fields() {
    let settings = OutputSettings {
        message: Some("VNIMU".into()),
        rate_hz: Some(20),
        window: Some(40),
        count: Some(true),
        ..OutputSettings::default()
    };
    let expected = ["07,20", "06,19", "32,3,0,0,0,1,0,39,100000000,0", "30,3,0,0,0,1,0,1", "85,0,40,40,4,0,0,3,3,3,0"];
    assert_eq!(planned(&current(115_200, 14, 40), &settings), expected);
}

#[test]
fn a_count_of_lines_follows_the_rate_and_no_other_pulse_does() {
    let counting = |sync| with(current(115_200, 14, 40), &[(Register::PROTOCOL_CONTROL, "3,0,0,0,1,0,1"), sync]);
    let lines = counting((Register::SYNC_CONTROL, "3,0,0,0,1,0,19,100000000,0"));
    assert_eq!(planned(&lines, &rate(20)), ["07,20", "32,3,0,0,0,1,0,39,100000000,0"]);
    assert_eq!(planned(&lines, &rate(50)), ["07,50", "32,3,0,0,0,1,0,15,100000000,0"]);
    assert_eq!(planned(&lines, &count(true)), [""; 0]);
    assert_eq!(planned(&lines, &count(false)), ["30,0,0,0,0,1,0,1", "32,3,0,0,0,0,0,0,100000000,0"]);
    // a pulse for every measurement, and for every attitude
    for sync in ["3,0,0,0,1,0,0,100000000,0", "3,0,0,0,3,0,19,100000000,0"] {
        assert_eq!(planned(&counting((Register::SYNC_CONTROL, sync)), &rate(20)), ["07,20"]);
    }
    // pulses for another purpose, which no line counts
    let own = with(current(115_200, 14, 40), &[(Register::SYNC_CONTROL, "3,0,0,0,1,0,19,100000000,0")]);
    assert_eq!(planned(&own, &rate(20)), ["07,20"]);
    let camera = (Register::SYNC_CONTROL, "3,0,0,0,3,1,9,5000000,0");
    assert_eq!(planned(&with(current(115_200, 14, 40), &[camera]), &count(false)), [""; 0]);
    assert_eq!(planned(&counting(camera), &count(false)), ["30,0,0,0,0,1,0,1"]);
}

#[test]
fn a_count_that_does_not_fit_is_named() {
    let counting = [(Register::PROTOCOL_CONTROL, "3,0,0,0,1,0,1")];
    let message = OutputSettings { message: Some("VNIMU".into()), ..rate(100) };
    let counted = error(&with(current(115_200, 14, 50), &counting), &message);
    assert_eq!(
        counted,
        "VNIMU at 100 Hz needs 12400 bytes a second and 115200 baud carry 11520; at most 50 Hz fit, or take \
         128000 baud or more, or switch the count off"
    );
    assert!(plan(&current(115_200, 14, 50), &message, true).is_ok());
    let without = error(&with(current(57_600, 14, 50), &counting), &message);
    assert!(!without.contains("count off"), "{without}");
}

#[test]
fn a_shorter_line_comes_before_a_higher_rate() {
    // 124 bytes 50 times per second are too many for 57 600 baud, 112 are not
    let counting =
        [(Register::PROTOCOL_CONTROL, "3,0,0,0,1,0,1"), (Register::SYNC_CONTROL, "3,0,0,0,1,0,19,100000000,0")];
    let settings = OutputSettings { rate_hz: Some(50), ..count(false) };
    assert_eq!(
        planned(&with(current(57_600, 19, 40), &counting), &settings),
        ["30,0,0,0,0,1,0,1", "07,50", "32,3,0,0,0,0,0,0,100000000,0"]
    );
}

#[test]
fn a_port_that_sends_no_lines_can_be_set() {
    let window = OutputSettings { window: Some(20), ..count(true) };
    assert_eq!(
        planned(&current(115_200, 14, 0), &window),
        ["32,3,0,0,0,1,0,0,100000000,0", "30,3,0,0,0,1,0,1", "85,0,20,20,4,0,0,3,3,3,0"]
    );
    assert_eq!(planned(&current(115_200, 14, 0), &rate(50)), ["07,50"]);
}

#[test]
fn the_highest_rates_are_those_of_the_sheet() {
    // VNYMR: the rate that the sensor accepts at each baud rate
    let table = [
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
    for (baud, expected) in table {
        for rate_hz in OUTPUT_RATES_HZ {
            let result = plan(&current(baud, 14, 1), &rate(rate_hz), true);
            if rate_hz <= expected {
                assert!(result.is_ok(), "{rate_hz} Hz at {baud}");
            } else {
                let error = result.unwrap_err().to_string();
                assert!(error.contains(&format!("at most {expected} Hz fit")), "{error}");
            }
        }
    }
}

#[test]
fn packets_need_their_part_of_the_line() {
    // 110 bytes 40 times per second
    let packets = |text| with(current(115_200, 14, 40), &[(Register::BINARY_OUTPUT_2, text)]);
    assert_eq!(planned(&packets("1,20,01,0739"), &rate(50)), ["07,50"]);
    assert_eq!(
        error(&packets("1,8,01,0739"), &rate(50)),
        "VNYMR at 50 Hz, beside 11000 bytes a second of packets, needs 17100 bytes a second and 115200 baud carry 11520; \
         at most 4 Hz fit, or take 230400 baud or more"
    );
    // outputs that are off or malformed are left to the sensor
    for text in ["0,8,01,0739", "1,0,01,0739", "1,8,08,0001", "1,8,?"] {
        assert_eq!(planned(&packets(text), &rate(50)), ["07,50"], "{text}");
    }
}

#[test]
fn impossible_settings_report_the_possible_ones() {
    let factory = current(115_200, 14, 40);
    assert_eq!(
        error(&factory, &rate(100)),
        "VNYMR at 100 Hz needs 12200 bytes a second and 115200 baud carry 11520; at most 50 Hz fit, or take 128000 baud or more"
    );
    for hz in [0, 30] {
        let text = format!("the rate can be 1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200, not {hz}");
        assert_eq!(error(&factory, &rate(hz)), text);
    }
    let settings = OutputSettings::default;
    let baud = OutputSettings { baud: Some(56_000), ..settings() };
    assert!(error(&factory, &baud).starts_with("the baud rate can be 9600, 19200, "));
    let message = OutputSettings { message: Some("VNXYZ".into()), ..settings() };
    assert!(error(&factory, &message).starts_with("the message can be VNYPR, VNQTN, "));
    for window in [0, 801, 65_540] {
        let window = OutputSettings { window: Some(window), ..settings() };
        assert!(error(&factory, &window).starts_with("the window can be 1 to 800 samples, not "));
    }
    let without = |register| {
        let mut current = factory.clone();
        current.retain(|contents| contents.register != register);
        current
    };
    let window = OutputSettings { window: Some(20), ..settings() };
    let text = "this sensor lacks register 85, which the setting needs";
    assert_eq!(error(&without(Register::IMU_FILTER), &window), text);
    assert!(error(&without(Register::SYNC_CONTROL), &count(true)).contains("lacks register 32"));
    let damaged = with(factory.clone(), &[(Register::SYNC_CONTROL, "3,0,0")]);
    assert!(error(&damaged, &count(true)).starts_with("register 32"));
    // they are ignored if they do not matter
    for passable in [without(Register::SYNC_CONTROL), without(Register::IMU_FILTER), damaged] {
        assert_eq!(planned(&passable, &rate(50)), ["07,50"]);
    }
}

#[test]
fn packets_follow_a_faster_line_and_replace_sentences() {
    let factory = current(115_200, 14, 40);
    let packets =
        |name: &str, rate_hz| OutputSettings { message: Some(name.into()), rate_hz, ..OutputSettings::default() };
    assert_eq!(planned(&factory, &packets("BINARY", None)), ["06,0", "75,1,4,05,0001,001C"]);
    let fast = packets("binary", Some(800));
    assert_eq!(planned(&factory, &fast), ["05,460800", "06,0", "75,1,1,05,0001,001C"]);
    let with_mag = OutputSettings { window: Some(1), ..packets("BINARY+MAG", Some(800)) };
    let expected = ["05,921600", "06,0", "85,0,1,1,4,0,0,3,3,3,0", "75,1,1,05,0001,003E"];
    assert_eq!(planned(&factory, &with_mag), expected);
    let OutputPlan { frames, rate_hz, .. } = plan(&factory, &fast, true).unwrap();
    assert_eq!((frames, rate_hz), (FrameKind::Packet(PacketHeader::new(5, &[1, 0x1C])), 800.0));
}

#[test]
fn active_packets_keep_their_port_and_get_another_rate() {
    let sending = with(current(921_600, 0, 40), &[(Register::BINARY_OUTPUT_1, "2,4,05,0001,001C")]);
    assert_eq!(planned(&sending, &rate(800)), ["75,2,1,05,0001,001C"]);
    let binary = OutputSettings { message: Some("BINARY".into()), ..OutputSettings::default() };
    assert_eq!(planned(&sending, &binary), [""; 0]);
    // packets that are off, or have no rate, are not sent
    for off in ["0,4,05,0001,001C", "2,0,05,0001,001C"] {
        let silent = with(current(921_600, 0, 40), &[(Register::BINARY_OUTPUT_1, off)]);
        let port = if off.starts_with('2') { 2 } else { 1 };
        assert_eq!(planned(&silent, &binary), [format!("75,{port},4,05,0001,001C")]);
    }
}

#[test]
fn a_sentence_replaces_the_packets_that_arrive() {
    let sending = with(current(115_200, 0, 40), &[(Register::BINARY_OUTPUT_1, "2,4,05,0001,001C")]);
    let back = OutputSettings { message: Some("VNYMR".into()), ..rate(50) };
    assert_eq!(planned(&sending, &back), ["75,0,4,05,0001,001C", "06,14", "07,50"]);
    let elsewhere = plan(&sending, &OutputSettings { rate_hz: Some(1), ..back }, false).unwrap().changes;
    assert_eq!(elsewhere.iter().map(|change| change.register.0).collect::<Vec<_>>(), [7, 6]);
}

#[test]
fn missing_packets_are_sent_to_the_second_port() {
    let changes = plan(
        &current(115_200, 14, 40),
        &OutputSettings { message: Some("BINARY".into()), ..OutputSettings::default() },
        true,
    )
    .unwrap()
    .changes;
    let moved = to_second_port(&changes).unwrap();
    assert_eq!((moved.before.as_str(), moved.after.as_str()), ("0,0,00", "2,4,05,0001,001C"));
    assert_eq!(writable(moved.register, &moved.before).as_str(), "0,0,01,0001");
    assert_eq!(writable(moved.register, &moved.after), moved.after);
    assert_eq!(to_second_port(&[moved]), None);
    assert_eq!(to_second_port(&changes[..1]), None);
}

#[test]
fn packets_that_do_not_fit_report_what_fits() {
    let factory = current(115_200, 14, 40);
    let asked = OutputSettings { message: Some("BINARY".into()), baud: Some(115_200), ..rate(800) };
    assert_eq!(
        error(&factory, &asked),
        "800 packets a second need 35200 bytes a second, and 115200 baud carry 11520; take 460800 baud or more"
    );
    let thirds = OutputSettings { baud: None, ..OutputSettings { rate_hz: Some(300), ..asked } };
    assert!(
        error(&factory, &thirds).starts_with("the rate of packets can be 1, 2, 4, 5, 8, 10, "),
        "{}",
        error(&factory, &thirds)
    );
}

/// A message with a known length.
fn message() -> impl Strategy<Value = AsyncType> {
    let known = |code: &AsyncType| code.header().is_some() && code.usual_length().is_some();
    select((0..=u8::MAX).map(AsyncType).filter(known).collect::<Vec<_>>())
}

/// A sensor with any output, whether or not it fits the line.
fn sensor() -> impl Strategy<Value = Vec<RegisterContents>> {
    let packets = select(vec!["0,0,00", "1,20,01,0101", "1,8,01,0739", "3,4,06,0001,001C"]);
    (select(BaudRate::ALL.to_vec()), message(), select(OUTPUT_RATES_HZ.to_vec()), any::<bool>(), packets).prop_map(
        |(baud, message, rate_hz, counts, packets)| {
            let sync = format!("3,0,0,0,1,0,{},100000000,0", 800 / rate_hz - 1);
            let mut others = vec![(Register::BINARY_OUTPUT_1, packets)];
            if counts {
                others.extend([(Register::PROTOCOL_CONTROL, "3,0,0,0,1,0,1"), (Register::SYNC_CONTROL, &sync)]);
            }
            with(current(baud.bits_per_s(), message.0, rate_hz), &others)
        },
    )
}

fn settings() -> impl Strategy<Value = OutputSettings> {
    let baud = option::of(select(BaudRate::ALL.map(BaudRate::bits_per_s).to_vec()));
    let sentences = message().prop_map(|message| message.header().map(ToOwned::to_owned));
    let packets = select(PACKET_MESSAGES.to_vec()).prop_map(|packets| Some(packets.name.to_owned()));
    let message = prop_oneof![2 => sentences, 1 => packets, 1 => Just(None)];
    (baud, message, option::of(select(OUTPUT_RATES_HZ.to_vec())), option::of(any::<bool>())).prop_map(
        |(baud, message, rate_hz, count)| OutputSettings { baud, message, rate_hz, count, ..OutputSettings::default() },
    )
}

fn output(sensor: &[RegisterContents]) -> Output {
    Output::from_registers(sensor, &count(true)).unwrap()
}

proptest! {
    #[test]
    fn every_step_fits_and_is_undone_in_reverse(
        sensor in sensor(),
        settings in settings(),
        packets_arrive: bool,
    ) {
        prop_assume!(output(&sensor).check_fit().is_ok());
        let Ok(OutputPlan { changes, rate_hz, .. }) = plan(&sensor, &settings, packets_arrive) else { return Ok(()) };
        let mut state = sensor.clone();
        for change in &changes {
            state = with(state, &[(change.register, change.after.as_str())]);
            prop_assert_eq!(output(&state).check_fit(), Ok(()), "{:?}", change);
        }
        let set = output(&state);
        let rate_before_hz = || match output(&sensor).binary {
            Some(binary) if set.sends_packets_alone() => match settings.message.as_deref().and_then(PacketMessage::named) {
                Some(packets) if !packets.is_of(&binary) || binary.rate_hz() == 0.0 => f64::from(PACKETS_HZ),
                _ => binary.rate_hz(),
            },
            _ => output(&sensor).rate.hz().into(),
        };
        prop_assert_eq!(rate_hz, settings.rate_hz.map_or_else(rate_before_hz, f64::from));
        let is_replaced = packets_arrive && settings.message.is_some() && set.message != AsyncType::OFF;
        prop_assert!(!is_replaced || set.binary.as_ref().is_none_or(|binary| binary.rate_hz() == 0.0));
        prop_assert_eq!(set.counts_lines(), settings.count.unwrap_or(output(&sensor).counts_lines()));
        prop_assert_eq!(plan(&state, &settings, packets_arrive).unwrap().changes, []);
        for change in changes.iter().rev() {
            state = with(state, &[(change.register, change.before.as_str())]);
            prop_assert_eq!(output(&state).check_fit(), Ok(()), "back: {:?}", change);
        }
        prop_assert_eq!(output(&state), output(&sensor));
    }
}

#[test]
fn a_change_names_the_changed_setting() {
    let fields = |text| RegisterFields::new(text).unwrap();
    for (register, name) in [
        (Register::BAUD_RATE, "the baud rate (register 05) from 1 to 2"),
        (Register::ASYNC_TYPE, "the message (register 06) from 1 to 2"),
        (Register::ASYNC_RATE, "the rate (register 07) from 1 to 2"),
        (Register::PROTOCOL_CONTROL, "the format of the sentences (register 30) from 1 to 2"),
        (Register::SYNC_CONTROL, "the synchronisation (register 32) from 1 to 2"),
        (Register::IMU_FILTER, "the averaging windows (register 85) from 1 to 2"),
        (Register::BINARY_OUTPUT_1, "the packets (register 75) from 1 to 2"),
    ] {
        assert_eq!(Change { register, before: fields("1"), after: fields("2") }.to_string(), name);
    }
}

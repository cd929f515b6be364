//! Commands as sent by the maker and by users of sensors, and the replies.

use proptest::prelude::*;
use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, Check, DeviceError, ImuFilter, ProtocolControl, Register, RegisterFields, Reply,
    SensorCommand, SyncControl, WritableValue,
};

use crate::support::{line, parse_reply, reply, sentence};

fn read(register: u8) -> SensorCommand {
    SensorCommand::ReadRegister(Register(register))
}

#[test]
fn reads_are_the_published_lines() {
    for published in ["$VNRRG,01*72", "$VNRRG,08*7B", "$VNRRG,85*7E", "$VNRRG,239*4B"] {
        let number = published[7..published.len() - 3].parse().unwrap();
        assert_eq!(line(&read(number), Check::Xor8), published);
    }
    for (number, published) in [(1, "$VNRRG,01*E15F"), (27, "$VNRRG,27*E7FB"), (8, "$VNRRG,08*7076")] {
        assert_eq!(line(&read(number), Check::Crc16), published);
    }
}

#[test]
fn writes_are_the_published_lines() {
    fn check(setting: &impl WritableValue, published: &str) {
        assert_eq!(line(&SensorCommand::write(setting), Check::Xor8), published);
    }
    for (code, published) in [
        (AsyncType::OFF, "$VNWRG,06,0*6C"),
        (AsyncType::YPR, "$VNWRG,06,1*6D"),
        (AsyncType::MAR, "$VNWRG,06,13*5E"),
        (AsyncType::YMR, "$VNWRG,06,14*59"),
        (AsyncType::IMU, "$VNWRG,06,19*54"),
        (AsyncType::DTV, "$VNWRG,06,30*5F"),
    ] {
        check(&code, published);
    }
    for published in [
        "$VNWRG,07,0*6D",
        "$VNWRG,07,1*6C",
        "$VNWRG,07,2*6F",
        "$VNWRG,07,4*69",
        "$VNWRG,07,5*68",
        "$VNWRG,07,10*5C",
        "$VNWRG,07,20*5F",
        "$VNWRG,07,25*5A",
        "$VNWRG,07,40*59",
        "$VNWRG,07,50*58",
        "$VNWRG,07,100*6C",
        "$VNWRG,07,200*6F",
    ] {
        let hz = published[10..published.len() - 3].parse().unwrap();
        check(&AsyncRate::new(hz).unwrap(), published);
    }
    for published in [
        "$VNWRG,05,9600*50",
        "$VNWRG,05,19200*65",
        "$VNWRG,05,38400*60",
        "$VNWRG,05,57600*6B",
        "$VNWRG,05,128000*54",
        "$VNWRG,05,115200*58",
        "$VNWRG,05,230400*5A",
        "$VNWRG,05,460800*55",
        "$VNWRG,05,921600*53",
    ] {
        let rate = published[10..published.len() - 3].parse().unwrap();
        check(&BaudRate::new(rate).unwrap(), published);
    }
    let factory = ProtocolControl::default();
    check(&factory, "$VNWRG,30,0,0,0,0,1,0,1*69");
    check(&ProtocolControl { serial_count: 3, ..factory }, "$VNWRG,30,3,0,0,0,1,0,1*6A");
    check(&ProtocolControl { serial_count: 3, serial_status: 1, ..factory }, "$VNWRG,30,3,1,0,0,1,0,1*6B");
    check(&ProtocolControl { serial_checksum: 3, ..factory }, "$VNWRG,30,0,0,0,0,3,0,1*6B");
    let sync = SyncControl { out_mode: 1, out_polarity: 1, out_pulse_ns: 500_000, ..SyncControl::default() };
    check(&sync, "$VNWRG,32,3,0,0,0,1,1,0,500000,0*5D");
    let filter = ImuFilter::default();
    let filter = ImuFilter { accel_window: 20, gyro_window: 20, ..filter };
    check(&filter, "$VNWRG,85,0,20,20,4,0,0,3,3,3,0*7C");
    let with_port =
        SensorCommand::WriteRegister { register: Register::ASYNC_TYPE, fields: RegisterFields::new("14,2").unwrap() };
    assert_eq!(line(&with_port, Check::Xor8), "$VNWRG,06,14,2*47");
    let crc = SensorCommand::WriteRegister {
        register: Register::BINARY_OUTPUT_1,
        fields: RegisterFields::new("1,4,01,0601").unwrap(),
    };
    assert_eq!(line(&crc, Check::Crc16), "$VNWRG,75,1,4,01,0601*BE74");
}

#[test]
fn the_other_commands_are_the_published_lines_and_answered_by_themselves() {
    let commands = [
        (SensorCommand::WriteSettings, "$VNWNV*57"),
        (SensorCommand::RestoreFactorySettings, "$VNRFS*5F"),
        (SensorCommand::Reset, "$VNRST*4D"),
        (SensorCommand::Tare, "$VNTAR*5F"),
        (SensorCommand::SetGyroBias, "$VNSGB*4E"),
        (SensorCommand::Async(false), "$VNASY,0*4F"),
        (SensorCommand::Async(true), "$VNASY,1*4E"),
    ];
    for (command, published) in &commands {
        assert_eq!(line(command, Check::Xor8), *published);
        for (other, echo) in &commands {
            assert_eq!(command.is_answered_by(&parse_reply(echo).unwrap()), command == other, "{published} {echo}");
        }
    }
    assert_eq!(line(&SensorCommand::Async(false), Check::Crc16), "$VNASY,0*4158");
}

#[test]
fn only_reads_writes_and_pausing_may_be_repeated() {
    let write = SensorCommand::write(&AsyncType::YMR);
    for command in [read(1), write, SensorCommand::Async(true)] {
        assert!(command.is_repeatable(), "{command:?}");
    }
    use SensorCommand::{Reset, RestoreFactorySettings, SetGyroBias, Tare, WriteSettings};
    for command in [WriteSettings, RestoreFactorySettings, Reset, SetGyroBias, Tare] {
        assert!(!command.is_repeatable(), "{command:?}");
    }
}

#[test]
fn answers_are_recognised_by_command_and_register_with_any_padding() {
    let write = SensorCommand::write(&AsyncRate::new(40).unwrap());
    for (body, reads, writes) in [
        ("VNRRG,07,40", true, false),
        ("VNRRG,7,40", true, false),
        ("VNRRG,007,40,1", true, false),
        ("VNRRG,08,-114.314,+000.058,-001.773", false, false),
        ("VNRRG,70,40", false, false),
        ("VNWRG,07,40", false, true),
        ("VNWRG,7,50", false, true),
        ("VNWRG,06,40", false, false),
        ("VNWNV", false, false),
        ("VNERR,03", false, false),
    ] {
        assert_eq!(read(7).is_answered_by(&reply(body)), reads, "{body}");
        assert_eq!(write.is_answered_by(&reply(body)), writes, "{body}");
    }
}

#[test]
fn errors_have_their_codes() {
    use DeviceError::*;
    for (published, error) in [
        ("$VNERR,01*70", HardFault),
        ("$VNERR,02*73", ReceiveBufferOverflow),
        ("$VNERR,03*72", InvalidChecksum),
        ("$VNERR,03*B43A", InvalidChecksum),
        ("$VNERR,04*75", InvalidCommand),
        ("$VNERR,05*74", TooFewParameters),
        ("$VNERR,06*77", TooManyParameters),
        ("$VNERR,07*76", InvalidParameter),
        ("$VNERR,08*79", InvalidRegister),
        ("$VNERR,09*78", Unauthorized),
        ("$VNERR,0A*00", WatchdogReset),
        ("$VNERR,0B*03", OutputBufferOverflow),
        ("$VNERR,0C*02", InsufficientBaudRate),
        ("$VNERR,FF*71", ErrorBufferOverflow),
        ("$VNERR,12*72", Unknown(0x12)),
    ] {
        assert_eq!(parse_reply(published), Some(Reply::Error(error)), "{published}");
    }
}

#[test]
fn a_read_without_a_value_is_the_question() {
    for body in ["VNRRG,07", "VNRRG,7"] {
        assert_eq!(parse_reply(&sentence(body)), Some(Reply::Question(Register(7))), "{body}");
    }
    assert!(matches!(parse_reply(&sentence("VNRRG,00,")), Some(Reply::Register(_))), "an empty text is a value");
}

#[test]
fn a_sentence_that_is_no_reply_is_none() {
    for body in [
        "VNYPR,-129.867,-000.355,-000.296",
        "GPGGA,1",
        "VNRRG",
        "VNRRG,",
        "VNRRG,x,1",
        "VNRRG,+1,1",
        "VNWRG,256,1",
        "VNWRG,07",
        "VNERR",
        "VNERR,",
        "VNERR,+3",
        "VNERR,003",
        "VNERR,03,1",
    ] {
        assert_eq!(parse_reply(&sentence(body)), None, "{body}");
    }
}

proptest! {
    #[test]
    fn a_sent_command_returns_as_an_answer(number: u8, text in "[ -#%-)+-~]{0,60}", crc: bool) {
        let fields = RegisterFields::new(text).unwrap();
        let register = Register(number);
        let command = SensorCommand::WriteRegister { register, fields: fields.clone() };
        let check = if crc { Check::Crc16 } else { Check::Xor8 };
        let reply = parse_reply(&line(&command, check)).unwrap();
        prop_assert!(command.is_answered_by(&reply));
        let Reply::Written(contents) = reply else { panic!("{reply:?}") };
        prop_assert_eq!((contents.register, contents.fields), (register, fields));
    }
}

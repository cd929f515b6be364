//! The contents of registers as sent by sensors, parsed and written again.

use core::fmt::Debug;

use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, BinaryOutput, Check, ImuFilter, ProtocolControl, ReferenceFrameRotation, Register,
    RegisterValue, Sample, SensorCommand, SyncControl, VNIMU, WritableValue,
};

use crate::support::{contents, line, sentence};

/// Reads `published`, and expects that a write of the value has the same fields.
fn check<T: WritableValue + PartialEq + Debug>(published: &str, expected: T) {
    let contents = contents(published);
    let value: T = contents.value().unwrap();
    assert_eq!(value, expected, "{published}");
    let body = format!("VNWRG,{},{}", contents.register, contents.fields);
    assert_eq!(format!("{}\r\n", line(&SensorCommand::write(&value), Check::Xor8)), sentence(&body));
}

/// The error of reading a value, as text.
fn error<T: RegisterValue + Debug>(body: &str) -> String {
    contents(&sentence(body)).value::<T>().unwrap_err().to_string()
}

#[test]
fn settings_return_as_they_are_written() {
    check("$VNRRG,05,115200*5D", BaudRate::DEFAULT);
    check("$VNRRG,06,14*5C", AsyncType::YMR);
    check("$VNRRG,07,40*5C", AsyncRate::new(40).unwrap());
    check("$VNRRG,30,0,0,0,0,1,0,1*6C", ProtocolControl::default());
    check("$VNRRG,32,3,0,0,0,0,0,0,100000000,0*6C", SyncControl::default());
    check("$VNRRG,85,0,4,4,4,0,0,3,3,3,0*79", ImuFilter::default());
}

#[test]
fn read_only_registers_are_read() {
    for (line, async_mode, rate_divisor, field_words) in [
        ("$VNRRG,75,0,0,01,0001*71", 0, 0, vec![1]),
        ("$VNRRG,75,2,4,01,0739*7B", 2, 4, vec![0x0739]),
        ("$VNRRG,75,3,400,01,0321*3B31", 3, 400, vec![0x0321]),
    ] {
        let output = BinaryOutput { async_mode, rate_divisor, groups: 1, field_words };
        assert_eq!(contents(line).value(), Ok(output), "{line}");
    }
    let rotation = contents("$VNRRG,26,1,0,0,0,1,0,0,0,1*6A").value();
    assert_eq!(rotation, Ok(ReferenceFrameRotation { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }));
}

#[test]
fn matrices_are_by_rows() {
    let found = contents(&sentence("VNRRG,26,1,2,3,4,5,6,-0.5,+00.250000,1e-05")).value::<ReferenceFrameRotation>();
    assert_eq!(found.unwrap().matrix, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [-0.5, 0.25, 1e-5]]);
}

#[test]
fn the_port_may_be_repeated() {
    assert_eq!(contents("$VNRRG,05,115200,1*40").value(), Ok(BaudRate::DEFAULT));
    assert_eq!(contents("$VNRRG,06,14,1*41").value(), Ok(AsyncType::YMR));
    assert_eq!(contents("$VNRRG,07,40,1*41").value(), Ok(AsyncRate::new(40).unwrap()));
    assert_eq!(contents("$VNRRG,06,1,1*0865").value(), Ok(AsyncType::YPR));
    assert_eq!(contents("$VNRRG,07,1,1*A234").value(), Ok(AsyncRate::new(1).unwrap()));
}

#[test]
fn a_polled_measurement_is_the_one_sent_unasked() {
    let polled = contents(
        "$VNRRG,54,-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475,+21.6,+00099.761*5B",
    );
    let sample = Sample::from_contents(&polled, &VNIMU).unwrap();
    assert_eq!(sample.counts(), [-20_841, 6_045, 28_911, 381, -154, -9_657, -5_683, 262, 1_475, 216, 99_761]);
    assert_eq!((sample.values().nth(9), sample.values().nth(10)), (Some(21.6), Some(99.761)));
    let damaged = Sample::from_contents(&contents(&sentence("VNRRG,54,-02.0841")), &VNIMU);
    assert_eq!(damaged.unwrap_err().to_string(), "grammar: the sentence has 1 fields, 11 are expected");
}

#[test]
fn contents_without_a_type_stay_text() {
    let tag = contents("$VNRRG,00,SENSOR_A14*52");
    assert_eq!((tag.register, tag.fields.as_str()), (Register(0), "SENSOR_A14"));
    let sync = contents("$VNRRG,33,2552498,0,0*6A");
    assert_eq!(sync.fields.iter().collect::<Vec<_>>(), ["2552498", "0", "0"]);
}

#[test]
fn errors_name_the_wrong_field() {
    assert_eq!(
        error::<BaudRate>("VNRRG,05,4800"),
        "register 05: baud rate is \"4800\", expected one of the nine rates from 9600 to 921600"
    );
    assert_eq!(error::<AsyncRate>("VNRRG,07,40,3"), "register 07: port is \"3\", expected 1 or 2");
    assert_eq!(
        error::<AsyncType>("VNRRG,06,+14"),
        "register 06: async type is \"+14\", expected a whole number in range"
    );
    assert_eq!(error::<ImuFilter>("VNRRG,85,0,4,4,4,0,0,3,3,3"), "register 85: the pressure mode is missing");
    assert_eq!(
        error::<ProtocolControl>("VNRRG,30,0,0,0,0,1,0,1,7"),
        "register 30: more fields than are known, from \"7\" on"
    );
    for field in ["nan", "1e99", "", " 1"] {
        let body = format!("VNRRG,26,{field},0,0,0,1,0,0,0,1");
        assert!(error::<ReferenceFrameRotation>(&body).contains("expected a finite number"), "{body}");
    }
    assert!(error::<BinaryOutput>("VNRRG,75,0,0,+1,0001").starts_with("register 75: groups is"));
}

#[test]
fn registers_have_names() {
    assert_eq!(Register::IMU_FILTER.name(), Some("IMU filter"));
    assert_eq!((Register(1).to_string(), Register(239).to_string()), ("01".to_owned(), "239".to_owned()));
    assert_eq!(Register(99).name(), None);
}

#[test]
fn messages_are_known_by_code_and_by_header() {
    for code in (0..=u8::MAX).map(AsyncType) {
        assert_eq!(
            code.header().and_then(|header| AsyncType::from_header(header.as_bytes())),
            code.header().map(|_| code)
        );
        assert_eq!(code.header().is_some(), code.description().is_some());
    }
    assert_eq!(AsyncType::from_header(b"VNMAR"), Some(AsyncType::MAR));
    assert_eq!(AsyncType::from_header(b"VNRRG"), None);
    assert_eq!(AsyncType::OFF.header(), None);
}

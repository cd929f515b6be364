//! Bags made here byte by byte, as left by merging, by sensors that start late and by clocks that
//! are set.

use std::io::{Cursor, Write};

use vn100_capture::{Capture, CaptureOptions};
use vn100_protocol::stream::StampSource;

use crate::bags::{Read, options};

/// One topic of ROS 1 messages, each with the place of its definition, its record time and its
/// bytes.
struct Bag<'a> {
    type_name: &'a str,
    definitions: &'a [&'a str],
    messages: Vec<(usize, u64, Vec<u8>)>,
}

impl Bag<'_> {
    fn mcap(&self) -> Vec<u8> {
        let mut mcap = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
        let mut channels = Vec::new();
        for (place, text) in self.definitions.iter().enumerate() {
            let schema = mcap.add_schema(self.type_name, "ros1msg", text.as_bytes()).unwrap();
            // equal channels are one channel
            let which = [("which".into(), place.to_string())].into();
            channels.push(mcap.add_channel(schema, "/imu", "ros1", &which).unwrap());
        }
        for (sequence, (definition, log_time, data)) in (0..).zip(&self.messages) {
            let (channel_id, log_time) = (channels[*definition], *log_time);
            let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            mcap.write_to_known_channel(&header, data).unwrap();
        }
        mcap.finish().unwrap();
        mcap.into_inner().into_inner()
    }

    /// The bag without chunks and an index.
    fn ros1(&self) -> Vec<u8> {
        let fields = |fields: &[(&str, &[u8])]| -> Vec<u8> {
            let field = |(name, value): &(&str, &[u8])| {
                let length = (name.len() as u32 + 1 + value.len() as u32).to_le_bytes();
                [&length[..], name.as_bytes(), b"=", value].concat()
            };
            fields.iter().flat_map(field).collect()
        };
        let record = |header: &[u8], data: &[u8]| {
            let lengths = [header, data].map(|part| (part.len() as u32).to_le_bytes());
            [&lengths[0][..], header, &lengths[1], data].concat()
        };
        let mut bag = [b"#ROSBAG V2.0\n", &record(&fields(&[("op", &[3])]), &[])[..]].concat();
        for (connection, text) in (0_u32..).zip(self.definitions) {
            let header = fields(&[("op", &[7]), ("conn", &connection.to_le_bytes()), ("topic", b"/imu")]);
            let about = fields(&[("type", self.type_name.as_bytes()), ("message_definition", text.as_bytes())]);
            bag.extend(record(&header, &about));
        }
        for (definition, time_ns, data) in &self.messages {
            let connection = (*definition as u32).to_le_bytes();
            let header = fields(&[("op", &[2]), ("conn", &connection), ("time", &time(*time_ns))]);
            bag.extend(record(&header, data));
        }
        bag
    }
}

/// Seconds and nanoseconds.
fn time(ns: u64) -> [u8; 8] {
    let [seconds, rest] = [(ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32].map(u32::to_le_bytes);
    [seconds, rest].concat().try_into().unwrap()
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// A `sensor_msgs/Imu` without an orientation.
fn imu(stamp_ns: u64, rates: [f64; 3], accelerations: [f64; 3]) -> Vec<u8> {
    let header = [&[0; 4][..], &time(stamp_ns), &[0; 4]].concat();
    let none = [[0.0; 4].to_vec(), vec![-1.0], vec![0.0; 8]].concat();
    [header, doubles(&none), doubles(&rates), doubles(&[0.0; 9]), doubles(&accelerations), doubles(&[0.0; 9])].concat()
}

fn read(bytes: Vec<u8>, options: &CaptureOptions) -> Read {
    Read::of(Capture::from_reader(Cursor::new(bytes), options).unwrap())
}

/// A bag of several topics, each with one type and one content of its messages.
fn of_topics(topics: &[(&str, &str, &[u8])]) -> Vec<u8> {
    let mut mcap = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    for (topic, type_name, data) in topics {
        let schema = mcap.add_schema(type_name, "ros1msg", b"").unwrap();
        let channel_id = mcap.add_channel(schema, topic, "ros1", &Default::default()).unwrap();
        for sequence in 0..10 {
            let log_time = 1_000_000_000 + u64::from(sequence) * 10_000_000;
            let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            mcap.write_to_known_channel(&header, data).unwrap();
        }
    }
    mcap.finish().unwrap();
    mcap.into_inner().into_inner()
}

/// The measured topics of a bag, or the candidates.
fn streams(bytes: &[u8]) -> Vec<Option<String>> {
    let mut file = tempfile::NamedTempFile::with_suffix(".mcap").unwrap();
    file.write_all(bytes).unwrap();
    Capture::streams(file.path(), &CaptureOptions::default())
}

#[test]
fn the_topic_of_a_sensor_is_chosen_by_its_measurements() {
    let [whole, rates, accelerations] =
        [[0.1, 9.8], [0.1, 0.0], [0.0, 9.8]].map(|[rate, acceleration]| imu(1, [rate; 3], [acceleration; 3]));
    let header = [&[0; 4][..], &time(1), &[0; 4]].concat();
    let field = [&header[..], &doubles(&[2e-5; 3]), &doubles(&[0.0; 9])].concat();
    let text = [&3_u32.to_le_bytes()[..], b"abc"].concat();
    let (log, mag) = (("/log", "std_msgs/String", &*text), ("/mag", "sensor_msgs/MagneticField", &*field));
    let [whole, rates, accelerations] = [&*whole, &*rates, &*accelerations];
    let inertial = |topic, data| (topic, "sensor_msgs/Imu", data);
    // without rates and accelerations the magnetic field is measured, with them it is not
    let alone = read(of_topics(&[log, mag]), &CaptureOptions::default());
    assert_eq!((&*alone.report().topic, alone.names.len()), ("/mag", 3));
    let beside = read(of_topics(&[mag, log, inertial("/imu", whole)]), &CaptureOptions::default());
    assert_eq!(&*beside.report().topic, "/imu");
    // rates and accelerations in separate topics are two streams, the rates first
    let (gyro, accel) = (inertial("/gyro", rates), inertial("/accel", accelerations));
    let both = ["/gyro", "/accel"].map(|topic| Some(topic.to_owned()));
    assert_eq!(
        (streams(&of_topics(&[gyro, accel])), streams(&of_topics(&[accel, mag, gyro]))),
        (both.to_vec(), both.to_vec())
    );
    // of two complete sensors neither is chosen
    let two = of_topics(&[inertial("/left", whole), inertial("/right", whole)]);
    assert_eq!(streams(&two), [None]);
    let refused = Capture::from_reader(Cursor::new(two), &CaptureOptions::default()).err().unwrap().to_string();
    assert!(refused.contains("/left") && refused.contains("/right"), "{refused}");
}

#[test]
fn messages_of_another_definition_are_refused() {
    let rows = || 0..80_u8;
    let messages = rows().map(|row| {
        let [x, y] = [f64::from(row), 0.5];
        let numbers = if row < 40 { [x, y] } else { [y, x] };
        (usize::from(row / 40), u64::from(row) * 10_000_000, doubles(&numbers))
    });
    let messages: Vec<_> = messages.collect();
    let made = |definitions: [&str; 2]| {
        let bag = Bag { type_name: "demo/Rates", definitions: &definitions, messages: messages.clone() };
        [bag.mcap(), bag.ros1()]
    };
    // another comment makes no other definition; the scale of a series is fitted to all messages
    for (map, scale) in [("gyro_x=x:deg/s", 1_f64.to_radians()), ("value=x:mbar", 1.0)] {
        let options = options(None, Some(map));
        for bytes in made(["float64 x\nfloat64 y\n", "float64 x # east\nfloat64 y\n"]) {
            let read = read(bytes, &options);
            assert!(read.end.error.is_none(), "{:?}", read.end.error);
            assert_eq!((read.rows.len(), read.report().used, read.report().other_messages), (80, 80, 0));
            let expected = rows().map(|row| if row < 40 { f64::from(row) } else { 0.5 } * scale);
            assert!(read.rows.iter().zip(expected).all(|(row, expected)| (row[0] - expected).abs() < 1e-6));
        }
        for other in ["float64 y\nfloat64 x # swapped\n", "float64 y\nfloat64 z\n"] {
            for bytes in made(["float64 x\nfloat64 y\n", other]) {
                let read = read(bytes, &options);
                assert_eq!(read.rows.len(), 40);
                let error = read.end.error.unwrap().to_string();
                assert!(error.contains("/imu") && error.contains("several definitions of demo/Rates"), "{error}");
            }
        }
    }
}

#[test]
fn more_definitions_than_any_bag_has_are_an_error() {
    let bag = |definitions: &[&str], messages| Bag { type_name: "demo/Rates", definitions, messages }.ros1();
    let messages = (0..80_u8).map(|row| (0, u64::from(row) * 10_000_000, doubles(&[row.into()])));
    let measured = bag(&["float64 x\n"], messages.collect());
    let long = &*"#".repeat(3_900_000);
    let error = |count: usize| {
        // the bytes after the magic bytes
        let behind = &bag(&vec![long; count], Vec::new())[13..];
        let read = read([&measured[..], behind].concat(), &options(None, Some("gyro_x=x:deg/s")));
        assert_eq!(read.rows.len(), 80);
        read.end.error.map(|error| error.to_string())
    };
    assert_eq!(error(4), None);
    let five = error(5).unwrap();
    assert!(five.contains("more topics or definitions than any bag"), "{five}");
}

#[test]
fn numbers_that_are_zero_at_first_are_not_read_and_end_the_record_later() {
    let bag = |zero: u64, gyro: f64| Bag {
        type_name: "sensor_msgs/Imu",
        definitions: &[""],
        messages: (0..200)
            .map(|row| {
                let (at_ns, accel) = (1_000_000_000 + row * 10_000_000, if row < zero { 0.0 } else { 9.8 });
                (0, at_ns, imu(at_ns, [gyro, 0.0, 0.0], [0.0, 0.0, accel]))
            })
            .collect(),
    };
    let no = CaptureOptions::default();
    let never = read(bag(200, 0.01).mcap(), &no);
    assert_eq!((never.names.len(), never.rows.len()), (3, 200));
    let late = read(bag(150, 0.01).ros1(), &no);
    assert_eq!((late.names.len(), late.rows.len()), (3, 151));
    let told = late.end.error.unwrap().to_string();
    assert!(told.starts_with("linear_acceleration was zero") && told.contains("message 151"), "{told}");
    let early = read(bag(99, 0.01).mcap(), &no);
    assert_eq!(early.names.len(), 6);
    // a number that the user names is read, zero or not
    let named = read(bag(150, 0.01).mcap(), &options(None, Some("accel_z=linear_acceleration.z:m/s^2")));
    assert_eq!(named.rows[0][0], 0.0);
    assert!((named.rows[199][0] - 9.8).abs() < 1e-6);
    let Err(refused) = Capture::from_reader(Cursor::new(bag(200, 0.0).mcap()), &no) else { panic!("opened") };
    let text = refused.to_string();
    assert!(text.contains("linear_acceleration, angular_velocity") && text.contains("first 100 messages"), "{text}");
}

#[test]
fn times_may_be_numbers_of_the_messages() {
    const START_NS: u64 = 1_700_000_000_000_000_123;
    const SENTENCE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63";
    let at_ns = |row: u64| START_NS + row * 25_000_000;
    let text = [&(SENTENCE.len() as u32).to_le_bytes()[..], SENTENCE.as_bytes()].concat();
    let messages = (0..60).map(|row| {
        let numbers = [doubles(&[at_ns(row) as f64 / 1e9, 0.01]), at_ns(row).to_le_bytes().to_vec()].concat();
        // the messages were recorded in bursts
        (0, 5_000_000_000 + row / 10 * 250_000_000, [&numbers[..], &time(at_ns(row)), &text].concat())
    });
    let fields = "float64 seconds\nfloat64 x\nuint64 ns\nuint32 sec\nuint32 nsec\nstring line\n";
    let bag = Bag { type_name: "demo/Line", definitions: &[fields], messages: messages.collect() };
    for (map, source, error_ns) in [
        ("t=ns:ns", "ns", 0),
        ("t=sec:s+nsec:ns", "sec + nsec", 0),
        ("t=seconds:s", "seconds", 239),
        ("gyro_x=x:rad/s,t=ns:ns", "ns", 0),
        ("gyro_x=x:rad/s,t=seconds:s", "seconds", 239),
    ] {
        for bytes in [bag.mcap(), bag.ros1()] {
            let read = read(bytes, &options(None, Some(map)));
            assert_eq!((&read.report().stamps, read.rows.len()), (&StampSource::Field(source.into()), 60), "{map}");
            let near = |(row, time_ns): (u64, &i64)| at_ns(row).cast_signed().abs_diff(*time_ns) <= error_ns;
            assert!((0..).zip(&read.times_ns).all(near), "{map}");
        }
    }
    let recorded = read(bag.mcap(), &CaptureOptions::default());
    assert_eq!((&recorded.report().stamps, recorded.times_ns[0]), (&StampSource::Recorded, 5_000_000_000));
    for (map, words) in
        [("t=ns:iso", "s, ms, us or ns"), ("t=line:s", "no time \"line\""), ("t=seconds:s+nope:ns", "no time \"nope\"")]
    {
        let refused = Capture::from_reader(Cursor::new(bag.mcap()), &options(None, Some(map)));
        let text = refused.err().unwrap().to_string();
        assert!(text.contains(words), "{map}: {text}");
    }
}

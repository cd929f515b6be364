//! A replay gives what was recorded: the same inputs, the same samples, up to the last whole read
//! of a file that was cut.

use std::{
    collections::BTreeMap,
    io::{self, Cursor, Read, Write},
};

use bytes::Bytes;
use proptest::prelude::*;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use tokio_util::sync::CancellationToken;
use vn100_capture::{
    Capture, CaptureOptions, Event, Format, OpenError, RecordingEnd, RecordingError, RecordingReader, RecordingWriter,
    Source, read_samples,
};
use vn100_protocol::DeviceError;
use vn100_protocol::stream::{Arrival, Chunk, LinkEvent, LinkEventKind, ReadOptions, StreamCounts, StreamInput};

const LINE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
const START_NS: i64 = 1_700_000_000_000_000_000;

fn read(bytes: &[u8], at_ns: i64) -> StreamInput {
    StreamInput::Chunk(Chunk { bytes: Bytes::copy_from_slice(bytes), at_ns: Some(at_ns) })
}

fn link(at_ns: i64, kind: LinkEventKind) -> StreamInput {
    StreamInput::Link(LinkEvent { at_ns, kind })
}

fn up(at_ns: i64) -> StreamInput {
    link(at_ns, LinkEventKind::Up { port: "/dev/ttyUSB0".into(), baud: Some(115_200) })
}

/// A session of a few lines that were read in pieces, with a break.
fn session() -> Vec<StreamInput> {
    let line = LINE.as_bytes();
    vec![
        link(START_NS, LinkEventKind::DiscardedDuringBaudScan { bytes: 9 }),
        up(START_NS + 1),
        read(&line[..50], START_NS + 2),
        read(&line[50..], START_NS + 3),
        read(&[line, line].concat(), START_NS + 25_000_000),
        read(&line[..7], START_NS + 30_000_000),
        link(START_NS + 30_000_001, LinkEventKind::Down { cause: "unplugged".into() }),
        up(START_NS + 40_000_000),
        link(START_NS + 40_000_001, LinkEventKind::Overrun { bytes: 3 }),
        read(line, START_NS + 50_000_000),
    ]
}

fn recording(inputs: &[StreamInput]) -> Vec<u8> {
    recording_ended(inputs, Some("the test is over"))
}

/// The recording, with a message for each input.
fn recording_ended(inputs: &[StreamInput], reason: Option<&str>) -> Vec<u8> {
    let mut writer = writer();
    for input in inputs {
        writer.write(input).unwrap();
        writer.flush().unwrap();
    }
    writer.finish(reason).unwrap()
}

/// The recording, with one message for reads that came together.
fn coalesced(inputs: &[StreamInput]) -> Vec<u8> {
    let mut writer = writer();
    inputs.iter().for_each(|input| writer.write(input).unwrap());
    writer.finish(Some("the test is over")).unwrap()
}

fn writer() -> RecordingWriter<Vec<u8>> {
    RecordingWriter::new(Vec::new(), &[("axis up".into(), "z".into())].into()).unwrap()
}

fn inputs(file: &[u8]) -> (Vec<StreamInput>, RecordingEnd) {
    let mut reader = RecordingReader::open(file).unwrap();
    let inputs = std::iter::from_fn(|| reader.next_input().unwrap()).collect();
    (inputs, reader.recorded().end.get().unwrap().clone())
}

/// The payloads in sequence.
fn stream(inputs: &[StreamInput]) -> Vec<u8> {
    let bytes = |input: &StreamInput| match input {
        StreamInput::Chunk(chunk) => chunk.bytes.to_vec(),
        StreamInput::Link(_) => Vec::new(),
    };
    inputs.iter().flat_map(bytes).collect()
}

/// Inputs of a list, in sequence.
struct Script(std::vec::IntoIter<StreamInput>);

impl Source for Script {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        Ok(self.0.next())
    }
}

/// The content of the events, without the borders of the batches.
#[derive(Debug, Default, PartialEq)]
struct Told {
    rows: Vec<Vec<i32>>,
    arrivals: Vec<Arrival>,
    marks: Vec<(usize, String)>,
    /// Link events, each with the number of rows before it.
    events: Vec<(usize, LinkEvent)>,
    counts: StreamCounts,
    error: Option<String>,
}

async fn told(mut events: tokio::sync::mpsc::Receiver<Event>) -> Told {
    let mut told = Told::default();
    while let Some(event) = events.recv().await {
        match event {
            Event::Batch(batch) => {
                let before = told.rows.len();
                for arrival in &batch.arrivals {
                    if told.arrivals.last().is_none_or(|last| last.at_ns != arrival.at_ns) {
                        told.arrivals.push(Arrival { from_row: before + arrival.from_row, ..*arrival });
                    }
                }
                told.marks
                    .extend(batch.marks.iter().map(|mark| (before + mark.before_row, format!("{:?}", mark.kind))));
                told.rows.extend(batch.rows().map(<[i32]>::to_vec));
                told.counts = batch.link;
            }
            Event::Link(event) => told.events.push((told.rows.len(), event)),
            Event::End(end) => told.error = end.error.map(|error| error.to_string()),
        }
    }
    told
}

async fn replayed(file: Vec<u8>) -> Told {
    let capture = Capture::from_reader(Cursor::new(file), &CaptureOptions::default()).unwrap();
    assert_eq!(capture.format, Format::Mcap);
    told(capture.read(ReadOptions::default(), CancellationToken::new()).unwrap()).await
}

async fn measured(inputs: Vec<StreamInput>) -> Told {
    told(read_samples(Script(inputs.into_iter()), ReadOptions::default(), CancellationToken::new())).await
}

#[tokio::test]
async fn a_replay_equals_the_measurement() {
    let live = measured(session()).await;
    assert_eq!((live.rows.len(), live.events.len(), live.counts.connects), (4, 5, 2));
    assert_eq!(replayed(recording(&session())).await, live);
    assert_eq!(replayed(coalesced(&session())).await, live);
}

#[tokio::test]
async fn reads_that_came_together_are_lost_together_by_a_cut() {
    let session = session();
    let file = coalesced(&session);
    assert!(file.len() < recording(&session).len());
    let mut lengths = Vec::new();
    for cut in 8..file.len() {
        let (left, end) = inputs(&file[..cut]);
        assert_eq!(left, session[..left.len()], "cut at {cut}");
        assert!(!end.complete || left.len() == session.len(), "cut at {cut}");
        lengths.push(left.len());
    }
    lengths.dedup();
    assert_eq!(lengths, [0, 1, 2, 6, 7, 8, 9, 10]);
}

#[test]
fn at_800_packets_a_second_the_file_has_little_more_than_their_bytes() {
    let mut writer = writer();
    // an adapter delivers 62 bytes every 1.76 ms
    let reads = 20_000;
    for number in 0..reads {
        writer.write(&read(&[0xFA; 62], START_NS + number * 1_761_363 + number % 7 * 31_000)).unwrap();
    }
    let file = writer.finish(None).unwrap();
    let ratio = file.len() as f64 / (62 * reads) as f64;
    assert!(ratio < 1.12, "{ratio}");
}

#[test]
fn a_recording_contains_its_metadata() {
    let file = recording(&session());
    let mut reader = RecordingReader::open(&file[..]).unwrap();
    let recorded = reader.recorded().clone();
    assert_eq!(recorded.started_ns, Some(START_NS));
    assert_eq!(recorded.program.as_deref(), Some(concat!("vn100 ", env!("CARGO_PKG_VERSION"))));
    assert_eq!(recorded.metadata, [("axis up".into(), "z".into())].into());
    assert_eq!(recorded.end.get(), None, "not yet read");
    while reader.next_input().unwrap().is_some() {}
    let reason = Some("the test is over".into());
    let end = RecordingEnd { ended_ns: Some(START_NS + 50_000_000), complete: true, reason };
    assert_eq!(recorded.end.get(), Some(&end));
}

#[tokio::test]
async fn a_cut_anywhere_leaves_all_up_to_the_last_whole_read() {
    let session = session();
    let file = recording(&session);
    // after the record of each input comes the end of a recording, which differs from the bytes of this file
    let ends_at = |count: usize| {
        let ended = recording_ended(&session[..count], None);
        ended.iter().zip(&file).take_while(|(a, b)| a == b).count()
    };
    let ends: Vec<usize> = (1..=session.len()).map(ends_at).collect();
    for cut in 0..file.len() {
        if cut < 8 {
            // not even the magic number: no format to detect, and no sample lost
            if let Ok(capture) = Capture::from_reader(Cursor::new(file[..cut].to_vec()), &CaptureOptions::default()) {
                let told = told(capture.read(ReadOptions::default(), CancellationToken::new()).unwrap()).await;
                assert_eq!((told.rows.len(), told.error), (0, None), "cut at {cut}");
            }
            continue;
        }
        let (left, end) = inputs(&file[..cut]);
        let whole = ends.iter().filter(|end| **end <= cut).count();
        assert_eq!(left, session[..whole], "cut at {cut}");
        assert!(!end.complete || whole == session.len(), "cut at {cut}");
        let told = replayed(file[..cut].to_vec()).await;
        assert_eq!(told.error, None, "cut at {cut}");
        assert_eq!(told, measured(left).await, "cut at {cut}");
    }
}

#[tokio::test]
async fn zeros_after_the_last_record_are_a_cut() {
    let mut file = recording_ended(&session()[..4], None);
    let whole = recording(&session());
    file.truncate(file.iter().zip(&whole).take_while(|(a, b)| a == b).count());
    file.resize(file.len() + 4096, 0);
    let (left, end) = inputs(&file);
    assert_eq!((&left[..], end.complete, end.reason), (&session()[..4], false, None));
}

#[test]
fn the_payloads_are_the_stream_for_any_reader() {
    let file = recording(&session());
    let messages = mcap::MessageStream::new(&file).unwrap().map(Result::unwrap);
    let payloads = messages.filter(|message| message.channel.topic == "/vn100/bytes");
    let extracted: Vec<u8> = payloads.flat_map(|message| message.data.to_vec()).collect();
    assert_eq!(extracted, stream(&session()));
}

const COMPRESSIONS: [Option<&str>; 3] = [None, Some("lz4"), Some("zstd")];

/// The session as other tools write it: in chunks.
fn repacked(compression: Option<&str>, chunk_bytes: u64, crcs: bool) -> Vec<u8> {
    let options = mcap::WriteOptions::new().compression(None).chunk_size(Some(chunk_bytes));
    let mut repacked = options.calculate_chunk_crcs(crcs).create(Cursor::new(Vec::new())).unwrap();
    for message in mcap::MessageStream::new(&recording(&session())).unwrap() {
        repacked.write(&message.unwrap()).unwrap();
    }
    repacked.finish().unwrap();
    let file = repacked.into_inner().into_inner();
    compression.map_or_else(|| file.clone(), |name| compressed(&file, name))
}

/// The session with the records of each chunk compressed.
fn compressed(file: &[u8], name: &str) -> Vec<u8> {
    const UNCOMPRESSED: [u8; 4] = [0; 4];
    let (magic, mut rest) = file.split_at(mcap::MAGIC.len());
    let mut packed = magic.to_vec();
    // kind and length
    while let Some((head, behind)) = rest.split_first_chunk::<9>() {
        let length = u64::from_le_bytes(head[1..].try_into().unwrap());
        let (data, behind) = behind.split_at(length as usize);
        rest = behind;
        let data = match head[0] {
            mcap::records::op::CHUNK => {
                let (sums, records) = (&data[..28], &data[28 + UNCOMPRESSED.len() + 8..]);
                let records = match name {
                    "lz4" => {
                        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
                        encoder.write_all(records).unwrap();
                        encoder.finish().unwrap()
                    }
                    _ => compress_to_vec(records, CompressionLevel::Fastest),
                };
                let name = [&(name.len() as u32).to_le_bytes()[..], name.as_bytes()].concat();
                [sums, &name, &(records.len() as u64).to_le_bytes(), &records].concat()
            }
            _ => data.to_vec(),
        };
        packed.push(head[0]);
        packed.extend((data.len() as u64).to_le_bytes());
        packed.extend(data);
    }
    packed.extend(rest);
    packed
}

/// The inputs up to an error, and its text.
fn inputs_to_error(file: &[u8]) -> (Vec<StreamInput>, Option<String>) {
    let (mut reader, mut inputs) = (RecordingReader::open(file).unwrap(), Vec::new());
    loop {
        match reader.next_input() {
            Ok(Some(input)) => inputs.push(input),
            Ok(None) => return (inputs, None),
            Err(error) => return (inputs, Some(error.to_string())),
        }
    }
}

#[test]
fn recordings_compressed_by_other_tools_are_read() {
    for compression in COMPRESSIONS {
        let repacked = repacked(compression, 300, true);
        assert_eq!(inputs(&repacked).0, session(), "{compression:?}");
        for cut in 8..repacked.len() {
            let left = inputs(&repacked[..cut]).0;
            assert_eq!(left, session()[..left.len()], "{compression:?} cut at {cut}");
        }
    }
}

#[test]
fn a_cut_chunk_gives_its_whole_records() {
    for compression in COMPRESSIONS {
        // one chunk only, after a head without messages
        let repacked = repacked(compression, 1 << 20, true);
        let mut most = 0;
        for cut in 8..repacked.len() {
            let (left, end) = inputs(&repacked[..cut]);
            assert_eq!(left, session()[..left.len()], "{compression:?} cut at {cut}");
            if left.len() < session().len() {
                assert!(!end.complete, "{compression:?} cut at {cut}");
                most = most.max(left.len());
            }
        }
        // compressed content comes in blocks, here one for all
        assert!(most == session().len() - 1 || compression.is_some(), "{compression:?}: {most}");
    }
}

#[test]
fn a_record_longer_than_its_chunk_is_damage() {
    let mut file = repacked(None, 300, false);
    let data_at = file.windows(50).position(|window| window == &LINE.as_bytes()[..50]).unwrap();
    // kind, length; then channel, number and two times
    let length_at = data_at - 22 - 8;
    for length in [5000_u64, 1 << 40, u64::MAX] {
        file[length_at..length_at + 8].copy_from_slice(&length.to_le_bytes());
        let (left, error) = inputs_to_error(&file);
        assert_eq!(left, session()[..2]);
        let error = error.unwrap();
        assert!(error.contains(&format!("a record of {length} bytes")), "{error}");
    }
}

#[test]
fn a_wrong_checksum_of_a_chunk_is_damage() {
    let whole = repacked(None, 300, true);
    let mut file = whole.clone();
    let at = file.windows(9).position(|window| window == b"unplugged").unwrap();
    file[at] = b'U';
    let (left, error) = inputs_to_error(&file);
    assert!(!left.is_empty() && left == session()[..left.len()], "{}", left.len());
    let error = error.unwrap();
    assert!(error.contains("checksum 0x") && error.contains("and not 0x"), "{error}");
    // without a checksum the damage cannot be detected
    let mut file = repacked(None, 300, false);
    file[at] = b'U';
    assert_eq!(inputs_to_error(&file).1, None);
}

#[test]
fn a_second_file_after_the_end_is_not_lost_in_silence() {
    for file in [recording(&session()), repacked(Some("zstd"), 300, true)] {
        let (read, error) = inputs_to_error(&[&file[..], &file].concat());
        assert_eq!(read, session());
        assert!(error.is_some_and(|error| error.contains("another MCAP file follows the end of this one")));
        // anything else after the end is not of this file
        let (read, error) = inputs_to_error(&[&file[..], &[0; 4096]].concat());
        assert_eq!((read, error), (session(), None));
    }
}

#[test]
fn another_programs_file_is_refused_by_its_topics() {
    let mut other = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    for topic in ["/imu/data", "/tf"] {
        other.add_channel(0, topic, "cdr", &BTreeMap::new()).unwrap();
    }
    other.finish().unwrap();
    let opened = Capture::from_reader(Cursor::new(other.into_inner().into_inner()), &CaptureOptions::default());
    let Some(error) = opened.err() else { panic!("opened") };
    assert!(matches!(&error, OpenError::Unusable { .. }));
    let text = error.to_string();
    assert!(text.contains("without a message") && text.contains("/imu/data") && text.contains("/tf"), "{text}");
}

#[test]
fn an_endless_file_of_another_program_is_not_searched_forever() {
    // a message of 1 MiB on an undefined channel
    let length = (1_u64 << 20).to_le_bytes();
    let message = [&[5][..], &length, &[0; 1 << 20]].concat();
    let reader = mcap::MAGIC.chain(Endless { record: &message, at: 0 });
    assert!(matches!(RecordingReader::open(reader), Err(RecordingError::Foreign(topics)) if topics.is_empty()));
}

#[test]
fn a_later_form_is_refused_by_its_name() {
    let file = recording(&session());
    let at = file.windows(6).position(|text| text == b"format").unwrap() + 10;
    let form = |digit: &[u8]| [&file[..at], digit, &file[at + 1..]].concat();
    assert!(matches!(RecordingReader::open(&form(b"3")[..]), Err(RecordingError::Format(found)) if found == "3"));
    assert_eq!(inputs(&form(b"1")).0, session(), "an older form");
}

fn any_input() -> impl Strategy<Value = StreamInput> {
    let bytes = prop::collection::vec(any::<u8>(), 1..300);
    prop_oneof![
        8 => (bytes, prop_oneof![any::<Option<i64>>(), (0_i64..200_000_000).prop_map(Some)]).prop_map(|(bytes, at_ns)| Chunk { bytes: bytes.into(), at_ns }.into()),
        1 => (any::<i64>(), any::<String>(), any::<Option<u32>>())
            .prop_map(|(at_ns, port, baud)| link(at_ns, LinkEventKind::Up { port, baud })),
        1 => (any::<i64>(), any::<String>()).prop_map(|(at_ns, cause)| link(at_ns, LinkEventKind::Down { cause })),
        1 => (any::<i64>(), any::<u64>()).prop_map(|(at_ns, bytes)| link(at_ns, LinkEventKind::DiscardedDuringBaudScan { bytes })),
        1 => (any::<i64>(), any::<u64>()).prop_map(|(at_ns, bytes)| link(at_ns, LinkEventKind::Overrun { bytes })),
        1 => (any::<i64>(), any::<u8>())
            .prop_map(|(at_ns, code)| link(at_ns, LinkEventKind::UnsolicitedError { error: DeviceError::from_code(code) })),
    ]
}

/// Returns a record repeatedly.
struct Endless<'a> {
    record: &'a [u8],
    at: usize,
}

impl Read for Endless<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = (&self.record[self.at..]).read(buffer)?;
        self.at = (self.at + read) % self.record.len();
        Ok(read)
    }
}

/// Returns a few bytes at a time.
struct Dribble<'a>(&'a [u8], usize);

impl Read for Dribble<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = self.1.min(buffer.len());
        self.0.read(&mut buffer[..most])
    }
}

proptest! {
    #[test]
    fn written_inputs_are_read(session in prop::collection::vec(any_input(), 0..30), piece in 1..5000_usize) {
        let file = coalesced(&session);
        let mut reader = RecordingReader::open(Dribble(&file, piece)).unwrap();
        let read: Vec<StreamInput> = std::iter::from_fn(|| reader.next_input().unwrap()).collect();
        prop_assert_eq!(read, session);
        prop_assert!(reader.recorded().end.get().unwrap().complete);
    }

    #[test]
    fn damage_ends_a_reading_and_nothing_else(at in any::<prop::sample::Index>(), flip in 1..=255_u8) {
        let mut file = coalesced(&session());
        *at.get_mut(&mut file) ^= flip;
        if let Ok(mut reader) = RecordingReader::open(&file[..]) {
            // it ends, because no input is shorter than its record
            let read = std::iter::from_fn(|| reader.next_input().ok().flatten()).count();
            prop_assert!(read <= session().len());
        }
    }
}

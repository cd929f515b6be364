//! A stream read in pieces of any size gives the same samples, marks and counts.

use std::io;

use bytes::Bytes;
use proptest::prelude::*;
use tokio_util::sync::CancellationToken;
use vn100_capture::{Event, Source, read_samples};
use vn100_protocol::stream::{
    Arrival, Chunk, LinkEvent, LinkEventKind, MarkKind, ReadOptions, StreamCounts, StreamInput,
};
use vn100_protocol::{VNIMU, xor8};

const YMR: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
const YMR_OLD: &str =
    "$VNYMR,-170.94,+007.34,+000.70,-1.7866,+0.1747,+2.2113,-00.085,+00.005,-09.847,+00.0003,-00.0012,-00.0001*61\r\n";
const IMU: &str =
    "$VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66\r\n";
const YPR: &str = "$VNYPR,-129.867,-000.355,-000.296*61\r\n";
const REPLY: &str = "$VNRRG,01,VN-100S-CR*35\r\n";
const DAMAGED: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*64\r\n";

/// Returns given inputs, then a given end.
struct Script {
    inputs: std::vec::IntoIter<StreamInput>,
    error: Option<io::Error>,
}

impl Script {
    fn new(bytes: &[u8], piece: usize) -> Self {
        Self::of(bytes.chunks(piece).map(chunk).collect())
    }

    fn of(inputs: Vec<StreamInput>) -> Self {
        Self { inputs: inputs.into_iter(), error: None }
    }
}

impl Source for Script {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        match self.inputs.next() {
            Some(input) => Ok(Some(input)),
            None => self.error.take().map_or(Ok(None), Err),
        }
    }
}

fn chunk(bytes: &[u8]) -> StreamInput {
    StreamInput::Chunk(Chunk { bytes: Bytes::copy_from_slice(bytes), at_ns: Some(7_000_000) })
}

fn link(kind: LinkEventKind) -> StreamInput {
    StreamInput::Link(LinkEvent { at_ns: 7_000_000, kind })
}

/// The content of a stream, without the borders of its batches.
#[derive(Debug, Default, PartialEq)]
struct Told {
    rows: Vec<Vec<i32>>,
    /// Marks, by the number of the row after them.
    marks: Vec<(usize, MarkKind)>,
    registers: Vec<(u8, String)>,
    counters: Vec<(usize, u64)>,
    link: StreamCounts,
    /// Link events, by the number of the row after them.
    link_events: Vec<(usize, LinkEventKind)>,
    error: Option<String>,
}

async fn told(source: Script, options: ReadOptions) -> Told {
    let mut events = read_samples(source, options, CancellationToken::new());
    let mut told = Told::default();
    while let Some(event) = events.recv().await {
        match event {
            Event::Batch(batch) => {
                told.marks.extend(batch.marks.iter().map(|mark| (told.rows.len() + mark.before_row, mark.kind)));
                told.registers.extend(batch.registers.iter().map(|r| (r.register.0, r.fields.to_string())));
                told.counters.extend(batch.counters.iter().map(|c| (told.rows.len() + c.row, c.count)));
                told.rows.extend(batch.rows().map(<[i32]>::to_vec));
                told.link = batch.link;
            }
            Event::Link(event) => told.link_events.push((told.rows.len(), event.kind)),
            Event::End(end) => told.error = end.error.map(|error| error.to_string()),
        }
    }
    told
}

fn block_on<T>(future: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(future)
}

#[test]
fn samples_replies_other_messages_and_bad_lines_are_distinguished() {
    let bytes = [YMR, DAMAGED, REPLY, YMR, YPR, IMU, YMR_OLD, "$VNYM"].concat();
    let told = block_on(told(Script::new(bytes.as_bytes(), 1000), ReadOptions::default()));
    assert_eq!(told.rows.len(), 3);
    assert_eq!(told.rows[2][..3], [-170_940, 7_340, 700], "old decimals, scaled to the layout");
    let kinds: Vec<_> = told.marks.iter().map(|(row, kind)| (*row, matches!(kind, MarkKind::Rejected))).collect();
    assert_eq!(kinds, [(0, false), (1, true), (2, false), (3, true)]);
    assert_eq!((told.link.samples(), told.link.tally.replies, told.link.other_messages()), (3, 1, 2));
    assert_eq!(told.registers, [(1, "VN-100S-CR".to_owned())]);
    assert_eq!(told.link.other_message.unwrap().to_string(), "VNYPR");
    assert_eq!(told.link.tally.bytes(), bytes.len() as u64);
    assert_eq!(
        told.link.tally.valid_sentences(),
        told.link.samples() + told.link.tally.replies + told.link.other_messages()
    );
}

/// The line with a counter after its numbers.
fn with_counter(line: &str, count: u64) -> String {
    let body = format!("{},T{count}", line.trim_start_matches('$').split_once('*').unwrap().0);
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

#[test]
fn counters_go_with_their_rows() {
    let bytes = [with_counter(YMR, 41), YMR.into(), with_counter(YMR, 43), with_counter(IMU, 44)].concat();
    for line_by_line in [false, true] {
        let options = ReadOptions { line_by_line, ..ReadOptions::default() };
        assert_eq!(block_on(told(Script::new(bytes.as_bytes(), 50), options)).counters, [(0, 41), (2, 43)]);
    }
}

#[test]
fn the_first_measurement_decides_the_message() {
    let bytes = [IMU, YMR, IMU].concat();
    block_on(async {
        let mut events =
            read_samples(Script::new(bytes.as_bytes(), 1000), ReadOptions::default(), CancellationToken::new());
        let Some(Event::Batch(batch)) = events.recv().await else { panic!("no batch") };
        assert_eq!(batch.layout.as_deref(), Some(&VNIMU));
        assert_eq!(batch.rows().len(), 2);
        assert_eq!(batch.arrivals, [Arrival { from_row: 0, at_ns: 7_000_000 }]);
        assert_eq!(batch.link.foreign_samples, 1);
    });
}

#[test]
fn an_error_ends_the_stream_and_keeps_what_came_before() {
    let bytes = [YMR, "$VNYMR,-0"].concat();
    let mut script = Script::new(bytes.as_bytes(), 1000);
    script.error = Some(io::Error::other("unplugged"));
    let told = block_on(told(script, ReadOptions::default()));
    assert_eq!(told.rows.len(), 1);
    assert_eq!(told.link.tally.rejected.truncated, 1);
    assert_eq!(told.error.as_deref(), Some("unplugged"));
}

#[test]
fn a_lost_link_cuts_the_incomplete_line() {
    let up = || LinkEventKind::Up { port: "/dev/ttyUSB0".into(), baud: Some(115_200) };
    let down = || LinkEventKind::Down { cause: "unplugged".into() };
    let (head, tail) = YMR.as_bytes().split_at(50);
    let inputs = vec![
        link(LinkEventKind::DiscardedDuringBaudScan { bytes: 31 }),
        link(up()),
        chunk(YMR.as_bytes()),
        chunk(head),
        link(down()),
        link(up()),
        // the rest of another line is never joined to the head of the line before
        chunk(tail),
        link(LinkEventKind::Overrun { bytes: 62 }),
        chunk(YMR.as_bytes()),
    ];
    for line_by_line in [false, true] {
        let options = ReadOptions { line_by_line, ..ReadOptions::default() };
        let told = block_on(told(Script::of(inputs.clone()), options));
        assert_eq!(told.rows.len(), 2);
        let places: Vec<_> = told.link_events.iter().map(|(row, _)| *row).collect();
        assert_eq!(places, [0, 0, 1, 1, 1]);
        assert_eq!((told.link.connects, told.link.baud_scan_bytes, told.link.overrun_bytes), (2, 31, 62));
        assert_eq!(told.link.tally.rejected.truncated, 1);
        assert_eq!(told.link.tally.bytes(), 3 * YMR.len() as u64);
    }
}

#[test]
fn stop_ends_the_stream_with_an_end() {
    block_on(async {
        let stop = CancellationToken::new();
        stop.cancel();
        let mut events = read_samples(Script::new(YMR.as_bytes(), 1000), ReadOptions::default(), stop);
        let Some(Event::Batch(batch)) = events.recv().await else { panic!("no batch") };
        assert_eq!(batch.rows().len(), 0);
        assert!(matches!(events.recv().await, Some(Event::End(_))));
        assert!(events.recv().await.is_none());
    });
}

#[test]
fn line_by_line_gives_each_row_its_own_counts() {
    let bytes = [YMR, YMR, DAMAGED, YMR].concat();
    for piece in [1, 60, 121, 1000] {
        let options = ReadOptions { line_by_line: true, ..ReadOptions::default() };
        let seen = block_on(async {
            let mut events = read_samples(Script::new(bytes.as_bytes(), piece), options, CancellationToken::new());
            let (mut seen, mut marks) = (Vec::new(), 0);
            while let Some(event) = events.recv().await {
                let Event::Batch(batch) = event else { continue };
                let mut lines = batch.lines();
                while let Some(line) = lines.next_line() {
                    marks += line.marks.len();
                    if line.row_count() > 0 {
                        let tally = line.link.tally;
                        seen.push((line.row_count(), tally.bytes(), tally.rejected.total(), marks));
                    }
                }
            }
            seen
        });
        // a cut through the check digits; the line end comes with the next batch, and the first row shows the print
        // format
        assert_eq!(seen, [(1, 120, 0, 1), (1, 242, 0, 1), (1, 486, 1, 2)], "pieces of {piece}");
    }
}

fn pieces_of_a_stream() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        8 => Just(YMR.as_bytes().to_vec()),
        2 => any::<u64>().prop_map(|count| with_counter(YMR, count).into_bytes()),
        1 => Just(YMR_OLD.as_bytes().to_vec()),
        1 => Just(IMU.as_bytes().to_vec()),
        1 => Just(YPR.as_bytes().to_vec()),
        1 => Just(REPLY.as_bytes().to_vec()),
        1 => Just(DAMAGED.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..40),
        1 => (1..121_usize).prop_map(|length| YMR.as_bytes()[..length].to_vec()),
    ];
    prop::collection::vec(piece, 0..30).prop_map(|pieces| pieces.concat())
}

proptest! {
    #[test]
    fn any_chunking_gives_the_same(bytes in pieces_of_a_stream(), piece in 1..400_usize, line_by_line: bool) {
        let options = ReadOptions { line_by_line, ..ReadOptions::default() };
        let whole = block_on(told(Script::new(&bytes, bytes.len().max(1)), ReadOptions::default()));
        prop_assert_eq!(whole.link.tally.bytes(), bytes.len() as u64);
        prop_assert_eq!(&block_on(told(Script::new(&bytes, piece), options)), &whole);
    }
}

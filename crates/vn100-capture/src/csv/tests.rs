//! Whole files through [`detect`] and [`CsvReader`].

use std::io::{Cursor, Read};

use vn100_protocol::{Decoder, Item, Options, VNYMR};

use vn100_protocol::stream::{
    AbsentValues, Batch, CsvReport, FileReport, MarkKind, ReadOptions, RejectedRow, RejectedRows,
};

use super::*;
use crate::read_samples::{Event, FileReader};

mod forms;
mod mapped;
mod printed_counts;
mod sentences;
mod streams;
mod times;
mod values;

/// A line of the sensor's manual.
const SENTENCE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63";
/// The fields of this line.
const VALUES: &str =
    "-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391";
/// The counts of these fields.
const COUNTS: [i32; 12] = [-85_469, 74_972, 63_752, -5_551, 4_403, 9_048, 8_971, -2_145, -1_093, 40, -301, -391];
/// The names of these fields, after a stamp.
const HEADER: &str = "t,yaw,pitch,roll,mag_x,mag_y,mag_z,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z";

/// The complete content of a file.
#[derive(Debug, Default, PartialEq)]
struct Whole {
    counts: Vec<i32>,
    stamps_ns: Vec<i64>,
    device_ns: Vec<u64>,
    /// The number of good rows before each rejected row.
    rejected: Vec<usize>,
    report: CsvReport,
    /// Bytes of rows, of rejected rows, and of lines that are no rows.
    bytes: [u64; 3],
    /// Why it ended before the end of the file.
    error: Option<String>,
}

impl Whole {
    /// The rejected rows for all reasons.
    fn rejected_rows(&self) -> u64 {
        self.report.rejected.iter().map(|rows| rows.count).sum()
    }
}

fn plan(text: impl AsRef<[u8]>, map: Option<&str>) -> Result<Option<CsvPlan>, Unusable> {
    let map = map.map(|map| map.parse().unwrap());
    detect(text.as_ref(), Said { map: map.as_ref(), ..Said::default() })
}

/// The layout, without the columns.
fn layout(plan: &CsvPlan) -> Layout {
    Layout { columns: None, ..Layout::clone(plan.layout.as_ref().unwrap()) }
}

fn rounded(plan: &CsvPlan) -> Vec<String> {
    plan.report.rounded.clone()
}

/// The plan of a file that has one.
fn planned(text: impl AsRef<[u8]>, map: Option<&str>) -> CsvPlan {
    plan(text, map).unwrap().unwrap()
}

/// Reads a file to its end.
fn read(plan: CsvPlan, bytes: impl AsRef<[u8]>) -> Whole {
    let whole = read_all(plan, Cursor::new(bytes.as_ref().to_vec()));
    assert_eq!(whole.error, None);
    whole
}

/// Reads a file as far as it can be read.
fn read_all(plan: CsvPlan, reader: impl Read + Send + 'static) -> Whole {
    let mut reader = CsvReader::new(plan, reader, ReadOptions { accept_unchecked: true, ..ReadOptions::default() });
    let mut whole = Whole::default();
    let mut rows = 0;
    let mut take = |batch: &Batch| {
        let rejected = batch.marks.iter().filter(|mark| mark.kind == MarkKind::Rejected);
        whole.rejected.extend(rejected.map(|mark| rows + mark.before_row));
        rows += batch.row_count();
        whole.counts.extend(&batch.counts);
        let stamp = |row: usize| batch.arrivals.iter().rfind(|arrival| arrival.from_row <= row);
        whole.stamps_ns.extend((0..batch.row_count()).filter_map(stamp).map(|arrival| arrival.at_ns));
        whole.device_ns.extend(&batch.device_ns);
        let tally = &batch.link.tally;
        whole.bytes = [tally.valid_sentence_bytes, tally.rejected_sentence_bytes, tally.skipped_bytes];
    };
    loop {
        match reader.next_events() {
            Ok(Some(events)) => {
                for event in events {
                    let Event::Batch(batch) = event else { panic!("{event:?}") };
                    take(&batch);
                }
            }
            Ok(None) => break,
            Err(error) => {
                whole.error = Some(error.to_string());
                break;
            }
        }
    }
    let (batches, report) = reader.finish();
    batches.iter().for_each(&mut take);
    let Some(FileReport::Csv(report)) = report else { panic!("{report:?}") };
    whole.report = report;
    let others = whole.report.other_stream_rows.unwrap_or_default();
    assert_eq!(whole.report.lines, whole.report.rows + whole.rejected_rows() + whole.report.skipped_lines + others);
    whole
}

fn read_text(text: impl AsRef<[u8]>, map: Option<&str>) -> Whole {
    read(planned(&text, map), text)
}

fn samples(bytes: &[u8], options: Options) -> Vec<i32> {
    let mut counts = Vec::new();
    let mut decoder = Decoder::new(options);
    let mut take = |item: Item<'_>| {
        if let Item::Sample(sample) = item {
            counts.extend_from_slice(sample.counts());
        }
    };
    decoder.push(bytes, &mut take);
    decoder.finish(&mut take);
    counts
}

#[test]
fn the_parsed_captures_equal_their_sentences() {
    let folder = std::env::var_os("VN100_CAPTURES").filter(|folder| std::path::Path::new(folder).is_dir());
    let Some(folder) = folder else {
        println!("skipped: no captures, VN100_CAPTURES names no folder of them");
        return;
    };
    let mut checked = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension() != Some("csv".as_ref()) {
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        let plan = detect(&bytes[..bytes.len().min(HEAD_BYTES)], Said::default()).unwrap().unwrap();
        assert_eq!(layout(&plan), Layout { compensated: None, ..VNYMR.clone() }, "{}", path.display());
        let whole = read(plan, bytes);
        let sentences = std::fs::read(path.with_extension("vnymr")).unwrap();
        let expected = samples(&sentences, Options { accept_unchecked: true });
        println!(
            "{:50} {:6} rows {:3} rejected, last stamp {} ns",
            path.file_name().unwrap().display(),
            whole.report.rows,
            whole.rejected_rows(),
            whole.stamps_ns.last().unwrap()
        );
        assert!(whole.counts == expected, "{}", path.display());
        checked += 1;
    }
    assert!(checked > 0, "no .csv in VN100_CAPTURES");
}

//! Captures in CSV, as laboratory scripts write them: detected by their content, and read exactly.
//!
//! There are three kinds: the fields of the sensor's sentences in columns of known names; whole
//! sentences in one column, with a stamp in another; and the numbers of any inertial sensor, in
//! columns and units that a [`ColumnMap`] names. Numbers become counts of their last digit without
//! passing through a float, stamps become nanoseconds, and a malformed row is counted with its
//! reason.

mod channels;
mod column_map;
mod columns;
mod dialect;
mod fields;
mod head;
mod header;
mod lines;
mod name;
mod number;
mod resolution;
mod rows;
mod sentence_rows;
mod stamp;
mod streams;
mod suggestion;
#[cfg(test)]
mod tests;
mod time_columns;
mod unit;

use std::sync::Arc;

use vn100_protocol::{Layout, stream::CsvReport};

use self::{dialect::Dialect, fields::RowEnd, number::Number, stamp::StampForm};
use crate::open_error::{OpenHint, Unusable};
pub(crate) use channels::{known, names, quantity_word};
pub use column_map::{ColumnMap, ColumnMapError};
pub(crate) use columns::Column;
pub(crate) use head::detect;
pub(crate) use resolution::Quantizer;
pub(crate) use rows::CsvReader;
pub(crate) use sentence_rows::checked_part;
pub(crate) use unit::{Unit, units};

/// Number of rows that are examined in the head of a file.
const HEAD_ROWS: usize = 1000;

/// Bytes of a file that are examined: a thousand rows of up to 260 bytes.
pub(crate) const HEAD_BYTES: usize = 256 * 1024;

/// The byte order mark that some programs write before the first line.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// The way to read a CSV file, as determined from its head.
#[derive(Debug, Clone, Default)]
pub(crate) struct CsvPlan {
    /// The layout of the rows in their counts; `None` for sentences. If the channels are exactly those
    /// of a message, it has its name, else `CSV`.
    layout: Option<Arc<Layout>>,
    /// The names of all columns; empty in a file without a header.
    names: Vec<String>,
    /// LF, which may follow a CR; or CR, as on old Macs.
    line_end: u8,
    dialect: Dialect,
    columns: Vec<ColumnUse>,
    /// A row of numbers has this many fields at least.
    fewest_fields: usize,
    /// The conversion of the column of each channel of the layout to counts.
    quantizers: Vec<Quantizer>,
    /// `None` for sentences, and if no row has a line end.
    row_end: Option<RowEnd>,
    /// Whether a row is a stamp and a sentence, with any signs between them.
    has_prefix_stamps: bool,
    /// Lines before the first row.
    lines_above: u64,
    /// The names of the streams of different rates; empty if all columns are one stream, as in a
    /// table without times and so without a known rate, or with the fields of a message of the sensor.
    pub(crate) streams: Vec<String>,
    /// The facts that are known before the first row.
    pub(crate) report: CsvReport,
}

impl CsvPlan {
    /// Whether the rows are numbers, not sentences.
    pub(crate) fn holds_values(&self) -> bool {
        self.layout.is_some()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ColumnUse {
    Ignored,
    /// The stamp, or a part that is added to it, such as nanoseconds in a second column.
    Stamp(StampForm),
    /// The sensor's time in nanoseconds; it restarts with the sensor.
    DeviceTime,
    /// The channel at this place of the layout.
    Channel(usize),
    /// A channel that belongs to another stream.
    OtherStream,
    Sentence,
}

/// The information about a table besides its bytes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Said<'a> {
    /// The columns that the user names; `None` to recognise them by their names.
    pub(crate) map: Option<&'a ColumnMap>,
    /// The channels that are read, as written in names of streams; `None` for all.
    pub(crate) stream: Option<&'a str>,
    /// The name of the file, which may tell the quantity of columns named only by an axis; `None`
    /// for a stream.
    pub(crate) file: Option<&'a str>,
}

/// The fields of one of the first rows.
type HeadRow = Vec<Vec<u8>>;
type HeadRows = [HeadRow];

/// The numbers of a column in the first rows.
fn numbers_at(rows: &HeadRows, place: usize) -> impl Iterator<Item = Number> {
    rows.iter().filter_map(move |row| Number::parse(row.get(place)?))
}

fn holds_number(row: &HeadRow, place: usize) -> bool {
    row.get(place).is_some_and(|cell| Number::parse(cell).is_some())
}

/// A map gives one column to two channels.
fn same_column(column: &str, one: &str, other: &str) -> Unusable {
    Unusable::new(format!("column {column:?} is mapped to both {one} and {other}: give each its own"))
}

/// Whether the day or the month comes first cannot be inferred from the dates. A column map names
/// the column by `argument`.
fn date_order(column: &str, argument: &str) -> Unusable {
    let reason = format!("the dates in column {column:?} may begin with the day or with the month");
    Unusable::certain(reason).with_hint(OpenHint::DateOrder(format!("t={argument}:dmy")))
}

/// The beginning of `text`, without control characters; read as Latin-1 if it is not UTF-8.
fn shown(text: &[u8]) -> String {
    const SHOWN_BYTES: usize = 160;
    let head = &text[..text.len().min(SHOWN_BYTES)];
    let decoded = match str::from_utf8(text) {
        Ok(_) => String::from_utf8_lossy(head),
        Err(_) => encoding_rs::mem::decode_latin1(head),
    };
    let mut shown = decoded.replace('\t', " ");
    shown.retain(|c| !c.is_control());
    if head.len() < text.len() {
        shown.push('…');
    }
    shown
}

//! Captures in CSV, as laboratory scripts write them: detected by their content, and read exactly.
//!
//! There are three kinds: the fields of the sensor's sentences in columns of known names; whole
//! sentences in one column, with a stamp in another; and the numbers of any inertial sensor, in
//! columns and units that a [`ColumnMap`] names. Numbers become counts of their last digit without
//! passing through a float, stamps become nanoseconds, and a malformed row is counted with its
//! reason.

mod cells;
mod column_map;
mod columns;
mod date;
mod dialect;
mod fields;
mod head;
mod header;
mod lines;
mod name;
mod number;
mod reader;
mod resolution;
mod row_counts;
mod row_parser;
mod sensor_column;
mod stamp;
mod stamp_search;
mod stamped_sentences;
mod streams;
mod suggestion;
#[cfg(test)]
mod tests;
mod time_name;
mod words;

use thiserror::Error;
use vn100_protocol::{Layout, stream::LeftOutColumn};

use self::{
    date::DateForm, dialect::Dialect, fields::LastField, number::Number, resolution::Quantizer, stamp::StampForm,
};
pub use column_map::{ColumnMap, ColumnMapError};
pub(crate) use column_map::{by_name, known, units};
pub(crate) use head::detect;
pub(crate) use reader::CsvReader;
pub(crate) use streams::streams;

/// Bytes of a file that are examined: a thousand rows of up to 260 bytes.
pub(crate) const HEAD_BYTES: usize = 256 * 1024;

/// The byte order mark that some programs write before the first line.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// The way to read a CSV file, as determined from its head.
#[derive(Debug, Clone)]
pub(crate) struct CsvPlan {
    kind: Kind,
    /// The names of all columns; empty in a file without a header.
    names: Vec<String>,
    /// The names of the columns that are not used.
    ignored_columns: Vec<String>,
    /// The columns that are not read although they could be.
    left_out: Vec<LeftOutColumn>,
    /// LF, which may follow a CR; or CR, as on old Macs.
    line_end: u8,
    dialect: Dialect,
    columns: Vec<ColumnUse>,
    /// The conversion of the column of each channel of the layout to counts.
    quantizers: Vec<Quantizer>,
    /// The common printed form of the last fields of the first rows, used to recognise a truncated
    /// row; `None` for sentences, which have a checksum, and if no row has a line end.
    last_field: Option<LastField>,
    /// The columns of the stamps and their forms, as written in a column map.
    times: Option<String>,
    /// The form of dates and times of day.
    date: Option<DateForm>,
    /// Lines before the first row.
    lines_above: u64,
}

impl CsvPlan {
    /// Whether the rows are numbers, not sentences.
    pub(crate) fn holds_values(&self) -> bool {
        matches!(self.kind, Kind::Values(_))
    }

    /// Whether the rows are numbers without a stamp.
    pub(crate) fn lacks_times(&self) -> bool {
        self.holds_values() && self.times.is_none()
    }
}

/// The content of the rows of a CSV file.
#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Numbers, one per channel. If the channels are exactly those of a message, the layout has its
    /// name, else `CSV`. Its scales convert the units of the file to those of the channels,
    /// independent of the size of a count.
    Values(Layout),
    /// Sentences as the sensor sent them.
    Sentences,
}

impl CsvPlan {
    /// The layout of the rows in their counts; `None` for sentences.
    fn layout(&self) -> Option<Layout> {
        let Kind::Values(layout) = &self.kind else { return None };
        let channels = layout.channels.iter().cloned().zip(&self.quantizers);
        let channels = channels.map(|(channel, quantizer)| quantizer.of_counts(channel)).collect::<Vec<_>>();
        Some(Layout { channels: channels.into(), ..layout.clone() })
    }

    /// The names of the channels whose last digits are rounded.
    fn rounded(&self) -> Vec<String> {
        let Kind::Values(layout) = &self.kind else { return Vec::new() };
        let channels = layout.channels.iter().zip(&self.quantizers).filter(|(_, quantizer)| quantizer.is_rounded);
        channels.map(|(channel, _)| channel.name.to_string()).collect()
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

/// The fields of the first rows.
type HeadRows = [Vec<Vec<u8>>];

/// The numbers of a column in the first rows.
fn numbers_at(rows: &HeadRows, place: usize) -> impl Iterator<Item = Number> {
    rows.iter().filter_map(move |row| Number::parse(row.get(place)?))
}

/// Whether a row has a number in this column.
fn holds_number(row: &[Vec<u8>], place: usize) -> bool {
    row.get(place).is_some_and(|cell| Number::parse(cell).is_some())
}

/// The reason why a CSV file cannot be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CsvError {
    /// No column of the rows of numbers has a known name in the header.
    #[error(
        "no known column in this CSV file: expected {}; found {}",
        columns::Columns::SEARCHED,
        described(found, left_out)
    )]
    UnknownColumns {
        /// The names in the header, or the places and mean values of columns without names.
        found: Vec<String>,
        /// The columns with known meanings, and the reasons why they cannot be read.
        left_out: Vec<LeftOutColumn>,
        /// A column map, if names, units and magnitudes fit exactly one.
        map: Option<String>,
    },
    /// The file does not have a column that the map names.
    #[error("no column {column:?} for {channel}: the file has {}", found.join(", "))]
    MissingColumn {
        /// The channel in the map.
        channel: &'static str,
        /// The name or number of the column in the map.
        column: String,
        /// The names in the header.
        found: Vec<String>,
    },
    /// The map gives one column to two channels.
    #[error("column {column:?} is mapped to both {} and {}: give each its own", channels[0], channels[1])]
    SameColumn {
        /// The name or number of the column.
        column: String,
        /// The two channels.
        channels: [&'static str; 2],
    },
    /// The file lacks the columns of the requested stream.
    #[error("no columns of {name:?}: name some of {found}")]
    NoStream {
        /// The requested stream.
        name: String,
        /// The quantities that the file has.
        found: String,
    },
    /// The rows are of several sensors.
    #[error(
        "the rows are of several sensors, by column {column:?}: {}; keep those of one, as awk -F, 'NR==1 || ${place}==\"{}\"' does",
        sensors.join(", "),
        sensors.first().map_or("", String::as_str)
    )]
    SeveralSensors {
        /// The name of the column.
        column: String,
        /// Its number, from 1.
        place: usize,
        /// The values of the column, one for each sensor.
        sensors: Vec<String>,
    },
    /// Hundreds of rows share each stamp, so the rate cannot be found.
    #[error(
        "the time stamps in column {column:?} are too coarse to show a sample rate: they change once at most in {rows} rows"
    )]
    CoarseStamps {
        /// The column of the stamps.
        column: String,
        /// Number of rows that were examined.
        rows: usize,
    },
    /// The unit of the stamps cannot be inferred from them.
    #[error(
        "the unit of the time stamps in column {column:?} is ambiguous: they step by {step} from row to row, which {}",
        stamp::may_be(units)
    )]
    StampUnit {
        /// The column of the stamps.
        column: String,
        /// The column as written in a column map.
        argument: String,
        /// The median step from row to row.
        step: f64,
        /// The units in which the step is 1 ms to 1 s.
        units: Vec<&'static str>,
    },
    /// Whether the day or the month comes first cannot be inferred from the dates.
    #[error("the dates in column {column:?} may begin with the day or with the month")]
    DateOrder {
        /// The column of the stamps.
        column: String,
        /// The column as written in a column map.
        argument: String,
    },
    /// No stamp has a known form.
    #[error(
        "the time stamps in column {column:?} are neither numbers nor dates nor times of day, the first is {text:?}: name another column"
    )]
    Stamps {
        /// The column of the stamps.
        column: String,
        /// The first stamp.
        text: String,
    },
}

/// The part that a [`ColumnMap`] must add so that the file can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MapHint {
    /// The columns; with a fitting map, if exactly one is certain.
    Columns(Option<String>),
    /// The unit of the stamps, one of s, ms, us and ns; with a map that names one.
    StampUnit(String),
    /// The order of the dates, dmy or mdy; with a map that names one.
    DateOrder(String),
}

impl CsvError {
    /// The part that a column map must add so that the file can be read; `None` if no map helps.
    #[must_use]
    pub fn hint(&self) -> Option<MapHint> {
        match self {
            Self::UnknownColumns { map, .. } => Some(MapHint::Columns(map.clone())),
            Self::StampUnit { argument, .. } => Some(MapHint::StampUnit(format!("t={argument}:ms"))),
            Self::DateOrder { argument, .. } => Some(MapHint::DateOrder(format!("t={argument}:dmy"))),
            Self::MissingColumn { .. }
            | Self::SameColumn { .. }
            | Self::SeveralSensors { .. }
            | Self::NoStream { .. }
            | Self::CoarseStamps { .. }
            | Self::Stamps { .. } => None,
        }
    }

    /// Whether the columns are known, but their stamps are not understood or the requested stream
    /// is missing.
    fn knows_columns(&self) -> bool {
        matches!(
            self,
            Self::Stamps { .. }
                | Self::StampUnit { .. }
                | Self::DateOrder { .. }
                | Self::NoStream { .. }
                | Self::SeveralSensors { .. }
                | Self::CoarseStamps { .. }
        )
    }
}

/// All columns; those that are left out with the reason.
fn described(found: &[String], left_out: &[LeftOutColumn]) -> String {
    let column = |name: &String| match left_out.iter().find(|column| column.name == *name) {
        Some(LeftOutColumn { reason, .. }) => format!("{name} ({reason})"),
        None => name.clone(),
    };
    found.iter().map(column).collect::<Vec<_>>().join(", ")
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

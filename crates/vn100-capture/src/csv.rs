//! Recordings as CSV, made by the scripts of laboratories: detected by their content, read
//! exactly.
//!
//! Three kinds. The fields of the sensor's lines in columns of known names; its lines whole, in a
//! column beside a stamp; and any inertial sensor's numbers, in columns and units named by a
//! [`ColumnMap`]. Numbers become counts of their last digit without the way through a float, stamps
//! become nanoseconds, and a row that is not understood is counted with its reason.

mod clock;
mod column_map;
mod column_name;
mod detect;
mod dialect;
mod fields;
mod guess;
mod header;
mod kept;
mod lines;
mod number;
mod reader;
mod resolution;
mod row_counts;
mod row_parser;
mod sensor_column;
mod so_far;
mod stamp;
mod stamp_columns;
mod stamp_search;
mod streams;
#[cfg(test)]
mod tests;
mod time_name;

use thiserror::Error;
use vn100_protocol::Layout;

use self::{
    clock::ClockForm,
    dialect::Dialect,
    fields::LastField,
    resolution::{ColumnScan, Prior, Quantizer, Scanned},
    stamp::{StampForm, StampUnit},
};
pub use column_map::{ColumnMap, ColumnMapError};
pub(crate) use column_map::{by_name, known};
pub(crate) use detect::detect;
pub(crate) use reader::CsvReader;
pub(crate) use streams::streams;

/// How much of a file it takes to judge it: a thousand rows of up to 260 bytes.
pub(crate) const HEAD_BYTES: usize = 256 * 1024;

/// What some programs put before the first line.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// How a CSV file is to be read, decided by its head; what a count is worth, by all rows.
#[derive(Debug, Clone)]
pub(crate) struct CsvPlan {
    kind: Kind,
    /// The columns that are not used, by their names in the file.
    ignored_columns: Vec<String>,
    /// LF, also behind a CR; or CR, as on old Macs.
    line_end: u8,
    dialect: Dialect,
    columns: Vec<ColumnUse>,
    /// Of the channels, in the order of the layout: what is known beforehand, and how their columns
    /// become counts.
    priors: Vec<Prior>,
    quantizers: Vec<Quantizer>,
    /// How the last fields of the first rows are printed; `None` for a sentence, which has a
    /// checksum.
    last_field: Option<LastField>,
    /// The columns of the stamps and their forms, as a column map names them.
    times: Option<String>,
    /// The form of dates and times of day.
    clock: Option<ClockForm>,
    /// How long behind the row before it a row came that repeats its stamp; `None` where several
    /// rows have one stamp as a rule.
    repeated_step_ns: Option<i64>,
    /// Lines before the first row.
    lines_above: u64,
}

impl CsvPlan {
    /// Whether its rows are numbers, not sentences.
    pub(crate) fn holds_values(&self) -> bool {
        matches!(self.kind, Kind::Values(_))
    }

    /// Whether its rows are numbers without a stamp.
    pub(crate) fn lacks_times(&self) -> bool {
        self.holds_values() && self.times.is_none()
    }
}

/// What the rows of a CSV file are.
#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Numbers, one per channel. The layout is named after the message when it has exactly the
    /// channels of one, `CSV` otherwise; its scales lead from the file's units to the channels'
    /// own, without regard to what a count is worth.
    Values(Layout),
    /// Sentences as the sensor sent them.
    Sentences,
}

impl CsvPlan {
    /// What a count of each channel is worth, by what its column prints.
    fn quantize(&mut self, scans: &[ColumnScan], scanned: Scanned) {
        self.quantizers = scans.iter().zip(&self.priors).map(|(scan, &prior)| scan.quantizer(prior, scanned)).collect();
    }

    /// The message of the rows in their counts; `None` for sentences.
    fn layout(&self) -> Option<Layout> {
        let Kind::Values(layout) = &self.kind else { return None };
        let channels = layout.channels.iter().cloned().zip(&self.quantizers);
        let channels = channels.map(|(channel, quantizer)| quantizer.of_counts(channel)).collect::<Vec<_>>();
        Some(Layout { channels: channels.into(), ..layout.clone() })
    }

    /// The names of the channels whose last digits are rounded away.
    fn rounded(&self) -> Vec<String> {
        let Kind::Values(layout) = &self.kind else { return Vec::new() };
        let channels = layout.channels.iter().zip(&self.quantizers).filter(|(_, quantizer)| quantizer.is_rounded);
        channels.map(|(channel, _)| channel.name.to_string()).collect()
    }
}

/// What a column is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ColumnUse {
    Ignored,
    Stamp(StampForm),
    /// What is added to the stamp: the nanoseconds beside its seconds.
    StampPart(StampUnit),
    /// The channel at this place of the layout.
    Channel(usize),
    /// A channel of another stream.
    OtherStream,
    Sentence,
}

/// Why a CSV file cannot be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CsvError {
    /// Rows of numbers, none of them known by the names in the header.
    #[error(
        "no known column in this CSV file: expected {}; found {}",
        header::ColumnPlaces::SEARCHED,
        .found.join(", ")
    )]
    UnknownColumns {
        /// The names in the header.
        found: Vec<String>,
        /// A map that may fit.
        guess: String,
    },
    /// A column named in the map is not there.
    #[error("no column {column:?} for {channel}: the file has {}", found.join(", "))]
    MissingColumn {
        /// Our name.
        channel: &'static str,
        /// Their name or number.
        column: String,
        /// The names in the header.
        found: Vec<String>,
    },
    /// Two channels in one column.
    #[error("column {column:?} is mapped to both {} and {}: give each its own", channels[0], channels[1])]
    SameColumn {
        /// Their name or number.
        column: String,
        /// Our names.
        channels: [&'static str; 2],
    },
    /// Columns are asked for that the file does not have.
    #[error("no columns of {name:?}: name some of {found}")]
    NoStream {
        /// What is asked for.
        name: String,
        /// The quantities that there are.
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
        /// What stands in it.
        sensors: Vec<String>,
    },
    /// Hundreds of rows share each stamp.
    #[error(
        "the time stamps in column {column:?} are too coarse to show a sample rate: they change once at most in {rows} rows"
    )]
    CoarseStamps {
        /// Their name.
        column: String,
        /// The rows looked at.
        rows: usize,
    },
    /// The unit of the stamps does not follow from them.
    #[error(
        "the unit of the time stamps in column {column:?} is ambiguous: they step by {step} from row to row, which {}",
        stamp::may_be(units)
    )]
    StampUnit {
        /// Their name.
        column: String,
        /// What a column map calls it.
        argument: String,
        /// The median step from row to row.
        step: f64,
        /// The units in which that is 1 ms to 1 s.
        units: Vec<&'static str>,
    },
    /// Whether day or month comes first does not follow from the dates.
    #[error("the dates in column {column:?} may begin with the day or with the month")]
    DateOrder {
        /// Their name.
        column: String,
        /// What a column map calls it.
        argument: String,
    },
    /// No stamp is understood.
    #[error(
        "the time stamps in column {column:?} are neither numbers nor dates nor times of day, the first is {text:?}: name another column"
    )]
    Stamps {
        /// Their name.
        column: String,
        /// The first stamp.
        text: String,
    },
}

/// What a [`ColumnMap`] would have to name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MapHint {
    /// The columns; with a map that may fit.
    Columns(String),
    /// The unit of the stamps, one of s, ms, us and ns; with a map that does so.
    StampUnit(String),
    /// The order of the dates, dmy or mdy; with a map that does so.
    DateOrder(String),
}

impl CsvError {
    /// The map that would make the file readable, where one would.
    #[must_use]
    pub fn hint(&self) -> Option<MapHint> {
        match self {
            Self::UnknownColumns { guess, .. } => Some(MapHint::Columns(guess.clone())),
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

    /// Whether the columns are known, and only the stamps in them are not understood, or none of
    /// them is asked for.
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

/// The beginning of `text`, without the characters that steer a terminal; in Latin-1 where it is no
/// UTF-8.
fn shown(text: &[u8]) -> String {
    const SHOWN_BYTES: usize = 160;
    let head = &text[..text.len().min(SHOWN_BYTES)];
    let is_utf8 = std::str::from_utf8(text).is_ok();
    let decoded = if is_utf8 {
        String::from_utf8_lossy(head).into()
    } else {
        head.iter().copied().map(char::from).collect::<String>()
    };
    let mut shown = decoded.replace('\t', " ");
    shown.retain(|c| !c.is_control());
    if head.len() < text.len() {
        shown.push('…');
    }
    shown
}

//! Finds the line that names the columns of a CSV file, and determines how the file is read.

use std::{borrow::Cow, sync::Arc};

use vn100_protocol::{Channel, ColumnRead, ColumnsRead, Layout, MESSAGES, Quantity, stream::CsvReport};

use super::{
    BYTE_ORDER_MARK, ColumnUse, CsvPlan, HEAD_ROWS, HeadRow, HeadRows, OpenHint, Said, Unusable,
    channels::known,
    column_map::STAMP,
    columns::{Column, Columns},
    dialect::Dialect,
    fields::{RowEnd, fields},
    header::Header,
    holds_number,
    lines::is_comment_or_blank,
    number::Number,
    numbers_at,
    resolution::Quantizer,
    same_column, sentence_rows, shown,
    streams::{check_one_sensor, streams},
    suggestion::suggestion,
    time_columns::{StampColumns, TimeSearch, argument},
};

/// The most comments above the first row, and lines of another kind, that are searched for the names
/// of the columns.
const SEARCHED_LINES: usize = 100;

/// Rows that show the number of fields of a row: only few, because each line above them is tried
/// as the header.
const FITTED_ROWS: usize = 50;

/// Decides how to read the CSV file that begins with `head`; `None` if it is no CSV file, or
/// contains nothing of a VN-100.
///
/// `head` should contain 1000 whole rows ([`HEAD_BYTES`](super::HEAD_BYTES)); if it has fewer,
/// these determine the decimals.
///
/// Without a map the columns are recognised by their names, in the sensor's units if the names state
/// none.
///
/// # Errors
/// [`Unusable`] if this is a CSV file without the columns or the stamps.
pub(crate) fn detect(head: &[u8], said: Said<'_>) -> Result<Option<CsvPlan>, Unusable> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let line_end = if head.contains(&b'\r') && !head.contains(&b'\n') { b'\r' } else { b'\n' };
    let lines: Vec<&[u8]> =
        head.split(|&byte| byte == line_end).map(|line| line.strip_suffix(b"\r").unwrap_or(line)).collect();
    // a zero byte in the names of the columns is no damage: the file is binary data, or UTF-16
    let first = lines.iter().position(|line| !is_comment_or_blank(line)).filter(|&first| !lines[first].contains(&0));
    // an object of JSON names its values in each line, which no header does
    let is_json =
        |line: &[u8]| [&b"{\""[..], b"[{", b"{ \""].iter().any(|begin| line.trim_ascii_start().starts_with(begin));
    let Some(first) = first.filter(|&first| !is_json(lines[first])) else { return Ok(None) };
    let names_channels = said.map.is_some_and(|map| map.has_channels());
    if !names_channels && let Some(plan) = sentence_rows::detect(&lines, said)? {
        return Ok(Some(CsvPlan { line_end, ..plan }));
    }
    let (mut evident, mut of_first) = (None, None);
    for index in first.saturating_sub(SEARCHED_LINES)..lines.len().min(first + SEARCHED_LINES) {
        let line = lines[index].trim_ascii_start();
        // scripts that save arrays put a # before the names of the columns
        let names = match line.strip_prefix(b"#") {
            Some(names) if index < first => names,
            _ if index < first || is_comment_or_blank(line) => continue,
            _ => lines[index],
        };
        let candidate = Candidate::new(names, &lines, index);
        // a name of one word may occur in any text
        if index != first && (!candidate.fits() || index > first && candidate.header.names.len() < 2) {
            continue;
        }
        match candidate.plan(said) {
            Ok(Some(plan)) => return Ok(Some(CsvPlan { line_end, ..plan })),
            Ok(None) => {}
            Err(error) if error.is_certain => return Err(error),
            Err(error) if index == first => of_first = Some(error),
            Err(error) if candidate.is_header_of_numbers() => evident = evident.or(Some(error)),
            Err(_) => {}
        }
        if index >= first && evident.is_some() {
            break;
        }
    }
    evident.or(of_first).map_or(Ok(None), Err)
}

/// A line that may be the header.
struct Candidate<'a> {
    header: Header,
    dialect: Dialect,
    lines: &'a [&'a [u8]],
    /// Its place among the lines; the place of the units below it, if there are any.
    index: usize,
    /// The first rows below it.
    below: Vec<HeadRow>,
}

impl<'a> Candidate<'a> {
    /// The line at `index`, which names the columns in the text `names`.
    fn new(names: &[u8], lines: &'a [&'a [u8]], index: usize) -> Self {
        let below: Vec<&[u8]> = rows(lines, index + 1).take(FITTED_ROWS).collect();
        let dialect = Dialect::of(names, if below.is_empty() { std::slice::from_ref(&names) } else { &below });
        let (header_names, separator) = dialect.header(names);
        let mut header = Header::read(&header_names, separator);
        if let Some(cells) = dialect.names_of_cells(names) {
            header = Header::of_names(cells);
            header.is_first_row = true;
        }
        let units = below
            .first()
            .filter(|units| header.names_columns() && header.take_units(&dialect.tidy(units), dialect.separator));
        let units = units.and_then(|_| (index + 1..lines.len()).find(|&below| !is_comment_or_blank(lines[below])));
        let index = units.unwrap_or(index);
        let below: Vec<HeadRow> = rows(lines, index + 1).take(FITTED_ROWS).map(|row| cells(dialect, row)).collect();
        header.cut_off_row(&below);
        header.name_ros2_imu();
        Self { header, dialect, lines, index, below }
    }

    fn fits(&self) -> bool {
        self.below.first().is_some_and(|row| self.header.fits(row))
    }

    /// Whether a row of numbers follows a line of names, and most other rows have its columns: a line
    /// such as `FirmwareVersion:,2.0.0` stands above many a table.
    fn is_header_of_numbers(&self) -> bool {
        let holds_number = self.below.first().is_some_and(|row| row.iter().any(|cell| Number::parse(cell).is_some()));
        let fitting = self.below.iter().filter(|row| self.header.fits(row)).count();
        self.header.names_columns() && self.fits() && holds_number && 2 * fitting > self.below.len()
    }

    /// Whether rows of as many numbers follow a row of numbers: a table without names.
    fn is_table_of_numbers(&self) -> bool {
        let width = self.header.names.len();
        let are_numbers = |row: &&HeadRow| row.len() == width && row.iter().all(|cell| Number::parse(cell).is_some());
        self.header.is_all_numbers() && self.below.iter().filter(are_numbers).count() + 1 >= FITTED_ROWS
    }

    /// The plan, if this is the header. The columns are those that the user names, or those with known
    /// names; the user may have named the stamps alone.
    fn plan(&self, said: Said<'_>) -> Result<Option<CsvPlan>, Unusable> {
        let mapped = said.map.filter(|map| map.has_channels());
        let is_row = self.header.is_first_row || mapped.is_some_and(|map| self.header.is_row(map));
        let lines_above = self.index + usize::from(!is_row);
        let mut cells = self.cells(lines_above);
        let has_names = self.is_header_of_numbers() || self.header.is_first_row;
        let mut columns = match mapped {
            Some(map) => Columns::mapped(&self.header, map)?,
            None => Columns::by_name(&self.header, said.file, if has_names { &cells } else { &[] }),
        };
        if mapped.is_none() && !columns.has_inertial_channel() {
            let is_table = has_names || self.is_table_of_numbers();
            return if is_table { Err(self.unknown_columns(&columns, &cells, has_names)) } else { Ok(None) };
        }
        if let Some(stream) = said.stream {
            columns.choose(stream)?;
            if !columns.others.is_empty() {
                cells.retain(|row| columns.read.iter().any(|column| holds_number(row, column.place)));
            }
        }
        let search = self.search(&columns, &cells);
        let stamp = match said.map.map_or(Ok(None), |map| search.mapped(map))? {
            None if mapped.is_some() => search.likely(),
            None => search.found()?,
            stamp => stamp,
        };
        let is_stamp = |place: usize| stamp.iter().flatten().any(|(taken, _)| *taken == place);
        if let Some(taken) = columns.read.iter().find(|column| is_stamp(column.place)) {
            let column = said.map.and_then(|map| map.stamp.first()).map(|(column, _)| column.clone());
            let column = column.unwrap_or_else(|| self.header.argument(taken.place));
            return Err(same_column(&column, taken.name(), STAMP));
        }
        check_one_sensor(&self.header, &cells, |place| search.taken.contains(&place) || is_stamp(place))?;
        let mut plan = self.complete(&columns, stamp, mapped.is_none(), lines_above, &cells);
        let is_of_message = plan.layout.as_ref().is_some_and(|layout| layout.message != "CSV");
        if plan.report.times.is_some() && !is_of_message && said.stream.is_none() {
            plan.streams = streams(&columns.read, &cells);
        }
        Ok(Some(plan))
    }

    /// No column of the rows of numbers has a known name in the header.
    fn unknown_columns(&self, columns: &Columns, cells: &HeadRows, has_names: bool) -> Unusable {
        let stamps = if has_names { self.search(columns, cells).likely() } else { None };
        let described = |name: String| match columns.left_out.iter().find(|column| column.name == name) {
            Some(column) => format!("{name} ({})", column.reason),
            None => name,
        };
        let found: Vec<String> = self.header.listed(cells).into_iter().map(described).collect();
        let (searched, found) = (Columns::SEARCHED, found.join(", "));
        let reason = format!("no known column in this CSV file: expected {searched}; found {found}");
        Unusable::new(reason).with_hint(OpenHint::Columns(suggestion(&self.header, stamps.as_ref(), cells)))
    }

    /// The fields of the first rows.
    fn cells(&self, lines_above: usize) -> Vec<HeadRow> {
        // a second header may give another order to the columns of the rows below it
        let is_header = |line: &&[u8]| {
            let row = cells(self.dialect, line.trim_ascii_start().strip_prefix(b"#").unwrap_or(line));
            let is_name = |cell: &Vec<u8>| self.header.names.contains(&shown(cell));
            let are_names = row.iter().all(|cell| cell.is_empty() || is_name(cell) && Number::parse(cell).is_none());
            let is_equal = || row.iter().map(|cell| shown(cell)).eq(self.header.names.iter().cloned());
            row.len() > 1 && are_names && row.iter().any(is_name) && !is_equal()
        };
        let below = self.lines.get(lines_above..).unwrap_or_default();
        let end = below.iter().position(is_header).map_or(self.lines.len(), |place| lines_above + place);
        let rows = rows(&self.lines[..end], lines_above).map(|row| cells(self.dialect, row));
        rows.filter(|row| self.header.fits(row)).collect()
    }

    fn search<'b>(&'b self, columns: &Columns, rows: &'b HeadRows) -> TimeSearch<'b> {
        let channels = columns.read.iter().map(|column| column.place);
        TimeSearch { header: &self.header, rows, taken: channels.chain(columns.others.iter().copied()).collect() }
    }

    /// Completes a plan with the properties of the first rows. Columns that are recognised by their
    /// names may be those of a message of the sensor.
    fn complete(
        &self,
        columns: &Columns,
        stamp: Option<StampColumns>,
        are_named: bool,
        lines_above: usize,
        cells: &HeadRows,
    ) -> CsvPlan {
        let times = stamp.as_ref().map(|stamp| argument(stamp, &self.header));
        let quantizer = |column: &Column| {
            let channel = known(column.channel);
            let numbers: Vec<Number> = numbers_at(cells, column.place).collect();
            Quantizer::new(&numbers, channel, &column.unit, are_named && column.unit.name == channel.unit)
        };
        let quantizers: Vec<Quantizer> = columns.read.iter().map(quantizer).collect();
        let mut layout = self.layout(columns, are_named, times.clone());
        let channels = layout.channels.iter().cloned().zip(&quantizers);
        layout.channels = channels.map(|(channel, quantizer)| quantizer.of_counts(channel)).collect::<Vec<_>>().into();
        let mut uses = vec![ColumnUse::Ignored; self.header.width];
        let channels = columns.read.iter().enumerate().map(|(slot, column)| (column.place, ColumnUse::Channel(slot)));
        let others = columns.others.iter().map(|&place| (place, ColumnUse::OtherStream));
        for (place, column) in stamp.into_iter().flatten().chain(channels).chain(others) {
            uses[place] = column;
        }
        let is_left_out = |name: &String| columns.left_out.iter().any(|left_out| left_out.name == *name);
        let names = self.header.names.iter().zip(&uses);
        let unused = names.filter(|(_, column)| matches!(column, ColumnUse::Ignored | ColumnUse::OtherStream));
        let ignored = unused.map(|(name, _)| name).filter(|name| !name.is_empty() && !is_left_out(name)).cloned();
        let rounded = layout.channels.iter().zip(&quantizers).filter(|(_, quantizer)| quantizer.is_rounded);
        CsvPlan {
            report: CsvReport {
                ignored_columns: ignored.collect(),
                left_out: columns.left_out.clone(),
                times,
                other_stream_rows: (!columns.others.is_empty()).then_some(0),
                rounded: rounded.map(|(channel, _)| channel.name.to_string()).collect(),
                ..CsvReport::default()
            },
            quantizers,
            layout: Some(Arc::new(layout)),
            row_end: self.row_end(lines_above),
            names: if lines_above > self.index { self.header.names.clone() } else { Vec::new() },
            fewest_fields: self.header.names.len(),
            lines_above: lines_above as u64,
            dialect: self.dialect,
            columns: uses,
            ..CsvPlan::default()
        }
    }

    /// The layout of the channels. It is that of a message of the sensor if the channels match it
    /// exactly and include an attitude, or have a stated compensation and not all occur in other
    /// sensors.
    fn layout(&self, columns: &Columns, are_named: bool, times: Option<String>) -> Layout {
        let channels: Vec<Channel> = columns.read.iter().map(|column| column.unit.of_channel(column.channel)).collect();
        let compensated = columns.compensated;
        let is_of_any_sensor = |channel: &Channel| {
            matches!(channel.quantity, Quantity::MagneticField | Quantity::Acceleration | Quantity::AngularRate)
        };
        let is_of_this_one = channels.iter().any(|channel| channel.quantity.is_attitude())
            || compensated.is_some() && !channels.iter().all(is_of_any_sensor);
        let message = MESSAGES.into_iter().find(|message| {
            are_named
                && is_of_this_one
                && *message.channels == *channels
                && (compensated.is_none() || message.compensated == compensated)
        });
        let read = |column: &Column| ColumnRead {
            name: self.header.argument(column.place),
            unit: column.unit.name.to_string(),
        };
        let read = ColumnsRead { columns: columns.read.iter().map(read).collect(), times };
        let message = message.map_or("CSV".into(), |message| message.message.clone());
        Layout { message, compensated, channels: channels.into(), columns: Some(read) }
    }

    /// The form of the ends of the first rows that have a line end.
    fn row_end(&self, lines_above: usize) -> Option<RowEnd> {
        let ended = &self.lines[..self.lines.len() - 1];
        let rows = rows(ended, lines_above.min(ended.len())).map(|row| cells(self.dialect, row));
        RowEnd::of_all(rows.filter(|row| self.header.fits(row)))
    }
}

fn cells(dialect: Dialect, row: &[u8]) -> HeadRow {
    fields(&dialect.tidy(row), dialect.separator).map(Cow::into_owned).collect()
}

/// The first rows below `lines_above`.
fn rows<'a>(lines: &'a [&'a [u8]], lines_above: usize) -> impl Iterator<Item = &'a [u8]> {
    let below = lines[lines_above..].iter().copied();
    below.filter(|line| !is_comment_or_blank(line)).take(HEAD_ROWS)
}

//! Finds the line that names the columns of a CSV file, and determines how the file is read.

use std::{borrow::Cow, sync::Arc};

use vn100_protocol::{Channel, ColumnRead, ColumnsRead, Layout, MESSAGES, Quantity};

use super::{
    BYTE_ORDER_MARK, ColumnUse, CsvError, CsvPlan, Said,
    channels::known,
    column_map::STAMP,
    columns::{ChannelColumn, Columns},
    dialect::Dialect,
    fields::{LastField, fields},
    header::Header,
    holds_number,
    lines::is_comment_or_blank,
    number::Number,
    numbers_at,
    resolution::{HEAD_ROWS, Prior, Quantizer},
    sensor_column::check_one_sensor,
    sentence_rows, shown,
    streams::streams,
    suggestion::suggestion,
    time_columns::{StampColumns, TimeSearch, argument, date_of},
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
/// [`CsvError`] if this is a CSV file without the columns or the stamps.
pub(crate) fn detect(head: &[u8], said: Said<'_>) -> Result<Option<CsvPlan>, CsvError> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let line_end = if head.contains(&b'\r') && !head.contains(&b'\n') { b'\r' } else { b'\n' };
    let lines: Vec<&[u8]> =
        head.split(|&byte| byte == line_end).map(|line| line.strip_suffix(b"\r").unwrap_or(line)).collect();
    // a zero byte in the names of the columns is no damage: the file is binary data, or UTF-16
    let first = lines.iter().position(|line| !is_comment_or_blank(line)).filter(|&first| !lines[first].contains(&0));
    let Some(first) = first else { return Ok(None) };
    let names_channels = said.map.is_some_and(|map| map.has_channels());
    if !names_channels && let Some(plan) = sentence_rows::detect(&lines, line_end, said)? {
        return Ok(Some(plan));
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
        let candidate = Candidate::new(names, &lines, line_end, index);
        // a name of one word may occur in any text
        if index != first && (!candidate.fits() || index > first && candidate.header.width() < 2) {
            continue;
        }
        match candidate.plan(said) {
            Ok(Some(plan)) => return Ok(Some(plan)),
            Ok(None) => {}
            Err(error) if error.is_certain => return Err(error),
            Err(error) if index != first && candidate.is_header_of_numbers() => evident = evident.or(Some(error)),
            Err(error) if index == first => of_first = Some(error),
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
    /// The head of the file.
    lines: &'a [&'a [u8]],
    /// The byte that ends them.
    line_end: u8,
    /// Its place among the lines; the place of the units below it, if there are any.
    index: usize,
}

impl<'a> Candidate<'a> {
    /// The line at `index`, which names the columns in the text `names`.
    fn new(names: &[u8], lines: &'a [&'a [u8]], line_end: u8, index: usize) -> Self {
        let below: Vec<&[u8]> = rows(lines, index + 1).take(FITTED_ROWS).collect();
        let dialect = Dialect::of(names, if below.is_empty() { std::slice::from_ref(&names) } else { &below });
        let (header_names, separator) = dialect.header(names);
        let mut header = Header::read(&header_names, separator);
        if let Some(cells) = dialect.names_of_cells(names) {
            header = Header::of_names(cells);
            header.is_first_row = true;
        }
        let units = (index + 1..lines.len()).find(|&below| !is_comment_or_blank(lines[below]));
        let units = units.filter(|&units| {
            header.names_columns() && header.take_units(&dialect.tidy(lines[units]), dialect.separator)
        });
        let tidy: Vec<_> = below.iter().map(|row| dialect.tidy(row)).collect();
        header.fit(&tidy, dialect.separator);
        header.name_ros2_imu();
        Self { header, dialect, lines, line_end, index: units.unwrap_or(index) }
    }

    /// The first rows below `lines_above`, tidied.
    fn rows(&self, lines_above: usize) -> impl Iterator<Item = Cow<'a, [u8]>> {
        rows(self.lines, lines_above).map(|row| self.dialect.tidy(row))
    }

    /// The number of fields in the row below.
    fn width_below(&self) -> Option<usize> {
        Some(fields(&self.rows(self.index + 1).next()?, self.dialect.separator).count())
    }

    fn fits(&self) -> bool {
        self.width_below() == Some(self.header.width())
    }

    /// Whether a row of numbers follows a line of names.
    fn is_header_of_numbers(&self) -> bool {
        let row = self.rows(self.index + 1).next();
        let holds_number =
            row.is_some_and(|row| fields(&row, self.dialect.separator).any(|field| Number::parse(&field).is_some()));
        self.header.names_columns() && self.fits() && holds_number
    }

    /// Whether rows of as many numbers follow a row of numbers: a table without names.
    fn is_table_of_numbers(&self) -> bool {
        let are_numbers = |row: &Cow<'_, [u8]>| {
            let cells: Vec<bool> =
                fields(row, self.dialect.separator).map(|field| Number::parse(&field).is_some()).collect();
            cells.len() == self.header.width() && !cells.contains(&false)
        };
        let rows = self.rows(self.index + 1).take(FITTED_ROWS).filter(are_numbers).count();
        self.header.is_all_numbers() && rows + 1 >= FITTED_ROWS
    }

    /// The plan, if this is the header. The columns are those that the user names, or those with known
    /// names; the user may have named the stamps alone.
    fn plan(&self, said: Said<'_>) -> Result<Option<CsvPlan>, CsvError> {
        let mapped = said.map.filter(|map| map.has_channels());
        let is_row = self.header.is_first_row || mapped.is_some_and(|map| self.header.is_row(map));
        let lines_above = self.index + usize::from(!is_row);
        let mut cells = self.cells(lines_above);
        let mut columns = match mapped {
            Some(map) => Columns::mapped(&self.header, map)?,
            None => {
                let has_names = self.is_header_of_numbers() || self.header.is_first_row;
                let columns = Columns::by_name(&self.header, said.file, if has_names { &cells } else { &[] });
                if !columns.has_inertial_channel() {
                    let is_table = has_names || self.is_table_of_numbers();
                    return if is_table { Err(self.unknown_columns(columns, &cells, has_names)) } else { Ok(None) };
                }
                columns
            }
        };
        if let Some(stream) = said.stream {
            columns.choose(stream)?;
            if !columns.others.is_empty() {
                cells.retain(|row| columns.channels.iter().any(|column| holds_number(row, column.place)));
            }
        }
        let search = self.search(&columns, &cells);
        let stamp = match said.map.map_or(Ok(None), |map| search.mapped(map))? {
            None if mapped.is_some() => search.likely(),
            None => search.found()?,
            stamp => stamp,
        };
        let is_stamp = |place: usize| stamp.iter().flatten().any(|(taken, _)| *taken == place);
        if let Some(taken) = columns.channels.iter().find(|column| is_stamp(column.place)) {
            let column = said.map.and_then(|map| map.stamp.first()).map(|(column, _)| column.to_string());
            let column = column.unwrap_or_else(|| self.header.argument(taken.place));
            return Err(CsvError::same_column(&column, &known(taken.channel).name, STAMP));
        }
        let is_taken = |place: usize| search.taken.contains(&place) || is_stamp(place);
        check_one_sensor(&self.header, &cells, is_taken)?;
        Ok(Some(self.complete(&columns, stamp, mapped.is_none(), lines_above, &cells, said)))
    }

    fn unknown_columns(&self, columns: Columns, cells: &[Vec<Vec<u8>>], has_names: bool) -> CsvError {
        let stamps = if has_names { self.search(&columns, cells).likely() } else { None };
        let map = suggestion(&self.header, stamps.as_ref(), cells);
        CsvError::unknown_columns(&self.header.listed(cells), &columns.left_out, map)
    }

    /// The fields of the first rows.
    fn cells(&self, lines_above: usize) -> Vec<Vec<Vec<u8>>> {
        let cut = |row: Cow<'_, [u8]>| fields(&row, self.dialect.separator).map(Cow::into_owned).collect::<Vec<_>>();
        // a second header may give another order to the columns of the rows below it
        let is_header = |row: &Vec<Vec<u8>>| {
            let is_name = |cell: &Vec<u8>| self.header.names.contains(&shown(cell));
            let are_names = row.iter().all(|cell| cell.is_empty() || is_name(cell) && Number::parse(cell).is_none());
            row.len() > 1 && are_names && row.iter().any(is_name)
        };
        let rows = self.rows(lines_above).map(cut).take_while(|row| !is_header(row));
        rows.filter(|cells| cells.len() == self.header.width()).collect()
    }

    fn search<'b>(&'b self, columns: &Columns, rows: &'b [Vec<Vec<u8>>]) -> TimeSearch<'b> {
        let channels = columns.channels.iter().map(|column| column.place);
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
        cells: &[Vec<Vec<u8>>],
        said: Said<'_>,
    ) -> CsvPlan {
        let times = stamp.as_ref().map(|stamp| argument(stamp, &self.header));
        let quantizer = |column: &ChannelColumn| {
            let channel = known(column.channel);
            let of_sensor = are_named && column.unit.name == channel.unit;
            let numbers: Vec<Number> = numbers_at(cells, column.place).collect();
            Quantizer::new(&numbers, Prior::new(channel, &column.unit, of_sensor))
        };
        let quantizers: Vec<Quantizer> = columns.channels.iter().map(quantizer).collect();
        let mut layout = self.layout(columns, are_named, times.clone());
        let channels = layout.channels.iter().cloned().zip(&quantizers);
        layout.channels = channels.map(|(channel, quantizer)| quantizer.of_counts(channel)).collect::<Vec<_>>().into();
        let mut uses = vec![ColumnUse::Ignored; self.header.width()];
        for &(place, column) in stamp.iter().flatten() {
            uses[place] = column;
        }
        for (slot, column) in columns.channels.iter().enumerate() {
            uses[column.place] = ColumnUse::Channel(slot);
        }
        for &place in &columns.others {
            uses[place] = ColumnUse::OtherStream;
        }
        let is_left_out = |name: &String| columns.left_out.iter().any(|left_out| left_out.name == *name);
        let names = self.header.names.iter().zip(&uses);
        let unused = names.filter(|(_, column)| matches!(column, ColumnUse::Ignored | ColumnUse::OtherStream));
        let ignored = unused.map(|(name, _)| name).filter(|name| !name.is_empty() && !is_left_out(name)).cloned();
        let is_one_stream = times.is_none() || layout.message != "CSV" || said.stream.is_some();
        CsvPlan {
            quantizers,
            streams: if is_one_stream { Vec::new() } else { streams(&columns.channels, cells) },
            layout: Some(Arc::new(layout)),
            last_field: self.last_field(lines_above),
            names: if lines_above > self.index { self.header.names.clone() } else { Vec::new() },
            ignored_columns: ignored.collect(),
            left_out: columns.left_out.clone(),
            line_end: self.line_end,
            dialect: self.dialect,
            columns: uses,
            has_prefix_stamps: false,
            times,
            date: stamp.as_ref().and_then(date_of),
            lines_above: lines_above as u64,
        }
    }

    /// The layout of the channels. It is that of a message of the sensor if the channels match it
    /// exactly and include an attitude, or have a stated compensation and not all occur in other
    /// sensors.
    fn layout(&self, columns: &Columns, are_named: bool, times: Option<String>) -> Layout {
        let channel = |column: &ChannelColumn| match known(column.channel) {
            series if series.quantity == Quantity::Value => {
                Channel { unit: column.unit.name.clone(), ..series.clone() }
            }
            known => Channel { scale: column.unit.scale, ..known.clone() },
        };
        let channels: Vec<Channel> = columns.channels.iter().map(channel).collect();
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
        let read = |column: &ChannelColumn| ColumnRead {
            name: self.header.argument(column.place),
            unit: column.unit.name.to_string(),
        };
        let read = ColumnsRead { columns: columns.channels.iter().map(read).collect(), times };
        let message = message.map_or("CSV".into(), |message| message.message.clone());
        Layout { message, compensated, channels: channels.into(), columns: Some(read) }
    }

    /// The common form of the ends of the first rows that have a line end.
    fn last_field(&self, lines_above: usize) -> Option<LastField> {
        let ended = &self.lines[..self.lines.len() - 1];
        let forms = rows(ended, lines_above.min(ended.len())).filter_map(|row| {
            let row = self.dialect.tidy(row);
            let cells: Vec<_> = fields(&row, self.dialect.separator).collect();
            cells.last().filter(|_| cells.len() == self.header.width()).map(|last| LastField::of(last))
        });
        forms.reduce(LastField::common)
    }
}

/// The first rows below `lines_above`.
fn rows<'a>(lines: &'a [&'a [u8]], lines_above: usize) -> impl Iterator<Item = &'a [u8]> {
    let below = lines[lines_above..].iter().copied();
    below.filter(|line| !is_comment_or_blank(line)).take(HEAD_ROWS)
}

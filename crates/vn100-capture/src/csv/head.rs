//! Finds the line that names the columns of a CSV file, and determines how the file is read.

use std::borrow::Cow;

use memchr::memmem;
use vn100_protocol::{Channel, ColumnRead, ColumnsRead, Layout, MESSAGES, Quantity};

use super::{
    BYTE_ORDER_MARK, ColumnUse, CsvError, CsvPlan, HeadRows, Kind, Said,
    column_map::{ColumnMap, RAW, STAMP, known},
    columns::{ChannelColumn, Columns},
    dialect::Dialect,
    fields::{FieldCutter, LastField},
    header::Header,
    holds_number,
    lines::is_comment_or_blank,
    number::Number,
    numbers_at,
    resolution::{HEAD_ROWS, Prior, Quantizer},
    sensor_column::several_sensors,
    shown,
    stamp_search::{StampColumns, StampSearch},
    stamped_sentences::stamped_sentences,
    suggestion::suggestion,
};

/// The most comments above the first row that are searched for the names of the columns, beginning
/// with the nearest.
const COMMENTS_ABOVE: usize = 100;

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
    let Some(first) = first else {
        return Ok(None);
    };
    let mut problem = None;
    // scripts that save arrays put a # before the names of the columns
    for index in first.saturating_sub(COMMENTS_ABOVE)..first {
        let Some(names) = lines[index].trim_ascii_start().strip_prefix(b"#") else {
            continue;
        };
        let candidate = HeaderCandidate::new(names, &lines, line_end, index);
        if !candidate.fits(lines[first]) {
            continue;
        }
        match candidate.plan(said) {
            Ok(Some(plan)) => return Ok(Some(plan)),
            Err(error) if error.knows_columns() || candidate.is_header_of_numbers() => problem = Some(error),
            // the comment is prose
            Ok(None) | Err(_) => {}
        }
    }
    let plan = HeaderCandidate::new(lines[first], &lines, line_end, first).plan(said);
    match (&plan, problem) {
        (Ok(Some(_)), _) => plan,
        (Err(error), _) if error.knows_columns() => plan,
        // a comment may be the header of a table that needs a map, if the first row gives no better one
        (_, Some(problem)) => Err(problem),
        _ => match below_preamble(&lines, first, line_end, said).unwrap_or(plan) {
            Ok(None) => stamped_sentences(&lines, line_end, said),
            plan => plan,
        },
    }
}

/// The plan of a file whose column names, or whose rows, stand below lines of another kind.
fn below_preamble(
    lines: &[&[u8]],
    first: usize,
    line_end: u8,
    said: Said<'_>,
) -> Option<Result<Option<CsvPlan>, CsvError>> {
    let last = lines.len().min(first + LONGEST_PREAMBLE);
    for index in (first + 1..last).filter(|&index| !is_comment_or_blank(lines[index])) {
        let candidate = HeaderCandidate::new(lines[index], lines, line_end, index);
        let fits = candidate.rows(index + 1).next().is_some_and(|row| candidate.fits(&row));
        // a name of one word may occur in any text
        if !fits || candidate.header.width() < 2 {
            continue;
        }
        let plan = candidate.plan(said);
        let is_evident = |error: &CsvError| error.knows_columns() || candidate.is_header_of_numbers();
        if matches!(&plan, Ok(Some(_))) || plan.as_ref().is_err_and(is_evident) {
            return Some(plan);
        }
    }
    None
}

/// The most lines of another kind above the names of the columns.
const LONGEST_PREAMBLE: usize = 100;

/// Rows that show the number of fields of a row: only few, because each comment above them is tried
/// as the header.
const FITTED_ROWS: usize = 50;

/// A line that may be the header.
struct HeaderCandidate<'a> {
    header: Header,
    dialect: Dialect,
    /// The head of the file.
    lines: &'a [&'a [u8]],
    /// The byte that ends them.
    line_end: u8,
    /// Its place among the lines; the place of the units below it, if there are any.
    index: usize,
}

impl<'a> HeaderCandidate<'a> {
    /// The line at `index`, which names the columns in the text `names`.
    fn new(names: &[u8], lines: &'a [&'a [u8]], line_end: u8, index: usize) -> Self {
        let below: Vec<&[u8]> = rows(lines, index + 1).take(FITTED_ROWS).collect();
        let dialect = match &below[..] {
            [] => Dialect::of(names, std::iter::once(names)),
            rows => Dialect::of(names, rows.iter().copied()),
        };
        let is_quoted = names.contains(&b'"');
        let (header_names, separator) = dialect.header(names);
        let mut header = Header::read(&header_names, separator);
        if let Some(cells) = dialect.names_of_cells(names) {
            (header.names, header.is_first_row) = (cells, true);
        }
        let mut candidate = Self { header, dialect, lines, line_end, index };
        // the commas of a sentence in the first row separate no columns
        let sentence = candidate.header.names.iter().position(|name| name.contains("$VN"));
        if let Some(place) = sentence.filter(|_| !is_quoted) {
            candidate.header.names.truncate(place + 1);
        }
        let units = (index + 1..lines.len()).find(|&below| !is_comment_or_blank(lines[below]));
        if let Some(units) = units
            && candidate.header.names_columns()
            && candidate.header.take_units(&dialect.tidy(lines[units]), dialect.separator)
        {
            candidate.index = units;
        }
        let mut cutter = FieldCutter::of_head(dialect.separator);
        let widths: Vec<usize> = below.iter().map(|row| cutter.cut(&dialect.tidy(row)).len()).collect();
        if sentence.is_none()
            && let Some(&width) = widths.first().filter(|first| widths.iter().all(|width| width == *first))
        {
            candidate.header.part_from_row(width);
        }
        candidate.header.fit(below.iter().map(|row| dialect.tidy(row)), dialect.separator);
        candidate.header.name_ros2_imu();
        candidate
    }

    /// The first rows below `lines_above`, tidied.
    fn rows(&self, lines_above: usize) -> impl Iterator<Item = Cow<'a, [u8]>> {
        rows(self.lines, lines_above).map(|row| self.dialect.tidy(row))
    }

    fn field_reader(&self) -> FieldCutter {
        FieldCutter::of_head(self.dialect.separator)
    }

    /// Whether `row` has as many fields as this line, or a sentence with commas of its own. A
    /// comment may mention a channel.
    fn fits(&self, row: &[u8]) -> bool {
        let fields = self.field_reader().cut(&self.dialect.tidy(row)).len();
        fields == self.header.width() || memmem::find(row, b"$VN").is_some()
    }

    /// The plan, if this is the header.
    fn plan(&self, said: Said<'_>) -> Result<Option<CsvPlan>, CsvError> {
        match said.map {
            Some(map) if !map.channels.is_empty() => self.mapped(map, said.stream).map(Some),
            _ => self.named(said),
        }
    }

    /// The plan for a header with known names, or for sentences; the user may have named the
    /// columns of the stamps and of the sentences.
    fn named(&self, said: Said<'_>) -> Result<Option<CsvPlan>, CsvError> {
        // the file has no header
        let is_row = self.header.names.iter().any(|name| name.contains("$VN")) || self.header.is_first_row;
        let lines_above = self.index + usize::from(!is_row);
        let has_names = self.is_header_of_numbers() || self.header.is_first_row;
        let cells = self.cells(lines_above, false);
        let mut columns = Columns::by_name(&self.header, said.file, if has_names { &cells } else { &[] });
        let named_sentence = said.map.and_then(|map| map.sentence.as_ref());
        columns.sentence = match named_sentence {
            Some(column) => Some(self.header.mapped_place(RAW, column)?),
            None => self.sentence_column(lines_above),
        };
        if columns.sentence.is_some() {
            (columns.channels, columns.left_out) = (Vec::new(), Vec::new());
        } else if !columns.has_inertial_channel() {
            if !has_names && !self.is_table_of_numbers() {
                return Ok(None);
            }
            let stamps = if has_names { self.stamp_search(&columns, &cells).likely() } else { None };
            let map = suggestion(&self.header, stamps.as_ref(), &cells);
            return Err(CsvError::UnknownColumns {
                found: self.header.listed(&cells),
                left_out: columns.left_out,
                map,
            });
        } else if let Some(stream) = said.stream {
            columns.choose(stream)?;
        }
        let cells = self.cells_of(&columns, lines_above);
        let search = self.stamp_search(&columns, &cells);
        columns.stamp = match said.map.map_or(Ok(None), |map| search.mapped(map))? {
            Some(stamp) => Some(stamp),
            None if is_row && columns.sentence.is_some() => search.unnamed(),
            None => match search.found()? {
                // next to sentences, a column that can only be times is the stamp
                None if columns.sentence.is_some() => search.unnamed(),
                found => found,
            },
        };
        let stamp_places = columns.stamp.iter().flat_map(|stamp| &stamp.columns).map(|&(place, _)| place);
        for place in stamp_places {
            if let Some(taken) = columns.channels.iter().find(|column| column.place == place) {
                let stamp = said.map.and_then(|map| map.stamp.first());
                let column = stamp.map_or_else(|| self.header.argument(place), |(column, _)| column.to_string());
                return Err(CsvError::SameColumn { column, channels: [&known(taken.channel).name, STAMP] });
            }
        }
        if columns.sentence.is_some() && columns.stamp.is_none() && named_sentence.is_none() {
            // without times the file can be read as text just as well
            return Ok(None);
        }
        self.check_one_sensor(&columns, &cells)?;
        Ok(Some(self.complete(&columns, true, lines_above)))
    }

    /// The plan for columns named by the user.
    fn mapped(&self, map: &ColumnMap, stream: Option<&str>) -> Result<CsvPlan, CsvError> {
        let mut columns = Columns::mapped(&self.header, map)?;
        let is_row =
            self.header.is_row(map, columns.channels.iter().map(|column| column.place)) || self.header.is_first_row;
        let lines_above = self.index + usize::from(!is_row);
        if let Some(stream) = stream {
            columns.choose(stream)?;
        }
        let cells = self.cells_of(&columns, lines_above);
        let search = self.stamp_search(&columns, &cells);
        columns.stamp = search.mapped(map)?.or_else(|| search.likely());
        self.check_one_sensor(&columns, &cells)?;
        Ok(self.complete(&columns, false, lines_above))
    }

    fn check_one_sensor(&self, columns: &Columns, cells: &HeadRows) -> Result<(), CsvError> {
        let is_taken = |place: usize| columns.uses(place) || columns.others.contains(&place);
        match several_sensors(&self.header, cells, is_taken) {
            None => Ok(()),
            Some((place, sensors)) => Err(CsvError::SeveralSensors {
                column: self.header.names[place].clone(),
                place: place + 1,
                sensors: sensors.iter().map(|sensor| shown(sensor)).collect(),
            }),
        }
    }

    /// The column in which most of the first rows hold a sentence, under any name.
    fn sentence_column(&self, lines_above: usize) -> Option<usize> {
        let mut reader = self.field_reader();
        let mut found = vec![0_u32; self.header.names.len()];
        for row in self.rows(lines_above) {
            let place = reader.cut(&row).iter().position(|cell| memmem::find(cell, b"$VN").is_some());
            if let Some(count) = place.and_then(|place| found.get_mut(place)) {
                *count += 1;
            }
        }
        let most = found.iter().copied().max().filter(|&most| most > 0)?;
        found.iter().position(|&count| count == most)
    }

    /// The fields of the first rows; a sentence has commas of its own.
    fn cells(&self, lines_above: usize, of_sentences: bool) -> Vec<Vec<Vec<u8>>> {
        let mut reader = self.field_reader();
        let cut = self.rows(lines_above).map(|row| reader.cut(&row).iter().map(<[u8]>::to_vec).collect::<Vec<_>>());
        // a second header may give another order to the columns of the rows below it
        let is_header = |row: &Vec<Vec<u8>>| {
            let is_name = |cell: &Vec<u8>| self.header.names.contains(&shown(cell));
            let are_names = row.iter().all(|cell| cell.is_empty() || is_name(cell) && Number::parse(cell).is_none());
            row.len() > 1 && are_names && row.iter().any(is_name)
        };
        cut.take_while(|row| !is_header(row))
            .filter(|cells| cells.len() == self.header.width() || of_sentences)
            .collect()
    }

    /// The fields of the first rows of its stream.
    fn cells_of(&self, columns: &Columns, lines_above: usize) -> Vec<Vec<Vec<u8>>> {
        let mut cells = self.cells(lines_above, columns.sentence.is_some());
        if !columns.others.is_empty() {
            cells.retain(|row| columns.channels.iter().any(|column| holds_number(row, column.place)));
        }
        cells
    }

    fn stamp_search<'b>(&'b self, columns: &Columns, rows: &'b HeadRows) -> StampSearch<'b> {
        let channels = columns.channels.iter().map(|column| column.place);
        let taken = channels.chain(columns.sentence).chain(columns.others.iter().copied()).collect();
        StampSearch { header: &self.header, rows, taken, has_sentences: columns.sentence.is_some() }
    }

    /// Whether a row of numbers follows a line of names.
    fn is_header_of_numbers(&self) -> bool {
        let Some(row) = self.rows(self.index + 1).next() else {
            return false;
        };
        let mut reader = self.field_reader();
        let fields = reader.cut(&row);
        self.header.names_columns()
            && fields.len() == self.header.width()
            && fields.iter().any(|field| Number::parse(field).is_some())
    }

    /// Whether rows of as many numbers follow a row of numbers: a table without names.
    fn is_table_of_numbers(&self) -> bool {
        let mut reader = self.field_reader();
        let mut are_numbers = |row: Cow<'_, [u8]>| {
            let fields = reader.cut(&row);
            fields.len() == self.header.width() && fields.iter().all(|field| Number::parse(field).is_some())
        };
        let rows = self.rows(self.index + 1).take(FITTED_ROWS).filter(|row| are_numbers(row.clone())).count();
        self.header.is_all_numbers() && rows + 1 >= FITTED_ROWS
    }

    /// Completes a plan with the properties of the first rows. Columns that are recognised by their
    /// names may be those of a message of the sensor.
    fn complete(&self, columns: &Columns, are_named: bool, lines_above: usize) -> CsvPlan {
        let times = columns.stamp.as_ref().map(|stamp| stamp.named(&self.header));
        let kind = match columns.sentence {
            Some(_) => Kind::Sentences,
            None => Kind::Values(self.layout(columns, are_named, times.clone())),
        };
        let cells = self.cells_of(columns, lines_above);
        let quantizer = |column: &ChannelColumn| {
            let channel = known(column.channel);
            let prior = match are_named && column.unit.name == channel.unit {
                true => Prior::of_sensor(channel),
                false => Prior::of_unit(&column.unit, channel),
            };
            Quantizer::new(&numbers_at(&cells, column.place).collect::<Vec<_>>(), prior)
        };
        let mut uses = vec![ColumnUse::Ignored; self.header.width()];
        for &(place, column) in columns.stamp.iter().flat_map(|stamp| &stamp.columns) {
            uses[place] = column;
        }
        if let Some(place) = columns.sentence {
            uses[place] = ColumnUse::Sentence;
        }
        for (slot, column) in columns.channels.iter().enumerate() {
            uses[column.place] = ColumnUse::Channel(slot);
        }
        for &place in &columns.others {
            uses[place] = ColumnUse::OtherStream;
        }
        let ends_in_sentence = uses.last() == Some(&ColumnUse::Sentence);
        CsvPlan {
            quantizers: columns.channels.iter().map(quantizer).collect(),
            kind,
            last_field: if ends_in_sentence { None } else { self.last_field(lines_above) },
            names: if lines_above > self.index { self.header.names.clone() } else { Vec::new() },
            ignored_columns: columns.ignored(&self.header),
            left_out: columns.left_out.clone(),
            line_end: self.line_end,
            dialect: self.dialect,
            columns: uses,
            times,
            date: columns.stamp.as_ref().and_then(StampColumns::date),
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
        let is_of_any_sensor = channels.iter().all(is_of_any_sensor);
        let has_attitude = channels.iter().any(|channel| channel.quantity.is_attitude());
        let message = MESSAGES.into_iter().find(|message| {
            are_named
                && *message.channels == *channels
                && (compensated.is_none() || message.compensated == compensated)
                && (has_attitude || compensated.is_some() && !is_of_any_sensor)
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
        let mut reader = self.field_reader();
        let ended = &self.lines[..self.lines.len() - 1];
        let forms = rows(ended, lines_above.min(ended.len())).filter_map(|row| {
            let row = self.dialect.tidy(row);
            let fields = reader.cut(&row);
            (fields.len() == self.header.width()).then(|| LastField::of(fields.last()))
        });
        forms.reduce(LastField::common)
    }
}

/// Whether inertial sensors of any make measure this channel.
fn is_of_any_sensor(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::MagneticField | Quantity::Acceleration | Quantity::AngularRate)
}

/// The first rows below `lines_above`.
fn rows<'a>(lines: &'a [&'a [u8]], lines_above: usize) -> impl Iterator<Item = &'a [u8]> {
    let below = lines[lines_above..].iter().copied();
    below.filter(|line| !is_comment_or_blank(line)).take(HEAD_ROWS)
}

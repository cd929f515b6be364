//! Finds the line that names the columns of a CSV file, and how the file is to be read then.

use std::borrow::Cow;

use memchr::memmem;
use vn100_protocol::{Channel, Layout, MESSAGES, Quantity};

use super::{
    BYTE_ORDER_MARK, ColumnUse, CsvError, CsvPlan, Kind,
    column_map::{ColumnMap, MappedChannel, RAW, STAMP, known},
    dialect::Dialect,
    fields::{FieldCutter, LastField},
    guess::guess,
    header::{ColumnPlaces, Header},
    lines::is_comment_or_blank,
    number::Number,
    resolution::{HEAD_ROWS, Prior, Quantizer},
    sensor_column::several_sensors,
    shown,
    stamp_columns::StampColumns,
    stamp_search::StampSearch,
};

/// Comments above the first row that are looked at for the names of the columns: the nearest to it.
const COMMENTS_ABOVE: usize = 100;

/// Decides how to read the CSV file that begins with `head`; `None` when it is none, or none that
/// holds anything of a VN-100.
///
/// Whole lines for 1000 rows are wanted in `head` ([`HEAD_BYTES`](super::HEAD_BYTES) of it); with
/// fewer the decimals are judged by those.
///
/// Without `map` the columns are known by their names, and the numbers are in the sensor's units.
/// Of numbers, those of `stream` are read, else all.
///
/// # Errors
/// [`CsvError`] when this is a CSV file but lacks the columns, or the stamps.
pub(crate) fn detect(head: &[u8], map: Option<&ColumnMap>, stream: Option<&str>) -> Result<Option<CsvPlan>, CsvError> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let line_end = if head.contains(&b'\r') && !head.contains(&b'\n') { b'\r' } else { b'\n' };
    let lines: Vec<&[u8]> =
        head.split(|&byte| byte == line_end).map(|line| line.strip_suffix(b"\r").unwrap_or(line)).collect();
    // a zero byte in the names of the columns is no damage: binary data, or UTF-16
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
        match candidate.plan(map, stream) {
            Ok(Some(plan)) => return Ok(Some(plan)),
            Err(error) if error.knows_columns() => problem = Some(error),
            // a comment in words
            Ok(None) | Err(_) => {}
        }
    }
    let plan = HeaderCandidate::new(lines[first], &lines, line_end, first).plan(map, stream);
    match (&plan, problem) {
        (Ok(Some(_)), _) => plan,
        (Err(error), _) if error.knows_columns() => plan,
        (_, Some(problem)) => Err(problem),
        _ => below_preamble(&lines, first, line_end, map, stream).unwrap_or(plan),
    }
}

/// The plan of a file whose names of columns, or whose rows, stand below lines of another kind.
fn below_preamble(
    lines: &[&[u8]],
    first: usize,
    line_end: u8,
    map: Option<&ColumnMap>,
    stream: Option<&str>,
) -> Option<Result<Option<CsvPlan>, CsvError>> {
    let last = lines.len().min(first + LONGEST_PREAMBLE);
    for index in (first + 1..last).filter(|&index| !is_comment_or_blank(lines[index])) {
        let candidate = HeaderCandidate::new(lines[index], lines, line_end, index);
        let fits = candidate.rows(index + 1).next().is_some_and(|row| candidate.fits(&row));
        // a name of one word may stand in any text
        if !fits || candidate.header.width() < 2 {
            continue;
        }
        let plan = candidate.plan(map, stream);
        let names_none = |error: &CsvError| {
            map.is_some() && matches!(error, CsvError::MissingColumn { .. }) && candidate.is_header_of_numbers()
        };
        let is_evident = |error: &CsvError| error.knows_columns() || names_none(error);
        if matches!(&plan, Ok(Some(_))) || plan.as_ref().is_err_and(is_evident) {
            return Some(plan);
        }
    }
    None
}

/// Lines of another kind above the names of the columns, at most.
const LONGEST_PREAMBLE: usize = 100;

/// Rows that show how many fields a row has: few, as every comment above them may be a header.
const FITTED_ROWS: usize = 50;

/// A line that may be the header.
struct HeaderCandidate<'a> {
    header: Header,
    dialect: Dialect,
    /// The head of the file.
    lines: &'a [&'a [u8]],
    /// What ends them.
    line_end: u8,
    /// Its place among the lines; of the units below it where there are some.
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
        let (names, separator) = dialect.header(names);
        let mut candidate = Self { header: Header::read(&names, separator), dialect, lines, line_end, index };
        // the commas of a sentence in the first row part no columns
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
        candidate.header.fit(below.iter().map(|row| dialect.tidy(row)), dialect.separator);
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
    /// comment may name a channel in passing.
    fn fits(&self, row: &[u8]) -> bool {
        let fields = self.field_reader().cut(&self.dialect.tidy(row)).len();
        fields == self.header.width() || memmem::find(row, b"$VN").is_some()
    }

    /// The plan, if this is the header.
    fn plan(&self, map: Option<&ColumnMap>, stream: Option<&str>) -> Result<Option<CsvPlan>, CsvError> {
        match map {
            Some(map) if !map.channels.is_empty() => self.mapped(map, stream).map(Some),
            map => self.named(map, stream),
        }
    }

    /// The plan for a header with known names, or for sentences; the user may have named the
    /// columns of the stamps and of the sentences.
    fn named(&self, map: Option<&ColumnMap>, stream: Option<&str>) -> Result<Option<CsvPlan>, CsvError> {
        let mut places = self.header.known_places();
        // a file of sentences without a header
        let is_row = self.header.names.iter().any(|name| name.contains("$VN"));
        let lines_above = self.index + usize::from(!is_row);
        let said = map.and_then(|map| map.sentence.as_ref());
        places.sentence = match said {
            Some(column) => Some(self.header.mapped_place(RAW, column)?),
            None => self.sentence_column(lines_above),
        };
        if places.sentence.is_some() {
            places.channels.clear();
        } else if !places.has_inertial_channel() {
            let has_names = self.is_header_of_numbers();
            if !has_names && !self.is_table_of_numbers() {
                return Ok(None);
            }
            let cells = self.cells(&places, self.index + usize::from(has_names));
            let search = self.stamp_search(&places, &cells);
            let stamps = if has_names { search.likely() } else { search.unnamed() };
            let guess = guess(&self.header, stamps.as_ref(), &cells);
            return Err(CsvError::UnknownColumns { found: self.header.given_names(), guess });
        } else if let Some(stream) = stream {
            places.choose(stream)?;
        }
        let cells = self.cells(&places, lines_above);
        let search = self.stamp_search(&places, &cells);
        places.stamp = match map.map_or(Ok(None), |map| search.mapped(map))? {
            Some(stamp) => Some(stamp),
            None if is_row => search.unnamed(),
            None => match search.found()? {
                // beside sentences what can only be times is
                None if places.sentence.is_some() => search.unnamed(),
                found => found,
            },
        };
        let stamp_places = places.stamp.iter().flat_map(|stamp| &stamp.columns).map(|&(place, _)| place);
        for place in stamp_places {
            if let Some(&(_, channel)) = places.channels.iter().find(|(taken, _)| *taken == place) {
                let said = map.and_then(|map| map.stamp.first());
                let column = said.map_or_else(|| self.header.argument(place), |(column, _)| column.to_string());
                return Err(CsvError::SameColumn { column, channels: [&known(channel).name, STAMP] });
            }
        }
        if places.sentence.is_some() && places.stamp.is_none() && said.is_none() {
            // without times the text is as good
            return Ok(None);
        }
        self.check_one_sensor(&places, &cells)?;
        places.channels.sort_by_key(|&(_, channel)| channel);
        let unit_of = |index: usize| places.units.iter().find(|(channel, _)| *channel == index).map(|&(_, unit)| unit);
        let channel = |&(_, index): &(usize, usize)| {
            let scale = unit_of(index).map_or(1.0, |unit| unit.scale);
            Channel { scale, ..known(index).clone() }
        };
        let channels: Vec<_> = places.channels.iter().map(channel).collect();
        let prior = |&(_, index): &(usize, usize)| match (unit_of(index), known(index)) {
            (Some(unit), channel) if *unit.name != *channel.unit => Prior::of_unit(unit, range(known(index))),
            (_, channel) => Prior {
                decimals: channel.decimals,
                limit: Some(channel.value(channel.limit_counts)),
                range: range(channel),
                zero_hundredths: 0,
            },
        };
        let priors: Vec<_> = places.channels.iter().map(prior).collect();
        let kind = match places.sentence {
            Some(_) => Kind::Sentences,
            None => Kind::Values(self.named_layout(channels)),
        };
        Ok(Some(self.complete(&places, kind, priors, lines_above)))
    }

    /// The plan for columns named by the user.
    fn mapped(&self, map: &ColumnMap, stream: Option<&str>) -> Result<CsvPlan, CsvError> {
        let mut places = self.header.mapped_places(map)?;
        let is_row = self.header.is_row(map, &places);
        let lines_above = self.index + usize::from(!is_row);
        if let Some(stream) = stream {
            places.choose(stream)?;
        }
        let cells = self.cells(&places, lines_above);
        let search = self.stamp_search(&places, &cells);
        places.stamp = search.mapped(map)?.or_else(|| search.likely());
        self.check_one_sensor(&places, &cells)?;
        places.channels.sort_by_key(|&(_, channel)| channel);
        let is_chosen = |mapped: &&MappedChannel| places.channels.iter().any(|&(_, channel)| channel == mapped.index);
        let mut mapped: Vec<_> = map.channels.iter().filter(is_chosen).collect();
        mapped.sort_by_key(|mapped| mapped.index);
        let channel = |mapped: &&MappedChannel| match known(mapped.index) {
            series if series.quantity == Quantity::Value => {
                Channel { unit: mapped.unit.name.clone(), ..series.clone() }
            }
            known => Channel { scale: mapped.unit.scale, ..known.clone() },
        };
        let channels: Vec<Channel> = mapped.iter().map(channel).collect();
        let compensated = self.said_compensated();
        let layout = Layout { message: "CSV".into(), compensated, channels: channels.into() };
        let priors: Vec<_> =
            mapped.iter().map(|mapped| Prior::of_unit(&mapped.unit, range(known(mapped.index)))).collect();
        Ok(self.complete(&places, Kind::Values(layout), priors, lines_above))
    }

    /// Whether the first rows are of one sensor.
    fn check_one_sensor(&self, places: &ColumnPlaces, cells: &[Vec<Vec<u8>>]) -> Result<(), CsvError> {
        let is_taken = |place: usize| places.uses(place) || places.others.contains(&place);
        match several_sensors(&self.header, cells, is_taken) {
            None => Ok(()),
            Some((place, sensors)) => Err(CsvError::SeveralSensors {
                column: self.header.names[place].clone(),
                place: place + 1,
                sensors: sensors.iter().map(|sensor| shown(sensor)).collect(),
            }),
        }
    }

    /// The column in which most of the first rows hold a sentence, whatever it is called.
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

    /// The fields of the first rows, of those of its stream.
    fn cells(&self, places: &ColumnPlaces, lines_above: usize) -> Vec<Vec<Vec<u8>>> {
        let mut reader = self.field_reader();
        let cut = self.rows(lines_above).map(|row| reader.cut(&row).iter().map(<[u8]>::to_vec).collect::<Vec<_>>());
        // a sentence has commas of its own
        cut.filter(|cells| cells.len() == self.header.width() || places.sentence.is_some())
            .filter(|cells| {
                places.others.is_empty() || places.channels.iter().any(|&(place, _)| holds_number(cells, place))
            })
            .collect()
    }

    fn stamp_search<'b>(&'b self, places: &ColumnPlaces, rows: &'b [Vec<Vec<u8>>]) -> StampSearch<'b> {
        let channels = places.channels.iter().map(|&(place, _)| place);
        let taken = channels.chain(places.sentence).chain(places.others.iter().copied()).collect();
        StampSearch { header: &self.header, rows, taken, has_sentences: places.sentence.is_some() }
    }

    /// The layout of channels found by name: that of a message of the sensor where the channels are
    /// its very own and an attitude is among them, or the file names it, or says of such a set of
    /// channels whether it is compensated.
    fn named_layout(&self, channels: Vec<Channel>) -> Layout {
        let compensated = self.said_compensated();
        let is_of_any_sensor = channels.iter().all(is_of_any_sensor);
        let has_attitude = channels.iter().any(|channel| channel.quantity.is_attitude());
        let message = MESSAGES.into_iter().find(|message| {
            *message.channels == *channels
                && (compensated.is_none() || message.compensated == compensated)
                && (has_attitude || self.says(&message.message) || compensated.is_some() && !is_of_any_sensor)
        });
        match message {
            Some(message) => Layout { compensated, ..message.clone() },
            None => Layout { message: "CSV".into(), compensated, channels: channels.into() },
        }
    }

    /// Whether the file says in its header or above it that its values are compensated: by the name
    /// of a message, or with `uncomp`. The names of columns are the same for both.
    fn said_compensated(&self) -> Option<bool> {
        if self.says("uncomp") {
            return Some(false);
        }
        let mut named =
            MESSAGES.iter().filter(|message| self.says(&message.message)).map(|message| message.compensated);
        let first = named.next()?;
        first.filter(|_| named.all(|other| other == first))
    }

    /// Whether `word` stands in the header or in a line above it, in any case of letters.
    fn says(&self, word: &str) -> bool {
        let word = word.to_ascii_lowercase();
        let above = &self.lines[..=self.index];
        above.iter().any(|line| memmem::find(&line.to_ascii_lowercase(), word.as_bytes()).is_some())
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

    /// Completes a plan with what the first rows show, the unit of the stamps too if it is not
    /// given.
    fn complete(&self, places: &ColumnPlaces, kind: Kind, priors: Vec<Prior>, lines_above: usize) -> CsvPlan {
        let numbers = self.first_numbers(places, lines_above);
        let quantizers = numbers.iter().zip(priors).map(|(numbers, prior)| Quantizer::new(numbers, prior));
        let mut columns = vec![ColumnUse::Ignored; self.header.width()];
        for &(place, column) in places.stamp.iter().flat_map(|stamp| &stamp.columns) {
            columns[place] = column;
        }
        if let Some(place) = places.sentence {
            columns[place] = ColumnUse::Sentence;
        }
        for (slot, &(place, _)) in places.channels.iter().enumerate() {
            columns[place] = ColumnUse::Channel(slot);
        }
        for &place in &places.others {
            columns[place] = ColumnUse::OtherStream;
        }
        let ends_in_sentence = columns.last() == Some(&ColumnUse::Sentence);
        CsvPlan {
            kind,
            last_field: (!ends_in_sentence).then(|| self.last_field(lines_above)),
            ignored_columns: places.ignored(&self.header),
            line_end: self.line_end,
            dialect: self.dialect,
            columns,
            quantizers: quantizers.collect(),
            times: places.stamp.as_ref().map(|stamp| stamp.named(&self.header)),
            clock: places.stamp.as_ref().and_then(StampColumns::clock),
            repeated_step_ns: places.stamp.as_ref().and_then(|stamp| stamp.repeated_step_ns),
            lines_above: lines_above as u64,
        }
    }

    /// How the first rows end that do have a line end.
    fn last_field(&self, lines_above: usize) -> LastField {
        let mut reader = self.field_reader();
        let ended = &self.lines[..self.lines.len() - 1];
        let forms = rows(ended, lines_above.min(ended.len())).filter_map(|row| {
            let row = self.dialect.tidy(row);
            let fields = reader.cut(&row);
            (fields.len() == self.header.width()).then(|| LastField::of(fields.last()))
        });
        forms.reduce(LastField::common).unwrap_or_default()
    }

    /// The numbers of the first rows in the column of each channel.
    fn first_numbers(&self, places: &ColumnPlaces, lines_above: usize) -> Vec<Vec<Number>> {
        let mut numbers = vec![Vec::new(); places.channels.len()];
        for cells in self.cells(places, lines_above) {
            for (numbers, &(place, _)) in numbers.iter_mut().zip(&places.channels) {
                numbers.extend(cells.get(place).and_then(|cell| Number::parse(cell)));
            }
        }
        numbers
    }
}

/// The largest magnitude that a sensor measures in this channel; an angle may turn several times,
/// and of a series nothing is known.
fn range(channel: &Channel) -> f64 {
    match channel.quantity {
        Quantity::Value => 0.0,
        Quantity::Angle => TURNS * channel.value(channel.limit_counts),
        _ => channel.value(channel.limit_counts),
    }
}

/// The counts of an angle continue beyond a turn: there is room for this many times the largest.
const TURNS: f64 = 8.0;

/// Whether inertial sensors of any make measure it.
fn is_of_any_sensor(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::MagneticField | Quantity::Acceleration | Quantity::AngularRate)
}

fn holds_number(cells: &[Vec<u8>], place: usize) -> bool {
    cells.get(place).is_some_and(|cell| Number::parse(cell).is_some())
}

/// The first rows below `lines_above`.
fn rows<'a>(lines: &'a [&'a [u8]], lines_above: usize) -> impl Iterator<Item = &'a [u8]> {
    let below = lines[lines_above..].iter().copied();
    below.filter(|line| !is_comment_or_blank(line)).take(HEAD_ROWS)
}

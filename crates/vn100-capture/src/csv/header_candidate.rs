//! A line that may be the header of a CSV file, and the plan that follows if it is.

use memchr::memmem;
use vn100_protocol::{Channel, Layout, MESSAGES, Quantity};

use super::{
    CsvError,
    channel::known,
    column_map::{ColumnMap, ColumnName, MappedChannel},
    fields::{Fields, is_comment_or_blank},
    header::{Header, Places},
    number::{LastDigit, Number},
    plan::{Column, Kind, Plan, Scale},
    resolution::{self, ColumnScan, Prior},
    shown,
    stamp::{StampScan, StampUnit},
    unended_row::LastField,
};

/// Rows that show how many fields a row has; fewer than are scanned, for every comment above them
/// may be a header.
const FITTED_ROWS: usize = 50;

/// A line that may be the header.
pub(super) struct HeaderCandidate<'a> {
    header: Header,
    /// The head of the file.
    lines: &'a [&'a [u8]],
    /// What ends them.
    line_end: u8,
    /// Its place among the lines.
    index: usize,
}

/// How the columns of a file are understood.
struct Reading {
    places: Places,
    kind: Kind,
    priors: Vec<Prior>,
    /// As in [`Unit`](super::channel::Unit), one per channel.
    zeros_hundredths: Vec<i64>,
    /// `None` where it follows from the stamps.
    stamp_unit: Option<StampUnit>,
    lines_above: usize,
}

impl<'a> HeaderCandidate<'a> {
    /// The line at `index`, which names the columns in the text `names`.
    pub(super) fn new(names: &[u8], lines: &'a [&'a [u8]], line_end: u8, index: usize) -> Self {
        let mut candidate = Self { header: Header::read(names), lines, line_end, index };
        candidate.header.fit(rows(lines, index + 1).take(FITTED_ROWS));
        candidate
    }

    /// Whether `row` has as many fields as this line, or a sentence with commas of its own. A
    /// comment may name a channel in passing.
    pub(super) fn fits(&self, row: &[u8]) -> bool {
        let fields = Fields::new(row, self.header.separator).count();
        fields == self.header.width() || memmem::find(row, b"$VN").is_some()
    }

    /// The plan, if this is the header.
    pub(super) fn plan(&self, map: Option<&ColumnMap>) -> Result<Option<Plan>, CsvError> {
        match map {
            Some(map) if !map.channels.is_empty() => self.mapped(map),
            Some(map) => self.named(map.stamp.as_ref()),
            None => self.named(None),
        }
    }

    /// The plan for a header with known names, of which the user may have named the stamp's.
    fn named(&self, stamp: Option<&(ColumnName, StampUnit)>) -> Result<Option<Plan>, CsvError> {
        let mut places = match stamp {
            Some((column, _)) => self.header.known_places_stamped(column)?,
            None => self.header.known_places(),
        };
        let lines_above = self.index + 1;
        let sentences = places.stamp.is_some() && places.sentence.is_some() && {
            let mut rows = rows(self.lines, lines_above);
            rows.any(|row| memmem::find(row, b"$VN").is_some())
        };
        if sentences {
            places.channels.clear();
        } else {
            places.sentence = None;
            if !places.has_inertial_channel() {
                return if self.is_header_of_numbers() {
                    Err(CsvError::UnknownColumns { found: self.header.names.clone() })
                } else {
                    Ok(None)
                };
            }
        }
        places.channels.sort_by_key(|&(_, channel)| channel);
        let channels = || places.channels.iter().map(|&(_, index)| known(index));
        let kind =
            if sentences { Kind::Sentences } else { Kind::Values(self.named_layout(channels().cloned().collect())) };
        let priors = channels()
            .map(|channel| Prior { decimals: channel.decimals, limit: Some(channel.value(channel.limit_counts)) });
        self.complete(Reading {
            kind,
            priors: priors.collect(),
            zeros_hundredths: vec![0; places.channels.len()],
            stamp_unit: stamp.map(|&(_, unit)| unit),
            lines_above,
            places,
        })
        .map(Some)
    }

    /// The plan for columns named by the user.
    fn mapped(&self, map: &ColumnMap) -> Result<Option<Plan>, CsvError> {
        let mut places = self.header.mapped_places(map)?;
        let is_row = self.header.is_row(map, &places);
        let lines_above = self.index + usize::from(!is_row);
        if places.stamp.is_none() && !is_row {
            places.stamp = self.likely_stamp(&places, lines_above);
        }
        places.channels.sort_by_key(|&(_, channel)| channel);
        let mut mapped: Vec<_> = map.channels.iter().collect();
        mapped.sort_by_key(|mapped| mapped.index);
        let channel = |mapped: &&MappedChannel| Channel { scale: mapped.unit.scale, ..known(mapped.index).clone() };
        let channels: Vec<Channel> = mapped.iter().map(channel).collect();
        let layout = Layout {
            message: "CSV".into(),
            compensated: channels.iter().any(|channel| channel.quantity.is_attitude()),
            channels: channels.into(),
        };
        let priors = mapped.iter().map(|mapped| Prior {
            // the distance between two zeros must be a whole count
            decimals: if mapped.unit.zero_hundredths == 0 { 0 } else { 2 },
            limit: None,
        });
        self.complete(Reading {
            kind: Kind::Values(layout),
            priors: priors.collect(),
            zeros_hundredths: mapped.iter().map(|mapped| mapped.unit.zero_hundredths).collect(),
            stamp_unit: map.stamp.as_ref().map(|&(_, unit)| unit),
            lines_above,
            places,
        })
        .map(Some)
    }

    /// The column of the stamps by its name, where the user mapped other columns only: if it holds
    /// times whose unit is sure. Otherwise it may be anything.
    fn likely_stamp(&self, mapped: &Places, lines_above: usize) -> Option<usize> {
        let place = self.header.known_places().stamp?;
        let is_free = mapped.channels.iter().all(|&(taken, _)| taken != place);
        let places = Places { stamp: Some(place), ..Places::default() };
        let (_, stamps) = self.first_rows(&places, lines_above).ok().filter(|_| is_free)?;
        stamps.are_times().then_some(place)
    }

    /// The layout of channels found by name. Uncompensated only when the file says so in its header
    /// or a comment above, with `uncomp` or the name of an uncompensated message: the names of the
    /// columns are the same for both, and to take compensated rates for uncompensated ones would
    /// claim a bias instability that is not the sensor's. A message of nothing but what any
    /// inertial sensor measures must be named, too.
    fn named_layout(&self, channels: Vec<Channel>) -> Layout {
        let head = self.lines[..=self.index].join(&b'\n').to_ascii_lowercase();
        let says = |word: &str| memmem::find(&head, word.to_ascii_lowercase().as_bytes()).is_some();
        let says_uncompensated =
            says("uncomp") || MESSAGES.iter().any(|message| !message.compensated && says(&message.message));
        let message = MESSAGES.into_iter().find(|message| {
            *message.channels == *channels
                && message.compensated != says_uncompensated
                && (message.channels.iter().any(|channel| !is_of_any_sensor(channel)) || says(&message.message))
        });
        match message {
            Some(message) => message.clone(),
            None => Layout { message: "CSV".into(), compensated: !says_uncompensated, channels: channels.into() },
        }
    }

    /// Whether a row of numbers follows a line of names.
    fn is_header_of_numbers(&self) -> bool {
        let Some(row) = rows(self.lines, self.index + 1).next() else {
            return false;
        };
        let fields = || Fields::new(row, self.header.separator);
        self.header.names_columns()
            && fields().count() == self.header.width()
            && fields().any(|field| Number::parse(field).is_some())
    }

    /// Completes a plan with what the first rows show.
    fn complete(&self, reading: Reading) -> Result<Plan, CsvError> {
        let Reading { places, mut kind, .. } = reading;
        let (scans, stamps) = self.first_rows(&places, reading.lines_above)?;
        let mut columns = vec![Column::Ignored; self.header.width()];
        if let Some(place) = places.stamp {
            let unit = reading.stamp_unit.map_or_else(|| stamps.unit(), Ok);
            columns[place] = Column::Stamp(unit.map_err(|unsure| CsvError::StampUnit {
                column: self.header.names[place].clone(),
                argument: self.header.argument(place),
                step: unsure.step,
                units: unsure.units,
            })?);
        }
        if let Some(place) = places.sentence {
            columns[place] = Column::Sentence;
        }
        let mut scales = Vec::new();
        let mut rounded = Vec::new();
        for (slot, &(place, index)) in places.channels.iter().enumerate() {
            columns[place] = Column::Channel(slot);
            let prior = reading.priors[slot];
            let resolution = scans[slot].resolution(prior);
            if resolution.last_digit == LastDigit::Rounded {
                rounded.push(known(index).name.to_string());
            }
            scales.push(Scale::new(resolution, prior.limit, reading.zeros_hundredths[slot]));
        }
        if let Kind::Values(layout) = &mut kind {
            for (channel, scale) in layout.channels.to_mut().iter_mut().zip(&scales) {
                channel.decimals = scale.resolution.decimals;
                channel.limit_counts = scale.limit_counts;
            }
        }
        let ends_in_sentence = columns.last() == Some(&Column::Sentence);
        Ok(Plan {
            kind,
            last_field: (!ends_in_sentence).then(|| self.last_field(reading.lines_above)),
            ignored_columns: places.ignored(&self.header),
            rounded,
            line_end: self.line_end,
            separator: self.header.separator,
            columns,
            scales,
            lines_above: reading.lines_above as u64,
        })
    }

    /// How the first rows end that do have a line end.
    fn last_field(&self, lines_above: usize) -> LastField {
        let ended = &self.lines[..self.lines.len() - 1];
        let mut last_field = LastField::default();
        for row in rows(ended, lines_above.min(ended.len())) {
            let fields: Vec<_> = Fields::new(row, self.header.separator).collect();
            if let Some(last) = fields.last().filter(|_| fields.len() == self.header.width()) {
                last_field.add(last);
            }
        }
        last_field
    }

    /// What the first rows print in the column of each channel, and in that of the stamps.
    fn first_rows(&self, places: &Places, lines_above: usize) -> Result<(Vec<ColumnScan>, StampScan), CsvError> {
        let mut scans = vec![ColumnScan::default(); places.channels.len()];
        let mut stamps = StampScan::default();
        let mut unreadable_stamp = None;
        for row in rows(self.lines, lines_above) {
            let fields: Vec<_> = Fields::new(row, self.header.separator).collect();
            // a sentence has commas of its own
            if fields.len() != self.header.width() && places.sentence.is_none() {
                continue;
            }
            for (scan, &(place, _)) in scans.iter_mut().zip(&places.channels) {
                if let Some(number) = Number::parse(fields[place]) {
                    scan.add(&number);
                }
            }
            if let Some(&field) = places.stamp.and_then(|place| fields.get(place)) {
                match Number::parse(field) {
                    Some(stamp) => stamps.add(&stamp),
                    None => unreadable_stamp = unreadable_stamp.or(Some(field)),
                }
            }
        }
        match (places.stamp, unreadable_stamp) {
            (Some(place), Some(field)) if stamps.is_empty() => {
                Err(CsvError::Stamps { column: self.header.names[place].clone(), text: shown(field) })
            }
            _ => Ok((scans, stamps)),
        }
    }
}

/// Whether inertial sensors of any make measure it.
fn is_of_any_sensor(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::MagneticField | Quantity::Acceleration | Quantity::AngularRate)
}

/// The first rows below `lines_above`.
fn rows<'a>(lines: &'a [&'a [u8]], lines_above: usize) -> impl Iterator<Item = &'a [u8]> {
    let below = lines[lines_above..].iter().copied();
    below.filter(|line| !is_comment_or_blank(line)).take(resolution::SCANNED_ROWS)
}

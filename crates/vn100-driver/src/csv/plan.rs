//! How a CSV file is to be read, decided by its head alone.

use memchr::memmem;
use vn100_protocol::{Channel, Layout, Quantity, VNIMU, VNYMR};

use super::{
    BYTE_ORDER_MARK, CsvError,
    channel::{KNOWN, known},
    column_map::ColumnMap,
    fields::{Fields, is_comment_or_blank},
    header::{Header, Places},
    number::{LastDigit, Number},
    stamp::StampUnit,
    survey::{self, Prior, Resolution, Survey},
    tally::shown,
};

/// How a CSV file is to be read.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// What its rows are.
    pub(crate) kind: Kind,
    /// The columns that are not used, by their names in the file.
    pub(crate) ignored_columns: Vec<String>,
    /// The channels whose last digits are rounded away.
    pub(crate) rounded: Vec<Rounded>,
    pub(super) separator: u8,
    /// What each column is for.
    pub(super) columns: Vec<Column>,
    /// How the columns of channels become counts, in the order of the layout.
    pub(super) scales: Vec<Scale>,
    /// Lines before the first row.
    pub(super) lines_above: u64,
}

/// What the rows of a CSV file are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    /// Numbers, one per channel.
    Values(CsvLayout),
    /// Sentences as the sensor sent them.
    Sentences,
}

/// The channels of a file of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CsvLayout {
    /// Named after the message when it has exactly the channels of one, `CSV` otherwise. `unit` is the channel's own; a count is in
    /// units of the last of `decimals` in the file's unit.
    pub(crate) layout: Layout,
    /// For each channel how many of its own unit make one of the file's: `channel.value(count) * scale` is in `channel.unit`. All 1
    /// without a column map.
    pub(crate) scale: Vec<f64>,
}

/// A channel that is printed with more digits than are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Rounded {
    pub(crate) channel: &'static str,
    /// The most decimals seen in the first rows.
    pub(crate) printed_decimals: u32,
    pub(crate) kept_decimals: u8,
}

/// What a column is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    Ignored,
    Stamp(StampUnit),
    /// The channel at this place of the layout.
    Channel(usize),
    Sentence,
}

/// How a number becomes a count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub(super) resolution: Resolution,
    /// Taken off every count.
    pub(super) zero_counts: i64,
    pub(super) limit_counts: i32,
}

/// Decides how to read the CSV file that begins with `head`; `None` when it is none, or none that holds anything of a VN-100.
///
/// Whole lines for 1000 rows are wanted in `head` ([`HEAD_BYTES`](super::HEAD_BYTES) of it); with fewer the decimals are judged by those.
///
/// Without `map` the columns are known by their names, and the numbers are in the sensor's units.
///
/// # Errors
/// [`CsvError`] when this is a CSV file but lacks the columns, or the stamps.
pub(crate) fn recognise(head: &[u8], map: Option<&ColumnMap>) -> Result<Option<Plan>, CsvError> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let lines: Vec<&[u8]> = head
        .split(|&byte| byte == b'\n')
        .map(|line| line.strip_suffix(b"\r").unwrap_or(line))
        .collect();
    for (index, line) in lines.iter().enumerate() {
        // scripts that save arrays put a # before the names of the columns
        let names = match line.trim_ascii_start().strip_prefix(b"#") {
            Some(names) => names,
            None => line,
        };
        if names.trim_ascii().is_empty() {
            continue;
        }
        let header = Header::read(names);
        let candidate = Candidate {
            header: &header,
            lines: &lines,
            index,
        };
        let plan = match map {
            Some(map) => candidate.mapped(map),
            None => candidate.named(),
        };
        if matches!(plan, Ok(Some(_))) || !is_comment_or_blank(line) {
            return plan;
        }
    }
    Ok(None)
}

/// A line that may be the header.
struct Candidate<'a> {
    header: &'a Header,
    lines: &'a [&'a [u8]],
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
    /// `None` when the size of the stamps tells.
    stamp_unit: Option<StampUnit>,
    lines_above: usize,
}

impl Candidate<'_> {
    /// The plan for a header with known names.
    fn named(&self) -> Result<Option<Plan>, CsvError> {
        let mut places = self.header.known_places();
        let lines_above = self.index + 1;
        let sentences = places.stamp.is_some() && places.sentence.is_some() && {
            let mut rows = self.rows(lines_above);
            rows.any(|row| memmem::find(row, b"$VN").is_some())
        };
        if sentences {
            places.channels.clear();
        } else {
            places.sentence = None;
            if !places.has_inertial_channel() {
                return if self.is_header_of_numbers() {
                    Err(CsvError::UnknownColumns {
                        found: self.header.names.clone(),
                    })
                } else {
                    Ok(None)
                };
            }
        }
        places.channels.sort_by_key(|&(_, channel)| channel);
        let channels = || places.channels.iter().map(|&(_, index)| known(index));
        let kind = if sentences {
            Kind::Sentences
        } else {
            Kind::Values(CsvLayout {
                layout: self.named_layout(channels().cloned().collect()),
                scale: vec![1.0; places.channels.len()],
            })
        };
        let priors = channels().map(|channel| Prior {
            decimals: channel.decimals,
            limit: Some(channel.value(channel.limit_counts)),
        });
        self.survey(Reading {
            kind,
            priors: priors.collect(),
            zeros_hundredths: vec![0; places.channels.len()],
            stamp_unit: None,
            lines_above,
            places,
        })
        .map(Some)
    }

    /// The plan for columns named by the user.
    fn mapped(&self, map: &ColumnMap) -> Result<Option<Plan>, CsvError> {
        let mut places = self.header.mapped_places(map)?;
        let is_row = self.header.is_row(map, &places);
        places.channels.sort_by_key(|&(_, channel)| channel);
        let mut mapped: Vec<_> = map.channels.iter().collect();
        mapped.sort_by_key(|mapped| mapped.index);
        let channels: Vec<Channel> = mapped.iter().map(|mapped| known(mapped.index).clone()).collect();
        let layout = Layout {
            message: "CSV".into(),
            // angles come out of an attitude filter
            compensated: channels.iter().any(|channel| channel.quantity == Quantity::Angle),
            channels: channels.into(),
        };
        let priors = mapped.iter().map(|mapped| Prior {
            // the distance between two zeros must be a whole count
            decimals: if mapped.unit.zero_hundredths == 0 { 0 } else { 2 },
            limit: None,
        });
        self.survey(Reading {
            kind: Kind::Values(CsvLayout {
                layout,
                scale: mapped.iter().map(|mapped| mapped.unit.scale).collect(),
            }),
            priors: priors.collect(),
            zeros_hundredths: mapped.iter().map(|mapped| mapped.unit.zero_hundredths).collect(),
            stamp_unit: map.stamp.as_ref().map(|&(_, unit)| unit),
            lines_above: self.index + usize::from(!is_row),
            places,
        })
        .map(Some)
    }

    /// The layout of channels found by name. Uncompensated only when the file says so in its header or a comment above, with `VNIMU` or
    /// `uncomp`: the names of the columns are the same for both, and to take compensated rates for uncompensated ones would claim a bias
    /// instability that is not the sensor's.
    fn named_layout(&self, channels: Vec<Channel>) -> Layout {
        let says_uncompensated = self.lines[..=self.index].iter().any(|line| {
            let line = line.to_ascii_lowercase();
            [&b"vnimu"[..], b"uncomp"]
                .iter()
                .any(|word| memmem::find(&line, word).is_some())
        });
        let message = [&VNYMR, &VNIMU]
            .into_iter()
            .find(|message| *message.channels == *channels && message.compensated != says_uncompensated);
        match message {
            Some(message) => message.clone(),
            None => Layout {
                message: "CSV".into(),
                compensated: !says_uncompensated,
                channels: channels.into(),
            },
        }
    }

    /// Whether a row of numbers follows a line of names.
    fn is_header_of_numbers(&self) -> bool {
        let Some(row) = self.rows(self.index + 1).next() else {
            return false;
        };
        let fields = || Fields::new(row, self.header.separator);
        self.header.names_columns()
            && fields().count() == self.header.names.len()
            && fields().any(|field| Number::parse(field).is_some())
    }

    /// The first rows below `lines_above`.
    fn rows(&self, lines_above: usize) -> impl Iterator<Item = &[u8]> {
        let below = self.lines[lines_above..].iter().copied();
        below.filter(|line| !is_comment_or_blank(line)).take(survey::ROWS)
    }

    /// Completes a plan with what the first rows show.
    fn survey(&self, reading: Reading) -> Result<Plan, CsvError> {
        let Reading { places, mut kind, .. } = reading;
        let mut surveys = [Survey::default(); KNOWN];
        let mut first_stamp = None;
        let mut unreadable_stamp = None;
        for row in self.rows(reading.lines_above) {
            let fields: Vec<_> = Fields::new(row, self.header.separator).collect();
            if fields.len() != self.header.names.len() && places.sentence.is_none() {
                continue;
            }
            for (survey, &(place, _)) in surveys.iter_mut().zip(&places.channels) {
                if let Some(number) = Number::parse(fields[place]) {
                    survey.add(&number);
                }
            }
            if let Some(field) = places.stamp.and_then(|place| fields.get(place)) {
                match Number::parse(field) {
                    Some(stamp) => first_stamp = first_stamp.or(Some(stamp)),
                    None => unreadable_stamp = unreadable_stamp.or(Some(*field)),
                }
            }
        }
        if let (Some(place), None, Some(field)) = (places.stamp, first_stamp, unreadable_stamp) {
            return Err(CsvError::Stamps {
                column: self.header.names[place].clone(),
                text: shown(field),
            });
        }
        let mut columns = vec![Column::Ignored; self.header.names.len()];
        if let Some(place) = places.stamp {
            let by_magnitude = || first_stamp.as_ref().map(StampUnit::by_magnitude);
            let unit = reading.stamp_unit.or_else(by_magnitude);
            columns[place] = Column::Stamp(unit.unwrap_or(StampUnit::Seconds));
        }
        if let Some(place) = places.sentence {
            columns[place] = Column::Sentence;
        }
        let mut scales = Vec::new();
        let mut rounded = Vec::new();
        for (slot, &(place, index)) in places.channels.iter().enumerate() {
            columns[place] = Column::Channel(slot);
            let prior = reading.priors[slot];
            let resolution = surveys[slot].resolution(prior);
            if resolution.last_digit == LastDigit::Rounded {
                rounded.push(Rounded {
                    channel: &known(index).name,
                    printed_decimals: surveys[slot].printed_decimals(),
                    kept_decimals: resolution.decimals,
                });
            }
            scales.push(Scale::new(resolution, prior.limit, reading.zeros_hundredths[slot]));
        }
        if let Kind::Values(CsvLayout { layout, .. }) = &mut kind {
            for (channel, scale) in layout.channels.to_mut().iter_mut().zip(&scales) {
                channel.decimals = scale.resolution.decimals;
                channel.limit_counts = scale.limit_counts;
            }
        }
        Ok(Plan {
            kind,
            ignored_columns: places.ignored(self.header),
            rounded,
            separator: self.header.separator,
            columns,
            scales,
            lines_above: reading.lines_above as u64,
        })
    }
}

impl Scale {
    fn new(resolution: Resolution, limit: Option<f64>, zero_hundredths: i64) -> Self {
        let power = 10_f64.powi(resolution.decimals.into());
        // a cast saturates
        let limit_counts = limit.map_or(i32::MAX, |limit| (limit * power).round() as i32);
        Self {
            resolution,
            zero_counts: (zero_hundredths as f64 * power / 100.0) as i64,
            limit_counts,
        }
    }
}

impl Plan {
    /// Whether the rows have stamps.
    pub(crate) fn is_stamped(&self) -> bool {
        self.columns.iter().any(|column| matches!(column, Column::Stamp(_)))
    }
}

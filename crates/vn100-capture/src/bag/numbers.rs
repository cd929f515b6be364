//! The numbers of a message that are channels, and the size of a count of each.

use std::{collections::BTreeMap, sync::Arc};

use vn100_protocol::{Channel, ColumnRead, ColumnsRead, Layout, Quantity, stream::StampSource};

use super::{
    definition::Definitions,
    fields::{Leaf, PathTarget, Step, places, steps},
    files::Bag,
    message_reader::{Taken, take},
    standard_types::{PARTS, Part},
    topic::{BagError, Topic},
    topic_scan::{ScannedTopic, unusable_definition},
};
use crate::csv::{ColumnMap, Unit, by_name, known, units};

/// How the messages of a topic become rows of counts.
#[derive(Debug)]
pub(super) struct NumberFields {
    pub(super) layout: Layout,
    /// The definition of the messages, and the steps to the numbers and to the time.
    definitions: Definitions,
    steps: Vec<Step>,
    slots: Vec<Taken>,
    /// In the order of the layout.
    quantizers: Vec<Quantizer>,
    /// The slots of the time in the message, if that time is used: one for each part, with its unit
    /// in nanoseconds if the part is a number.
    stamp: Vec<(usize, i64)>,
    pub(super) stamp_source: StampSource,
    /// The paths of numbers that are zero in the first messages and are not read, with their slots.
    zero: Vec<(String, Vec<usize>)>,
    /// The first of these that is not zero later.
    pub(super) late: Option<String>,
}

/// A count is 2^-`bits` of the unit in the message.
#[derive(Debug, Clone, Copy)]
struct Quantizer {
    slot: usize,
    counts_per_unit: f64,
    /// The value in the message for a channel of zero.
    zero: f64,
}

/// The numbers of a message.
#[derive(Debug, Default)]
pub(super) struct Row {
    /// The counts, in the order of the layout.
    pub(super) counts: Vec<i32>,
    /// The channels that the message lacks, in order.
    pub(super) absent: Vec<(usize, Absence)>,
}

/// Why a number has no count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Absence {
    NotANumber,
    /// The number exceeds 32 bits.
    OutOfRange,
}

/// The message ends too early, or has another form.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unreadable;

/// A channel, the path of its number, and the size of a count.
struct NumberField {
    place: usize,
    path: String,
    unit: Unit,
    bits: i32,
}

impl NumberField {
    fn channel(&self) -> Channel {
        let own = known(self.place);
        let is_series = own.quantity == Quantity::Value;
        Channel {
            unit: if is_series { self.unit.name.clone() } else { own.unit.clone() },
            decimals: 0,
            scale: self.unit.scale * 2_f64.powi(-self.bits),
            limit_counts: i32::MAX,
            ..own.clone()
        }
    }

    fn column(&self) -> ColumnRead {
        ColumnRead { name: self.path.clone(), unit: self.unit.name.to_string() }
    }
}

/// The paths of values in a message, each with its slot.
#[derive(Default)]
struct Slots(BTreeMap<String, usize>);

impl Slots {
    fn of(&mut self, path: String) -> usize {
        let next = self.0.len();
        *self.0.entry(path).or_insert(next)
    }
}

impl NumberFields {
    /// All standard numbers that the messages have.
    pub(super) fn standard(topic: &ScannedTopic, columns: Option<&ColumnMap>) -> Result<Self, BagError> {
        let mut fields = Vec::new();
        for (part, prefix) in &topic.parts {
            for (channel, path) in part.channels() {
                // only known channels and units are in the table of the parts
                let Some(place) = by_name(&channel) else { continue };
                let unit = units(known(place).quantity).find(|unit| unit.scale == part.unit_scale).cloned();
                let path = format!("{prefix}{path}");
                fields.extend(unit.map(|unit| NumberField { place, path, unit, bits: part.bits.into() }));
            }
        }
        let mut numbers = Self::new(topic, fields, columns, &topic.zero_parts)?;
        let rates = topic.parts.iter().find(|(part, _)| part.channel == "gyro");
        numbers.layout.compensated = rates.and_then(|(part, _)| part.compensated());
        Ok(numbers)
    }

    /// Only the time that a column map names, for messages of sentences; `None` if the map names
    /// none.
    pub(super) fn of_time(topic: &ScannedTopic, map: &ColumnMap) -> Result<Option<Self>, BagError> {
        map.stamp_columns().next().map(|_| Self::new(topic, Vec::new(), Some(map), &[])).transpose()
    }

    /// The numbers that a column map names by their paths.
    pub(super) fn mapped(topic: &ScannedTopic, map: &ColumnMap) -> Result<Self, BagError> {
        let fields = map.channels.iter().map(|mapped| {
            let (place, unit) = (mapped.index, mapped.unit.clone());
            let bits = bits(known(place).quantity, unit.scale);
            NumberField { place, path: mapped.column.clone(), unit, bits }
        });
        Self::new(topic, fields.collect(), Some(map), &[])
    }

    fn new(
        topic: &ScannedTopic,
        mut fields: Vec<NumberField>,
        columns: Option<&ColumnMap>,
        zero_parts: &[(&Part, String)],
    ) -> Result<Self, BagError> {
        fields.sort_by_key(|field| field.place);
        let type_name = &topic.topic.type_name;
        let definitions = topic.definitions()?;
        let all: BTreeMap<_, _> = places(definitions, type_name).into_iter().collect();
        let is_number = |path: &String| matches!(all.get(path), Some(PathTarget::Leaf(Leaf::Number(_))));
        if let Some(other) = fields.iter().find(|field| !is_number(&field.path)) {
            return Err(no_field(topic, &other.path));
        }
        let mut slots = Slots::default();
        let quantizer = |field: &NumberField| Quantizer {
            slot: slots.of(field.path.clone()),
            counts_per_unit: 2_f64.powi(field.bits),
            zero: field.unit.zero,
        };
        let quantizers = fields.iter().map(quantizer).collect();
        let stamp = stamp_paths(topic, columns, &all)?;
        let paths: Vec<&str> = stamp.iter().map(|(path, _)| &**path).collect();
        let stamp_source = if paths.is_empty() { StampSource::Recorded } else { StampSource::Field(paths.join(" + ")) };
        let stamp = stamp.into_iter().map(|(path, in_unit)| (slots.of(path), in_unit)).collect();
        let zero = zero_parts.iter().map(|(part, prefix)| {
            let numbers = part.channels().map(|(_, path)| slots.of(format!("{prefix}{path}"))).collect();
            (format!("{prefix}{}", part.field), numbers)
        });
        let zero = zero.collect();
        let steps =
            steps(definitions, type_name, &slots.0).map_err(|problem| unusable_definition(type_name, &problem))?;
        let columns = ColumnsRead { columns: fields.iter().map(NumberField::column).collect(), times: None };
        Ok(Self {
            layout: Layout {
                message: type_name.clone().into(),
                compensated: None,
                channels: fields.iter().map(NumberField::channel).collect(),
                columns: Some(columns),
            },
            definitions: definitions.clone(),
            steps,
            slots: vec![Taken::Number(f64::NAN); slots.0.len()],
            quantizers,
            stamp,
            stamp_source,
            zero,
            late: None,
        })
    }

    /// Checks that messages of this topic elsewhere in the bag have the same structure.
    ///
    /// # Errors
    /// [`BagError::Unusable`] if they are not.
    pub(super) fn check(&self, topic: &Topic) -> Result<(), BagError> {
        let Topic { name, type_name, .. } = topic;
        match Definitions::of(topic) {
            Ok(Some(definitions)) if definitions == self.definitions => Ok(()),
            _ => Err(BagError::Unusable(format!(
                "topic {name:?} has messages by several definitions of {type_name}, as in bags that were merged: read the \
                 bags one by one"
            ))),
        }
    }

    /// Sets the scales of series by their largest value in the bag, because their range is not
    /// known beforehand.
    pub(super) fn fit(&mut self, bag: &Bag, topic: &Topic) -> Result<(), BagError> {
        let is_series: Vec<bool> =
            self.layout.channels.iter().map(|channel| channel.quantity == Quantity::Value).collect();
        if !is_series.contains(&true) {
            return Ok(());
        }
        let mut largest = vec![0.0_f64; is_series.len()];
        let mut messages = bag.messages(&Arc::default())?;
        let mut is_read = Vec::<bool>::new();
        // an error is reported when the messages are read again
        while let Ok(Some(head)) = messages.next_head() {
            let is_alike = |other: &Topic| other.is(topic) && self.check(other).is_ok();
            is_read.extend(messages.topics()[is_read.len()..].iter().map(is_alike));
            if !is_read[head.topic] {
                continue;
            }
            let Ok(data) = messages.read_data() else { break };
            if take(&self.steps, &topic.encoding, data, &mut self.slots).is_some() {
                for (largest, quantizer) in largest.iter_mut().zip(&self.quantizers) {
                    if let Some(number) = self.slots[quantizer.slot].number()
                        && number.is_finite()
                    {
                        *largest = largest.max(number.abs());
                    }
                }
            }
        }
        let channels = self.layout.channels.to_mut().iter_mut().zip(&mut self.quantizers);
        for (((channel, quantizer), largest), is_series) in channels.zip(largest).zip(is_series) {
            if is_series && largest > 0.0 {
                // with larger exponents a power of two exceeds the range of a float
                let bits = (f64::from(i32::MAX) / largest).log2().floor().clamp(-1000.0, 1000.0) as i32;
                quantizer.counts_per_unit = 2_f64.powi(bits);
                channel.scale = 2_f64.powi(-bits);
            }
        }
        Ok(())
    }

    /// Reads the numbers of a message. Returns the time in the message, if that time is used.
    pub(super) fn read(&mut self, topic: &Topic, data: &[u8], row: &mut Row) -> Result<Option<i64>, Unreadable> {
        take(&self.steps, &topic.encoding, data, &mut self.slots).ok_or(Unreadable)?;
        row.counts.clear();
        row.absent.clear();
        for (channel, quantizer) in self.quantizers.iter().enumerate() {
            let number = self.slots[quantizer.slot].number().ok_or(Unreadable)?;
            let count = ((number - quantizer.zero) * quantizer.counts_per_unit).round_ties_even();
            if (f64::from(-i32::MAX)..=f64::from(i32::MAX)).contains(&count) {
                row.counts.push(count as i32);
            } else {
                row.counts.push(0);
                row.absent.push((channel, if count.is_finite() { Absence::OutOfRange } else { Absence::NotANumber }));
            }
        }
        if self.late.is_none() {
            let is_late = |slots: &[usize]| slots.iter().any(|&slot| self.slots[slot].number() != Some(0.0));
            self.late = self.zero.iter().find(|(_, slots)| is_late(slots)).map(|(path, _)| path.clone());
        }
        if self.stamp.is_empty() {
            return Ok(None);
        }
        let parts = self.stamp.iter().map(|&(slot, in_unit)| self.slots[slot].nanoseconds(in_unit));
        let at_ns = parts.into_iter().try_fold(0_i64, |sum, part| sum.checked_add(part?));
        at_ns.map(Some).ok_or(Unreadable)
    }
}

/// The paths of the times that `columns` name, else of the time that the topic has, each with its
/// unit in nanoseconds.
fn stamp_paths(
    topic: &ScannedTopic,
    columns: Option<&ColumnMap>,
    all: &BTreeMap<String, PathTarget>,
) -> Result<Vec<(String, i64)>, BagError> {
    let Topic { name, type_name, .. } = &topic.topic;
    let unit = |(column, in_unit): (&String, Option<i64>)| {
        let path = column.clone();
        match (all.get(&path), in_unit) {
            (Some(PathTarget::Leaf(Leaf::Time)), _) => Ok((path, 1)),
            (Some(PathTarget::Leaf(Leaf::Number(_))), Some(in_unit)) => Ok((path, in_unit)),
            (Some(PathTarget::Leaf(Leaf::Number(_))), None) => Err(BagError::Unusable(format!(
                "{path:?} in messages of topic {name:?} is a number, and no date: say whether it is in s, ms, us or ns"
            ))),
            _ => {
                let times = all.iter().filter(|(_, place)| matches!(place, PathTarget::Leaf(Leaf::Time)));
                let times: Vec<_> = times.map(|(path, _)| &**path).collect();
                let times = if times.is_empty() { "none".into() } else { times.join(", ") };
                Err(BagError::Unusable(format!(
                    "messages of topic {name:?} ({type_name}) have no time {path:?}; they have {times}"
                )))
            }
        }
    };
    let named = columns.iter().flat_map(|map| map.stamp_columns()).map(unit).collect::<Result<Vec<_>, BagError>>()?;
    let own = || topic.stamp.iter().map(|path| (path.clone(), 1)).collect();
    Ok(if named.is_empty() { own() } else { named })
}

/// Fractional bits of a count: all bits that the range of the quantity leaves of 32, for numbers in
/// a unit of `unit_scale` units of the channel.
fn bits(quantity: Quantity, unit_scale: f64) -> i32 {
    let is_of = |channel: &str| by_name(channel).is_some_and(|place| known(place).quantity == quantity);
    let own = PARTS.iter().find(|part| part.channels().any(|(channel, _)| is_of(&channel)));
    match (own, quantity) {
        (Some(part), _) => i32::from(part.bits) + (unit_scale / part.unit_scale).log2().floor() as i32,
        // 512 degrees
        (None, Quantity::Angle) => 22 + unit_scale.log2().floor() as i32,
        (None, _) => 0,
    }
}

fn no_field(topic: &ScannedTopic, path: &str) -> BagError {
    let Topic { name, type_name, .. } = &topic.topic;
    let fields = topic.number_paths().join(", ");
    BagError::Unusable(format!("messages of topic {name:?} ({type_name}) have no number {path:?}; they have {fields}"))
}

//! The numbers of a message that are channels, and the size of a count of each.

use std::sync::Arc;

use vn100_protocol::{ColumnRead, ColumnsRead, Layout, Quantity, stream::StampSource};

use super::{
    definition::Leaf,
    files::Bag,
    message_reader::{Taken, take},
    structure::{Step, Structure},
    topic::Topic,
    topic_scan::{FoundPart, ScannedTopic, unusable_definition},
};
use crate::{
    csv::{Column, ColumnMap, Quantizer, Unit, known, units},
    open_error::Problem,
    rows_of_samples::{Absence, NumberRows},
};

/// How the messages of a topic become rows of counts.
#[derive(Debug)]
pub(super) struct NumberFields {
    pub(super) layout: Layout,
    /// The content of the messages, and the steps to the values that are read.
    structure: Structure,
    steps: Vec<Step>,
    values: Vec<Taken>,
    /// The place of the number of each channel of the layout, and its conversion to counts.
    numbers: Vec<(usize, Quantizer)>,
    /// The places of the parts of the time in the message, if that time is used, each with its unit
    /// in nanoseconds if it is a number.
    stamp: Vec<(usize, i64)>,
    pub(super) stamp_source: StampSource,
    /// The parts that are zero in the first messages and are not read.
    zero_parts: Vec<FoundPart>,
    /// The path of the first of these that is not zero later.
    pub(super) late: Option<String>,
}

/// The message ends too early, or has another form.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unreadable;

impl NumberFields {
    /// All standard numbers that the messages have.
    pub(super) fn standard(topic: &ScannedTopic, columns: Option<&ColumnMap>) -> Result<Self, Problem> {
        let mut fields = Vec::new();
        for found in &topic.parts {
            for &(channel, place) in &found.numbers {
                let named = |unit: &&Unit| found.part.unit().is_none_or(|name| unit.name == name);
                let unit = units(known(channel).quantity).find(named);
                fields.extend(unit.cloned().map(|unit| Column { channel, place, unit }));
            }
        }
        let mut numbers = Self::new(topic, fields, columns, &topic.zero_parts)?;
        let rates = topic.parts.iter().find(|found| found.part.channel == "gyro");
        numbers.layout.compensated = rates.and_then(|found| found.part.compensated());
        Ok(numbers)
    }

    /// Only the time that a column map names, for messages of sentences; `None` if the map names
    /// none.
    pub(super) fn of_time(topic: &ScannedTopic, map: &ColumnMap) -> Result<Option<Self>, Problem> {
        map.stamp_columns().next().map(|_| Self::new(topic, Vec::new(), Some(map), &[])).transpose()
    }

    /// The numbers that a column map names by their paths.
    pub(super) fn mapped(topic: &ScannedTopic, map: &ColumnMap) -> Result<Self, Problem> {
        let structure = topic.structure()?;
        let fields = map.channels.iter().map(|mapped| {
            let place = structure.place(&mapped.column).filter(|&place| structure.leaves[place].1 != Leaf::Time);
            let place = place.ok_or_else(|| no_field(topic, &mapped.column))?;
            Ok(Column { channel: mapped.index, place, unit: mapped.unit.clone() })
        });
        Self::new(topic, fields.collect::<Result<_, Problem>>()?, Some(map), &[])
    }

    fn new(
        topic: &ScannedTopic,
        mut fields: Vec<Column>,
        columns: Option<&ColumnMap>,
        zero_parts: &[FoundPart],
    ) -> Result<Self, Problem> {
        fields.sort_by_key(|field| field.channel);
        let (structure, type_name) = (topic.structure()?, &topic.topic.type_name);
        let stamp = stamp_places(topic, columns, structure)?;
        let path = |place: usize| &*structure.leaves[place].0;
        let stamp_paths: Vec<&str> = stamp.iter().map(|(place, _)| path(*place)).collect();
        let numbers = fields.iter().map(|field| field.place);
        let zero = zero_parts.iter().flat_map(|found| found.numbers.iter().map(|(_, place)| *place));
        let steps = structure.steps(numbers.chain(zero).chain(stamp.iter().map(|(place, _)| *place)));
        let quantizer = |field: &Column| {
            let range = range(known(field.channel).quantity);
            Quantizer::binary(31 - (range / field.unit.scale).log2().ceil() as i32, &field.unit)
        };
        let numbers: Vec<_> = fields.iter().map(|field| (field.place, quantizer(field))).collect();
        let channel = |(field, (_, quantizer)): (&Column, &(usize, Quantizer))| {
            quantizer.of_counts(field.unit.of_channel(field.channel))
        };
        let column = |field: &Column| ColumnRead { name: path(field.place).into(), unit: field.unit.name.to_string() };
        Ok(Self {
            layout: Layout {
                message: type_name.clone().into(),
                compensated: None,
                channels: fields.iter().zip(&numbers).map(channel).collect(),
                columns: Some(ColumnsRead { columns: fields.iter().map(column).collect(), times: None }),
            },
            steps: steps.map_err(|problem| unusable_definition(type_name, &problem))?,
            values: vec![Taken::Number(f64::NAN); structure.leaves.len()],
            numbers,
            stamp_source: match &*stamp_paths {
                [] => StampSource::Recorded,
                paths => StampSource::Field(paths.join(" + ")),
            },
            structure: structure.clone(),
            stamp,
            zero_parts: zero_parts.to_vec(),
            late: None,
        })
    }

    /// Checks that messages of this topic elsewhere in the bag have the same structure.
    ///
    /// # Errors
    /// [`Problem::Unusable`] if they are not.
    pub(super) fn check(&self, topic: &Topic) -> Result<(), Problem> {
        let Topic { name, type_name, .. } = topic;
        match Structure::of(topic) {
            Ok(Some(structure)) if structure == self.structure => Ok(()),
            _ => Err(Problem::new(format!(
                "topic {name:?} has messages by several definitions of {type_name}, as in bags that were merged: read the \
                 bags one by one"
            ))),
        }
    }

    /// Sets the scales of series by their largest value in the bag, because their range is not
    /// known beforehand.
    pub(super) fn fit(&mut self, bag: &Bag, topic: &Topic) -> Result<(), Problem> {
        let is_series: Vec<bool> =
            self.layout.channels.iter().map(|channel| channel.quantity == Quantity::Value).collect();
        if !is_series.contains(&true) {
            return Ok(());
        }
        let mut largest = vec![0.0_f64; is_series.len()];
        let mut messages = bag.messages(&Arc::default())?;
        let place_of = |fields: &Self, other: &Topic| (other.is(topic) && fields.check(other).is_ok()).then_some(0);
        // an error is reported when the messages are read again
        while let Ok(Some((place, _))) = messages.next_head(|other| Ok(place_of(self, other))) {
            if place.is_none() {
                continue;
            }
            let Ok(data) = messages.read_data() else { break };
            if take(&self.steps, &topic.encoding, data, &mut self.values).is_some() {
                for (largest, (place, _)) in largest.iter_mut().zip(&self.numbers) {
                    if let Some(number) = self.values[*place].number()
                        && number.is_finite()
                    {
                        *largest = largest.max(number.abs());
                    }
                }
            }
        }
        let channels = self.layout.channels.to_mut().iter_mut().zip(&mut self.numbers);
        for (((channel, (_, quantizer)), largest), is_series) in channels.zip(largest).zip(is_series) {
            if is_series && largest > 0.0 {
                // with larger exponents a power of two exceeds the range of a float
                let bits = (f64::from(i32::MAX) / largest).log2().floor().clamp(-1000.0, 1000.0) as i32;
                *quantizer = Quantizer::binary(bits, &Unit::unconverted(channel.unit.to_string()));
                channel.scale = 2_f64.powi(-bits);
            }
        }
        Ok(())
    }

    /// Takes the values of a message. Returns the time in it, if that time is used.
    pub(super) fn read(&mut self, topic: &Topic, data: &[u8]) -> Result<Option<i64>, Unreadable> {
        take(&self.steps, &topic.encoding, data, &mut self.values).ok_or(Unreadable)?;
        if self.late.is_none() {
            let is_late = |&(_, place): &(usize, usize)| self.values[place].number() != Some(0.0);
            let late = self.zero_parts.iter().find(|found| found.numbers.iter().any(is_late));
            self.late = late.map(|found| found.path.clone());
        }
        if self.stamp.is_empty() {
            return Ok(None);
        }
        let parts = self.stamp.iter().map(|&(place, in_unit)| self.values[place].nanoseconds(in_unit));
        let at_ns = parts.into_iter().try_fold(0_i64, |sum, part| sum.checked_add(part?));
        at_ns.map(Some).ok_or(Unreadable)
    }

    /// Sets a row to the numbers of the message that was read.
    pub(super) fn set(&self, row: &mut NumberRows) {
        row.begin();
        for (channel, (place, quantizer)) in self.numbers.iter().enumerate() {
            let number = self.values[*place].number().unwrap_or(f64::NAN);
            let absence = if number.is_finite() { Absence::OutOfRange } else { Absence::NotANumber };
            row.set(channel, quantizer.count_of(number).ok_or(absence));
        }
    }
}

/// The places of the times that `columns` name, else of the time that the topic has, each with its
/// unit in nanoseconds.
fn stamp_places(
    topic: &ScannedTopic,
    columns: Option<&ColumnMap>,
    structure: &Structure,
) -> Result<Vec<(usize, i64)>, Problem> {
    let Topic { name, type_name, .. } = &topic.topic;
    let unit = |(path, in_unit): (&String, Option<i64>)| {
        let place = structure.place(path);
        match (place.map(|place| (place, structure.leaves[place].1)), in_unit) {
            (Some((place, Leaf::Time)), _) => Ok((place, 1)),
            (Some((place, _)), Some(in_unit)) => Ok((place, in_unit)),
            (Some(_), None) => Err(Problem::new(format!(
                "{path:?} in messages of topic {name:?} is a number, and no date: say whether it is in s, ms, us or ns"
            ))),
            (None, _) => {
                let mut times: Vec<_> = structure.times().map(|(_, path)| path).collect();
                times.sort_unstable();
                let times = if times.is_empty() { "none".into() } else { times.join(", ") };
                Err(Problem::new(format!(
                    "messages of topic {name:?} ({type_name}) have no time {path:?}; they have {times}"
                )))
            }
        }
    };
    let named = columns.iter().flat_map(|map| map.stamp_columns()).map(unit).collect::<Result<Vec<_>, Problem>>()?;
    let own = || topic.stamp.iter().filter_map(|path| Some((structure.place(path)?, 1))).collect();
    Ok(if named.is_empty() { own() } else { named })
}

/// The largest value of a quantity that a count of 32 bits has room for, in the unit of its channels.
fn range(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::AngularRate => 64.0,
        Quantity::Acceleration | Quantity::Temperature | Quantity::Pressure => 256.0,
        // 2^-9 tesla
        Quantity::MagneticField => 19.531_25,
        Quantity::Quaternion => 2.0,
        Quantity::Angle => 512.0,
        // until all messages are known
        Quantity::Value => 2_f64.powi(31),
    }
}

fn no_field(topic: &ScannedTopic, path: &str) -> Problem {
    let Topic { name, type_name, .. } = &topic.topic;
    let fields = topic.number_paths().join(", ");
    Problem::new(format!("messages of topic {name:?} ({type_name}) have no number {path:?}; they have {fields}"))
}

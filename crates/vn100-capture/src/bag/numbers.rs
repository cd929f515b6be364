//! The numbers of a message that are channels, and what a count of each is worth.

use std::{collections::BTreeMap, sync::Arc};

use vn100_protocol::{Channel, Layout, Quantity, stream::StampSource};

use super::{
    fields::{Leaf, PathTarget, Step, places, steps},
    files::Bag,
    message_reader::{Taken, take},
    standard_types::PARTS,
    topic::{BagError, Topic},
    topic_scan::{ScannedTopic, StampProblem},
};
use crate::csv::{ColumnMap, by_name, known};

/// How the messages of a topic become rows of counts.
#[derive(Debug)]
pub(super) struct NumberFields {
    pub(super) layout: Layout,
    steps: Vec<Step>,
    slots: Vec<Taken>,
    /// In the order of the layout.
    quantizers: Vec<Quantizer>,
    /// The slot of the time in the message, where that is used.
    stamp: Option<usize>,
    pub(super) stamp_source: StampSource,
}

/// A count is 2^-`bits` of the unit of the message.
#[derive(Debug, Clone, Copy)]
struct Quantizer {
    slot: usize,
    counts_per_unit: f64,
    /// Where the channel's own zero lies.
    zero: f64,
}

/// The numbers of a message.
#[derive(Debug, Default)]
pub(super) struct Row {
    /// In the order of the layout.
    pub(super) counts: Vec<i32>,
    /// The channels that it lacks, in order.
    pub(super) absent: Vec<(usize, Absence)>,
}

/// Why a number has no count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Absence {
    NotANumber,
    /// Beyond 32 bits.
    OutOfRange,
}

/// A message that ends too early, or has another form.
pub(super) struct Unreadable;

/// A channel, the path of its number, and how that is counted.
struct NumberField {
    place: usize,
    path: String,
    unit: Option<String>,
    unit_scale: f64,
    zero: f64,
    bits: i32,
}

impl NumberFields {
    /// All standard numbers that the messages have.
    pub(super) fn standard(topic: &ScannedTopic, columns: Option<&ColumnMap>) -> Result<Self, BagError> {
        let mut fields = Vec::new();
        for (part, prefix) in &topic.parts {
            for (channel, path) in part.channels {
                // each name is one of a known channel
                let Some(place) = by_name(channel) else { continue };
                let path = format!("{prefix}{path}");
                let (unit_scale, bits) = (part.unit_scale, part.bits.into());
                fields.push(NumberField { place, path, unit: None, unit_scale, zero: 0.0, bits });
            }
        }
        Self::new(topic, fields, columns)
    }

    /// The numbers that a map names by their paths.
    pub(super) fn mapped(topic: &ScannedTopic, map: &ColumnMap) -> Result<Self, BagError> {
        let fields = map.channels.iter().map(|mapped| {
            let (place, unit) = (mapped.index, &mapped.unit);
            let own = known(place);
            let unit_scale = if own.quantity == Quantity::Value { 1.0 } else { unit.scale };
            let zero = unit.zero_hundredths as f64 / 100.0;
            NumberField {
                place,
                path: mapped.column.to_string(),
                unit: (own.quantity == Quantity::Value).then(|| unit.name.to_string()),
                unit_scale,
                zero,
                bits: bits(own.quantity, unit_scale),
            }
        });
        Self::new(topic, fields.collect(), Some(map))
    }

    fn new(topic: &ScannedTopic, mut fields: Vec<NumberField>, columns: Option<&ColumnMap>) -> Result<Self, BagError> {
        fields.sort_by_key(|field| field.place);
        let Topic { name, type_name, .. } = &topic.topic;
        let definition = |problem| BagError::Definition { type_name: type_name.clone(), problem };
        let definitions = match &topic.definitions {
            Ok(Some(definitions)) => definitions,
            Ok(None) => return Err(BagError::NoDefinition { topic: name.clone(), type_name: type_name.clone() }),
            Err(problem) => return Err(definition(problem.clone())),
        };
        let all: BTreeMap<_, _> = places(definitions, type_name).into_iter().collect();
        let mut slots = BTreeMap::new();
        for field in &fields {
            if !matches!(all.get(&field.path), Some(PathTarget::Leaf(Leaf::Number(_)))) {
                return Err(no_field(topic, &field.path));
            }
            let next = slots.len();
            slots.entry(field.path.clone()).or_insert(next);
        }
        let asked = columns.and_then(ColumnMap::stamp_column).map(ToString::to_string);
        let (path, stamp_source) = match (asked, &topic.stamp) {
            (Some(path), _) if !matches!(all.get(&path), Some(PathTarget::Leaf(Leaf::Time))) => {
                let times = all.iter().filter(|(_, place)| matches!(place, PathTarget::Leaf(Leaf::Time)));
                return Err(BagError::NoTime {
                    topic: name.clone(),
                    type_name: type_name.clone(),
                    path,
                    times: times.map(|(path, _)| path.clone()).collect(),
                });
            }
            (Some(path), _) => (Some(path.clone()), StampSource::Field(path)),
            (None, Ok(path)) => (Some(path.clone()), StampSource::Field(path.clone())),
            (None, Err(StampProblem::None)) => (None, StampSource::Recorded),
            (None, Err(StampProblem::Zero)) => (None, StampSource::RecordedAsZero),
            (None, Err(StampProblem::Constant)) => (None, StampSource::RecordedAsConstant),
            (None, Err(StampProblem::Backwards)) => (None, StampSource::RecordedAsBackwards),
        };
        let stamp = path.map(|path| {
            let next = slots.len();
            *slots.entry(path).or_insert(next)
        });
        let steps = steps(definitions, type_name, &slots).map_err(definition)?;
        let channels = fields.iter().map(|field| {
            let own = known(field.place);
            Channel {
                unit: field.unit.clone().map_or_else(|| own.unit.clone(), Into::into),
                decimals: 0,
                scale: field.unit_scale * 2_f64.powi(-field.bits),
                limit_counts: i32::MAX,
                ..own.clone()
            }
        });
        let layout = Layout { message: type_name.clone().into(), compensated: None, channels: channels.collect() };
        let quantizer = |field: &NumberField| Quantizer {
            slot: slots[&field.path],
            counts_per_unit: 2_f64.powi(field.bits),
            zero: field.zero,
        };
        Ok(Self {
            layout,
            steps,
            slots: vec![Taken::Number(f64::NAN); slots.len()],
            quantizers: fields.iter().map(quantizer).collect(),
            stamp,
            stamp_source,
        })
    }

    /// Fits the scales of series to their largest value in the bag: nothing is known of these
    /// beforehand.
    pub(super) fn fit(&mut self, bag: &Bag, topic: &Topic) -> Result<(), BagError> {
        let is_series: Vec<bool> =
            self.layout.channels.iter().map(|channel| channel.quantity == Quantity::Value).collect();
        if !is_series.contains(&true) {
            return Ok(());
        }
        let mut largest = vec![0.0_f64; is_series.len()];
        let mut messages = bag.messages(&Arc::default())?;
        let mut is_read: Vec<bool> = Vec::new();
        // an error is reported where the messages are read again
        while let Ok(Some(head)) = messages.next_head() {
            is_read.extend(messages.topics()[is_read.len()..].iter().map(|other| other.is(topic)));
            if !is_read[head.topic] {
                continue;
            }
            let Ok(data) = messages.read_data() else { break };
            if take(&self.steps, &topic.encoding, data, &mut self.slots).is_some() {
                for (largest, quantizer) in largest.iter_mut().zip(&self.quantizers) {
                    if let Taken::Number(number) = self.slots[quantizer.slot]
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
                // beyond these a power of two is no float
                let bits = (f64::from(i32::MAX) / largest).log2().floor().clamp(-1000.0, 1000.0) as i32;
                quantizer.counts_per_unit = 2_f64.powi(bits);
                channel.scale = 2_f64.powi(-bits);
            }
        }
        Ok(())
    }

    /// Reads the numbers of a message and, where it has one that is used, its time.
    pub(super) fn read(&mut self, topic: &Topic, data: &[u8], row: &mut Row) -> Result<Option<i64>, Unreadable> {
        take(&self.steps, &topic.encoding, data, &mut self.slots).ok_or(Unreadable)?;
        row.counts.clear();
        row.absent.clear();
        for (channel, quantizer) in self.quantizers.iter().enumerate() {
            let Taken::Number(number) = self.slots[quantizer.slot] else { return Err(Unreadable) };
            let count = ((number - quantizer.zero) * quantizer.counts_per_unit).round_ties_even();
            if (f64::from(-i32::MAX)..=f64::from(i32::MAX)).contains(&count) {
                row.counts.push(count as i32);
            } else {
                row.counts.push(0);
                row.absent.push((channel, if count.is_finite() { Absence::OutOfRange } else { Absence::NotANumber }));
            }
        }
        Ok(self.stamp.and_then(|slot| match self.slots[slot] {
            Taken::Time(at_ns) => Some(at_ns),
            Taken::Number(_) => None,
        }))
    }
}

/// As fine as the range of the quantity allows in 32 bits, for numbers in a unit of which
/// `unit_scale` make one of the channel's own.
fn bits(quantity: Quantity, unit_scale: f64) -> i32 {
    let own = |name: &str| PARTS.iter().find(|part| part.channels[0].0 == name);
    let part = match quantity {
        Quantity::AngularRate => own("gyro_x"),
        Quantity::Acceleration => own("accel_x"),
        Quantity::MagneticField => own("mag_x"),
        Quantity::Quaternion => own("quat_x"),
        Quantity::Temperature => own("temperature"),
        Quantity::Pressure => own("pressure"),
        Quantity::Angle | Quantity::Value => None,
    };
    match (part, quantity) {
        (Some(part), _) => i32::from(part.bits) + (unit_scale / part.unit_scale).log2().floor() as i32,
        // 512 degrees
        (None, Quantity::Angle) => 22 + unit_scale.log2().floor() as i32,
        (None, _) => 0,
    }
}

fn no_field(topic: &ScannedTopic, path: &str) -> BagError {
    let Topic { name, type_name, .. } = &topic.topic;
    BagError::NoField {
        topic: name.clone(),
        type_name: type_name.clone(),
        path: path.into(),
        fields: topic.number_paths(),
    }
}

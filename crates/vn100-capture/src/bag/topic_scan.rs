//! The contents of the topics of a bag, judged by their types and first messages.

use std::{collections::BTreeMap, sync::Arc};

use super::{
    definition::Definitions,
    fields::{Leaf, PathTarget, Step, places, steps},
    files::{Bag, BagForm},
    message_reader::{Taken, take},
    sentences::has_sentence,
    standard_types::{PARTS, Part},
    topic::{BagError, Topic, TopicCount, TopicSummary},
};

/// Messages of each topic that are examined, and the bytes of all of them.
const PROBED_MESSAGES: usize = 100;
const PROBED_BYTES: usize = 1024 * 1024;

/// Messages of all topics that are read to examine them: a topic whose first message comes later is
/// judged by its type alone.
const PASSED_MESSAGES: usize = 100_000;

/// Messages may be out of order by fewer places than this.
const OUT_OF_ORDER: usize = 16;

pub(crate) struct TopicScan {
    pub(super) form: BagForm,
    pub(super) topics: Vec<ScannedTopic>,
}

/// A topic and its content from a sensor.
pub(super) struct ScannedTopic {
    pub(super) topic: Topic,
    /// `None` while they are not counted.
    pub(super) count: Option<TopicCount>,
    /// `None` if no definition is known; an error if it cannot be used.
    definitions: Result<Option<Definitions>, String>,
    /// Examined messages that contain a sentence.
    with_sentences: usize,
    /// The standard numbers that its messages have, each with the path of the message that contains it.
    pub(super) parts: Vec<(&'static Part, String)>,
    /// The parts that are zero in all examined messages.
    pub(super) zero_parts: Vec<(&'static Part, String)>,
    /// The path of the first time in its messages that increases from message to message.
    pub(super) stamp: Option<String>,
    /// Examined messages, and their bytes.
    pub(super) probed: usize,
    probed_bytes: usize,
}

impl TopicScan {
    pub(crate) fn of(bag: &Bag) -> Result<Self, BagError> {
        let topics = bag.topics(false)?.into_iter().map(|(topic, count)| ScannedTopic::new(topic, count));
        let mut scan = Self { form: bag.form, topics: topics.collect() };
        scan.probe(bag)?;
        Ok(scan)
    }

    /// Counts the messages of all topics, if this was not done.
    pub(super) fn count(&mut self, bag: &Bag) -> Result<(), BagError> {
        if self.topics.iter().any(|topic| topic.count.is_none()) {
            for (topic, count) in bag.topics(true)? {
                self.topics.iter_mut().filter(|other| other.topic.is(&topic)).for_each(|other| other.count = count);
            }
        }
        Ok(())
    }

    /// The topics, as listed for the user to choose from.
    pub(super) fn summaries(&self) -> Vec<TopicSummary> {
        self.topics.iter().map(ScannedTopic::summary).collect()
    }

    fn probe(&mut self, bag: &Bag) -> Result<(), BagError> {
        let mut probes: Vec<Probe> = self.topics.iter().map(Probe::new).collect();
        let mut messages = bag.messages(&Arc::default())?;
        let mut places = Vec::new();
        for _ in 0..PASSED_MESSAGES {
            if self.topics.iter().all(ScannedTopic::is_settled) {
                break;
            }
            // an error is reported when the messages are read
            let Ok(Some(head)) = messages.next_head() else { break };
            for topic in &messages.topics()[places.len()..] {
                // messages of another definition have a form of their own
                places.push(self.topics.iter().position(|other| other.topic == *topic));
            }
            let Some(place) = places[head.topic].filter(|&place| !self.topics[place].is_settled()) else { continue };
            let topic = &mut self.topics[place];
            let Ok(data) = messages.read_data() else { break };
            topic.probed_bytes += data.len();
            topic.probed += 1;
            topic.with_sentences += usize::from(has_sentence(data));
            probes[place].push(&topic.topic, data);
        }
        self.topics.iter_mut().zip(probes).for_each(|(topic, probe)| probe.finish(topic));
        Ok(())
    }
}

pub(super) fn unusable_definition(type_name: &str, problem: &str) -> BagError {
    BagError::Unusable(format!("the definition of {type_name} cannot be used: {problem}"))
}

impl ScannedTopic {
    fn new(topic: Topic, count: Option<TopicCount>) -> Self {
        Self {
            definitions: Definitions::of(&topic),
            topic,
            count,
            with_sentences: 0,
            parts: Vec::new(),
            zero_parts: Vec::new(),
            stamp: None,
            probed: 0,
            probed_bytes: 0,
        }
    }

    pub(super) fn summary(&self) -> TopicSummary {
        TopicSummary {
            name: self.topic.name.clone(),
            type_name: self.topic.type_name.clone(),
            messages: self.count.unwrap_or_default().messages,
            rate_hz: self.count.and_then(|count| count.rate_hz()),
        }
    }

    /// All numbers, times and messages of its messages, by their paths.
    pub(super) fn places(&self) -> Vec<(String, PathTarget)> {
        self.definitions().map(|types| places(types, &self.topic.type_name)).unwrap_or_default()
    }

    /// The paths of all numbers of its messages; the first element stands for a whole array.
    pub(super) fn number_paths(&self) -> Vec<String> {
        let is_first = |path: &str| path.matches('[').count() == path.matches("[0]").count();
        let is_number =
            |(path, place): &(String, PathTarget)| matches!(place, PathTarget::Leaf(Leaf::Number(_))) && is_first(path);
        self.places().into_iter().filter(is_number).map(|(path, _)| path).collect()
    }

    /// The definitions of its messages.
    ///
    /// # Errors
    /// [`BagError::Unusable`] if none is known or usable.
    pub(super) fn definitions(&self) -> Result<&Definitions, BagError> {
        let Topic { name, type_name, .. } = &self.topic;
        match &self.definitions {
            Ok(Some(definitions)) => Ok(definitions),
            Ok(None) => Err(BagError::Unusable(format!(
                "the bag does not say how messages of topic {name:?} are built, and {type_name} is no standard type: convert \
                 the bag where that package is installed (`ros2 bag convert` to MCAP), or record a topic of sensor_msgs/Imu"
            ))),
            Err(problem) => Err(unusable_definition(type_name, problem)),
        }
    }

    /// Whether enough of its messages were examined.
    fn is_settled(&self) -> bool {
        let messages = self.count.map_or(u64::MAX, |count| count.messages);
        let wanted = PROBED_MESSAGES.min(usize::try_from(messages).unwrap_or(usize::MAX));
        self.probed >= wanted || self.probed_bytes >= PROBED_BYTES
    }

    /// Whether its messages carry sentences: a log may quote a single sentence.
    pub(super) fn has_sentences(&self) -> bool {
        self.with_sentences > 0 && 2 * self.with_sentences >= self.probed
    }
}

/// The standard numbers and the times in the first messages of a topic.
struct Probe {
    steps: Vec<Step>,
    /// The parts of its type: the path of each, the slot of its covariance and the slots of its
    /// numbers.
    parts: Vec<(&'static Part, String, Option<usize>, Vec<usize>)>,
    /// The paths of the times, and their slots.
    stamps: Vec<(String, usize)>,
    slots: usize,
    /// The values of the slots in each message.
    messages: Vec<Vec<Taken>>,
}

impl Probe {
    fn new(topic: &ScannedTopic) -> Self {
        let type_name = &topic.topic.type_name;
        let all = topic.places();
        let mut slots = BTreeMap::new();
        let mut slot = |path: String| {
            let next = slots.len();
            *slots.entry(path).or_insert(next)
        };
        let mut parts = Vec::new();
        for part in &PARTS {
            // the first of several such messages counts, as the topic's own does
            let is_message = |place: &PathTarget| matches!(place, PathTarget::Message(name) if name == part.message);
            let inside = || all.iter().find(|(_, place)| is_message(place)).map(|(path, _)| format!("{path}."));
            let prefix = if type_name == part.message { Some(String::new()) } else { inside() };
            let Some(prefix) = prefix else { continue };
            let paths: Vec<String> = part.channels().map(|(_, path)| format!("{prefix}{path}")).collect();
            let is_there = |path: &String| all.iter().any(|(other, _)| other == path);
            if paths.iter().all(is_there) {
                let covariance =
                    part.covariance().map(|path| format!("{prefix}{path}")).filter(is_there).map(&mut slot);
                parts.push((part, prefix, covariance, paths.into_iter().map(&mut slot).collect()));
            }
        }
        let times = all.iter().filter(|(_, place)| matches!(place, PathTarget::Leaf(Leaf::Time)));
        let stamps = times.map(|(path, _)| (path.clone(), slot(path.clone()))).collect();
        // a message whose steps are unknown gives no numbers, but may give sentences
        let steps = topic.definitions().ok().and_then(|types| steps(types, type_name, &slots).ok());
        Self { steps: steps.unwrap_or_default(), parts, stamps, slots: slots.len(), messages: Vec::new() }
    }

    fn push(&mut self, topic: &Topic, data: &[u8]) {
        let mut slots = vec![Taken::Number(f64::NAN); self.slots];
        if !self.steps.is_empty() && take(&self.steps, &topic.encoding, data, &mut slots).is_some() {
            self.messages.push(slots);
        }
    }

    /// If no message was examined, the type decides.
    fn finish(self, topic: &mut ScannedTopic) {
        let number = |message: &[Taken], slot: usize| message[slot].number().unwrap_or(f64::NAN);
        for (part, path, covariance, numbers) in self.parts {
            // a covariance of -1 says that the sensor does not measure the part
            let mut known =
                self.messages.iter().filter(|message| covariance.is_none_or(|slot| number(message, slot) != -1.0));
            let is_measured = known.clone().any(|message| numbers.iter().any(|&slot| number(message, slot) != 0.0));
            // the first of several parts of one channel is preferred; it is not compensated
            if topic.parts.iter().any(|(other, _)| (other.message, other.channel) == (part.message, part.channel)) {
                continue;
            }
            if is_measured || topic.probed == 0 {
                topic.parts.push((part, path));
            } else if known.next().is_some() {
                topic.zero_parts.push((part, path));
            }
        }
        let times =
            |slot: usize| self.messages.iter().filter_map(move |message| message[slot].nanoseconds(1)).collect();
        topic.stamp = self.stamps.into_iter().find(|&(_, slot)| are_times(times(slot))).map(|(path, _)| path);
    }
}

/// Whether times increase over many messages: not at each step if messages are out of order.
fn are_times(times_ns: Vec<i64>) -> bool {
    let goes_back = |times: &[i64]| times[times.len() - 1] < times[0];
    let is_constant = times_ns.len() > 1 && times_ns.iter().all(|time| *time == times_ns[0]);
    let is_zero = times_ns.iter().all(|time| *time == 0);
    !is_zero && !is_constant && !goes_back(&times_ns) && !times_ns.windows(OUT_OF_ORDER).any(goes_back)
}

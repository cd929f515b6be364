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

/// Messages of each topic that are examined.
const PROBED_MESSAGES: usize = 100;

/// Bytes of each message that are examined.
const PROBED_BYTES: usize = 1024 * 1024;

/// Messages of all topics that are read to examine them: a topic whose first message comes later is
/// judged by its type alone.
const PASSED_MESSAGES: usize = 100_000;

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
    pub(super) stamp: Result<String, StampProblem>,
    /// Examined messages, and their bytes.
    pub(super) probed: usize,
    probed_bytes: usize,
}

/// Why the times in messages are not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampProblem {
    /// The messages have no times.
    None,
    Zero,
    Constant,
    Backwards,
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
        let mut open = self.topics.iter().filter(|topic| !topic.is_settled()).count();
        let mut places = Vec::new();
        for _ in 0..PASSED_MESSAGES {
            if open == 0 {
                break;
            }
            // an error is reported when the messages are read
            let Ok(Some(head)) = messages.next_head() else { break };
            for topic in &messages.topics()[places.len()..] {
                // messages of another definition have a form of their own
                places.push(self.topics.iter().position(|other| other.topic == *topic));
            }
            let Some(place) = places[head.topic] else { continue };
            let topic = &mut self.topics[place];
            if topic.is_settled() {
                continue;
            }
            let Ok(data) = messages.read_data() else { break };
            topic.probed_bytes += data.len();
            topic.probed += 1;
            open -= usize::from(topic.is_settled());
            topic.with_sentences += usize::from(has_sentence(data));
            probes[place].push(&topic.topic, data);
        }
        for (topic, probe) in self.topics.iter_mut().zip(probes) {
            probe.finish(topic);
        }
        Ok(())
    }
}

pub(super) fn unusable_definition(type_name: &str, problem: &str) -> BagError {
    BagError::Messages(format!("the definition of {type_name} cannot be used: {problem}"))
}

impl ScannedTopic {
    fn new(topic: Topic, count: Option<TopicCount>) -> Self {
        let definitions = Definitions::of(&topic);
        Self {
            topic,
            count,
            definitions,
            with_sentences: 0,
            parts: Vec::new(),
            zero_parts: Vec::new(),
            stamp: Err(StampProblem::None),
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

    /// The paths of all numbers of its messages.
    pub(super) fn number_paths(&self) -> Vec<String> {
        let all = self.definitions().map(|types| places(types, &self.topic.type_name)).unwrap_or_default();
        let numbers = all.into_iter().filter(|(_, place)| matches!(place, PathTarget::Leaf(Leaf::Number(_))));
        // the first element stands for the whole array
        let listed =
            numbers.filter(|(path, _)| !path.contains('[') || path.matches('[').count() == path.matches("[0]").count());
        listed.map(|(path, _)| path).collect()
    }

    /// The definitions of its messages.
    ///
    /// # Errors
    /// [`BagError::Messages`] if none is known or usable.
    pub(super) fn definitions(&self) -> Result<&Definitions, BagError> {
        let Topic { name, type_name, .. } = &self.topic;
        match &self.definitions {
            Ok(Some(definitions)) => Ok(definitions),
            Ok(None) => Err(BagError::Messages(format!(
                "the bag does not say how messages of topic {name:?} are built, and {type_name} is no standard type: convert \
                 the bag where that package is installed (`ros2 bag convert` to MCAP), or record a topic of sensor_msgs/Imu"
            ))),
            Err(problem) => Err(unusable_definition(type_name, problem)),
        }
    }

    /// Whether enough of its messages were examined.
    fn is_settled(&self) -> bool {
        self.probed >= self.wanted() || self.probed_bytes >= PROBED_BYTES
    }

    /// Whether its messages carry sentences: a log may quote a single sentence.
    pub(super) fn has_sentences(&self) -> bool {
        self.with_sentences > 0 && 2 * self.with_sentences >= self.probed
    }

    fn wanted(&self) -> usize {
        let messages = self.count.map_or(u64::MAX, |count| count.messages);
        PROBED_MESSAGES.min(usize::try_from(messages).unwrap_or(usize::MAX))
    }
}

/// The facts that the first messages of a topic show.
struct Probe {
    steps: Vec<Step>,
    slots: Vec<Taken>,
    /// The parts of its type: the path of each, the slot of its covariance and the slots of its
    /// numbers.
    parts: Vec<ProbedPart>,
    stamps: Vec<ProbedStamp>,
}

struct ProbedPart {
    part: &'static Part,
    path: String,
    covariance: Option<usize>,
    numbers: Vec<usize>,
    /// The covariance in a message is not -1, so the sensor measures the part.
    is_known: bool,
    /// Some number of the part is not zero in such a message.
    is_there: bool,
}

struct ProbedStamp {
    path: String,
    slot: usize,
    times_ns: Vec<i64>,
}

impl Probe {
    fn new(topic: &ScannedTopic) -> Self {
        let type_name = &topic.topic.type_name;
        let all = topic.definitions().map(|types| places(types, type_name)).unwrap_or_default();
        let mut slots = BTreeMap::new();
        let mut slot = |path: String| {
            let next = slots.len();
            *slots.entry(path).or_insert(next)
        };
        let mut parts = Vec::new();
        for part in &PARTS {
            // the first of several such messages counts, as the topic's own does
            let message = |place: &PathTarget| matches!(place, PathTarget::Message(name) if name == part.message);
            let prefix = if type_name == part.message {
                Some(String::new())
            } else {
                all.iter().find(|(_, place)| message(place)).map(|(path, _)| format!("{path}."))
            };
            let Some(prefix) = prefix else { continue };
            let is_there = |path: &str| all.iter().any(|(other, _)| *other == format!("{prefix}{path}"));
            if part.channels().all(|(_, path)| is_there(&path)) {
                let covariance = part.covariance().filter(|path| is_there(path));
                parts.push(ProbedPart {
                    part,
                    covariance: covariance.map(|path| slot(format!("{prefix}{path}"))),
                    numbers: part.channels().map(|(_, path)| slot(format!("{prefix}{path}"))).collect(),
                    path: prefix,
                    is_known: false,
                    is_there: false,
                });
            }
        }
        let times = all.iter().filter(|(_, place)| matches!(place, PathTarget::Leaf(Leaf::Time)));
        let stamps = times
            .map(|(path, _)| ProbedStamp { path: path.clone(), slot: slot(path.clone()), times_ns: Vec::new() })
            .collect();
        // a message whose steps are unknown gives no numbers, but may give sentences
        let steps = topic.definitions().ok().and_then(|types| steps(types, type_name, &slots).ok());
        Self { steps: steps.unwrap_or_default(), slots: vec![Taken::Number(f64::NAN); slots.len()], parts, stamps }
    }

    fn push(&mut self, topic: &Topic, data: &[u8]) {
        if self.steps.is_empty() || take(&self.steps, &topic.encoding, data, &mut self.slots).is_none() {
            return;
        }
        let number = |slot: usize| self.slots[slot].number().unwrap_or(f64::NAN);
        for part in &mut self.parts {
            let is_known = part.covariance.is_none_or(|slot| number(slot) != -1.0);
            let is_zero = part.numbers.iter().all(|&slot| number(slot) == 0.0);
            part.is_known |= is_known;
            part.is_there |= is_known && !is_zero;
        }
        for stamp in &mut self.stamps {
            if let Taken::Time(at_ns) = self.slots[stamp.slot] {
                stamp.times_ns.push(at_ns);
            }
        }
    }

    /// If no message was examined, the type decides.
    fn finish(self, topic: &mut ScannedTopic) {
        for part in self.parts {
            // the first of several parts of one channel is preferred; it is not compensated
            let is_second = topic
                .parts
                .iter()
                .any(|(other, _)| other.message == part.part.message && other.channel == part.part.channel);
            if is_second {
                continue;
            }
            if part.is_there || topic.probed == 0 {
                topic.parts.push((part.part, part.path));
            } else if part.is_known {
                topic.zero_parts.push((part.part, part.path));
            }
        }
        let mut first_problem = None;
        for stamp in self.stamps {
            match stamp.problem() {
                None => {
                    topic.stamp = Ok(stamp.path);
                    return;
                }
                Some(problem) => first_problem = first_problem.or(Some(problem)),
            }
        }
        topic.stamp = Err(first_problem.unwrap_or(StampProblem::None));
    }
}

impl ProbedStamp {
    /// Times that increase over many messages, but not at each step, belong to messages out of
    /// order.
    fn problem(&self) -> Option<StampProblem> {
        const OUT_OF_ORDER: usize = 16;
        let times = &*self.times_ns;
        match times {
            [] => Some(StampProblem::None),
            times if times.iter().all(|time| *time == 0) => Some(StampProblem::Zero),
            [first, rest @ ..] if !rest.is_empty() && rest.iter().all(|time| time == first) => {
                Some(StampProblem::Constant)
            }
            [first, .., last] if last < first => Some(StampProblem::Backwards),
            times if times.windows(OUT_OF_ORDER).any(|times| times[OUT_OF_ORDER - 1] < times[0]) => {
                Some(StampProblem::Backwards)
            }
            _ => None,
        }
    }
}

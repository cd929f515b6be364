//! The contents of the topics of a bag, judged by their types and first messages.

use std::{fmt, sync::Arc};

use super::{
    definition::Leaf,
    files::{Bag, BagForm},
    message_reader::{Taken, take},
    sentences::has_sentence,
    standard_types::{PARTS, Part},
    structure::{Step, Structure},
    topic::{Topic, TopicCount},
};
use crate::open_error::Problem;

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
    structure: Result<Option<Structure>, String>,
    /// Examined messages that contain a sentence.
    with_sentences: usize,
    /// The standard numbers that its messages have.
    pub(super) parts: Vec<FoundPart>,
    /// The parts that are zero in all examined messages.
    pub(super) zero_parts: Vec<FoundPart>,
    /// The path of the first time in its messages that increases from message to message.
    pub(super) stamp: Option<String>,
    /// Examined messages, and their bytes.
    pub(super) probed: usize,
    probed_bytes: usize,
    /// The steps to the numbers of the parts and to the times; none before the messages are
    /// examined.
    steps: Vec<Step>,
    /// The values in each examined message.
    values: Vec<Vec<Taken>>,
}

/// A part of a message, inside another one or not.
#[derive(Debug, Clone)]
pub(super) struct FoundPart {
    pub(super) part: &'static Part,
    /// The path of the field that holds the numbers.
    pub(super) path: String,
    /// The channels, and the places of their numbers in the message.
    pub(super) numbers: Vec<(usize, usize)>,
    /// The place of the number that is -1 if the sensor does not measure the part.
    covariance: Option<usize>,
}

impl TopicScan {
    pub(crate) fn of(bag: &Bag) -> Result<Self, Problem> {
        let topics = bag.topics(false)?.into_iter().map(|(topic, count)| ScannedTopic::new(topic, count));
        let mut scan = Self { form: bag.form, topics: topics.collect() };
        scan.probe(bag)?;
        Ok(scan)
    }

    /// Counts the messages of all topics, if this was not done.
    pub(super) fn count(&mut self, bag: &Bag) -> Result<(), Problem> {
        if self.topics.iter().any(|topic| topic.count.is_none()) {
            for (topic, count) in bag.topics(true)? {
                self.topics.iter_mut().filter(|other| other.topic.is(&topic)).for_each(|other| other.count = count);
            }
        }
        Ok(())
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.topics.iter().map(|topic| topic.topic.name.clone()).collect()
    }

    fn probe(&mut self, bag: &Bag) -> Result<(), Problem> {
        let mut messages = bag.messages(&Arc::default())?;
        for _ in 0..PASSED_MESSAGES {
            if self.topics.iter().all(ScannedTopic::is_settled) {
                break;
            }
            // messages of another definition have a form of their own
            let place_of = |topic: &Topic| Ok(self.topics.iter().position(|other| other.topic == *topic));
            // an error is reported when the messages are read
            let Ok(Some((place, _))) = messages.next_head(place_of) else { break };
            let Some(place) = place.filter(|&place| !self.topics[place].is_settled()) else { continue };
            let Ok(data) = messages.read_data() else { break };
            self.topics[place].examine(data);
        }
        self.topics.iter_mut().for_each(ScannedTopic::judge);
        Ok(())
    }
}

/// The topics as listed for the user to choose from, each on a line of its own.
pub(super) fn lines<'a>(topics: impl IntoIterator<Item = &'a ScannedTopic>) -> String {
    const LISTED: usize = 40;
    let lines: Vec<String> = topics.into_iter().map(|topic| format!("\n  {topic}")).collect();
    match lines.len() {
        0 => " no topic".into(),
        count if count > LISTED => format!("{}\n  and {} more", lines[..LISTED].concat(), count - LISTED),
        _ => lines.concat(),
    }
}

pub(super) fn unusable_definition(type_name: &str, problem: &str) -> Problem {
    Problem::new(format!("the definition of {type_name} cannot be used: {problem}"))
}

impl fmt::Display for ScannedTopic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Topic { name, type_name, .. }, count) = (&self.topic, self.count.unwrap_or_default());
        let plural = if count.messages == 1 { "" } else { "s" };
        write!(f, "{name:.80} ({type_name:.80}, {} message{plural}", count.messages)?;
        match count.rate_hz() {
            Some(hz) => write!(f, ", {hz:.4} Hz)"),
            None => f.write_str(")"),
        }
    }
}

impl ScannedTopic {
    fn new(topic: Topic, count: Option<TopicCount>) -> Self {
        let structure = Structure::of(&topic);
        let known = structure.as_ref().ok().and_then(Option::as_ref);
        let parts: Vec<FoundPart> =
            known.map_or_else(Vec::new, |structure| FoundPart::all(structure, &topic.type_name));
        // a message whose steps are unknown gives no numbers, but may give sentences
        let steps = known.and_then(|structure| {
            let numbers = parts.iter().flat_map(|found| found.numbers.iter().map(|(_, place)| *place));
            let covariances = parts.iter().filter_map(|found| found.covariance);
            let times = structure.times().map(|(place, _)| place);
            structure.steps(numbers.chain(covariances).chain(times)).ok()
        });
        Self {
            structure,
            topic,
            count,
            with_sentences: 0,
            parts,
            zero_parts: Vec::new(),
            stamp: None,
            probed: 0,
            probed_bytes: 0,
            steps: steps.unwrap_or_default(),
            values: Vec::new(),
        }
    }

    fn examine(&mut self, data: &[u8]) {
        self.probed_bytes += data.len();
        self.probed += 1;
        self.with_sentences += usize::from(has_sentence(data));
        let leaves = self.structure().map_or(0, |structure| structure.leaves.len());
        let mut values = vec![Taken::Number(f64::NAN); leaves];
        if !self.steps.is_empty() && take(&self.steps, &self.topic.encoding, data, &mut values).is_some() {
            self.values.push(values);
        }
    }

    /// Keeps the parts that the examined messages hold. If none was examined, the type decides.
    fn judge(&mut self) {
        let number = |values: &[Taken], place: usize| values[place].number().unwrap_or(f64::NAN);
        for found in std::mem::take(&mut self.parts) {
            let is_unknown = |values: &[Taken]| found.covariance.is_some_and(|place| number(values, place) == -1.0);
            let mut known = self.values.iter().filter(|values| !is_unknown(values));
            let is_measured =
                known.clone().any(|values| found.numbers.iter().any(|&(_, place)| number(values, place) != 0.0));
            let kind = |found: &FoundPart| (found.part.message, found.part.channel);
            if self.parts.iter().any(|other| kind(other) == kind(&found)) {
                continue;
            }
            if is_measured || self.probed == 0 {
                self.parts.push(found);
            } else if known.next().is_some() {
                self.zero_parts.push(found);
            }
        }
        let times = |place: usize| self.values.iter().filter_map(|values| values[place].nanoseconds(1)).collect();
        let stamp = self.structure().ok().and_then(|structure| {
            structure.times().find(|(place, _)| are_times(times(*place))).map(|(_, path)| path.to_owned())
        });
        (self.stamp, self.values) = (stamp, Vec::new());
    }

    /// The paths of all numbers of its messages; the first element stands for a whole array.
    pub(super) fn number_paths(&self) -> Vec<String> {
        let is_first = |path: &str| path.matches('[').count() == path.matches("[0]").count();
        let leaves = self.structure().map_or(&[][..], |structure| &structure.leaves).iter();
        leaves.filter(|(path, leaf)| *leaf != Leaf::Time && is_first(path)).map(|(path, _)| path.clone()).collect()
    }

    /// The content of its messages.
    ///
    /// # Errors
    /// [`Problem::Unusable`] if no definition is known or usable.
    pub(super) fn structure(&self) -> Result<&Structure, Problem> {
        let Topic { name, type_name, .. } = &self.topic;
        match &self.structure {
            Ok(Some(structure)) => Ok(structure),
            Ok(None) => Err(Problem::new(format!(
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

impl FoundPart {
    /// The parts of a message of this type: its own, or those of the first standard message inside.
    fn all(structure: &Structure, type_name: &str) -> Vec<Self> {
        let of = |part: &'static Part| {
            let inside = || structure.messages.iter().find(|(_, name)| name == part.message);
            let prefix = if type_name == part.message { String::new() } else { format!("{}.", inside()?.0) };
            let place = |path: String| structure.place(&format!("{prefix}{path}"));
            let numbers = part.channels().map(|(channel, path)| Some((channel, place(path)?)));
            Some(Self {
                part,
                path: format!("{prefix}{}", part.field),
                numbers: numbers.collect::<Option<_>>()?,
                covariance: part.covariance().and_then(place),
            })
        };
        PARTS.iter().filter_map(of).collect()
    }
}

/// Whether times increase over many messages: not at each step if messages are out of order.
fn are_times(times_ns: Vec<i64>) -> bool {
    let goes_back = |times: &[i64]| times[times.len() - 1] < times[0];
    let is_constant = times_ns.len() > 1 && times_ns.iter().all(|time| *time == times_ns[0]);
    let is_zero = times_ns.iter().all(|time| *time == 0);
    !is_zero && !is_constant && !goes_back(&times_ns) && !times_ns.windows(OUT_OF_ORDER).any(goes_back)
}

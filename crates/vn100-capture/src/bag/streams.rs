//! The choice of the topics of a bag that are streams of a sensor.

use super::{
    files::Bag,
    numbers::NumberFields,
    standard_types::Part,
    topic::{BagError, Topic, lines},
    topic_scan::{ScannedTopic, TopicScan},
};
use crate::{capture_options::CaptureOptions, csv::ColumnMap};

/// A topic that is read, and the content that becomes samples.
#[derive(Debug)]
pub(crate) struct TopicStream {
    pub(crate) topic: Topic,
    pub(super) content: Content,
}

#[derive(Debug)]
pub(super) enum Content {
    /// The VectorNav sentences inside the messages, at the times of the recording or of the
    /// messages.
    Sentences(Option<NumberFields>),
    Numbers(NumberFields),
}

/// The topics to be read: the requested topic, or the only one with sentences, else the only one of
/// an inertial sensor; else one of angular rates and one of accelerations, because some drivers
/// send them separately.
///
/// # Errors
/// [`BagError`] if no topic qualifies, or more than one.
pub(crate) fn choose(bag: &Bag, options: &CaptureOptions) -> Result<Vec<TopicStream>, BagError> {
    let mut scan = TopicScan::of(bag)?;
    chosen(&scan, options).or_else(|_| {
        // messages are counted only if they are listed
        scan.count(bag)?;
        chosen(&scan, options)
    })
}

/// The only topic to be read.
///
/// # Errors
/// [`BagError`] if no topic qualifies, or more than one.
pub(crate) fn choose_one(bag: &Bag, options: &CaptureOptions) -> Result<TopicStream, BagError> {
    let mut streams = choose(bag, options)?;
    match (streams.pop(), streams.is_empty()) {
        (Some(one), true) => Ok(one),
        (last, _) => {
            let mut scan = TopicScan::of(bag)?;
            scan.count(bag)?;
            let is_meant =
                |topic: &&ScannedTopic| streams.iter().chain(&last).any(|stream| stream.topic.is(&topic.topic));
            let topics = scan.topics.iter().filter(is_meant).map(ScannedTopic::summary).collect();
            Err(BagError::SeveralTopics { form: bag.form.words(), topics })
        }
    }
}

fn chosen(scan: &TopicScan, options: &CaptureOptions) -> Result<Vec<TopicStream>, BagError> {
    let (topic, columns) = (options.topic.as_deref(), options.columns.as_ref());
    let form = scan.form.words();
    if scan.topics.iter().all(|topic| topic.count.is_some_and(|count| count.messages == 0)) {
        let topics =
            if scan.topics.is_empty() { String::new() } else { format!(". Its topics:{}", lines(&scan.summaries())) };
        return Err(BagError::Unusable(format!("it is {form} without a message{topics}")));
    }
    let mapped = columns.filter(|map| map.has_channels());
    if let Some(name) = topic {
        let slashless = |name: &str| name.trim_start_matches('/').to_owned();
        let exact = scan.topics.iter().find(|topic| topic.topic.name == name);
        let found = exact.or_else(|| scan.topics.iter().find(|topic| slashless(&topic.topic.name) == slashless(name)));
        let found = found.ok_or_else(|| BagError::NoTopic { name: name.into(), topics: scan.summaries() })?;
        return Ok(vec![stream(found, columns)?]);
    }
    let list = |topics: &[&ScannedTopic]| topics.iter().map(|topic| topic.summary()).collect();
    if let Some(map) = mapped {
        let has_fields = |topic: &&ScannedTopic| NumberFields::mapped(topic, map).is_ok();
        let found: Vec<_> = scan.topics.iter().filter(has_fields).collect();
        return match &*found {
            [one] => Ok(vec![stream(one, columns)?]),
            // the error names what the only topic lacks, or lists the topics
            [] => match &*scan.topics {
                [one] => stream(one, columns).map(|stream| vec![stream]),
                _ => {
                    let paths: Vec<_> = map.columns().map(|(_, column)| column.to_string()).collect();
                    let (paths, topics) = (paths.join(", "), lines(&scan.summaries()));
                    Err(BagError::Unusable(format!("no topic has the numbers {paths}. It holds:{topics}")))
                }
            },
            several => Err(BagError::SeveralTopics { form, topics: list(several) }),
        };
    }
    let with_sentences: Vec<_> = scan.topics.iter().filter(|topic| topic.has_sentences()).collect();
    let has_rates = |topic: &ScannedTopic| has(topic, |part| part.channel == "gyro");
    let has_accelerations = |topic: &ScannedTopic| has(topic, |part| part.channel == "accel");
    let is_inertial = |topic: &&ScannedTopic| has_rates(topic) || has_accelerations(topic);
    let inertial: Vec<_> = scan.topics.iter().filter(is_inertial).collect();
    let of_sensor: Vec<_> = scan.topics.iter().filter(|topic| !topic.parts.is_empty()).collect();
    let are_apart = |a: &ScannedTopic, b: &ScannedTopic| {
        has_rates(a) && !has_accelerations(a) && !has_rates(b) && has_accelerations(b)
    };
    let chosen = match (&*with_sentences, &*inertial, &*of_sensor) {
        ([one], _, _) | ([], [one], _) | ([], [], [one]) => vec![*one],
        ([], [a, b], _) if are_apart(a, b) => vec![*a, *b],
        ([], [a, b], _) if are_apart(b, a) => vec![*b, *a],
        ([], [], []) => return Err(no_sensor(scan)),
        ([], [], several) | ([], several, _) | (several, _, _) => {
            return Err(BagError::SeveralTopics { form, topics: list(several) });
        }
    };
    chosen.into_iter().map(|topic| stream(topic, columns)).collect()
}

impl TopicStream {
    /// Sets properties that only the whole bag shows, such as the scales of series.
    pub(crate) fn fit(&mut self, bag: &Bag) -> Result<(), BagError> {
        match &mut self.content {
            Content::Sentences(_) => Ok(()),
            Content::Numbers(fields) => fields.fit(bag, &self.topic),
        }
    }

    /// Whether the topic holds numbers that may be of any sensor.
    pub(crate) const fn holds_values(&self) -> bool {
        matches!(self.content, Content::Numbers(_))
    }
}

fn has(topic: &ScannedTopic, is: impl Fn(&Part) -> bool) -> bool {
    topic.parts.iter().any(|(part, _)| is(part))
}

fn no_sensor(scan: &TopicScan) -> BagError {
    let form = scan.form.words();
    let only_zero = scan.topics.iter().find(|topic| !topic.zero_parts.is_empty());
    match (&*scan.topics, only_zero) {
        ([topic], _) | (_, Some(topic)) => no_sensor_in(topic),
        _ => BagError::NoSensor { form, topics: scan.summaries() },
    }
}

fn no_sensor_in(topic: &ScannedTopic) -> BagError {
    let Topic { name, type_name, .. } = &topic.topic;
    if topic.zero_parts.is_empty() {
        return topic.definitions().err().unwrap_or_else(|| BagError::NotOfSensor {
            topic: name.clone(),
            type_name: type_name.clone(),
            fields: topic.number_paths(),
        });
    }
    let paths: Vec<_> = topic.zero_parts.iter().map(|(part, prefix)| format!("{prefix}{}", part.field)).collect();
    BagError::Unusable(format!(
        "messages of topic {name:?} ({type_name}) have {}, and all of it is zero in the first {} messages: is the sensor \
         read? Name their numbers as columns if they are not zero later",
        paths.join(", "),
        topic.probed
    ))
}

fn stream(topic: &ScannedTopic, columns: Option<&ColumnMap>) -> Result<TopicStream, BagError> {
    let content = match columns {
        Some(map) if map.has_channels() => Content::Numbers(NumberFields::mapped(topic, map)?),
        Some(map) if topic.has_sentences() => Content::Sentences(NumberFields::of_time(topic, map)?),
        None if topic.has_sentences() => Content::Sentences(None),
        _ if topic.parts.is_empty() => return Err(no_sensor_in(topic)),
        map => Content::Numbers(NumberFields::standard(topic, map)?),
    };
    Ok(TopicStream { topic: topic.topic.clone(), content })
}

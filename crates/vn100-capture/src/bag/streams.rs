//! The choice of the topics of a bag that are streams of a sensor.

use super::{
    files::{Bag, BagForm},
    numbers::NumberFields,
    topic::Topic,
    topic_scan::{ScannedTopic, TopicScan, lines},
};
use crate::{
    capture_options::CaptureOptions,
    csv::ColumnMap,
    open_error::{OpenHint, Problem, Unusable},
};

#[derive(Debug)]
pub(crate) struct TopicStream {
    pub(crate) topic: Topic,
    /// The numbers that become samples. For the VectorNav sentences inside the messages only the
    /// time, unless the times of the recording are used.
    pub(super) fields: Option<NumberFields>,
}

/// The topics to be read, `most` at most: the requested topic, or the only one with sentences, else
/// the only one of an inertial sensor; else one of angular rates and one of accelerations, because
/// some drivers send them separately.
///
/// # Errors
/// [`Problem`] if no topic qualifies, or too many.
pub(crate) fn choose(bag: &Bag, options: &CaptureOptions, most: usize) -> Result<Vec<TopicStream>, Problem> {
    let streams = |scan: &TopicScan| match chosen(scan, options)? {
        topics if topics.len() > most => Err(several_topics(scan.form, &topics)),
        topics => topics.into_iter().map(|topic| stream(topic, options.columns.as_ref())).collect(),
    };
    let mut scan = TopicScan::of(bag)?;
    streams(&scan).or_else(|_| {
        // messages are counted only if they are listed
        scan.count(bag)?;
        streams(&scan)
    })
}

fn chosen<'a>(scan: &'a TopicScan, options: &CaptureOptions) -> Result<Vec<&'a ScannedTopic>, Problem> {
    let (topic, columns) = (options.topic.as_deref(), options.columns.as_ref());
    let form = scan.form.words();
    if scan.topics.iter().all(|topic| topic.count.is_some_and(|count| count.messages == 0)) {
        let topics =
            if scan.topics.is_empty() { String::new() } else { format!(". Its topics:{}", lines(&scan.topics)) };
        return Err(Problem::new(format!("it is {form} without a message{topics}")));
    }
    let mapped = columns.filter(|map| map.has_channels());
    if let Some(name) = topic {
        let slashless = |name: &str| name.trim_start_matches('/').to_owned();
        let exact = scan.topics.iter().find(|topic| topic.topic.name == name);
        let found = exact.or_else(|| scan.topics.iter().find(|topic| slashless(&topic.topic.name) == slashless(name)));
        let found = found.ok_or_else(|| {
            let problem = Unusable::new(format!("it has no topic {name:?}. It holds:{}", lines(&scan.topics)));
            match scan.names() {
                names if names.is_empty() => problem,
                names => problem.with_hint(OpenHint::Topic(names)),
            }
        })?;
        return Ok(vec![found]);
    }
    if let Some(map) = mapped {
        let has_fields = |topic: &&ScannedTopic| NumberFields::mapped(topic, map).is_ok();
        let found: Vec<_> = scan.topics.iter().filter(has_fields).collect();
        return match &*found {
            [one] => Ok(vec![*one]),
            // the error names what the only topic lacks, or lists the topics
            [] => match &*scan.topics {
                [one] => Ok(vec![one]),
                _ => {
                    let paths: Vec<_> = map.columns().map(|(_, column)| column.to_string()).collect();
                    let (paths, topics) = (paths.join(", "), lines(&scan.topics));
                    Err(Problem::new(format!("no topic has the numbers {paths}. It holds:{topics}")))
                }
            },
            several => Err(several_topics(scan.form, several)),
        };
    }
    let with_sentences: Vec<_> = scan.topics.iter().filter(|topic| topic.has_sentences()).collect();
    let has = |topic: &ScannedTopic, channel| topic.parts.iter().any(|found| found.part.channel == channel);
    let has_rates = |topic: &ScannedTopic| has(topic, "gyro");
    let has_accelerations = |topic: &ScannedTopic| has(topic, "accel");
    let is_inertial = |topic: &&ScannedTopic| has_rates(topic) || has_accelerations(topic);
    let inertial: Vec<_> = scan.topics.iter().filter(is_inertial).collect();
    let of_sensor: Vec<_> = scan.topics.iter().filter(|topic| !topic.parts.is_empty()).collect();
    let are_apart = |a: &ScannedTopic, b: &ScannedTopic| {
        has_rates(a) && !has_accelerations(a) && !has_rates(b) && has_accelerations(b)
    };
    match (&*with_sentences, &*inertial, &*of_sensor) {
        ([one], _, _) | ([], [one], _) | ([], [], [one]) => Ok(vec![*one]),
        ([], [a, b], _) if are_apart(a, b) => Ok(vec![*a, *b]),
        ([], [a, b], _) if are_apart(b, a) => Ok(vec![*b, *a]),
        ([], [], []) => Err(no_sensor(scan)),
        ([], [], several) | ([], several, _) | (several, _, _) => Err(several_topics(scan.form, several)),
    }
}

impl TopicStream {
    /// Sets properties that only the whole bag shows, such as the scales of series.
    pub(crate) fn fit(&mut self, bag: &Bag) -> Result<(), Problem> {
        self.fields.as_mut().map_or(Ok(()), |fields| fields.fit(bag, &self.topic))
    }

    /// Whether the topic holds numbers that may be of any sensor.
    pub(crate) fn holds_values(&self) -> bool {
        self.fields.as_ref().is_some_and(|fields| !fields.layout.channels.is_empty())
    }
}

fn several_topics(form: BagForm, topics: &[&ScannedTopic]) -> Problem {
    let reason =
        format!("it is {} with several topics that may be meant:{}", form.words(), lines(topics.iter().copied()));
    let names = topics.iter().map(|topic| topic.topic.name.clone()).collect();
    Unusable::new(reason).with_hint(OpenHint::Topic(names)).into()
}

fn no_sensor(scan: &TopicScan) -> Problem {
    let only_zero = scan.topics.iter().find(|topic| !topic.zero_parts.is_empty());
    match (&*scan.topics, only_zero) {
        ([topic], _) | (_, Some(topic)) => no_sensor_in(topic),
        _ => {
            let (form, topics) = (scan.form.words(), lines(&scan.topics));
            let reason = format!(
                "it is {form} in which no topic has VectorNav sentences or messages of an inertial sensor. It holds:{topics}"
            );
            Unusable::new(reason).with_hint(OpenHint::TopicAndColumns(scan.names())).into()
        }
    }
}

fn no_sensor_in(topic: &ScannedTopic) -> Problem {
    let Topic { name, type_name, .. } = &topic.topic;
    if topic.zero_parts.is_empty() {
        return topic.structure().err().unwrap_or_else(|| {
            let reason = format!(
                "messages of topic {name:?} ({type_name}) hold neither VectorNav sentences nor a message of an inertial \
                 sensor; their numbers are: {}",
                topic.number_paths().join(", ")
            );
            Unusable::new(reason).with_hint(OpenHint::ColumnsOfTopic).into()
        });
    }
    let paths: Vec<_> = topic.zero_parts.iter().map(|found| &*found.path).collect();
    Problem::new(format!(
        "messages of topic {name:?} ({type_name}) have {}, and all of it is zero in the first {} messages: is the sensor \
         read? Name their numbers as columns if they are not zero later",
        paths.join(", "),
        topic.probed
    ))
}

fn stream(topic: &ScannedTopic, columns: Option<&ColumnMap>) -> Result<TopicStream, Problem> {
    let fields = match columns {
        Some(map) if map.has_channels() => Some(NumberFields::mapped(topic, map)?),
        Some(map) if topic.has_sentences() => NumberFields::of_time(topic, map)?,
        None if topic.has_sentences() => None,
        _ if topic.parts.is_empty() => return Err(no_sensor_in(topic)),
        map => Some(NumberFields::standard(topic, map)?),
    };
    Ok(TopicStream { topic: topic.topic.clone(), fields })
}

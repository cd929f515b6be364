//! Batches of samples from one topic of a bag.

use std::{
    io, mem,
    sync::{Arc, atomic::AtomicU64},
};

use vn100_protocol::{
    Layout,
    stream::{
        AbsentCell, AbsentValues, Arrival, BagReport, Batch, FileReport, Mark, MarkKind, ReadOptions, SampleReader,
        StampSource,
    },
};

use super::{
    files::{Bag, Messages},
    numbers::{Absence, NumberFields, Row, Unreadable},
    sentences::sentences,
    streams::{Content, TopicStream},
    topic::{BagError, Topic},
};
use crate::read_samples::{Event, FileReader};

/// The most bytes of the sentences in one message: messages of drivers have one sentence or two.
const SENTENCE_BYTES: usize = 64 * 1024;

const BATCH_MESSAGES: usize = 512;

/// Reads the samples of one topic, some hundred messages at a time, in the order of the file.
pub(crate) struct BagSamples {
    messages: Messages,
    topic: Topic,
    /// For each topic, whether it is the one that is read.
    is_read: Vec<bool>,
    content: OpenContent,
    line_by_line: bool,
    report: BagReport,
    /// Bytes of the messages that were read, and of those rejected.
    used_bytes: u64,
    rejected_bytes: u64,
    at_end: bool,
}

#[expect(clippy::large_enum_variant, reason = "there is one for each file")]
enum OpenContent {
    Sentences {
        reader: SampleReader,
        /// Reads the time in the messages, unless the time of the recording is used.
        time: Option<NumberFields>,
    },
    Numbers {
        fields: NumberFields,
        layout: Arc<Layout>,
        row: Row,
        open: Batch,
    },
}

impl BagSamples {
    /// Reads a topic of a bag from its first message on; `read` counts the bytes read from the
    /// files.
    pub(crate) fn open(
        bag: &Bag,
        stream: TopicStream,
        options: ReadOptions,
        read: &Arc<AtomicU64>,
    ) -> Result<Self, BagError> {
        let TopicStream { topic, content } = stream;
        let (content, stamps) = match content {
            Content::Sentences(time) => {
                let stamps = time.as_ref().map_or(StampSource::Recorded, |time| time.stamp_source.clone());
                (OpenContent::Sentences { reader: SampleReader::new(options), time }, stamps)
            }
            Content::Numbers(fields) => {
                let (layout, stamps) = (Arc::new(fields.layout.clone()), fields.stamp_source.clone());
                (OpenContent::Numbers { fields, layout, row: Row::default(), open: Batch::default() }, stamps)
            }
        };
        let report = BagReport {
            topic: topic.name.clone(),
            type_name: topic.type_name.clone(),
            unpacked_bytes: bag.unpacked_bytes,
            stamps,
            ..BagReport::default()
        };
        Ok(Self {
            messages: bag.messages(read)?,
            topic,
            is_read: Vec::new(),
            content,
            line_by_line: options.line_by_line,
            report,
            used_bytes: 0,
            rejected_bytes: 0,
            at_end: false,
        })
    }

    /// Takes the next message of the topic; `false` at the end.
    fn take_message(&mut self) -> io::Result<bool> {
        loop {
            let Some(head) = self.messages.next_head()? else { return Ok(false) };
            for topic in &self.messages.topics()[self.is_read.len()..] {
                self.is_read.push(topic.is(&self.topic));
                if let Some(fields) = self.content.fields().filter(|_| topic.is(&self.topic)) {
                    fields.check(topic).map_err(|problem| io::Error::new(io::ErrorKind::InvalidData, problem))?;
                }
            }
            if self.is_read[head.topic] {
                let data = self.messages.read_data()?;
                self.report.messages += 1;
                let (first_ns, last_ns) = self.report.recorded_ns.unwrap_or((head.record_ns, head.record_ns));
                self.report.recorded_ns = Some((first_ns.min(head.record_ns), last_ns.max(head.record_ns)));
                let problem = self.content.push(&self.topic, head.record_ns, data, &mut self.report);
                let (count, bytes) = match problem {
                    None => (&mut self.report.used, &mut self.used_bytes),
                    Some(Problem::WithoutSample) => (&mut self.report.without_sample, &mut self.rejected_bytes),
                    Some(Problem::Unreadable) => (&mut self.report.unreadable, &mut self.rejected_bytes),
                };
                (*count, *bytes) = (*count + 1, *bytes + data.len() as u64);
                return match self.content.fields().and_then(|fields| fields.late.as_ref()) {
                    Some(path) => Err(io::Error::other(format!(
                        "{path} was zero in the first messages and is not in message {}: name its numbers as columns",
                        self.report.messages
                    ))),
                    None => Ok(true),
                };
            }
            self.report.other_messages += 1;
        }
    }

    /// Adds the counts of everything that is no sample to the batches.
    fn with_counts(&self, mut batches: Vec<Batch>) -> Vec<Batch> {
        for batch in &mut batches {
            let tally = &mut batch.link.tally;
            match self.content {
                OpenContent::Sentences { .. } => {
                    let bytes = self.used_bytes + self.rejected_bytes;
                    tally.skipped_bytes += bytes.saturating_sub(tally.bytes());
                }
                OpenContent::Numbers { .. } => {
                    tally.samples = self.report.used;
                    tally.unchecked_sentences = self.report.used;
                    tally.valid_sentence_bytes = self.used_bytes;
                    tally.rejected_sentence_bytes = self.rejected_bytes;
                    tally.rejected.grammar = self.report.unreadable;
                    tally.rejected.range = self.report.without_sample;
                }
            }
        }
        batches
    }
}

impl FileReader for BagSamples {
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let mut batches = Vec::new();
        for place in 0..BATCH_MESSAGES {
            self.at_end = self.at_end || !self.take_message()?;
            if self.at_end && place == 0 {
                return Ok(None);
            }
            if self.at_end || self.line_by_line || place + 1 == BATCH_MESSAGES {
                let taken = self.content.take_batches();
                batches.extend(self.with_counts(taken));
            }
            if self.at_end {
                break;
            }
        }
        Ok(Some(batches.into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        let last = match &mut self.content {
            OpenContent::Sentences { reader, .. } => reader.finish(),
            numbers => numbers.take_batches(),
        };
        (self.with_counts(last), Some(FileReport::Bag(self.report.clone())))
    }
}

/// The reason why a message gives no sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Problem {
    WithoutSample,
    Unreadable,
}

fn count_absent(report: &mut BagReport, layout: &Layout, row: &Row) {
    for &(channel, absence) in &row.absent {
        let name = &layout.channels[channel].name;
        let place = report.absent.iter().position(|absent| absent.channel == *name).unwrap_or_else(|| {
            let first =
                AbsentValues { channel: name.to_string(), first_line: report.messages, ..AbsentValues::default() };
            report.absent.push(first);
            report.absent.len() - 1
        });
        let absent = &mut report.absent[place];
        *match absence {
            Absence::NotANumber => &mut absent.not_a_number,
            Absence::OutOfRange => &mut absent.out_of_range,
        } += 1;
    }
}

impl OpenContent {
    const fn fields(&self) -> Option<&NumberFields> {
        match self {
            Self::Sentences { time, .. } => time.as_ref(),
            Self::Numbers { fields, .. } => Some(fields),
        }
    }

    fn push(&mut self, topic: &Topic, record_ns: i64, data: &[u8], report: &mut BagReport) -> Option<Problem> {
        match self {
            Self::Sentences { reader, time } => {
                let stamp_ns = match time {
                    Some(time) => time.read(topic, data, &mut Row::default()),
                    None => Ok(None),
                };
                let lines: Vec<u8> = sentences(data).flat_map(|sentence| [sentence, b"\r\n"].concat()).collect();
                match (stamp_ns, lines.len()) {
                    (Err(Unreadable), _) => Some(Problem::Unreadable),
                    (_, 0) => Some(Problem::WithoutSample),
                    (Ok(stamp_ns), 1..=SENTENCE_BYTES) => {
                        reader.push(&lines, Some(stamp_ns.unwrap_or(record_ns)));
                        None
                    }
                    _ => Some(Problem::Unreadable),
                }
            }
            Self::Numbers { fields, layout, row, open } => {
                let stamp_ns = fields.read(topic, data, row);
                let from_row = open.counts.len() / layout.channels.len();
                match stamp_ns {
                    Ok(stamp_ns) if row.absent.len() < layout.channels.len() => {
                        count_absent(report, layout, row);
                        open.arrivals.push(Arrival { from_row, at_ns: stamp_ns.unwrap_or(record_ns) });
                        open.counts.extend_from_slice(&row.counts);
                        let cell = |&(channel, _): &(usize, Absence)| AbsentCell { row: from_row, channel };
                        open.absent.extend(row.absent.iter().map(cell));
                        None
                    }
                    outcome => {
                        open.marks.push(Mark { before_row: from_row, kind: MarkKind::Rejected });
                        Some(if outcome.is_ok() { Problem::WithoutSample } else { Problem::Unreadable })
                    }
                }
            }
        }
    }

    fn take_batches(&mut self) -> Vec<Batch> {
        match self {
            Self::Sentences { reader, .. } => reader.take_batches(),
            Self::Numbers { layout, open, .. } => vec![Batch { layout: Some(Arc::clone(layout)), ..mem::take(open) }],
        }
    }
}

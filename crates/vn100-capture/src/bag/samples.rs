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
    time_order::TimeOrder,
    topic::{BagError, Topic},
};
use crate::read_samples::{Event, FileReader};

/// The most bytes of the sentences in one message: messages of drivers have one sentence or two.
const SENTENCE_BYTES: usize = 64 * 1024;

const BATCH_MESSAGES: usize = 512;

/// Reads the samples of one topic, some hundred messages at a time.
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
    /// Complete batches.
    sealed: Vec<Batch>,
}

#[expect(clippy::large_enum_variant, reason = "there is one for each file")]
enum OpenContent {
    Sentences {
        reader: SampleReader,
        /// Reads the time in the messages, unless the time of the recording is used.
        time: Option<NumberFields>,
        order: TimeOrder<Vec<u8>>,
    },
    Numbers {
        fields: NumberFields,
        layout: Arc<Layout>,
        order: TimeOrder<HeldRow>,
        open: Batch,
        /// Rows that were forwarded.
        rows: u64,
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
                let reader = SampleReader::new(options);
                (OpenContent::Sentences { reader, time, order: TimeOrder::new() }, stamps)
            }
            Content::Numbers(fields) => {
                let (layout, stamps) = (Arc::new(fields.layout.clone()), fields.stamp_source.clone());
                (
                    OpenContent::Numbers { fields, layout, order: TimeOrder::new(), open: Batch::default(), rows: 0 },
                    stamps,
                )
            }
        };
        let report =
            BagReport { unpacked_bytes: bag.unpacked_bytes, ..BagReport::of(&topic.name, &topic.type_name, stamps) };
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
            sealed: Vec::new(),
        })
    }

    /// Takes the next message of the topic; `false` at the end.
    fn take_message(&mut self) -> io::Result<bool> {
        loop {
            let Some(head) = self.messages.next_head()? else { return Ok(false) };
            for topic in &self.messages.topics()[self.is_read.len()..] {
                self.is_read.push(topic.is(&self.topic));
                if topic.is(&self.topic) {
                    self.content.check(topic)?;
                }
            }
            if self.is_read[head.topic] {
                let data = self.messages.read_data()?;
                self.report.messages += 1;
                let (first_ns, last_ns) = self.report.recorded_ns.unwrap_or((head.record_ns, head.record_ns));
                self.report.recorded_ns = Some((first_ns.min(head.record_ns), last_ns.max(head.record_ns)));
                let problem = self.content.push(&self.topic, head.record_ns, data, &mut self.report);
                let bytes = data.len() as u64;
                *match problem {
                    None => &mut self.report.used,
                    Some(Problem::WithoutSample) => &mut self.report.without_sample,
                    Some(Problem::Unreadable) => &mut self.report.unreadable,
                } += 1;
                *if problem.is_none() { &mut self.used_bytes } else { &mut self.rejected_bytes } += bytes;
                return Ok(true);
            }
            self.report.other_messages += 1;
        }
    }

    /// Forwards the rows whose place is decided, each in a batch of its own if the options ask for
    /// it.
    fn pass_on(&mut self) {
        while self.content.pass_on(self.at_end) {
            if self.line_by_line {
                self.seal();
            }
        }
    }

    /// Completes the batch of the rows forwarded so far.
    fn seal(&mut self) {
        let batches = self.content.take_batches();
        let batches = self.with_counts(batches);
        self.sealed.extend(batches);
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
                    tally.unchecked_sentences = tally.samples;
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
        if self.at_end {
            return Ok(None);
        }
        for _ in 0..BATCH_MESSAGES {
            self.at_end = !self.take_message()?;
            self.pass_on();
            if self.at_end {
                break;
            }
        }
        self.seal();
        Ok(Some(mem::take(&mut self.sealed).into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        self.at_end = true;
        self.pass_on();
        self.seal();
        let mut last = Vec::new();
        (self.report.reordered, self.report.late) = match &mut self.content {
            OpenContent::Sentences { reader, order, .. } => {
                last = reader.finish();
                (order.moved, order.late)
            }
            OpenContent::Numbers { fields, order, .. } => {
                self.report.unread = fields.unread();
                (order.moved, order.late)
            }
        };
        let mut batches = mem::take(&mut self.sealed);
        batches.extend(self.with_counts(last));
        (batches, Some(FileReport::Bag(self.report.clone())))
    }
}

/// The reason why a message gives no sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Problem {
    WithoutSample,
    Unreadable,
}

/// A message whose place in the order of time is not decided yet.
#[derive(Default)]
struct HeldRow {
    row: Row,
    /// Whether the message gives no sample.
    is_rejected: bool,
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

/// The time that orders a message: its own, if it has one; `None` if it cannot be read.
fn place_ns(stamp_ns: Result<Option<i64>, Unreadable>, record_ns: i64) -> Option<i64> {
    stamp_ns.map(|stamp_ns| stamp_ns.unwrap_or(record_ns)).ok()
}

impl OpenContent {
    /// Checks that messages of this topic have the structure of the topic that is read.
    fn check(&self, topic: &Topic) -> io::Result<()> {
        let fields = match self {
            Self::Sentences { time, .. } => time.as_ref(),
            Self::Numbers { fields, .. } => Some(fields),
        };
        let checked = fields.map_or(Ok(()), |fields| fields.check(topic));
        checked.map_err(|problem| io::Error::new(io::ErrorKind::InvalidData, problem))
    }

    fn push(&mut self, topic: &Topic, record_ns: i64, data: &[u8], report: &mut BagReport) -> Option<Problem> {
        match self {
            Self::Sentences { order, time, .. } => {
                let stamp_ns = match time {
                    Some(time) => time.read(topic, data, &mut Row::default()),
                    None => Ok(None),
                };
                let mut lines = order.spare();
                lines.clear();
                for sentence in sentences(data) {
                    lines.extend_from_slice(sentence);
                    lines.extend_from_slice(b"\r\n");
                }
                let problem = match lines.len() {
                    _ if stamp_ns.is_err() => {
                        lines.clear();
                        Some(Problem::Unreadable)
                    }
                    0 => Some(Problem::WithoutSample),
                    1..=SENTENCE_BYTES => None,
                    _ => {
                        lines.clear();
                        Some(Problem::Unreadable)
                    }
                };
                order.push(place_ns(stamp_ns, record_ns), record_ns, lines);
                problem
            }
            Self::Numbers { fields, layout, order, .. } => {
                let mut held = order.spare();
                let stamp_ns = fields.read(topic, data, &mut held.row);
                let problem = match stamp_ns {
                    Err(_) => Some(Problem::Unreadable),
                    Ok(_) if held.row.absent.len() == layout.channels.len() => Some(Problem::WithoutSample),
                    Ok(_) => None,
                };
                held.is_rejected = problem.is_some();
                if !held.is_rejected {
                    count_absent(report, layout, &held.row);
                }
                order.push(place_ns(stamp_ns, record_ns), record_ns, held);
                problem
            }
        }
    }

    /// Forwards the next message, if its place is decided.
    fn pass_on(&mut self, at_end: bool) -> bool {
        match self {
            Self::Sentences { reader, order, .. } => {
                let Some((at_ns, lines)) = order.pop(at_end) else { return false };
                reader.push(lines, Some(at_ns));
            }
            Self::Numbers { layout, order, open, rows, .. } => {
                let Some((at_ns, held)) = order.pop(at_end) else { return false };
                let from_row = open.counts.len() / layout.channels.len();
                if held.is_rejected {
                    open.marks.push(Mark { before_row: from_row, kind: MarkKind::Rejected });
                } else {
                    *rows += 1;
                    open.arrivals.push(Arrival { from_row, at_ns });
                    open.counts.extend_from_slice(&held.row.counts);
                    let cell = |&(channel, _): &(usize, Absence)| AbsentCell { row: from_row, channel };
                    open.absent.extend(held.row.absent.iter().map(cell));
                }
            }
        }
        true
    }

    fn take_batches(&mut self) -> Vec<Batch> {
        match self {
            Self::Sentences { reader, .. } => reader.take_batches(),
            Self::Numbers { layout, open, rows, .. } => {
                let mut batch = mem::take(open);
                batch.layout = Some(Arc::clone(layout));
                batch.link.tally.samples = *rows;
                vec![batch]
            }
        }
    }
}

//! Batches of samples from one topic of a bag.

use std::{
    io,
    sync::{Arc, atomic::AtomicU64},
};

use vn100_protocol::stream::{BagReport, Batch, FileReport, ReadOptions, SampleReader, StampSource};

use super::{
    files::{Bag, Messages},
    numbers::{NumberFields, Unreadable},
    sentences::sentences,
    streams::TopicStream,
    topic::Topic,
};
use crate::{
    open_error::Problem,
    read_samples::{Event, FileReader},
    rows_of_samples::{NumberRows, RowSamples},
};

/// The most bytes of the sentences in one message: messages of drivers have one sentence or two.
const SENTENCE_BYTES: usize = 64 * 1024;

const BATCH_MESSAGES: usize = 512;

/// Reads the samples of one topic, some hundred messages at a time, in the order of the file.
pub(crate) struct BagSamples {
    messages: Messages,
    topic: Topic,
    /// The numbers of its messages; of messages of sentences the time, unless the time of the
    /// recording is used.
    fields: Option<NumberFields>,
    samples: RowSamples,
    line_by_line: bool,
    report: BagReport,
    /// The error that ended the unpacking early, given after the messages before it.
    unpack_error: Option<io::Error>,
    /// Bytes of the messages that were read, and of those rejected.
    used_bytes: u64,
    rejected_bytes: u64,
    at_end: bool,
}

impl BagSamples {
    /// Reads a topic of a bag from its first message on; `read` counts the bytes read from the
    /// files.
    pub(crate) fn open(
        bag: &Bag,
        stream: TopicStream,
        options: ReadOptions,
        read: &Arc<AtomicU64>,
    ) -> Result<Self, Problem> {
        let holds_values = stream.holds_values();
        let TopicStream { topic, fields } = stream;
        let samples = match &fields {
            Some(fields) if holds_values => RowSamples::Numbers(NumberRows::new(Arc::new(fields.layout.clone()))),
            _ => RowSamples::Sentences(SampleReader::new(options)),
        };
        let report = BagReport {
            topic: topic.name.clone(),
            type_name: topic.type_name.clone(),
            unpacked_bytes: bag.unpacked_bytes,
            stamps: fields.as_ref().map_or(StampSource::Recorded, |fields| fields.stamp_source.clone()),
            ..BagReport::default()
        };
        Ok(Self {
            messages: bag.messages(read)?,
            topic,
            fields,
            samples,
            line_by_line: options.line_by_line,
            report,
            unpack_error: bag.unpack_error.as_ref().map(|error| io::Error::new(error.kind(), error.to_string())),
            used_bytes: 0,
            rejected_bytes: 0,
            at_end: false,
        })
    }

    /// Takes the next message of the topic; `false` at the end.
    fn take_message(&mut self) -> io::Result<bool> {
        loop {
            let place_of = |topic: &Topic| {
                if let Some(fields) = self.fields.as_ref().filter(|_| topic.is(&self.topic)) {
                    fields.check(topic).map_err(|problem| io::Error::new(io::ErrorKind::InvalidData, problem))?;
                }
                Ok(topic.is(&self.topic).then_some(0))
            };
            let Some((place, record_ns)) = self.messages.next_head(place_of)? else {
                return self.unpack_error.take().map_or(Ok(false), Err);
            };
            if place.is_some() {
                let data = self.messages.read_data()?;
                self.report.messages += 1;
                let (first_ns, last_ns) = self.report.recorded_ns.unwrap_or((record_ns, record_ns));
                self.report.recorded_ns = Some((first_ns.min(record_ns), last_ns.max(record_ns)));
                let stamp_ns = match &mut self.fields {
                    Some(fields) => fields.read(&self.topic, data),
                    None => Ok(None),
                };
                let at_ns = stamp_ns.map(|stamp_ns| stamp_ns.unwrap_or(record_ns));
                let is_used = match (&mut self.samples, at_ns) {
                    (_, Err(Unreadable)) => Err(Unreadable),
                    (RowSamples::Sentences(reader), Ok(at_ns)) => push_sentences(reader, at_ns, data),
                    (RowSamples::Numbers(rows), Ok(at_ns)) => {
                        self.fields.iter().for_each(|fields| fields.set(rows));
                        if !rows.is_blank() {
                            rows.push(Some(at_ns), None, self.report.messages);
                        }
                        Ok(!rows.is_blank())
                    }
                };
                let (count, bytes) = match is_used {
                    Ok(true) => (&mut self.report.used, &mut self.used_bytes),
                    Ok(false) => (&mut self.report.without_sample, &mut self.rejected_bytes),
                    Err(Unreadable) => (&mut self.report.unreadable, &mut self.rejected_bytes),
                };
                (*count, *bytes) = (*count + 1, *bytes + data.len() as u64);
                if !matches!(is_used, Ok(true)) && matches!(self.samples, RowSamples::Numbers(_)) {
                    self.samples.mark_rejected_row();
                }
                return match self.fields.as_ref().and_then(|fields| fields.late.as_ref()) {
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

    fn report(&self) -> FileReport {
        FileReport::Bag(BagReport { absent: self.samples.absent(), ..self.report.clone() })
    }

    /// Adds the counts of everything that is no sample to the batches.
    fn with_counts(&self, mut batches: Vec<Batch>) -> Vec<Batch> {
        for batch in &mut batches {
            batch.report = self.line_by_line.then(|| self.report().into());
            let tally = &mut batch.link.tally;
            match self.samples {
                RowSamples::Sentences(_) => {
                    let bytes = self.used_bytes + self.rejected_bytes;
                    let skipped = bytes.saturating_sub(tally.bytes());
                    batch.tallies.iter_mut().chain([tally]).for_each(|tally| tally.skipped_bytes += skipped);
                }
                RowSamples::Numbers(_) => {
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
    /// Those of one message, or of some hundred. Samples before an error are given at the end.
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let most = if self.line_by_line { 1 } else { BATCH_MESSAGES };
        for place in 0..most {
            self.at_end = self.at_end || !self.take_message()?;
            if self.at_end && place == 0 {
                return Ok(None);
            }
            if self.at_end {
                break;
            }
        }
        let taken = self.samples.take_batches();
        Ok(Some(self.with_counts(taken).into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        let last = self.samples.finish();
        (self.with_counts(last), Some(self.report()))
    }
}

/// Reads the sentences of a message; whether it has any.
fn push_sentences(reader: &mut SampleReader, at_ns: i64, data: &[u8]) -> Result<bool, Unreadable> {
    let lines: Vec<u8> = sentences(data).flat_map(|sentence| [sentence, b"\r\n"].concat()).collect();
    if lines.len() > SENTENCE_BYTES {
        return Err(Unreadable);
    }
    if !lines.is_empty() {
        reader.push(&lines, Some(at_ns));
    }
    Ok(!lines.is_empty())
}

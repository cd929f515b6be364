//! Chunks in, batches of samples out: the task between a source and whoever uses its samples.

use std::{collections::BTreeMap, sync::Arc};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use vn100_protocol::{
    AsyncType, Decoder, Item, Layout, Options, PrintFormat, Reply, Sentence, Suffix, Tally, VNIMU, VNYMR,
};

use crate::{
    diagnostic::Diagnostic,
    event::{Arrival, Batch, End, Event, LinkCounts, Mark, MarkKind, MessageName, RegisterValue, RowCounter},
    source::{Input, LinkEvent, LinkEventKind, Source},
};

/// How a stream is read.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadOptions {
    /// Take lines that carry no checksum. Nothing then protects a value but its own grammar.
    pub accept_unchecked: bool,
    /// Give every sample a batch of its own, whose counts end with its line: what was known at each
    /// sample is then the same however the bytes were cut into reads. Costs a channel send per
    /// sample.
    pub line_by_line: bool,
    /// Keep commands, answers and refused lines in the batches, as
    /// [`diagnostics`](Batch::diagnostics). The rows of a CSV file that are not let in are not
    /// among them: its [report](crate::CsvReport) names the first of each kind.
    pub diagnostics: bool,
}

/// Batches that may wait to be used: enough to keep both sides busy, few enough to keep memory
/// flat.
pub(crate) const WAITING_BATCHES: usize = 4;

/// Starts a task that reads `source` to its end, or until `stop`, and tells what it holds: a
/// [`Batch`] for each chunk, then one [`Event::End`].
///
/// When the channel is full the task waits, and so does the source behind it; when the receiver is
/// dropped it ends.
///
/// The first measurement decides which message the stream is about; lines of another one are
/// counted, not mixed in.
///
/// # Panics
/// Outside a tokio runtime.
#[must_use]
pub fn read_samples(source: impl Source, options: ReadOptions, stop: CancellationToken) -> mpsc::Receiver<Event> {
    let (events, inbox) = mpsc::channel(WAITING_BATCHES);
    // ends with the source, with `stop`, or when the inbox is dropped
    tokio::spawn(read(source, options, events, stop));
    inbox
}

async fn read(mut source: impl Source, options: ReadOptions, events: mpsc::Sender<Event>, stop: CancellationToken) {
    let mut parser = Parser::new(options);
    let error = loop {
        let input = tokio::select! {
            // checked first: a source that always has data must not outrun the request to stop
            biased;
            () = stop.cancelled() => break None,
            input = source.next_input() => input,
        };
        let input = match input {
            Ok(Some(input)) => input,
            Ok(None) => break None,
            Err(error) => break Some(error),
        };
        for event in parser.take_input(input) {
            if events.send(event).await.is_err() {
                return;
            }
        }
    };
    for batch in parser.finish() {
        // a receiver that left has no use for the end either
        let _ = events.send(Event::Batch(batch)).await;
    }
    let _ = events.send(Event::End(End { error, csv: None })).await;
}

pub(crate) struct Parser {
    decoder: Decoder,
    stream: Stream,
    line_by_line: bool,
    /// Line by line only: bytes not yet decoded.
    waiting: Vec<u8>,
}

/// What is known of the stream from one batch to the next, and the batches not yet sent.
#[derive(Default)]
struct Stream {
    layout: Option<Arc<Layout>>,
    at_ns: Option<i64>,
    printed: Option<PrintFormat>,
    /// The counts but for the tally, which is the decoder's.
    link: LinkCounts,
    /// Good lines of each message but that of the samples, by its code; those without a code of
    /// their own by [`AsyncType::OFF`].
    other_lines: BTreeMap<u8, u64>,
    open: Batch,
    sealed: Vec<Batch>,
    /// Answers, where somebody takes them.
    replies: Option<Vec<Reply>>,
    /// Whether diagnostics are kept.
    is_diagnosed: bool,
}

impl Parser {
    pub(crate) fn new(options: ReadOptions) -> Self {
        let decoder = Decoder::new(Options { accept_unchecked: options.accept_unchecked });
        let stream = Stream { is_diagnosed: options.diagnostics, ..Stream::default() };
        Self { decoder, stream, line_by_line: options.line_by_line, waiting: Vec::new() }
    }

    /// Takes what a source delivered: the events that follow from it.
    pub(crate) fn take_input(&mut self, input: Input) -> impl Iterator<Item = Event> + use<> {
        let link_event = match input {
            Input::Chunk(chunk) => {
                self.push(&chunk.bytes, chunk.at_ns);
                None
            }
            Input::Link(event) => {
                self.take_link_event(&event);
                Some(event)
            }
        };
        self.take_batches().into_iter().map(Event::Batch).chain(link_event.map(Event::Link))
    }

    /// Keeps the sensor's answers for [`take_replies`](Self::take_replies).
    pub(crate) fn keep_replies(&mut self) {
        self.stream.replies = Some(Vec::new());
    }

    /// The answers since the last call.
    pub(crate) fn take_replies(&mut self) -> Vec<Reply> {
        self.stream.replies.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Notes that a command was written.
    pub(crate) fn note_sent(&mut self, line: &[u8]) {
        self.stream.diagnose(|| Diagnostic::Sent(line.into()));
    }

    /// What the stream has carried so far.
    pub(crate) fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    /// Good lines of each message so far, by its code.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (u8, u64)> {
        let samples = self.tally().samples - self.stream.link.foreign_samples;
        let layout = self.stream.layout.as_deref();
        let of_samples = layout.map(|layout| (code(layout.message.as_bytes()), samples));
        of_samples.into_iter().chain(self.stream.other_lines.iter().map(|(&code, &lines)| (code, lines)))
    }

    /// Takes the next bytes of the stream, which came at one time.
    pub(crate) fn push(&mut self, bytes: &[u8], at_ns: Option<i64>) {
        self.stream.at_ns = at_ns;
        if self.line_by_line {
            self.waiting.extend_from_slice(bytes);
            self.decode_line_by_line(false);
        } else {
            // the shortest line of a measurement, of old firmware, has 109 bytes
            self.stream.open.counts.reserve(bytes.len() / 100 * VNYMR.channels.len());
            self.decoder.push(bytes, |item| self.stream.put(item));
        }
    }

    /// Takes what befell the link. A line that was under way when it went down is cut off.
    fn take_link_event(&mut self, event: &LinkEvent) {
        let link = &mut self.stream.link;
        match &event.kind {
            LinkEventKind::Up { .. } => link.connects += 1,
            LinkEventKind::Down { .. } => self.cut(),
            LinkEventKind::Probed { bytes } => link.probed_bytes += bytes,
            LinkEventKind::Overrun { bytes } => link.overrun_bytes += bytes,
            LinkEventKind::UnaskedError { error } => link.unasked_errors.count(*error),
            LinkEventKind::OutputResumed => link.outputs_resumed += 1,
            LinkEventKind::OutputPaused => {}
        }
    }

    /// Ends the stream. Gives the batches that were not taken.
    pub(crate) fn finish(&mut self) -> Vec<Batch> {
        self.cut();
        self.take_batches()
    }

    /// Decides on the bytes held back: nothing follows them.
    fn cut(&mut self) {
        if self.line_by_line {
            self.decode_line_by_line(true);
        } else {
            self.decoder.finish(|item| self.stream.put(item));
        }
    }

    /// Notes that a line of the source was not let in, and why is counted there.
    pub(crate) fn mark_bad_line(&mut self) {
        self.stream.mark(MarkKind::BadLine);
    }

    fn decode_line_by_line(&mut self, end: bool) {
        let mut at = 0;
        loop {
            let (consumed, item) = self.decoder.next(&self.waiting[at..], end);
            at += consumed;
            let Some(item) = item else { break };
            self.stream.put(item);
            if !self.stream.open.counts.is_empty() {
                self.stream.seal(self.decoder.tally());
            }
        }
        self.waiting.drain(..at);
    }

    /// All batches since the last call; one, unless line by line.
    pub(crate) fn take_batches(&mut self) -> Vec<Batch> {
        self.stream.seal(self.decoder.tally());
        std::mem::take(&mut self.stream.sealed)
    }
}

fn code(header: &[u8]) -> u8 {
    AsyncType::from_header(header).unwrap_or(AsyncType::OFF).0
}

impl Stream {
    fn put(&mut self, item: Item<'_>) {
        if let Item::Bad(bad) = &item {
            self.diagnose(|| Diagnostic::refused(bad));
        }
        match item {
            Item::Ymr(ymr) => self.put_sample(&VNYMR, ymr.counts(), ymr.print_format(), ymr.suffix()),
            Item::Imu(imu) => self.put_sample(&VNIMU, imu.counts(), PrintFormat::Current, imu.suffix()),
            Item::Bad(bad) if self.may_be_sample(bad.raw) => self.mark(MarkKind::BadLine),
            Item::Other(sentence) => self.note_other(sentence.header()),
            Item::Reply(sentence) => self.put_reply(&sentence),
            // in the tally
            Item::Packet(_) | Item::Bad(_) => {}
        }
    }

    fn diagnose(&mut self, diagnostic: impl FnOnce() -> Diagnostic) {
        if self.is_diagnosed {
            self.open.diagnostics.push(diagnostic());
        }
    }

    fn put_reply(&mut self, sentence: &Sentence<'_>) {
        self.diagnose(|| Diagnostic::reply(sentence));
        // one that says nothing is in the tally
        let Ok(reply) = Reply::parse(sentence) else { return };
        match &reply {
            Reply::Register(contents) | Reply::Written(contents) => {
                let before_row = self.row();
                self.open.registers.push(RegisterValue::new(contents, before_row));
            }
            Reply::Question(_) => self.link.echoes += 1,
            Reply::Error(error) if error.is_unasked() => self.link.unasked_errors.count(*error),
            Reply::Error(_) | Reply::Echo(_) => {}
        }
        if let Some(replies) = &mut self.replies {
            replies.push(reply);
        }
    }

    #[inline]
    fn put_sample(&mut self, layout: &'static Layout, counts: &[i32], printed: PrintFormat, suffix: Suffix) {
        let chosen = self.layout.get_or_insert_with(|| Arc::new(layout.clone()));
        if chosen.message != layout.message {
            self.link.foreign_samples += 1;
            self.note_other(layout.message.as_bytes());
            return;
        }
        if self.printed != Some(printed) {
            self.printed = Some(printed);
            self.mark(MarkKind::Printed(printed));
        }
        if let Some(at_ns) = self.at_ns
            && self.open.arrivals.last().is_none_or(|last| last.at_ns != at_ns)
        {
            self.open.arrivals.push(Arrival { from_row: self.row(), at_ns });
        }
        if let Some(count) = suffix.count() {
            self.open.counters.push(RowCounter { row: self.row(), count });
        }
        self.open.counts.extend_from_slice(counts);
    }

    fn note_other(&mut self, header: &[u8]) {
        self.link.other_message = self.link.other_message.or(Some(MessageName::new(header)));
        *self.other_lines.entry(code(header)).or_default() += 1;
    }

    /// Whether a bad line may have been one of this stream's measurements: by its name, as far as
    /// that is there, or by its length. A damaged reply, or a `$` in some text, takes no sample's
    /// place.
    fn may_be_sample(&self, raw: &[u8]) -> bool {
        const LONG: usize = 60;
        let message = self.layout.as_ref().map_or("VN", |layout| &layout.message).as_bytes();
        let name = &raw[1..];
        let common = name.len().min(message.len());
        raw.len() >= LONG || common > 0 && name[..common] == message[..common]
    }

    fn mark(&mut self, kind: MarkKind) {
        self.open.marks.push(Mark { before_row: self.row(), kind });
    }

    /// The number of the next row in the open batch.
    fn row(&self) -> usize {
        self.layout.as_ref().map_or(0, |layout| self.open.counts.len() / layout.channels.len())
    }

    fn seal(&mut self, tally: Tally) {
        let mut batch = std::mem::take(&mut self.open);
        batch.layout = self.layout.clone();
        batch.link = LinkCounts { tally, ..self.link };
        self.sealed.push(batch);
    }
}

//! Turns bytes and link events into batches of samples.

use alloc::{collections::BTreeMap, string::ToString, sync::Arc, vec::Vec};
use core::mem;

use super::{
    Arrival, Batch, Diagnostic, LinkEvent, LinkEventKind, Mark, MarkKind, MessageName, RowCounter, StreamCounts,
    packet_reader::{PacketOutcome, PacketReader},
};
use crate::{
    AsyncType, BINARY, Decoder, Item, Layout, Options, Packet, PacketForm, PacketHeader, PrintFormat, Quantity,
    Register, RegisterContents, RejectedCounts, Reply, Sample, Sentence, Tally, VNIMU,
};

/// Sentences with a position or a velocity, which require a satellite receiver (VN-200 and VN-300
/// User Manuals, register 6).
const OF_OTHER_MODELS: [&[u8]; 7] = [b"VNINS", b"VNINE", b"VNISL", b"VNISE", b"VNGPS", b"VNGPE", b"VNG2S"];

/// Options for reading a stream.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadOptions {
    /// Accept lines without a checksum. Only the grammar then protects a value.
    pub accept_unchecked: bool,
    /// Add the counts at the end of every row to batches, so that their [lines](Batch::lines) can
    /// be taken one by one. The counts at each sample are then independent of the division of the
    /// bytes into reads.
    pub line_by_line: bool,
    /// Keep commands, replies and rejected lines in the batches, as
    /// [`diagnostics`](Batch::diagnostics). Rejected rows of a CSV file are not among them: its
    /// [report](super::CsvReport) names the first of each kind.
    pub diagnostics: bool,
    /// The measured frames of a stream with sentences and packets.
    pub measured: MeasuredFrames,
}

/// The measured frames of a stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MeasuredFrames {
    /// The kind that comes first.
    #[default]
    First,
    /// Sentences.
    Sentences,
    /// Packets.
    Packets,
}

/// A kind of frame that the sensor sends by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FrameKind {
    /// Sentences of a message; [`AsyncType::OFF`] for all sentences without a known name.
    Sentence(AsyncType),
    /// Binary packets of one output.
    Packet(PacketHeader),
}

/// Decodes a stream and collects its samples in batches.
pub struct SampleReader {
    decoder: Decoder,
    stream: Stream,
    line_by_line: bool,
    /// Only line by line: bytes not yet decoded.
    waiting: Vec<u8>,
}

/// The state of the stream from one batch to the next, and the batches not yet sent.
#[derive(Default)]
struct Stream {
    measured: MeasuredFrames,
    layout: Option<Arc<Layout>>,
    packets: PacketReader,
    at_ns: Option<i64>,
    printed: Option<PrintFormat>,
    /// The counts except the tally, which the decoder keeps except for the measured packets.
    link: StreamCounts,
    /// Valid sentences of each message except that of the samples; [`AsyncType::OFF`] for messages
    /// without a code.
    other_lines: BTreeMap<AsyncType, u64>,
    /// Parts of damaged packets that the decoder has rejected as sentences.
    fragments: RejectedCounts,
    fragment_bytes: u64,
    open: Batch,
    sealed: Vec<Batch>,
    /// Replies since the last call of `take_replies`, if they are kept.
    replies: Option<Vec<Reply>>,
    is_diagnosed: bool,
}

impl SampleReader {
    /// A reader at the beginning of a stream.
    pub fn new(options: ReadOptions) -> Self {
        let decoder = Decoder::new(Options { accept_unchecked: options.accept_unchecked });
        let stream = Stream { measured: options.measured, is_diagnosed: options.diagnostics, ..Stream::default() };
        Self { decoder, stream, line_by_line: options.line_by_line, waiting: Vec::new() }
    }

    /// Keeps the sensor's replies for [`take_replies`](Self::take_replies).
    pub fn keep_replies(&mut self) {
        self.stream.replies = Some(Vec::new());
    }

    /// The replies since the last call.
    pub fn take_replies(&mut self) -> Vec<Reply> {
        self.stream.replies.as_mut().map(mem::take).unwrap_or_default()
    }

    /// Notes that a command was written.
    pub fn note_sent(&mut self, line: &[u8]) {
        self.stream.diagnose(|| Diagnostic::Sent(line.into()));
    }

    /// The counts of the stream so far.
    pub fn tally(&self) -> Tally {
        let Stream { packets, fragments, fragment_bytes, .. } = &self.stream;
        let tally = self.decoder.tally().without_fragments(fragments, *fragment_bytes);
        Tally { measured_packets: packets.counts, ..tally }
    }

    /// Frames that the sensor has sent by itself so far, by their kind.
    pub fn frames(&self) -> impl Iterator<Item = (FrameKind, u64)> {
        let samples = self.tally().samples - self.stream.link.foreign_samples;
        let layout = self.stream.layout.as_deref().filter(|layout| layout.message != BINARY);
        let of_samples = layout.map(|layout| (message(layout.message.as_bytes()), samples));
        let others = self.stream.other_lines.iter().map(|(&message, &lines)| (message, lines));
        let sentences = of_samples.into_iter().chain(others);
        let sentences = sentences.map(|(message, lines)| (FrameKind::Sentence(message), lines));
        let packets = self.stream.packets.packets();
        sentences.chain(packets.map(|(header, packets)| (FrameKind::Packet(header), packets)))
    }

    /// Takes the next bytes of the stream, which arrived together.
    pub fn push(&mut self, bytes: &[u8], at_ns: Option<i64>) {
        self.stream.at_ns = at_ns;
        if self.line_by_line {
            self.waiting.extend_from_slice(bytes);
            self.decode_line_by_line(false);
        } else {
            // a count takes at least four bytes of its packet, and nine of its sentence
            let bytes_per_count = if self.stream.packets.form.is_some() { 4 } else { 9 };
            self.stream.open.counts.reserve(bytes.len() / bytes_per_count);
            self.decoder.push(bytes, |item| self.stream.item(item));
        }
    }

    /// Counts an event of the link, which comes after the [batches](Self::take_batches) that are
    /// complete now.
    pub fn take_link_event(&mut self, event: &LinkEvent) {
        let link = &mut self.stream.link;
        match &event.kind {
            LinkEventKind::Up { .. } => link.connects += 1,
            LinkEventKind::Down { .. } => self.cut(),
            LinkEventKind::DiscardedDuringBaudScan { bytes } => link.baud_scan_bytes += bytes,
            LinkEventKind::Overrun { bytes } => link.overrun_bytes += bytes,
            LinkEventKind::UnsolicitedError { error } => link.unsolicited_errors.count(*error),
            LinkEventKind::OutputResumed => link.outputs_resumed += 1,
            LinkEventKind::OutputPaused
            | LinkEventKind::PortShared { .. }
            | LinkEventKind::Closed
            | LinkEventKind::Marked { .. } => {}
        }
    }

    /// Ends the stream, and returns the remaining batches.
    pub fn finish(&mut self) -> Vec<Batch> {
        self.cut();
        self.take_batches()
    }

    /// Decides about the pending bytes, because no byte follows them.
    fn cut(&mut self) {
        let rejected = self.tally().rejected.total();
        if self.line_by_line {
            self.decode_line_by_line(true);
        } else {
            self.decoder.finish(|item| self.stream.item(item));
        }
        self.stream.link.cut_sentences += self.tally().rejected.total() - rejected;
    }

    /// Marks a row that the source has rejected, and counted by its reason.
    pub fn mark_rejected_row(&mut self) {
        self.stream.mark(MarkKind::Rejected);
    }

    fn decode_line_by_line(&mut self, end: bool) {
        let mut at = 0;
        loop {
            let (consumed, item) = self.decoder.next(&self.waiting[at..], end);
            at += consumed;
            let Some(item) = item else { break };
            if !self.stream.is_one_more_row(&item) {
                self.stream.seal_rows();
            }
            let rows = self.stream.row();
            self.stream.item(item);
            if self.stream.row() > rows {
                let tally = self.tally();
                self.stream.open.tallies.push(tally);
            }
        }
        self.stream.seal_rows();
        self.waiting.drain(..at);
    }

    /// All batches since the last call; a single one, unless line by line.
    pub fn take_batches(&mut self) -> Vec<Batch> {
        self.stream.seal(self.tally());
        mem::take(&mut self.stream.sealed)
    }
}

fn message(header: &[u8]) -> AsyncType {
    AsyncType::from_header(header).unwrap_or(AsyncType::OFF)
}

impl Stream {
    fn item(&mut self, item: Item<'_>) {
        if let Item::Rejected(rejected) = &item {
            // a `$` may occur in a damaged packet by chance
            if self.packets.form.is_some() && !rejected.raw.starts_with(b"$VN") {
                self.fragments.count(rejected.kind);
                self.fragment_bytes += rejected.raw.len() as u64;
                return;
            }
            self.diagnose(|| Diagnostic::Refused {
                reason: rejected.kind.to_string(),
                offset: rejected.offset,
                raw: rejected.raw.into(),
            });
        }
        match item {
            Item::Sample(sample) => self.put_sample(&sample),
            Item::Rejected(rejected) if self.may_be_sample(rejected.raw) => self.mark(MarkKind::Rejected),
            Item::Other(sentence) => self.note_other(sentence.header()),
            Item::Reply(sentence) => self.put_reply(&sentence),
            Item::Packet(packet) => self.put_packet(&packet),
            // counted in the tally
            Item::Rejected(_) => {}
        }
    }

    fn diagnose(&mut self, diagnostic: impl FnOnce() -> Diagnostic) {
        if self.is_diagnosed {
            self.open.diagnostics.push(diagnostic());
        }
    }

    fn put_reply(&mut self, sentence: &Sentence<'_>) {
        self.diagnose(|| Diagnostic::Reply(sentence.raw.trim_ascii_end().into()));
        // a reply that cannot be parsed is counted in the tally
        let Some(reply) = Reply::parse(sentence) else { return };
        if let Reply::Register(contents) = &reply {
            self.mark_temperature(contents);
        }
        match &reply {
            Reply::Register(contents) | Reply::Written(contents) => self.open.registers.push(contents.clone()),
            Reply::Question(_) => self.link.echoes += 1,
            Reply::Error(error) if error.is_unsolicited() => self.link.unsolicited_errors.count(*error),
            Reply::Error(_) | Reply::Echo(_) => {}
        }
        if let Some(replies) = &mut self.replies {
            replies.push(reply);
        }
    }

    fn mark_temperature(&mut self, contents: &RegisterContents) {
        if contents.register == Register::IMU
            && let Ok(sample) = Sample::from_contents(contents, &VNIMU)
        {
            let cells = VNIMU.channels.iter().zip(sample.counts());
            let temperature = cells.filter(|(channel, _)| channel.quantity == Quantity::Temperature);
            temperature.for_each(|(_, counts)| self.mark(MarkKind::Temperature(*counts)));
        }
    }

    #[inline]
    fn put_sample(&mut self, sample: &Sample) {
        let (layout, printed) = (sample.layout, sample.print_format);
        if self.layout.is_none() && self.measured != MeasuredFrames::Packets {
            self.layout = Some(Arc::new(layout.clone()));
        }
        if self.layout.as_ref().is_none_or(|chosen| chosen.message != layout.message) {
            self.link.foreign_samples += 1;
            self.note_other(layout.message.as_bytes());
            return;
        }
        if self.printed != Some(printed) {
            self.printed = Some(printed);
            self.mark(MarkKind::Printed(printed));
        }
        self.note_arrival_of(self.open.counts.len());
        if let Some(count) = sample.suffix.count {
            self.open.counters.push(RowCounter { row: self.row(), count });
        }
        self.open.counts.extend_from_slice(sample.counts());
    }

    #[inline]
    fn put_packet(&mut self, packet: &Packet<'_>) {
        if self.layout.is_none()
            && self.measured != MeasuredFrames::Sentences
            && let Some(form) = PacketForm::of(packet)
        {
            self.layout = Some(Arc::clone(&form.layout));
            self.packets.form = Some(form);
        }
        let before = self.open.counts.len();
        match self.packets.read(packet, &mut self.open.counts) {
            PacketOutcome::Sample { device_ns, saturation } => {
                if saturation != 0 {
                    let before_row = self.row_at(before);
                    self.open.marks.push(Mark { before_row, kind: MarkKind::Saturated(saturation) });
                }
                self.open.device_ns.extend(device_ns);
                self.note_arrival_of(before);
            }
            PacketOutcome::Rejected(rejected) => {
                self.diagnose(|| Diagnostic::Refused {
                    reason: rejected.to_string(),
                    offset: packet.offset,
                    raw: packet.raw.into(),
                });
                self.mark(MarkKind::Rejected);
            }
            PacketOutcome::None => {}
        }
    }

    /// Notes the arrival of the row whose counts begin at this place, whose number is calculated only
    /// if needed, because it takes a division.
    #[inline]
    fn note_arrival_of(&mut self, place: usize) {
        if let Some(at_ns) = self.at_ns
            && self.open.arrivals.last().is_none_or(|last| last.at_ns != at_ns)
        {
            self.open.arrivals.push(Arrival { from_row: self.row_at(place), at_ns });
        }
    }

    fn note_other(&mut self, header: &[u8]) {
        self.link.other_message = self.link.other_message.or(Some(MessageName::new(header)));
        if OF_OTHER_MODELS.contains(&header) {
            self.link.other_model = self.link.other_model.or(Some(MessageName::new(header)));
        }
        *self.other_lines.entry(message(header)).or_default() += 1;
    }

    /// Whether a rejected sentence may have been one of this stream's measurements: by the existing
    /// part of its name, or by its length. A damaged reply, or a `$` in some text, replaces no
    /// sample.
    fn may_be_sample(&self, raw: &[u8]) -> bool {
        const LONG: usize = 60;
        if self.packets.form.is_some() {
            return false;
        }
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
        self.row_at(self.open.counts.len())
    }

    /// The number of the row whose counts begin at this place.
    fn row_at(&self, place: usize) -> usize {
        self.layout.as_ref().map_or(0, |layout| place / layout.channels.len())
    }

    /// Whether the item is a row like the one before it, without marks.
    fn is_one_more_row(&mut self, item: &Item<'_>) -> bool {
        match item {
            Item::Sample(sample) => {
                let is_ours = self.layout.as_ref().is_some_and(|layout| layout.message == sample.layout.message);
                is_ours && self.printed == Some(sample.print_format)
            }
            Item::Packet(packet) => self.packets.is_one_more_row(packet),
            _ => false,
        }
    }

    fn seal_rows(&mut self) {
        if let Some(tally) = self.open.tallies.last() {
            let tally = *tally;
            if self.open.tallies.len() == 1 {
                self.open.tallies.clear();
            }
            self.seal(tally);
        }
    }

    fn seal(&mut self, tally: Tally) {
        let mut batch = mem::take(&mut self.open);
        batch.layout = self.layout.clone();
        batch.link = StreamCounts { tally, other_packet: self.packets.first_other, ..self.link };
        self.sealed.push(batch);
    }
}

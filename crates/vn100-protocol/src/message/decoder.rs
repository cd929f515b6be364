//! Bytes to messages: the framer, the messages and the fast path together.

use crate::{
    framing::checksum::Check,
    framing::framer::{Frame, Framer, Options},
    framing::packet::{MAX_PACKET, Packet, START},
    framing::sentence::{RejectReason, RejectedSentence, Sentence},
    framing::tally::Tally,
    message::GrammarError,
    message::sample::Sample,
    message::template,
};

/// Decodes a byte stream.
///
/// The items depend only on the bytes, not on their division into pieces. [`push`](Self::push)
/// takes pieces of any size and keeps incomplete frames; with [`next`](Self::next) the caller keeps
/// them.
#[derive(Debug, Clone)]
pub struct Decoder {
    framer: Framer,
    /// The beginning of a sentence or packet, between calls of `push`.
    carry: [u8; CARRY],
    carried: usize,
}

/// Room for the longest packet with the longest sentence begun in its last byte, after which no
/// frame needs more bytes.
const CARRY: usize = 2 * MAX_PACKET;

/// One item of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Item<'a> {
    /// A sentence of one of the [`MESSAGES`](crate::MESSAGES).
    Sample(Sample),
    /// An answer to a command.
    Reply(Sentence<'a>),
    /// Any other valid sentence, of a VN-100 or not.
    Other(Sentence<'a>),
    /// A binary packet.
    Packet(Packet<'a>),
    /// A rejected sentence.
    Rejected(RejectedSentence<'a>),
}

impl Decoder {
    /// A decoder at the beginning of a stream.
    pub fn new(options: Options) -> Self {
        Self { framer: Framer::new(options), carry: [0; CARRY], carried: 0 }
    }

    /// Takes the next piece of the stream, of any size, and calls `sink` with each item that it
    /// completes, in the order of the stream.
    ///
    /// Only the beginning of a sentence or packet at the end of the piece is copied, at most about
    /// 850 bytes.
    pub fn push(&mut self, bytes: &[u8], mut sink: impl FnMut(Item<'_>)) {
        if let Some(rest) = self.finish_carried(bytes, &mut sink) {
            let incomplete = decode(&mut self.framer, rest, false, &mut sink);
            self.carry[..incomplete.len()].copy_from_slice(incomplete);
            self.carried = incomplete.len();
        }
    }

    /// Ends the stream: pending bytes are decoded as they are. Offsets and [`tally`](Self::tally)
    /// continue with bytes pushed later.
    pub fn finish(&mut self, mut sink: impl FnMut(Item<'_>)) {
        decode(&mut self.framer, &self.carry[..self.carried], true, &mut sink);
        self.carried = 0;
    }

    /// The number of bytes at the head of `input` that are consumed, and the item that ends there.
    ///
    /// The caller drops these bytes and passes the others again. `None` means that more bytes are
    /// needed; with `end_of_input`, when no more follow, it means that all are consumed. Must not
    /// be mixed with [`push`](Self::push) on one stream.
    #[inline]
    pub fn next<'a>(&mut self, input: &'a [u8], end_of_input: bool) -> (usize, Option<Item<'a>>) {
        self.framer.next_item(input, end_of_input)
    }

    /// The counts of the stream so far.
    pub fn tally(&self) -> Tally {
        Tally { buffered_bytes: self.carried as u64, ..self.framer.tally }
    }

    /// Decodes the carried bytes, followed by as many of `bytes` as needed. Returns the rest of
    /// `bytes`, or `None` if all of them had to be carried as well.
    fn finish_carried<'a>(&mut self, bytes: &'a [u8], sink: &mut impl FnMut(Item<'_>)) -> Option<&'a [u8]> {
        if self.carried == 0 {
            return Some(bytes);
        }
        let added = bytes.len().min(CARRY - self.carried);
        let filled = self.carried + added;
        self.carry[self.carried..filled].copy_from_slice(&bytes[..added]);
        let mut at = 0;
        while at < self.carried {
            let (consumed, item) = self.framer.next_item(&self.carry[at..filled], false);
            at += consumed;
            match item {
                Some(item) => sink(item),
                None if at < self.carried => {
                    self.carry.copy_within(at..filled, 0);
                    self.carried = filled - at;
                    return None;
                }
                None => {}
            }
        }
        let used = at - self.carried;
        self.carried = 0;
        Some(&bytes[used..])
    }
}

/// Passes each item to `sink`; returns the remaining bytes, which are incomplete.
#[inline]
fn decode<'a>(framer: &mut Framer, mut rest: &'a [u8], end: bool, sink: &mut impl FnMut(Item<'_>)) -> &'a [u8] {
    loop {
        // the usual packets of a capture, without a move of the largest item
        while rest.first() == Some(&START)
            && let Some(packet) = framer.known_packet(rest)
        {
            rest = &rest[packet.raw.len()..];
            sink(Item::Packet(packet));
        }
        let (consumed, item) = framer.next_item(rest, end);
        rest = &rest[consumed..];
        match item {
            Some(item) => sink(item),
            None => return rest,
        }
    }
}

impl Framer {
    #[inline]
    fn next_item<'a>(&mut self, input: &'a [u8], end_of_input: bool) -> (usize, Option<Item<'a>>) {
        let at = self.take_line_end(input);
        if let Some(sample) = template::read(&input[at..]) {
            let length = template::length(&input[at..]);
            self.accept(length);
            self.tally.samples += 1;
            return (at + length, Some(Item::Sample(sample)));
        }
        let (consumed, item) = self.any_item(&input[at..], end_of_input);
        (at + consumed, item)
    }

    #[inline(never)]
    fn any_item<'a>(&mut self, input: &'a [u8], end_of_input: bool) -> (usize, Option<Item<'a>>) {
        let (consumed, frame) = self.next(input, end_of_input);
        let item = frame.map(|frame| match frame {
            Frame::Sentence(sentence) => self.message(sentence),
            Frame::Packet(packet) => Item::Packet(packet),
            Frame::Rejected(rejected) => Item::Rejected(rejected),
        });
        (consumed, item)
    }

    #[inline]
    fn message<'a>(&mut self, sentence: Sentence<'a>) -> Item<'a> {
        let (item, count) = match Sample::parse(&sentence) {
            Some(Ok(sample)) => (Item::Sample(sample), &mut self.tally.samples),
            Some(Err(kind)) => return Item::Rejected(self.reject(sentence, kind)),
            None if !sentence.has_name() => {
                return Item::Rejected(self.reject(sentence, RejectReason::Grammar(GrammarError::Name)));
            }
            None if sentence.is_reply() => (Item::Reply(sentence), &mut self.tally.replies),
            None => (Item::Other(sentence), &mut self.tally.other),
        };
        *count += 1;
        self.tally.unchecked_sentences += u64::from(sentence.check == Check::None);
        item
    }
}

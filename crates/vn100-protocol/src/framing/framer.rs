//! Finds sentences and packets in a stream of any bytes.
//!
//! A sentence is `$`, a body of printable ASCII without `$` and `*`, `*` and two or four
//! hexadecimal digits. The first byte that is no such digit ends it, CR or not: the checksum
//! decides, so a valid sentence with a damaged end is not lost. The sensor prints upper-case
//! digits. Lower-case digits, of programs that rewrite its sentences, count if the upper-case ones
//! give no valid sentence.
//!
//! The search after a false start continues one byte after it, or after all bytes that were taken
//! for a sentence, because they contain neither `$` nor 0xFA.

use memchr::{memchr_iter, memchr3};

use crate::{
    framing::checksum::{Check, CheckDigits, crc16, xor8},
    framing::packet::{self, Packet, PacketStart, SeenHeads},
    framing::sentence::{MAX_BODY, RejectReason, RejectedSentence, Sentence},
    framing::tally::Tally,
};

/// The conditions for a valid sentence.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Accept sentences without check digits. Only the form of its numbers then protects a line.
    pub accept_unchecked: bool,
}

/// Finds the sentences and packets of a byte stream.
///
/// The caller owns the bytes: it drops the consumed bytes, and passes the others again with more
/// bytes after them. At most [`MAX_PACKET`](crate::MAX_PACKET) plus [`MAX_BODY`] bytes and a few
/// are left pending. The frames and their offsets depend only on the stream, not on its division
/// into inputs.
#[derive(Debug, Clone)]
pub struct Framer {
    options: Options,
    pub(crate) tally: Tally,
    offset: u64,
    /// The line to which CR and LF at this place would belong.
    line_end_of: LineEndOf,
    seen_heads: SeenHeads,
    /// The expected end of the last damaged packet.
    damaged_until: u64,
}

/// A piece of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frame<'a> {
    /// A valid sentence.
    Sentence(Sentence<'a>),
    /// A binary packet.
    Packet(Packet<'a>),
    /// A rejected sentence.
    Rejected(RejectedSentence<'a>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LineEndOf {
    Nothing,
    Valid,
    Rejected,
}

/// The classification of the bytes after a `$`.
enum Start {
    Incomplete,
    /// The sentence has a body of `body` bytes and has a total of `length` bytes.
    Ends {
        body: usize,
        length: usize,
        checked: Result<Check, RejectReason>,
    },
}

impl Framer {
    /// A framer at the beginning of a stream.
    pub fn new(options: Options) -> Self {
        Self {
            options,
            tally: Tally::default(),
            offset: 0,
            line_end_of: LineEndOf::Nothing,
            seen_heads: SeenHeads::default(),
            damaged_until: 0,
        }
    }

    /// Searches the next sentence or packet in `input`, the bytes of the stream after the last
    /// consumed one. Returns the number of bytes at its head that are consumed, and the frame that
    /// ends there; `None` if more bytes are needed.
    ///
    /// With `end_of_input` no more bytes follow: an incomplete frame is classified as it is, and
    /// without a frame all bytes are consumed.
    #[inline]
    pub fn next<'a>(&mut self, input: &'a [u8], end_of_input: bool) -> (usize, Option<Frame<'a>>) {
        let mut at = self.take_line_end(input);
        while let Some(skipped) = memchr3(b'$', packet::START, packet::SPLIT_START, &input[at..]) {
            self.skip(skipped);
            at += skipped;
            let candidate = &input[at..];
            let found = match candidate[0] {
                b'$' => self.sentence(candidate, end_of_input),
                packet::START => self.packet(candidate, end_of_input),
                _ => match packet::classify_part(candidate) {
                    PacketStart::Packet(length) => Found::Part(length),
                    PacketStart::Incomplete => Found::Incomplete,
                    PacketStart::No => Found::Nothing,
                },
            };
            match found {
                Found::Frame(length, frame) => return (at + length, Some(frame)),
                Found::Part(length) => {
                    self.tally.split_packets += 1;
                    self.skip(length);
                    at += length;
                }
                Found::Incomplete if !end_of_input => return (at, None),
                Found::Incomplete | Found::Nothing => {
                    self.skip(1);
                    at += 1;
                }
            }
        }
        self.skip(input.len() - at);
        if end_of_input {
            self.line_end_of = LineEndOf::Nothing;
        }
        (input.len(), None)
    }

    /// Counts a valid sentence of `length` bytes that the fast path has found.
    #[inline]
    pub(crate) fn accept(&mut self, length: usize) {
        self.advance(length);
        self.tally.valid_sentence_bytes += length as u64;
        self.line_end_of = LineEndOf::Valid;
    }

    /// Rejects the last sentence.
    #[cold]
    pub(crate) fn reject<'a>(&mut self, sentence: Sentence<'a>, kind: RejectReason) -> RejectedSentence<'a> {
        self.tally.valid_sentence_bytes -= sentence.raw.len() as u64;
        self.tally.rejected_sentence_bytes += sentence.raw.len() as u64;
        self.tally.rejected.count(kind);
        self.line_end_of = LineEndOf::Rejected;
        RejectedSentence { kind, raw: sentence.raw, offset: sentence.offset }
    }

    /// Assigns CR and LF at the head of `input` to the line before them.
    #[inline]
    pub(crate) fn take_line_end(&mut self, input: &[u8]) -> usize {
        let bytes = match self.line_end_of {
            LineEndOf::Nothing => return 0,
            LineEndOf::Valid => &mut self.tally.valid_sentence_bytes,
            LineEndOf::Rejected => &mut self.tally.rejected_sentence_bytes,
        };
        let length = input.iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        *bytes += length as u64;
        self.advance(length);
        length
    }

    fn sentence<'a>(&mut self, input: &'a [u8], end_of_input: bool) -> Found<'a> {
        let Start::Ends { body, length, checked } = classify(input, end_of_input) else {
            return Found::Incomplete;
        };
        let (raw, offset) = (&input[..length], self.offset);
        let checked = match checked {
            Err(RejectReason::Unchecked) if self.options.accept_unchecked => Ok(Check::None),
            checked => checked,
        };
        let frame = match checked {
            Ok(check) => {
                self.accept(length);
                let body = &input[1..1 + body];
                let body = if check == Check::None { without_closing_quote(body) } else { body };
                Frame::Sentence(Sentence { body, raw, check, offset })
            }
            Err(kind) => {
                self.advance(length);
                self.tally.rejected_sentence_bytes += length as u64;
                self.tally.rejected.count(kind);
                self.line_end_of = LineEndOf::Rejected;
                Frame::Rejected(RejectedSentence { kind, raw, offset })
            }
        };
        Found::Frame(length, frame)
    }

    fn packet<'a>(&mut self, input: &'a [u8], end_of_input: bool) -> Found<'a> {
        let known = self.seen_heads.length_of(input);
        let classified = match known {
            Some(length) => packet::checked(input, length),
            None => packet::classify(input),
        };
        let length = match classified {
            PacketStart::Incomplete => return Found::Incomplete,
            PacketStart::No => return self.damaged_packet(input),
            PacketStart::Packet(length) => length,
        };
        match is_completed_by_sentence(input, length, end_of_input) {
            None => Found::Incomplete,
            Some(true) => self.damaged_packet(input),
            Some(false) => {
                if known.is_none() {
                    self.seen_heads.remember(&input[..length]);
                }
                Found::Frame(length, Frame::Packet(self.accept_packet(&input[..length])))
            }
        }
    }

    /// The packet at the head of `input`, if one with the same head was seen: the usual case.
    #[inline(never)]
    pub(crate) fn known_packet<'a>(&mut self, input: &'a [u8]) -> Option<Packet<'a>> {
        let length = self.seen_heads.length_of(input)?;
        let is_packet = packet::checked(input, length) == PacketStart::Packet(length)
            && is_completed_by_sentence(input, length, false) == Some(false);
        is_packet.then(|| self.accept_packet(&input[..length]))
    }

    #[inline]
    fn accept_packet<'a>(&mut self, raw: &'a [u8]) -> Packet<'a> {
        let packet = Packet { raw, offset: self.offset };
        self.advance(raw.len());
        self.tally.packet_bytes += raw.len() as u64;
        self.tally.packets += 1;
        self.line_end_of = LineEndOf::Nothing;
        packet
    }

    /// Counts bytes that begin with 0xFA and are no packet, if they were a packet before they were
    /// damaged.
    #[cold]
    fn damaged_packet<'a>(&mut self, input: &[u8]) -> Found<'a> {
        if self.offset >= self.damaged_until
            && let Some(length) = self.seen_heads.length_of(input)
        {
            self.tally.damaged_packets += 1;
            self.damaged_until = self.offset + length as u64;
        }
        Found::Nothing
    }

    fn skip(&mut self, length: usize) {
        if length > 0 {
            self.advance(length);
            self.tally.skipped_bytes += length as u64;
            self.line_end_of = LineEndOf::Nothing;
        }
    }

    #[inline]
    fn advance(&mut self, length: usize) {
        self.offset += length as u64;
    }
}

/// The beginning of sentences of the sensor, after the `$`.
const TALKER: &[u8] = b"VN";

enum Found<'a> {
    Frame(usize, Frame<'a>),
    /// A part of a split packet, with its length.
    Part(usize),
    Incomplete,
    Nothing,
}

/// Classifies the sentence that begins with the `$` at the head of `input`.
fn classify(input: &[u8], end_of_input: bool) -> Start {
    let behind_start = &input[1..];
    let body = body_length(&behind_start[..behind_start.len().min(MAX_BODY + 1)]);
    let without_digits = |kind| Start::Ends { body, length: 1 + body, checked: Err(kind) };
    if body > MAX_BODY {
        return without_digits(RejectReason::TooLong);
    }
    match behind_start.get(body) {
        Some(b'*') => check_digits(&behind_start[..body], &behind_start[body + 1..], end_of_input),
        Some(b'\r' | b'\n') => without_digits(RejectReason::Unchecked),
        Some(_) => without_digits(RejectReason::Truncated),
        None if end_of_input => without_digits(RejectReason::Truncated),
        None => Start::Incomplete,
    }
}

/// Whether a packet of `length` bytes was cut and is complete only with the beginning of a good
/// sentence after it: with one borrowed byte, a CRC is correct by chance once in 256 times. `None`
/// if this depends on bytes that are not received yet.
fn is_completed_by_sentence(input: &[u8], length: usize, end_of_input: bool) -> Option<bool> {
    let completed = memchr_iter(b'$', &input[..length])
        .map(|at| sentence_completes(&input[at..], length - at, end_of_input))
        .find(|completed| *completed != Some(false));
    completed.unwrap_or(Some(false))
}

/// Whether the `$` at the head of `input` begins a good sentence of the sensor that is longer than the
/// `rest` of the packet around it. `None` if this depends on bytes that are not received yet. Sentences
/// of other devices do not count, because a packet with a `$` near its end would wait for the next one.
fn sentence_completes(input: &[u8], rest: usize, end_of_input: bool) -> Option<bool> {
    let talker = &input[1..input.len().min(1 + TALKER.len())];
    if !TALKER.starts_with(talker) {
        return Some(false);
    }
    match classify(input, end_of_input) {
        Start::Incomplete => None,
        Start::Ends { length, checked, .. } => Some(checked.is_ok() && length > rest),
    }
}

/// Checks a sentence by its `body` and the bytes after its `*`.
fn check_digits(body: &[u8], tail: &[u8], end_of_input: bool) -> Start {
    let head = &tail[..tail.len().min(5)];
    let runs_on = |length| length < 5 && length == tail.len() && !end_of_input;
    let ends =
        |behind_body, checked| Start::Ends { body: body.len(), length: 1 + body.len() + 1 + behind_body, checked };

    let digits = head.iter().take_while(|byte| byte.is_ascii_hexdigit()).count();
    if runs_on(digits) {
        return Start::Incomplete;
    }
    let upper_case = head.iter().take_while(|byte| matches!(byte, b'0'..=b'9' | b'A'..=b'F')).count();
    match (checked(body, &head[..upper_case]), checked(body, &head[..digits])) {
        (None | Some(Err(_)), Some(Ok(check))) => return ends(digits, Ok(check)),
        (Some(checked), _) => return ends(upper_case, checked),
        (None, Some(checked)) => return ends(digits, checked),
        (None, None) => {}
    }
    // any text in place of the digits is part of the evidence
    let written = head.iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
    if runs_on(written) {
        return Start::Incomplete;
    }
    match head.get(written) {
        Some(b'\r' | b'\n') if written == 0 => ends(0, Err(RejectReason::Unchecked)),
        Some(b'$' | ..=0x1F | 0x7F..) | None if written == 0 => ends(0, Err(RejectReason::Truncated)),
        _ => ends(written, Err(RejectReason::Checksum { computed: CheckDigits::Xor8(xor8(body)), received: None })),
    }
}

/// Whether two or four digits are the checksum of `body`; `None` for another number of digits.
fn checked(body: &[u8], digits: &[u8]) -> Option<Result<Check, RejectReason>> {
    match *digits {
        [a, b] => {
            let received = hex(a) << 4 | hex(b);
            Some(compare(CheckDigits::Xor8(xor8(body)), CheckDigits::Xor8(received), Check::Xor8))
        }
        [a, b, c, d] => {
            let received = u16::from_be_bytes([hex(a) << 4 | hex(b), hex(c) << 4 | hex(d)]);
            Some(compare(CheckDigits::Crc16(crc16(body)), CheckDigits::Crc16(received), Check::Crc16))
        }
        _ => None,
    }
}

fn compare(computed: CheckDigits, received: CheckDigits, check: Check) -> Result<Check, RejectReason> {
    if computed == received { Ok(check) } else { Err(RejectReason::Checksum { computed, received: Some(received) }) }
}

/// A sentence without check digits may have been written in quotes, with its line end in letters.
#[cold]
fn without_closing_quote(body: &[u8]) -> &[u8] {
    let body = body.trim_ascii_end();
    let Some(mut inner) = body.strip_suffix(b"\"").or(body.strip_suffix(b"'")) else { return body };
    while let Some(shorter) = inner.strip_suffix(b"\\n").or(inner.strip_suffix(b"\\r")) {
        inner = shorter;
    }
    inner.trim_ascii_end()
}

/// The value of a hexadecimal digit.
fn hex(digit: u8) -> u8 {
    if digit <= b'9' { digit - b'0' } else { (digit & !0x20) - b'A' + 10 }
}

/// The number of bytes at the head of `bytes` that can stand in a body.
fn body_length(bytes: &[u8]) -> usize {
    // sixteen at a time without a branch: one vector register
    let (blocks, _) = bytes.as_chunks::<16>();
    let clean = 16
        * blocks
            .iter()
            .take_while(|block| block.iter().fold(0, |wrong, &byte| wrong | u8::from(!is_body(byte))) == 0)
            .count();
    clean + bytes[clean..].iter().take_while(|&&byte| is_body(byte)).count()
}

#[inline]
fn is_body(byte: u8) -> bool {
    matches!(byte, 0x20..=0x7E) & (byte != b'$') & (byte != b'*')
}

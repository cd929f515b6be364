//! What all phases of a link share: the one path of every input, and what the link knows of its
//! sensor.

use std::{collections::VecDeque, mem, time::Duration};

use vn100_capture::Event as StreamEvent;
use vn100_protocol::stream::{LinkEvent, LinkEventKind, SampleReader, StreamInput};
use vn100_protocol::{Options, Register, RegisterContents, Reply};

use super::{
    LinkOutput, OpenPort, PortAction, pending_inputs::PendingInputs, requests::RequestEvent, requests::Requests,
    stream_health::FrameCounts,
};
use crate::{
    link::{LinkOptions, LinkState},
    link_error::{LinkError, LinkHint},
    output_plan::Change,
};

/// The first and the longest delay before an attempt to reconnect.
pub(super) const FIRST_DELAY: Duration = Duration::from_millis(100);
const LONGEST_DELAY: Duration = Duration::from_secs(5);

pub(super) struct LinkContext {
    /// The name of the port as the user gave it.
    pub(super) given_name: String,
    /// Whether the link has a baud rate.
    pub(super) has_baud: bool,
    pub(super) listen_only: bool,
    /// How frames are read.
    pub(super) options: Options,
    /// The words for a hint.
    pub(super) hint_text: fn(LinkHint) -> &'static str,
    /// Written again when the sensor has lost them.
    pub(super) desired_settings: Vec<Change>,
    /// The only baud rate to try; `None` to try all.
    pub(super) fixed_baud: Option<u32>,
    /// The baud rate at which the sensor was connected last.
    pub(super) last_baud: Option<u32>,
    /// Whether the sensor was connected at all.
    pub(super) was_connected: bool,
    /// The delay before the next attempt to reconnect; it doubles until the link has carried a good
    /// frame.
    pub(super) reconnect_delay: Duration,
    /// The port, as it was opened last.
    pub(super) port: OpenPort,
    pub(super) requests: Requests,
    /// What was received and is neither forwarded nor discarded yet.
    pub(super) pending: PendingInputs,
    pub(super) port_actions: VecDeque<PortAction>,
    pub(super) events: VecDeque<LinkOutput>,
    pub(super) reader: SampleReader,
    serial_number: Option<String>,
    /// A different serial number that the sensor has reported once.
    unconfirmed_serial: Option<String>,
}

impl LinkContext {
    pub(super) fn new(given_name: String, has_baud: bool, options: LinkOptions) -> Self {
        let mut reader = SampleReader::new(options.read);
        reader.keep_replies();
        let listen_only = options.listen_only;
        let frames = Options { accept_unchecked: options.read.accept_unchecked };
        Self {
            given_name,
            has_baud,
            listen_only,
            options: frames,
            hint_text: options.hint_text.unwrap_or(LinkHint::text),
            desired_settings: if listen_only { Vec::new() } else { options.desired_settings },
            fixed_baud: options.baud,
            last_baud: None,
            was_connected: false,
            reconnect_delay: FIRST_DELAY,
            port: OpenPort::default(),
            requests: Requests::new(listen_only, options.poll_temperature),
            pending: PendingInputs::new(frames),
            port_actions: VecDeque::new(),
            events: VecDeque::new(),
            reader,
            serial_number: options.known_serial,
            unconfirmed_serial: None,
        }
    }

    /// The frames of all connections so far. A frame with a right checksum counts even if its
    /// fields are malformed: it shows that the link carries a sensor.
    pub(super) fn frame_counts(&self) -> FrameCounts {
        let tally = self.reader.tally();
        let output = tally.samples + tally.other + tally.packets + tally.rejected.grammar + tally.rejected.range;
        FrameCounts { good: output + tally.replies, output }
    }

    /// The delay before the next attempt to reconnect; the one after that is twice as long.
    pub(super) fn next_delay(&mut self) -> Duration {
        let doubled = (self.reconnect_delay * 2).min(LONGEST_DELAY);
        mem::replace(&mut self.reconnect_delay, doubled)
    }

    pub(super) fn publish(&mut self, state: LinkState) {
        self.events.push_back(LinkOutput::State(state));
    }

    /// Adds an event of the link to the stream.
    pub(super) fn emit(&mut self, now: Duration, kind: LinkEventKind) {
        let at_ns = nanoseconds(now);
        _ = self.forward(StreamInput::Link(LinkEvent { at_ns, kind }));
    }

    /// Makes an input a part of the measurement: records it, counts it and decodes it. Gives the
    /// replies that it completes.
    pub(super) fn forward(&mut self, input: StreamInput) -> Vec<Reply> {
        // bytes are context, not copied
        self.events.push_back(LinkOutput::Recorded(input.clone()));
        self.events.extend(StreamEvent::from_input(&mut self.reader, input).map(LinkOutput::Stream));
        self.reader.take_replies()
    }

    /// Discards what is pending, and gives the number of its bytes: they are counted and recorded
    /// as discarded.
    pub(super) fn discard_pending(&mut self, now: Duration) -> u64 {
        let inputs = self.pending.take_all();
        self.discard(now, inputs)
    }

    /// As [`discard_pending`](Self::discard_pending), up to the first frame of a sensor.
    pub(super) fn discard_before_sensor(&mut self, now: Duration) -> u64 {
        let inputs = self.pending.take_before_sensor();
        self.discard(now, inputs)
    }

    fn discard(&mut self, now: Duration, inputs: VecDeque<StreamInput>) -> u64 {
        let mut bytes = 0;
        for input in inputs {
            match input {
                StreamInput::Chunk(chunk) => bytes += chunk.bytes.len() as u64,
                StreamInput::Link(event) => self.emit(now, event.kind),
            }
        }
        if bytes > 0 {
            self.emit(now, LinkEventKind::DiscardedDuringBaudScan { bytes });
        }
        bytes
    }

    /// Handles a reply that was received before it is decided whether its bytes are part of the
    /// measurement. Unsolicited errors are handled with the measurement.
    pub(super) fn handle_pending_reply(&mut self, now: Duration, reply: &Reply) -> Result<(), LinkError> {
        if is_unsolicited_error(reply) {
            return Ok(());
        }
        let identified = self.check_serial_number(reply).map(drop);
        self.requests.handle_reply(reply, now);
        identified
    }

    /// The serial number to verify; `None` where it is not known or must not be asked for.
    pub(super) fn serial_to_verify(&self) -> Option<&str> {
        // a link that only listens may have overheard it
        self.serial_number.as_deref().filter(|_| !self.listen_only)
    }

    /// Compares a reply with the serial number that is known. Whether the number must be read
    /// again: one reply in a few million is damaged in spite of its checksum, but not two alike.
    pub(super) fn check_serial_number(&mut self, reply: &Reply) -> Result<bool, LinkError> {
        let Reply::Register(RegisterContents { register: Register::SERIAL_NUMBER, fields, .. }) = reply else {
            return Ok(false);
        };
        let serial = fields.to_string();
        match &self.serial_number {
            None => self.serial_number = Some(serial),
            Some(known) if *known == serial => self.unconfirmed_serial = None,
            Some(known) if self.unconfirmed_serial.as_ref() == Some(&serial) => {
                return Err(LinkError::OtherSensor { serial, known: known.clone() });
            }
            Some(_) => self.unconfirmed_serial = Some(serial),
        }
        Ok(self.unconfirmed_serial.is_some())
    }

    /// The next event of the requests that concerns the phase; those of the user are passed on.
    pub(super) fn poll_request_event(&mut self) -> Option<RequestEvent> {
        loop {
            match self.requests.poll_event()? {
                RequestEvent::Answered { id, result } => self.events.push_back(LinkOutput::Answered { id, result }),
                event => return Some(event),
            }
        }
    }
}

pub(super) fn is_unsolicited_error(reply: &Reply) -> bool {
    matches!(reply, Reply::Error(error) if error.is_unsolicited())
}

/// A time as the stamps of the stream have it.
pub(super) fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

//! Finds out at which speed a sensor talks: listen, then ask.

use std::{io, time::Duration};

use tokio::time::{Instant, timeout_at};
use vn100_protocol::{Frame, Framer, Options};

use crate::connect::Connection;
use vn100_protocol::stream::{Chunk, Input};

/// The speeds of a VN-100, all of [`BaudRate::ALL`](vn100_protocol::BaudRate::ALL), in the order
/// they are tried: the one it is delivered with, the other fast ones, the slow ones.
pub const BAUD_RATES: [u32; 9] = [115_200, 921_600, 460_800, 230_400, 57_600, 38_400, 19_200, 9600, 128_000];

/// How long to listen before asking: three lines of the usual 40 Hz.
const LISTEN: Duration = Duration::from_millis(150);

/// How long to listen where asking is not allowed: a whole line of the slowest output, 1 Hz, with
/// its pause before it.
const LISTEN_ONLY: Duration = Duration::from_millis(1200);

/// How long the sensor may take to answer, besides the time on the line.
const ANSWER: Duration = Duration::from_millis(100);

/// What a network adds to that, there and back.
const NETWORK: Duration = Duration::from_millis(500);

/// The longest line under way when the question comes, and the answer behind it.
const BYTES_BEFORE_ANSWER: u32 = 256;

/// Asks for the model, which every firmware answers.
pub(crate) const QUESTION: &[u8] = b"$VNRRG,01*72\r\n";

/// How a speed is tried.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial {
    /// The speed, which says how long a line takes; `None` where the link has none.
    pub(crate) baud: Option<u32>,
    /// Send nothing.
    pub(crate) listen_only: bool,
}

/// What a trial heard, in two parts.
#[derive(Debug)]
pub(crate) struct Heard {
    /// What came before anything good; all of it where nothing good came.
    pub(crate) before: Vec<Input>,
    /// What came from the beginning of the first good line or packet on; `None` where no sensor was
    /// heard.
    pub(crate) sensor: Option<Vec<Input>>,
    /// How often the question itself came back: such a line says nothing of a sensor.
    pub(crate) echoes: u64,
}

impl Trial {
    /// Listens, and asks unless that is not allowed; the question, if it was written, is handed to
    /// `sent`. Gives the place of the first good line or packet; `listener` keeps all that came,
    /// also behind an error or where the future is dropped.
    ///
    /// # Errors
    /// When the link goes down.
    pub(crate) async fn run(
        self,
        connection: &mut impl Connection,
        listener: &mut Listener,
        sent: impl FnOnce(&[u8]),
    ) -> io::Result<Option<u64>> {
        // ten bits a byte
        let line_time = self.baud.map_or(NETWORK, |baud| Duration::from_secs(10) * BYTES_BEFORE_ANSWER / baud.max(1));
        let listen = if self.listen_only { LISTEN_ONLY + line_time } else { LISTEN };
        let mut found_at = listener.listen(connection, listen).await?;
        if found_at.is_none() && !self.listen_only {
            connection.write(QUESTION).await?;
            sent(QUESTION);
            found_at = listener.listen(connection, ANSWER + line_time).await?;
        }
        Ok(found_at)
    }
}

/// Takes what has come at the speed before, and what comes of it for so long yet, so that it is not
/// taken for something of the next: put behind `inputs`, also before an error.
pub(crate) async fn drain(connection: &mut impl Connection, time: Duration, inputs: &mut Vec<Input>) -> io::Result<()> {
    let end = Instant::now() + time;
    while let Ok(input) = timeout_at(end, connection.next_input()).await {
        inputs.push(input?.ok_or(io::ErrorKind::UnexpectedEof)?);
    }
    Ok(())
}

/// Keeps what comes, and looks for a sensor in it.
pub(crate) struct Listener {
    framer: Framer,
    inputs: Vec<Input>,
    bytes: Vec<u8>,
    /// Bytes that the framer is done with.
    framed: usize,
    echoes: u64,
}

impl Listener {
    pub(crate) fn new(accept_unchecked: bool) -> Self {
        let framer = Framer::new(Options { accept_unchecked });
        Self { framer, inputs: Vec::new(), bytes: Vec::new(), framed: 0, echoes: 0 }
    }

    /// Listens for `time`, or until something good has come: where in the bytes that begins.
    async fn listen(&mut self, connection: &mut impl Connection, time: Duration) -> io::Result<Option<u64>> {
        let end = Instant::now() + time;
        while let Ok(input) = timeout_at(end, connection.next_input()).await {
            let input = input?.ok_or(io::ErrorKind::UnexpectedEof)?;
            let found_at = match &input {
                Input::Chunk(chunk) => self.search(&chunk.bytes),
                Input::Link(_) => None,
            };
            self.inputs.push(input);
            if found_at.is_some() {
                return Ok(found_at);
            }
        }
        Ok(None)
    }

    fn search(&mut self, bytes: &[u8]) -> Option<u64> {
        self.bytes.extend_from_slice(bytes);
        loop {
            let step = self.framer.next(&self.bytes[self.framed..], false);
            self.framed += step.consumed;
            match step.item? {
                Frame::Sentence(sentence) if QUESTION.strip_suffix(b"\r\n") == Some(sentence.raw) => self.echoes += 1,
                Frame::Sentence(sentence) if sentence.header().starts_with(b"VN") => return Some(sentence.offset),
                Frame::Packet(packet) => return Some(packet.offset),
                Frame::Sentence(_) | Frame::Bad(_) => {}
            }
        }
    }

    /// All that came, cut where the first good line or packet begins.
    pub(crate) fn heard(self, found_at: Option<u64>) -> Heard {
        let echoes = self.echoes;
        let Some(found_at) = found_at else { return Heard { before: self.inputs, sensor: None, echoes } };
        let (mut before, mut sensor) = (Vec::new(), Vec::new());
        let mut left = usize::try_from(found_at).unwrap_or(usize::MAX);
        for input in self.inputs {
            match input {
                Input::Chunk(mut chunk) if left > 0 => {
                    let head = chunk.bytes.split_to(left.min(chunk.bytes.len()));
                    left -= head.len();
                    before.push(Chunk { bytes: head, at_ns: chunk.at_ns }.into());
                    if !chunk.bytes.is_empty() {
                        sensor.push(chunk.into());
                    }
                }
                Input::Link(_) if left > 0 => before.push(input),
                Input::Chunk(_) | Input::Link(_) => sensor.push(input),
            }
        }
        Heard { before, sensor: Some(sensor), echoes }
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use vn100_protocol::{BaudRate, Check, Command, Register};

    use super::*;

    fn chunk(text: &'static str) -> Input {
        Chunk { bytes: Bytes::from_static(text.as_bytes()), at_ns: None }.into()
    }

    /// What is told of pieces that come in this order.
    fn heard(pieces: &[&'static str]) -> Heard {
        let mut listener = Listener::new(false);
        let mut found_at = None;
        for piece in pieces {
            listener.inputs.push(chunk(piece));
            found_at = found_at.or(listener.search(piece.as_bytes()));
        }
        listener.heard(found_at)
    }

    #[test]
    fn all_speeds_are_tried_and_the_question_is_that_for_the_model() {
        let mut rates = BAUD_RATES;
        rates.sort_unstable();
        assert_eq!(rates, BaudRate::ALL.map(BaudRate::bits_per_s));
        let mut question = String::new();
        Command::ReadRegister(Register::MODEL).encode(Check::Xor8, &mut question).unwrap();
        assert_eq!(question.as_bytes(), QUESTION);
    }

    #[test]
    fn the_stream_begins_with_the_first_good_line() {
        let heard = heard(&["\u{7f}junk*00\r\n$VN", "YMR,-0$VNRRG,01,VN", "-100S-CR*35\r\n"]);
        assert_eq!(heard.before, [chunk("\u{7f}junk*00\r\n$VN"), chunk("YMR,-0")]);
        assert_eq!(heard.sensor, Some(vec![chunk("$VNRRG,01,VN"), chunk("-100S-CR*35\r\n")]));
    }

    #[test]
    fn the_question_that_comes_back_is_no_sensor_and_the_answer_behind_it_is() {
        let echo = "$VNRRG,01*72\r\n";
        let nobody = heard(&["$VNRRG,", "01*72\r\n", echo]);
        assert_eq!((nobody.before.len(), nobody.sensor, nobody.echoes), (3, None, 2));
        let answer = "$VNRRG,01,VN-100S-CR*35\r\n";
        let answered = heard(&[echo, answer]);
        assert_eq!(answered.before, [chunk(echo)]);
        assert_eq!((answered.sensor, answered.echoes), (Some(vec![chunk(answer)]), 1));
    }

    #[test]
    fn other_sentences_are_no_sensor() {
        // a satellite receiver on the same kind of adapter
        let heard =
            heard(&["$GPGLL,4916.45,N,12311.12,W,225444,A,*1D\r\n", "$VNYPR,+010.071,+000.278,-002.026*61\r\n"]);
        assert_eq!((heard.before.len(), heard.sensor), (2, None));
    }
}

//! A silence of a link that is open, and what must be known of a sensor that speaks again after one
//! before it is measured on: it may be another one, or have lost its power and its settings.

use tokio::time::Instant;
use vn100_protocol::{Frame, Framer, Options, Register, RegisterContents, Reply};

use super::LinkTask;
use crate::{connect::Connect, set_again::check_serial, set_again::still_set, trouble::Trouble};
use vn100_protocol::stream::Input;

pub(super) struct Silence {
    pub(super) since: Instant,
    /// When it was last looked whether the sensor is there.
    pub(super) looked: Instant,
    framer: Framer,
    unframed: Vec<u8>,
}

impl Silence {
    /// Begins now.
    pub(super) fn begin(options: Options) -> Self {
        let now = Instant::now();
        Self { since: now, looked: now, framer: Framer::new(options), unframed: Vec::new() }
    }

    /// Takes what comes meanwhile: whether the sensor speaks by itself in it. Answers are no sign
    /// of that, nor is what nobody understands.
    pub(super) fn ends_with(&mut self, input: &Input) -> bool {
        let Input::Chunk(chunk) = input else { return false };
        self.unframed.extend_from_slice(&chunk.bytes);
        let (mut at, mut ends) = (0, false);
        loop {
            let step = self.framer.next(&self.unframed[at..], false);
            at += step.consumed;
            match step.item {
                Some(Frame::Sentence(sentence)) => ends |= Reply::parse(&sentence).is_err(),
                Some(Frame::Packet(_)) => ends = true,
                Some(Frame::Bad(_)) => {}
                None => break,
            }
        }
        self.unframed.drain(..at);
        ends
    }
}

impl<C: Connect> LinkTask<C> {
    /// The sensor speaks again after a silence: all that came until it is known to be the same one,
    /// set as it was. What came of another one, or of one with other settings, is no part of the
    /// measurement.
    pub(super) async fn meet_again(
        &mut self,
        connection: &mut C::Connection,
        first: Input,
    ) -> Result<Vec<Input>, Trouble> {
        let mut held = vec![first];
        let met = match self.check_known(connection, &mut held).await {
            Ok(()) => self.check_still_set(connection, &mut held).await,
            Err(trouble) => Err(trouble),
        };
        if let Err(trouble) = met {
            self.set_aside(held).await?;
            return Err(trouble);
        }
        Ok(held)
    }

    /// A sensor is found: where it is the first one of this link it must be the one that is known
    /// from before.
    pub(super) async fn meet_first(
        &mut self,
        connection: &mut C::Connection,
        held: &mut Vec<Input>,
    ) -> Result<(), Trouble> {
        if !self.was_up
            && let Err(trouble) = self.check_known(connection, held).await
        {
            self.set_aside(std::mem::take(held)).await?;
            return Err(trouble);
        }
        self.was_up = true;
        Ok(())
    }

    /// Takes what a sensor says of its serial number. Another one may have come without a loss of
    /// the link, behind an adapter that stays.
    pub(super) fn recognise(&mut self, reply: &Reply) -> Result<(), Trouble> {
        let Reply::Register(RegisterContents { register: Register::SERIAL_NUMBER, fields, .. }) = reply else {
            return Ok(());
        };
        let serial = fields.to_string();
        match &self.serial {
            None => self.serial = Some(serial),
            Some(known) if *known == serial => self.strange_serial = None,
            Some(known) if self.strange_serial.as_ref() == Some(&serial) => {
                return Err(Trouble::Another { serial, known: known.clone() });
            }
            Some(_) => {
                // one answer in a few million is damaged and looks good; not two alike
                self.strange_serial = Some(serial);
                self.conversation.read_next(Register::SERIAL_NUMBER);
            }
        }
        Ok(())
    }

    /// Makes sure that it is the sensor of before, where that has told its serial number. What
    /// comes meanwhile is put behind `held`.
    pub(super) async fn check_known(
        &mut self,
        connection: &mut C::Connection,
        held: &mut Vec<Input>,
    ) -> Result<(), Trouble> {
        // it may have told another program on the line
        let Some(known) = self.serial.clone().filter(|_| !self.listen_only) else { return Ok(()) };
        let output = &mut self.output;
        let check = check_serial(connection, &known, held, |line| output.note_sent(line));
        self.stop.run_until_cancelled(check).await.ok_or(Trouble::Stopped)?
    }

    async fn check_still_set(&mut self, connection: &mut C::Connection, held: &mut Vec<Input>) -> Result<(), Trouble> {
        if self.keep.is_empty() {
            return Ok(());
        }
        let output = &mut self.output;
        let check = still_set(connection, &self.keep, held, |line| output.note_sent(line));
        match self.stop.run_until_cancelled(check).await.ok_or(Trouble::Stopped)?? {
            true => Ok(()),
            false => Err(Trouble::Returned),
        }
    }
}

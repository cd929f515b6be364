//! Asks a sensor that has come back which one it is and how it is set, and sets it as it was
//! before: it may have lost its power, and with it all that was not saved.

use std::time::Duration;

use tokio::time::{Instant, sleep_until};
use vn100_protocol::{
    Answer, BaudRate, Check, Command, Frame, Framer, Options, Register, Reply, RequestFailure, Session, Setting,
};

use crate::{connect::Connection, output_plan::Change, trouble::Trouble};
use vn100_protocol::stream::{Chunk, Input};

/// Writes the changes again while the output is paused, and resumes it. All that comes meanwhile is
/// put behind `aside`; each line written is told to `sent`.
///
/// # Errors
/// When the sensor refuses or does not answer, or the link goes down.
pub(crate) async fn set_again(
    connection: &mut impl Connection,
    changes: &[Change],
    aside: &mut Vec<Input>,
    sent: impl FnMut(&[u8]),
) -> Result<(), Trouble> {
    let writes =
        changes.iter().map(|change| Command::WriteRegister { register: change.register, fields: change.after.clone() });
    // a question first: where it comes back the session knows the echo of a write from its answer
    let begin = [Command::ReadRegister(Register::MODEL), Command::Async(false)];
    let commands = begin.into_iter().chain(writes).chain([Command::Async(true)]);
    let results = exchange(connection, commands, aside, sent).await?;
    all_done(results)
}

/// Sets the sensor and the port to another speed. All that comes meanwhile is put behind `aside`;
/// each line written is told to `sent`.
///
/// # Errors
/// When the sensor refuses or does not answer, or the link goes down.
pub(crate) async fn set_speed(
    connection: &mut impl Connection,
    baud: BaudRate,
    aside: &mut Vec<Input>,
    sent: impl FnMut(&[u8]),
) -> Result<(), Trouble> {
    let write = Command::WriteRegister { register: Register::BAUD_RATE, fields: baud.fields() };
    // a question first, as above
    let results = exchange(connection, [Command::ReadRegister(Register::MODEL), write], aside, sent).await?;
    all_done(results)?;
    Ok(connection.set_baud(baud.bits_per_s())?)
}

fn all_done(results: Vec<Result<Answer, RequestFailure>>) -> Result<(), Trouble> {
    results.into_iter().find_map(Result::err).map_or(Ok(()), |failure| Err(failure.into()))
}

/// Checks that the sensor that has come back is the `known` one, by its serial number; one that
/// does not say is taken for it. All that comes meanwhile is put behind `held`; each line written
/// is told to `sent`.
///
/// # Errors
/// When it is another one, or the link goes down.
pub(crate) async fn check_serial(
    connection: &mut impl Connection,
    known: &str,
    held: &mut Vec<Input>,
    mut sent: impl FnMut(&[u8]),
) -> Result<(), Trouble> {
    let mut strange = None;
    loop {
        let results = exchange(connection, [Command::ReadRegister(Register::SERIAL_NUMBER)], held, &mut sent).await?;
        let Some(Ok(Answer::Register(contents))) = results.first() else { return Ok(()) };
        let serial = contents.fields.to_string();
        if serial == known {
            return Ok(());
        }
        // one answer in a few million is damaged and looks good; not two alike
        if strange.as_ref() == Some(&serial) {
            return Err(Trouble::Another { serial, known: known.to_owned() });
        }
        strange = Some(serial);
    }
}

/// Whether the sensor has kept the changes; not where it does not say. The speed of the line is one
/// that the sensor is heard at. All that comes meanwhile is put behind `held`; each line written is
/// told to `sent`.
///
/// # Errors
/// When the link goes down.
pub(crate) async fn still_set(
    connection: &mut impl Connection,
    changes: &[Change],
    held: &mut Vec<Input>,
    sent: impl FnMut(&[u8]),
) -> Result<bool, Trouble> {
    let reads = changes.iter().map(|change| Command::ReadRegister(change.register));
    let results = exchange(connection, reads, held, sent).await?;
    let holds = |(change, result): (&Change, &Result<Answer, RequestFailure>)| matches!(result, Ok(Answer::Register(contents)) if contents.is_as_written(&change.after));
    Ok(changes.iter().zip(&results).all(holds))
}

/// Says all `commands` one after the other: what became of each, in their order. All that comes
/// meanwhile is put behind `aside`; each line written is told to `sent`.
///
/// # Errors
/// When the link goes down.
pub(crate) async fn exchange(
    connection: &mut impl Connection,
    commands: impl IntoIterator<Item = Command>,
    aside: &mut Vec<Input>,
    mut sent: impl FnMut(&[u8]),
) -> Result<Vec<Result<Answer, RequestFailure>>, Trouble> {
    let mut session = Session::new(Check::Xor8);
    // there are fewer registers to change than a session takes requests
    let mut left = commands.into_iter().filter(|command| session.submit(command.clone()).is_ok()).count();
    let mut results = Vec::new();
    let mut framer = Framer::new(Options::default());
    let mut unframed = Vec::new();
    let start = Instant::now();
    while left > 0 {
        while let Some(line) = session.poll_transmit(start.elapsed()) {
            connection.write(&line).await?;
            sent(&line);
        }
        let wake = start + session.poll_timeout().unwrap_or(Duration::ZERO);
        tokio::select! {
            input = connection.next_input() => {
                let input = input?.ok_or(Trouble::Closed)?;
                if let Input::Chunk(Chunk { bytes, .. }) = &input {
                    unframed.extend_from_slice(bytes);
                    take_replies(&mut framer, &mut unframed, |reply| {
                        session.handle_reply(reply, start.elapsed());
                    });
                }
                aside.push(input);
            }
            () = sleep_until(wake) => {}
        }
        session.handle_timeout(start.elapsed());
        while let Some((_, result)) = session.poll_completion() {
            left -= 1;
            results.push(result);
        }
    }
    Ok(results)
}

fn take_replies(framer: &mut Framer, unframed: &mut Vec<u8>, mut take: impl FnMut(&Reply)) {
    let mut at = 0;
    loop {
        let step = framer.next(&unframed[at..], false);
        at += step.consumed;
        match step.item {
            Some(Frame::Sentence(sentence)) => {
                if let Ok(reply) = Reply::parse(&sentence) {
                    take(&reply);
                }
            }
            Some(Frame::Packet(_) | Frame::Bad(_)) => {}
            None => break,
        }
    }
    unframed.drain(..at);
}

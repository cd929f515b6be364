//! Changes what a sensor sends, step by step: checked before it is written, read back after, and undone on request.

use std::time::Duration;

use thiserror::Error;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use vn100_protocol::{AsyncRate, AsyncType, Command, Fields, Register, RegisterContents, RequestFailure};

use crate::{
    command_error::CommandError,
    link::LinkHandle,
    link_state::LinkState,
    output_plan::{Change, OutputSettings, PlanError, plan},
};

/// How long after the output was paused the last of it may still come: a long line at the slowest speed.
const DRAIN: Duration = Duration::from_millis(150);

/// How long to leave the output to settle, and how long to count it.
const SETTLE: Duration = Duration::from_millis(300);
const MEASURE: Duration = Duration::from_secs(2);

/// How long to listen for a line: longer than the pause between two of the slowest output, 1 Hz, and as often is looked whether one came.
const LISTEN: Duration = Duration::from_millis(1200);
const LOOK: Duration = Duration::from_millis(50);

/// What was changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Configured {
    /// The registers in the order they were written; empty where all was as asked.
    pub changes: Vec<Change>,
    /// Lines a second of the message that the sensor is set to, counted for two seconds after. Others that come beside them, as those
    /// that the other port is set to, are not among them.
    pub measured_hz: f64,
    /// The rate the sensor is set to; 0 where it sends no lines.
    pub rate_hz: u32,
    /// Whether its output was found paused, as a program leaves it that breaks off. It is on now.
    pub was_paused: bool,
}

impl Configured {
    /// Whether as many lines come as the sensor is set to send: within a line and 5 %.
    #[must_use]
    pub fn rate_is_kept(&self) -> bool {
        (self.measured_hz - f64::from(self.rate_hz)).abs()
            <= 1.0 / MEASURE.as_secs_f64() + 0.05 * f64::from(self.rate_hz)
    }
}

/// Why a sensor is not set as asked. What was written by then is put back, and its output goes on, as far as the link is up.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigureError {
    /// It cannot be.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A command failed.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// A register says something else than what was written.
    #[error("register {register} was to be {asked} and reads {got}")]
    ReadBack {
        /// Which one.
        register: Register,
        /// What was written.
        asked: Fields,
        /// What it says.
        got: String,
    },
    /// It was told to stop.
    #[error("interrupted{}", if undone.is_empty() { "" } else { ", and put back as it was" })]
    Interrupted {
        /// What had been written by then, and is put back.
        undone: Vec<Change>,
    },
    /// What was written stays written, or the output paused.
    #[error("{cause}; the sensor stays changed: {}", list(changes, *may_be_paused))]
    Left {
        /// Why it is not set as asked.
        cause: Box<ConfigureError>,
        /// What was written, or may have been.
        changes: Vec<Change>,
        /// Whether its output may be paused still: it did not take the command to go on.
        may_be_paused: bool,
    },
}

fn list(changes: &[Change], may_be_paused: bool) -> String {
    let output = may_be_paused.then(|| "its output, which may be paused".into());
    let list: Vec<_> = changes.iter().map(ToString::to_string).chain(output).collect();
    list.join(", ")
}

/// Sets the sensor: reads how it is, checks that its output will fit the line, pauses the output, writes, reads back, resumes it and
/// counts what comes; where the link was lost meanwhile it reads them once more. Nothing is kept through switching off unless `settings` say so.
///
/// All or nothing: when anything fails, or on `stop`, what was written is put back before this returns, and an output that was found paused
/// is paused again. Only what the sensor was told to keep through switching off stays. When all is well the output is on, however it was
/// found: whoever sets it wants it.
///
/// The events of the link must be taken meanwhile. Dropped before it returns, it leaves the sensor as it is then, with its output paused
/// perhaps: cancel `stop` instead.
///
/// # Errors
/// When it cannot be so, when the sensor refuses, or when it does not keep what was written.
pub async fn configure(
    link: &LinkHandle,
    settings: &OutputSettings,
    stop: &CancellationToken,
) -> Result<Configured, ConfigureError> {
    let mut written = Written::default();
    let set = stop.run_until_cancelled(set(link, settings, &mut written)).await;
    let Written { changes, kept, was_paused, touched } = written;
    let cause = match set.unwrap_or(Err(ConfigureError::Interrupted { undone: Vec::new() })) {
        Ok((measured_hz, rate_hz)) => return Ok(Configured { changes, measured_hz, rate_hz, was_paused }),
        Err(cause) => cause,
    };
    let is_back = changes.is_empty() || !kept && write_back(link, &changes).await.is_ok();
    // also where nothing was written, and answered: whoever asked may close the link right behind this
    let is_as_found = !touched || link.request(Command::Async(!was_paused)).await.is_ok();
    let may_be_paused = !is_as_found && !was_paused;
    if !is_back || may_be_paused {
        let changes = if is_back { Vec::new() } else { changes };
        return Err(ConfigureError::Left { cause: Box::new(cause), changes, may_be_paused });
    }
    Err(match cause {
        ConfigureError::Interrupted { .. } => ConfigureError::Interrupted { undone: changes },
        cause => cause,
    })
}

/// What was done to a sensor so far.
#[derive(Default)]
struct Written {
    changes: Vec<Change>,
    /// Whether it was told to keep them: the flash may hold them then.
    kept: bool,
    /// Whether its output was found paused.
    was_paused: bool,
    /// Whether it was told to pause its output, or to go on where it was found paused: whether it took that, nobody knows.
    touched: bool,
}

/// Lines a second that come, and those the sensor is set to.
async fn set(
    link: &LinkHandle,
    settings: &OutputSettings,
    written: &mut Written,
) -> Result<(f64, u32), ConfigureError> {
    let current = read_current(link, settings).await?;
    let (planned, message, rate) = plan(&current, settings)?;
    written.was_paused = is_paused(link).await?;
    if !planned.is_empty() || settings.save || written.was_paused {
        write_paused(link, planned, settings.save, written).await?;
        link.request(Command::Async(true)).await?;
    }
    let mut state = link.state();
    state.mark_unchanged();
    tokio::time::sleep(SETTLE).await;
    let (before, began) = (link.lines(message), Instant::now());
    tokio::time::sleep(MEASURE).await;
    let measured_hz = (link.lines(message) - before) as f64 / began.elapsed().as_secs_f64();
    // a link that went down or fell silent may have been without power, and what was written is gone then
    if state.has_changed().unwrap_or(true) {
        for change in &written.changes {
            read_back(link, change).await?;
        }
    }
    Ok((measured_hz, rate.hz()))
}

/// Puts back what [`configure`] changed, the last first. An output that is paused stays so.
///
/// # Errors
/// As [`configure`]; what could not be put back stays.
pub async fn restore(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    if changes.is_empty() {
        return Ok(());
    }
    let was_paused = is_paused(link).await?;
    let is_back = write_back(link, changes).await;
    let is_as_found = link.request(Command::Async(!was_paused)).await;
    is_back?;
    is_as_found?;
    Ok(())
}

/// Writes how it was, and leaves the output paused.
async fn write_back(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    let back = changes.iter().rev().map(|change| Change {
        register: change.register,
        before: change.after.clone(),
        after: change.before.clone(),
    });
    write_paused(link, back.collect(), false, &mut Written::default()).await
}

/// Whether the output of the sensor is paused: it is set to send, and nothing comes.
async fn is_paused(link: &LinkHandle) -> Result<bool, ConfigureError> {
    let end = Instant::now() + LISTEN;
    // lines that came before a silence say nothing of now
    let is_silent = matches!(*link.state().borrow(), LinkState::Silent(_));
    let before = if is_silent { link.lines_of_all() } else { 0 };
    while link.lines_of_all() == before {
        if Instant::now() >= end {
            let message = link.read(Register::ASYNC_TYPE).await?.and_then(|contents| contents.value().ok());
            let rate = link.read(Register::ASYNC_RATE).await?.and_then(|contents| contents.value().ok());
            let sends = |message: AsyncType, rate: AsyncRate| message != AsyncType::OFF && rate.hz() > 0;
            // behind a stall of this machine lines come before the answers
            let is_silent = link.lines_of_all() == before;
            return Ok(is_silent && message.zip(rate).is_some_and(|(message, rate)| sends(message, rate)));
        }
        tokio::time::sleep(LOOK).await;
    }
    Ok(false)
}

async fn read_current(link: &LinkHandle, settings: &OutputSettings) -> Result<Vec<RegisterContents>, ConfigureError> {
    let mut current = Vec::new();
    for register in settings.registers() {
        // the plan decides whether it can do without
        current.extend(link.read(register).await?);
    }
    Ok(current)
}

/// Pauses the output and writes what is `planned`, and notes in `written` what is done before it is. Whoever calls it has the output go on,
/// however this ends.
async fn write_paused(
    link: &LinkHandle,
    planned: Vec<Change>,
    save: bool,
    written: &mut Written,
) -> Result<(), ConfigureError> {
    // commands that come between lines of a busy port lose bytes
    written.touched = true;
    link.request(Command::Async(false)).await?;
    tokio::time::sleep(DRAIN).await;
    for change in planned {
        // whether a write that was not answered was carried out, nobody knows
        written.changes.push(change.clone());
        let write = Command::WriteRegister { register: change.register, fields: change.after.clone() };
        let answer = link.request(write).await;
        if let Err(CommandError::Failed(RequestFailure::Device { .. })) = answer {
            written.changes.pop();
        }
        answer?;
        read_back(link, &change).await?;
    }
    if save {
        written.kept = true;
        link.request(Command::WriteSettings).await?;
    }
    Ok(())
}

async fn read_back(link: &LinkHandle, change: &Change) -> Result<(), ConfigureError> {
    let Change { register, after, .. } = change;
    let got = link.read(*register).await?;
    if got.as_ref().is_some_and(|contents| contents.is_as_written(after)) {
        return Ok(());
    }
    let got = got.map_or_else(|| "nothing".into(), |contents| contents.fields.to_string());
    Err(ConfigureError::ReadBack { register: *register, asked: after.clone(), got })
}

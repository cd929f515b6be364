//! Changes what a sensor sends, step by step: checked before it is written, read back after, and undone on request.

use std::time::Duration;

use thiserror::Error;

use crate::{
    command::{Command, CommandError, NO_SUCH_REGISTER, same_fields},
    link::LinkHandle,
    output_plan::{Current, OutputSettings, PlanError, Write, plan},
};

/// How long after the output was paused the last of it may still come: a long line at the slowest speed.
const DRAIN: Duration = Duration::from_millis(150);

/// How long to leave the output to settle, and how long to count it.
const SETTLE: Duration = Duration::from_millis(300);
const MEASURE: Duration = Duration::from_secs(2);

/// What was changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Configured {
    /// The registers in the order they were written; empty where all was as asked.
    pub changes: Vec<Change>,
    /// Samples a second, counted for two seconds after; lines of other messages are no samples.
    pub measured_hz: f64,
    /// The rate the sensor is set to.
    pub rate_hz: u32,
}

impl Configured {
    /// Whether as many samples come as the sensor is set to send: within a line and 5 %.
    #[must_use]
    pub fn rate_is_kept(&self) -> bool {
        (self.measured_hz - f64::from(self.rate_hz)).abs()
            <= 1.0 / MEASURE.as_secs_f64() + 0.05 * f64::from(self.rate_hz)
    }
}

/// A register that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// Its number.
    pub register: u8,
    /// Its fields before.
    pub before: String,
    /// Its fields now.
    pub after: String,
}

/// Why a sensor is not set as asked. Its output goes on in any case, as far as the link is up.
#[derive(Debug, Error)]
pub enum ConfigureError {
    /// It cannot be.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A command failed; what was written before stays written.
    #[error("{source}{}", written(changes))]
    Command {
        /// What failed.
        source: CommandError,
        /// What had been written by then.
        changes: Vec<Change>,
    },
    /// A register says something else than what was written.
    #[error("register {register} was to be {asked} and reads {got}")]
    ReadBack {
        /// Its number.
        register: u8,
        /// What was written.
        asked: String,
        /// What it says.
        got: String,
    },
}

fn written(changes: &[Change]) -> String {
    let list: Vec<_> = changes.iter().map(|change| format!("{} was {}", change.register, change.before)).collect();
    if list.is_empty() { String::new() } else { format!("; written before that: register {}", list.join(", ")) }
}

impl From<CommandError> for ConfigureError {
    fn from(source: CommandError) -> Self {
        Self::Command { source, changes: Vec::new() }
    }
}

/// Sets the sensor: reads how it is, checks that its output will fit the line, pauses the output, writes, reads back, resumes it and
/// counts what comes. Nothing is kept through switching off unless `settings` say so.
///
/// The events of the link must be taken meanwhile.
///
/// # Errors
/// When it cannot be so, when the sensor refuses, or when it does not keep what was written.
pub async fn configure(link: &LinkHandle, settings: &OutputSettings) -> Result<Configured, ConfigureError> {
    let current = read_current(link, settings).await?;
    let (writes, rate_hz) = plan(&current, settings)?;
    let changes = write_paused(link, writes, settings.save).await?;
    tokio::time::sleep(SETTLE).await;
    let (before, began) = (link.samples(), tokio::time::Instant::now());
    tokio::time::sleep(MEASURE).await;
    let measured_hz = (link.samples() - before) as f64 / began.elapsed().as_secs_f64();
    Ok(Configured { changes, measured_hz, rate_hz })
}

/// Puts back what [`configure`] changed, the last first.
///
/// # Errors
/// As [`configure`].
pub async fn restore(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    let back = changes.iter().rev().map(|change| Write {
        register: change.register,
        before: change.after.clone(),
        after: change.before.clone(),
    });
    write_paused(link, back.collect(), false).await.map(drop)
}

async fn read_current(link: &LinkHandle, settings: &OutputSettings) -> Result<Current, ConfigureError> {
    let mut current = Current::default();
    for register in settings.registers() {
        match link.request(Command::ReadRegister(register)).await {
            Ok(answer) => _ = current.insert(register, answer.fields),
            // the plan decides whether it can do without
            Err(CommandError::Refused { code: NO_SUCH_REGISTER, .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(current)
}

/// Resumes the output of the sensor when it is dropped, wherever an exchange broke off.
struct ResumeOnDrop<'a>(Option<&'a LinkHandle>);

impl Drop for ResumeOnDrop<'_> {
    fn drop(&mut self) {
        if let Some(link) = self.0 {
            link.send(Command::Output(true));
        }
    }
}

async fn write_paused(link: &LinkHandle, writes: Vec<Write>, save: bool) -> Result<Vec<Change>, ConfigureError> {
    let mut changes = Vec::new();
    if writes.is_empty() && !save {
        return Ok(changes);
    }
    // commands that come between lines of a busy port lose bytes
    let mut resume = ResumeOnDrop(Some(link));
    link.request(Command::Output(false)).await?;
    tokio::time::sleep(DRAIN).await;
    for write in writes {
        let result = write_and_read_back(link, &write).await;
        if let Err(ConfigureError::Command { source, .. }) = result {
            return Err(ConfigureError::Command { source, changes });
        }
        result?;
        changes.push(Change { register: write.register, before: write.before, after: write.after });
    }
    let end = async {
        if save {
            link.request(Command::SaveSettings).await?;
        }
        link.request(Command::Output(true)).await
    };
    if let Err(source) = end.await {
        return Err(ConfigureError::Command { source, changes });
    }
    resume.0 = None;
    Ok(changes)
}

async fn write_and_read_back(link: &LinkHandle, write: &Write) -> Result<(), ConfigureError> {
    let Write { register, after, .. } = write;
    link.request(Command::WriteRegister { register: *register, fields: after.clone() }).await?;
    let got = link.request(Command::ReadRegister(*register)).await?.fields;
    if same_fields(*register, after, &got) {
        Ok(())
    } else {
        Err(ConfigureError::ReadBack { register: *register, asked: after.clone(), got })
    }
}

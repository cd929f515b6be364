//! Changes what a sensor sends, step by step: checked before it is written, read back after, and undone on request.

use std::time::Duration;

use thiserror::Error;
use vn100_protocol::{Command, Fields, Register, RegisterContents};

use crate::{
    command_error::CommandError,
    link::LinkHandle,
    output_plan::{Change, OutputSettings, PlanError, plan},
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
    /// The rate the sensor is set to; 0 where it sends no lines.
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
        /// Which one.
        register: Register,
        /// What was written.
        asked: Fields,
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
    let (planned, rate) = plan(&current, settings)?;
    let changes = write_paused(link, planned, settings.save).await?;
    tokio::time::sleep(SETTLE).await;
    let (before, began) = (link.samples(), tokio::time::Instant::now());
    tokio::time::sleep(MEASURE).await;
    let measured_hz = (link.samples() - before) as f64 / began.elapsed().as_secs_f64();
    Ok(Configured { changes, measured_hz, rate_hz: rate.hz() })
}

/// Puts back what [`configure`] changed, the last first.
///
/// # Errors
/// As [`configure`].
pub async fn restore(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    let back = changes.iter().rev().map(|change| Change {
        register: change.register,
        before: change.after.clone(),
        after: change.before.clone(),
    });
    write_paused(link, back.collect(), false).await.map(drop)
}

async fn read_current(link: &LinkHandle, settings: &OutputSettings) -> Result<Vec<RegisterContents>, ConfigureError> {
    let mut current = Vec::new();
    for register in settings.registers() {
        // the plan decides whether it can do without
        current.extend(link.read(register).await?);
    }
    Ok(current)
}

/// Resumes the output of the sensor when it is dropped, wherever an exchange broke off.
struct ResumeOnDrop<'a>(Option<&'a LinkHandle>);

impl Drop for ResumeOnDrop<'_> {
    fn drop(&mut self) {
        if let Some(link) = self.0 {
            link.send(Command::Async(true));
        }
    }
}

/// Writes what is `planned` while the output is paused: what was written.
async fn write_paused(link: &LinkHandle, planned: Vec<Change>, save: bool) -> Result<Vec<Change>, ConfigureError> {
    let mut changes = Vec::new();
    if planned.is_empty() && !save {
        return Ok(changes);
    }
    // commands that come between lines of a busy port lose bytes
    let mut resume = ResumeOnDrop(Some(link));
    link.request(Command::Async(false)).await?;
    tokio::time::sleep(DRAIN).await;
    for change in planned {
        let result = write_and_read_back(link, &change).await;
        if let Err(ConfigureError::Command { source, .. }) = result {
            return Err(ConfigureError::Command { source, changes });
        }
        result?;
        changes.push(change);
    }
    let end = async {
        if save {
            link.request(Command::WriteSettings).await?;
        }
        link.request(Command::Async(true)).await
    };
    if let Err(source) = end.await {
        return Err(ConfigureError::Command { source, changes });
    }
    resume.0 = None;
    Ok(changes)
}

async fn write_and_read_back(link: &LinkHandle, change: &Change) -> Result<(), ConfigureError> {
    let Change { register, after, .. } = change;
    link.request(Command::WriteRegister { register: *register, fields: after.clone() }).await?;
    let got = link.read(*register).await?;
    if got.as_ref().is_some_and(|contents| contents.is_as_written(after)) {
        return Ok(());
    }
    let got = got.map_or_else(|| "nothing".into(), |contents| contents.fields.to_string());
    Err(ConfigureError::ReadBack { register: *register, asked: after.clone(), got })
}

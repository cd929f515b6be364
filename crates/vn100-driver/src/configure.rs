//! Changes the output of a sensor step by step: settings are checked before the write, read back
//! after it, and undone on request.

use std::time::Duration;

use thiserror::Error;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use vn100_protocol::{
    AsyncRate, AsyncType, BinaryOutput, Register, RegisterContents, RegisterFields, RegisterValue, RequestFailure,
    SensorCommand, stream::FrameKind,
};

use crate::{
    link::{CommandError, LinkHandle, LinkState},
    output_plan::{Change, OutputPlan, OutputSettings, PlanError, plan, to_second_port, writable},
};

/// The longest delay of the last frame after a pause: a long frame at the lowest baud rate.
const DRAIN: Duration = Duration::from_millis(150);

/// The shortest time for the output to settle, and the time in which its frames are counted.
const SETTLE: Duration = Duration::from_millis(300);
const MEASURE: Duration = Duration::from_secs(2);

/// The most counts while the rate differs from the setting: a busy machine or adapter may delay
/// frames from the first count into the second.
const COUNTS: u32 = 3;

/// The timeout for a frame, longer than a period of the slowest output; and the interval of checks.
const LISTEN: Duration = Duration::from_millis(1200);
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// The attempts to set the sensor if the link is lost meanwhile, and the timeout of the
/// reconnection: the sum of the longest back-off, the boot of the sensor and a baud scan.
const ATTEMPTS: u32 = 2;
const RETURN: Duration = Duration::from_secs(10);

/// The changes that [`configure`] has made.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Configured {
    /// The registers in the order in which they were written; empty if none differed.
    pub changes: Vec<Change>,
    /// Frames per second of the message that the sensor is set to, counted for two seconds, up to
    /// three times if they differ from the setting; 0 if the output is off.
    pub measured_hz: f64,
    /// The rate that the sensor is set to, in hertz; 0 if its output is off.
    pub rate_hz: f64,
    /// Whether the output was found paused, as left by a program that was killed. The output is on
    /// now.
    pub was_paused: bool,
}

impl Configured {
    /// Whether the measured rate agrees with the setting, within one frame and 5 %.
    pub fn rate_is_kept(&self) -> bool {
        (self.measured_hz - self.rate_hz).abs() <= 1.0 / MEASURE.as_secs_f64() + 0.05 * self.rate_hz
    }
}

/// The reason why a sensor is not set as requested. Registers written before the error are
/// restored, and the output is resumed, if the link is up.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigureError {
    /// The settings are not possible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A command failed.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// A register does not read back as it was written.
    #[error("register {register} was to be {asked} and reads {got}")]
    ReadBack {
        /// The register.
        register: Register,
        /// The fields that were written.
        asked: RegisterFields,
        /// The fields in the register.
        got: String,
    },
    /// The change was stopped.
    #[error("interrupted{}", if undone.is_empty() { "" } else { ", and settings restored" })]
    Interrupted {
        /// The changes that were made before and are restored.
        undone: Vec<Change>,
    },
    /// A change that was made, or may have been made, could not be restored, or the output.
    #[error("{cause}; the sensor {} changed: {}", if *is_read { "stays" } else { "may stay" }, list(changes, *output))]
    Left {
        /// The reason why the sensor is not set as requested.
        cause: Box<ConfigureError>,
        /// The changes that remain, or may remain, in the sensor.
        changes: Vec<Change>,
        /// Whether these changes were read from the sensor.
        is_read: bool,
        /// The possible state of the output if the command to restore it failed.
        output: Option<OutputLeft>,
    },
}

/// The output of a sensor if it may differ from the state in which it was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputLeft {
    /// The output may be on, and was found paused.
    On,
    /// The output may be paused, and was found on.
    MaybePaused,
}

impl OutputLeft {
    /// The state after the command to restore the output; `None` if the command succeeded.
    const fn after(is_restored: bool, was_paused: bool) -> Option<Self> {
        match (is_restored, was_paused) {
            (true, _) => None,
            (false, true) => Some(Self::On),
            (false, false) => Some(Self::MaybePaused),
        }
    }
}

fn list(changes: &[Change], output: Option<OutputLeft>) -> String {
    let output = output.map(|output| match output {
        OutputLeft::On => "its output, which may be on".into(),
        OutputLeft::MaybePaused => "its output, which may be paused".into(),
    });
    let list: Vec<_> = changes.iter().map(ToString::to_string).chain(output).collect();
    list.join(", ")
}

/// Sets the sensor: reads its settings, checks that the new output fits the baud rate, pauses the
/// output, writes, reads back, resumes the output and measures its rate; does so a second time if
/// the link was lost meanwhile.
///
/// On a failure, or on `stop`, all changes are restored before this returns, and an output that was
/// found paused is paused again. Only saved settings stay. On success the output is on in any case.
///
/// The events of the link must be received meanwhile. If the future is dropped, the sensor keeps
/// its state of that moment, perhaps with its output paused: cancel `stop` instead.
///
/// # Errors
/// [`ConfigureError`] if the settings are not possible, if the sensor refuses or does not keep
/// them, or on `stop`.
pub async fn configure(
    link: &LinkHandle,
    settings: &OutputSettings,
    stop: &CancellationToken,
) -> Result<Configured, ConfigureError> {
    let mut written = Written::default();
    let set = stop.run_until_cancelled(set(link, settings, &mut written)).await;
    let Written { configured, kept, touched } = written;
    let Err(cause) = set.unwrap_or(Err(ConfigureError::Interrupted { undone: Vec::new() })) else {
        return Ok(configured);
    };
    let Configured { changes, was_paused, .. } = configured;
    let is_back = changes.is_empty() || !kept && write_back(link, &changes).await.is_ok();
    // also if nothing was written; awaited because the caller may close the link next
    let is_as_found = !touched || link.request(SensorCommand::Async(!was_paused)).await.is_ok();
    let unrestored = if is_back { &[] } else { &*changes };
    Err(match with_left(link, cause, unrestored, OutputLeft::after(is_as_found, was_paused)).await {
        ConfigureError::Interrupted { .. } => ConfigureError::Interrupted { undone: changes },
        error => error,
    })
}

#[derive(Default)]
struct Written {
    configured: Configured,
    /// Whether the changes may be saved in the flash of the sensor.
    kept: bool,
    /// Whether a command to pause or resume the output was sent, even if the sensor has not
    /// executed it.
    touched: bool,
}

/// Sets the sensor; a second time if the link was lost meanwhile.
async fn set(link: &LinkHandle, settings: &OutputSettings, written: &mut Written) -> Result<(), ConfigureError> {
    for _ in 1..ATTEMPTS {
        match attempt(link, settings, written).await {
            Ok(true) => return Ok(()),
            Ok(false) | Err(ConfigureError::Command(CommandError::Failed(RequestFailure::LinkDown { .. }))) => {
                until_back(link).await;
            }
            Err(error) => return Err(error),
        }
    }
    if !attempt(link, settings, written).await? {
        until_back(link).await;
        read_all_back(link, &written.configured.changes).await?;
    }
    Ok(())
}

/// Reads the settings, writes those that differ, and measures the rate. `false` if the link was
/// lost or silent meanwhile: a sensor that lost its power has lost the written settings.
async fn attempt(link: &LinkHandle, settings: &OutputSettings, written: &mut Written) -> Result<bool, ConfigureError> {
    let mut state = link.state();
    let up_since = |state: &LinkState| state.up().map(|up| up.since_ns);
    let begun = up_since(&state.borrow());
    let mut current = Vec::new();
    for register in settings.registers() {
        // the plan decides whether a missing register matters
        current.extend(link.read(register).await?);
    }
    if !written.touched {
        written.configured.was_paused = is_paused(link).await?;
    }
    // packets that are paused here may be those of this port
    let packets_arrive = written.configured.was_paused || packets_arrive(link, &current).await;
    let OutputPlan { changes: planned, frames, rate_hz } = plan(&current, settings, packets_arrive)?;
    if !planned.is_empty() || settings.save || written.configured.was_paused || written.touched {
        pause(link, written).await?;
        write(link, planned, written).await?;
        if settings.save {
            written.kept = true;
            link.request(SensorCommand::WriteSettings).await?;
        }
        link.request(SensorCommand::Async(true)).await?;
    }
    let before = link.frames(frames);
    let new_period = Duration::try_from_secs_f64(rate_hz.recip()).unwrap_or_default();
    tokio::time::sleep(SETTLE.max(period(&current)).max(SETTLE + new_period)).await;
    let mut moved = to_second_port(&written.configured.changes).filter(|_| link.frames(frames) == before);
    if let Some(change) = &moved {
        // packets delayed by a stall arrive before the reply
        link.read(change.register).await?;
        moved = moved.filter(|_| link.frames(frames) == before);
    }
    if let Some(change) = moved {
        pause(link, written).await?;
        write(link, vec![change], written).await?;
        link.request(SensorCommand::Async(true)).await?;
        tokio::time::sleep(SETTLE).await;
    }
    let is_same_link = up_since(&state.borrow_and_update()) == begun;
    written.configured.rate_hz = rate_hz;
    for _ in 0..COUNTS {
        let (before, began) = (link.frames(frames), Instant::now());
        tokio::time::sleep(MEASURE).await;
        written.configured.measured_hz = (link.frames(frames) - before) as f64 / began.elapsed().as_secs_f64();
        // settings that were lost with the power are written once more
        if written.configured.rate_is_kept() || state.has_changed().unwrap_or(true) {
            break;
        }
    }
    // a loss of power that was too short for the link to notice is visible in the registers
    Ok(is_same_link
        && !state.has_changed().unwrap_or(true)
        && read_all_back(link, &written.configured.changes).await.is_ok())
}

/// Whether packets of the first output arrive on this port. The sensor does not report which of its
/// ports this is.
async fn packets_arrive(link: &LinkHandle, current: &[RegisterContents]) -> bool {
    let output = current.iter().find(|contents| contents.register == Register::BINARY_OUTPUT_1);
    let output = output.and_then(|contents| contents.value::<BinaryOutput>().ok());
    let Some(output) = output.filter(|output| output.rate_hz() > 0.0) else { return false };
    let frames = FrameKind::Packet(output.header());
    let end = Instant::now() + LISTEN;
    while link.frames(frames) == 0 && Instant::now() < end {
        tokio::time::sleep(CHECK_INTERVAL).await;
    }
    link.frames(frames) > 0
}

/// The period of the output before the change: the first frame of the new output may come as late
/// as that.
fn period(current: &[RegisterContents]) -> Duration {
    let rate = current.iter().find(|contents| contents.register == Register::ASYNC_RATE);
    let rate = rate.and_then(|contents| contents.value::<AsyncRate>().ok());
    Duration::from_secs(1).checked_div(rate.map_or(0, AsyncRate::hz)).unwrap_or_default()
}

/// Waits until the sensor answers on a link that was lost; gives up after a timeout.
async fn until_back(link: &LinkHandle) {
    let mut state = link.state();
    let answers = async {
        loop {
            let is_open = |state: &LinkState| state.up().is_some() || matches!(state, LinkState::Closed { .. });
            let _ = state.wait_for(is_open).await;
            match link.read(Register::MODEL).await {
                Err(
                    CommandError::OneWay { .. }
                    | CommandError::Failed(RequestFailure::LinkDown { .. } | RequestFailure::Timeout { .. }),
                ) => {}
                _ => return,
            }
        }
    };
    // after the timeout the next command fails
    let _ = tokio::time::timeout(RETURN, answers).await;
}

/// Restores the changes of [`configure`], the last one first. An output that is paused stays
/// paused.
///
/// # Errors
/// If a command fails or a register does not read back; [`ConfigureError::Left`] names the changes
/// that stay.
pub async fn restore(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    if changes.is_empty() {
        return Ok(());
    }
    // if the output cannot be read, no register can be restored either
    let was_paused = is_paused(link).await.unwrap_or(false);
    let back = write_back(link, changes).await;
    let output = link.request(SensorCommand::Async(!was_paused)).await;
    let left = OutputLeft::after(output.is_ok(), was_paused);
    let Err(cause) = back.and(output.map(drop).map_err(ConfigureError::from)) else { return Ok(()) };
    Err(with_left(link, cause, changes, left).await)
}

/// Writes the former values if the registers differ from them, and leaves the output paused.
async fn write_back(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    let mut written = Written::default();
    pause(link, &mut written).await?;
    let mut back = Vec::new();
    for Change { register, before, after } in changes.iter().rev() {
        if !link.read(*register).await?.is_some_and(|now| now.is_as_written(before)) {
            back.push(Change { register: *register, before: after.clone(), after: writable(*register, before) });
        }
    }
    write(link, back, &mut written).await
}

/// The error with the changes that remain in the sensor; with all of them if they cannot be read.
async fn with_left(
    link: &LinkHandle,
    cause: ConfigureError,
    changes: &[Change],
    output: Option<OutputLeft>,
) -> ConfigureError {
    let (mut left, mut is_read) = (Vec::new(), true);
    for change in changes {
        let Ok(now) = link.read(change.register).await else {
            (left, is_read) = (changes.to_vec(), false);
            break;
        };
        if now.is_some_and(|now| now.is_as_written(&change.after)) {
            left.push(change.clone());
        }
    }
    if left.is_empty() && output.is_none() {
        return cause;
    }
    ConfigureError::Left { cause: Box::new(cause), changes: left, is_read, output }
}

/// Whether the output of the sensor is paused: it is set to send, but sends nothing.
async fn is_paused(link: &LinkHandle) -> Result<bool, ConfigureError> {
    let end = Instant::now() + LISTEN;
    // frames that arrived before a silence do not show the present state
    let is_silent = matches!(*link.state().borrow(), LinkState::Silent(_));
    let before = if is_silent { link.frames_of_all() } else { 0 };
    while link.frames_of_all() == before {
        if Instant::now() >= end {
            let message = value(link, Register::ASYNC_TYPE).await?;
            let rate = value(link, Register::ASYNC_RATE).await?;
            let sends = |message: AsyncType, rate: AsyncRate| message != AsyncType::OFF && rate.hz() > 0;
            let packets: Option<BinaryOutput> = value(link, Register::BINARY_OUTPUT_1).await?;
            let is_set = message.zip(rate).is_some_and(|(message, rate)| sends(message, rate))
                || packets.is_some_and(|packets| packets.rate_hz() > 0.0);
            // after a stall of this machine, frames arrive before the replies
            return Ok(is_set && link.frames_of_all() == before);
        }
        tokio::time::sleep(CHECK_INTERVAL).await;
    }
    Ok(false)
}

/// The value of a register; `None` if the sensor does not have the register, or the fields are
/// malformed.
async fn value<T: RegisterValue>(link: &LinkHandle, register: Register) -> Result<Option<T>, ConfigureError> {
    Ok(link.read(register).await?.and_then(|contents| contents.value().ok()))
}

/// Pauses the output. The caller resumes it in any case.
async fn pause(link: &LinkHandle, written: &mut Written) -> Result<(), ConfigureError> {
    written.touched = true;
    // commands lose bytes while the port is busy with frames
    link.request(SensorCommand::Async(false)).await?;
    tokio::time::sleep(DRAIN).await;
    Ok(())
}

/// Writes the `planned` changes, and adds each to `written` before it is made.
async fn write(link: &LinkHandle, planned: Vec<Change>, written: &mut Written) -> Result<(), ConfigureError> {
    for mut change in planned {
        let changes = &mut written.configured.changes;
        let changes_before = changes.clone();
        // a write that is not answered may have been executed
        match changes.iter_mut().find(|earlier| earlier.register == change.register) {
            Some(earlier) => {
                // written again: the first value is the one to restore
                change.before = earlier.before.clone();
                *earlier = change.clone();
            }
            None => changes.push(change.clone()),
        }
        let write = SensorCommand::WriteRegister { register: change.register, fields: change.after.clone() };
        let answer = link.request(write).await;
        if let Err(CommandError::Failed(RequestFailure::Device { .. })) = answer {
            *changes = changes_before;
        }
        answer?;
        read_back(link, &change).await?;
    }
    Ok(())
}

async fn read_all_back(link: &LinkHandle, changes: &[Change]) -> Result<(), ConfigureError> {
    for change in changes {
        read_back(link, change).await?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_kept_within_one_frame_and_a_twentieth() {
        // a frame in two seconds is 0.5 Hz, a twentieth of 40 Hz is 2 Hz
        for (measured_hz, is_kept) in
            [(40.0, true), (42.5, true), (42.6, false), (37.5, true), (37.4, false), (0.0, false)]
        {
            let configured = Configured { measured_hz, rate_hz: 40.0, ..Configured::default() };
            assert_eq!(configured.rate_is_kept(), is_kept, "{measured_hz}");
        }
    }
}

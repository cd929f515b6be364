//! The steps before output counts as that of the sensor measured so far. The output may be that of
//! another sensor, or of one that has lost its power and its settings. So the serial number is
//! read, and the settings are read or written again.

use std::{collections::VecDeque, io, time::Duration};

use vn100_protocol::{BaudRate, DeviceError, Register, RequestFailure, Response, SensorCommand, WritableValue};

use super::{PortAction, link_context::LinkContext};
use crate::{link_error::LinkError, output_plan::Change};

/// Steps that are executed in sequence; each waits for the result of its commands.
pub(super) struct Verification {
    steps: VecDeque<Step>,
}

enum Step {
    /// Read the serial number. A sensor that does not report one is accepted as the known sensor.
    VerifySerialNumber,
    /// Read the registers and compare them with the desired settings.
    VerifySettings { left: VecDeque<Change> },
    /// Write the desired settings while the output is paused.
    ReapplySettings {
        commands: VecDeque<SensorCommand>,
        failure: Option<RequestFailure>,
        /// The baud rate to change to if the present rate is too low for the settings.
        faster: Option<BaudRate>,
    },
    /// Change the baud rate of the sensor, then that of the port.
    RaiseBaudRate(BaudRate),
}

impl Verification {
    /// The verification of a sensor that a baud scan has found at the rate `baud`.
    pub(super) fn after_scan(context: &mut LinkContext, baud: Option<u32>) -> Self {
        let faster = context.last_baud.filter(|last| context.has_baud && *last > baud.unwrap_or_default());
        let reapply = reapply_settings(&context.options.desired_settings, faster.and_then(BaudRate::new));
        let reapply = reapply.filter(|_| context.was_connected);
        Self::start(context, reapply)
    }

    /// The verification of a sensor that sends again after a silence.
    pub(super) fn after_silence(context: &mut LinkContext) -> Self {
        context.requests.cancel_own();
        let left = context.options.desired_settings.clone().into();
        Self::start(context, Some(Step::VerifySettings { left }))
    }

    /// Starts by reading the serial number, if it is known.
    fn start(context: &mut LinkContext, settings: Option<Step>) -> Self {
        let serial = context.serial_to_verify().map(|_| Step::VerifySerialNumber);
        let mut verification = Self { steps: serial.into_iter().chain(settings).collect() };
        verification.submit(context);
        verification
    }

    pub(super) fn is_done(&self) -> bool {
        self.steps.is_empty()
    }

    pub(super) fn may_have_paused_output(&self) -> bool {
        matches!(self.steps.front(), Some(Step::ReapplySettings { .. } | Step::RaiseBaudRate(_)))
    }

    pub(super) fn handle_answer(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        result: Result<Response, RequestFailure>,
    ) -> Result<(), LinkError> {
        match self.steps.front_mut() {
            Some(Step::VerifySerialNumber) => {
                let is_known = match &result {
                    Ok(Response::Register(contents)) => context.serial_to_verify() == Some(contents.fields.as_str()),
                    _ => true,
                };
                if is_known {
                    self.steps.pop_front();
                }
            }
            Some(Step::VerifySettings { left }) => {
                let is_kept = |change: &Change| matches!(&result, Ok(Response::Register(contents)) if contents.is_as_written(&change.after));
                if !left.pop_front().is_some_and(|change| is_kept(&change)) {
                    return Err(LinkError::SettingsLost);
                }
            }
            Some(Step::ReapplySettings { commands, failure, faster }) => {
                *failure = failure.take().or(result.err());
                if commands.is_empty() {
                    let (failure, faster) = (failure.take(), faster.take());
                    // output under other settings is not part of the measurement
                    context.discard_pending(now);
                    match (failure, faster) {
                        (Some(failure), Some(faster)) if is_baud_too_low(&failure) => {
                            self.steps.push_front(Step::RaiseBaudRate(faster));
                        }
                        (Some(failure), _) => return Err(failure.into()),
                        (None, _) => {}
                    }
                }
            }
            Some(Step::RaiseBaudRate(baud)) => {
                result?;
                context.port_actions.push_back(PortAction::SetBaud(baud.bits_per_s()));
                return Ok(());
            }
            None => {}
        }
        self.submit(context);
        Ok(())
    }

    /// The port was switched to the baud rate of the sensor. Returns that rate; `None` if no step
    /// waits for it.
    pub(super) fn handle_baud_set(
        &mut self,
        context: &mut LinkContext,
        result: io::Result<()>,
    ) -> Result<Option<u32>, LinkError> {
        let Some(Step::RaiseBaudRate(baud)) = self.steps.front() else { return Ok(None) };
        let baud = baud.bits_per_s();
        result?;
        self.steps = reapply_settings(&context.options.desired_settings, None).into_iter().collect();
        self.submit(context);
        Ok(Some(baud))
    }

    /// Submits the next command; a step without one is done.
    fn submit(&mut self, context: &mut LinkContext) {
        while let Some(step) = self.steps.front_mut() {
            let command = match step {
                Step::VerifySerialNumber => Some(SensorCommand::ReadRegister(Register::SERIAL_NUMBER)),
                Step::VerifySettings { left } => {
                    left.front().map(|change| SensorCommand::ReadRegister(change.register))
                }
                Step::ReapplySettings { commands, .. } => commands.pop_front(),
                Step::RaiseBaudRate(baud) => {
                    Some(SensorCommand::WriteRegister { register: Register::BAUD_RATE, fields: baud.fields() })
                }
            };
            match command {
                Some(command) => return context.requests.submit_for_phase(command),
                None => self.steps.pop_front(),
            };
        }
    }
}

/// The step that writes the desired settings; `None` if there are none. The baud rate is not
/// written, because the sensor is found at its present rate.
fn reapply_settings(desired: &[Change], faster: Option<BaudRate>) -> Option<Step> {
    let changes = desired.iter().filter(|change| change.register != Register::BAUD_RATE);
    let writes: Vec<_> = changes
        .map(|change| SensorCommand::WriteRegister { register: change.register, fields: change.after.clone() })
        .collect();
    if writes.is_empty() {
        return None;
    }
    // with a read the queue detects an echoing line, and can then distinguish the echo of a write
    // from its answer
    let begin = [SensorCommand::ReadRegister(Register::MODEL), SensorCommand::Async(false)];
    let commands = begin.into_iter().chain(writes).chain([SensorCommand::Async(true)]).collect();
    Some(Step::ReapplySettings { commands, failure: None, faster })
}

/// Whether the sensor refused an output because its baud rate is too low.
fn is_baud_too_low(failure: &RequestFailure) -> bool {
    matches!(failure, RequestFailure::Device { error: DeviceError::InsufficientBaudRate, .. })
}

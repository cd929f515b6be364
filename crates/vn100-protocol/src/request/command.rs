//! The commands that the sensor accepts.

use alloc::{borrow::ToOwned, format, string::String};
use core::time::Duration;

use crate::{
    framing::checksum::Check,
    register::fields::RegisterFields,
    register::{Register, WritableValue},
    request::reply::Reply,
};

/// A command to the sensor.
///
/// Commands that leave the protocol (firmware update, the prompt for people) are not among them.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum SensorCommand {
    /// `VNRRG`: reads a register.
    ReadRegister(Register),
    /// `VNWRG`: writes a register; the value is lost without power, unless
    /// [`WriteSettings`](Self::WriteSettings) follows.
    WriteRegister {
        /// The register.
        register: Register,
        /// Its fields in order. Registers 5 to 7 are of the port in use, unless a further field
        /// names a port.
        fields: RegisterFields,
    },
    /// `VNWNV`: saves all registers. The sensor should not move meanwhile.
    WriteSettings,
    /// `VNRFS`: restores the factory default of all registers, saves them and restarts.
    RestoreFactorySettings,
    /// `VNRST`: restarts with the registers as saved.
    Reset,
    /// `VNASY`: pauses (`false`) or resumes (`true`) all output of the port, sentences and packets;
    /// no register changes.
    Async(bool),
    /// `VNSGB`: makes the present bias estimate of the filter its initial bias (register 43).
    SetGyroBias,
    /// `VNTAR`: makes the present attitude the zero attitude. Firmware 3 answers
    /// [`InvalidCommand`](crate::DeviceError::InvalidCommand).
    Tare,
}

/// The waits of the maker's libraries: for an answer, for the settings to be saved, which takes
/// about half a second, and for a restart.
const ANSWER_TIME: Duration = Duration::from_millis(500);
const SAVE_TIME: Duration = Duration::from_millis(1200);
const RESTART_TIME: Duration = Duration::from_millis(2500);
/// The time from the answer to the first output after a restart, as measured for the driver of the
/// ArduPilot autopilot.
const BOOT_TIME: Duration = Duration::from_millis(1250);

impl SensorCommand {
    /// The command that writes `setting` to its register.
    pub fn write(setting: &impl WritableValue) -> Self {
        Self::WriteRegister { register: setting.register(), fields: setting.fields() }
    }

    /// The sentence from `$` to LF. The sensor accepts either check; it rejects a sentence with
    /// [`Check::None`].
    pub fn sentence(&self, check: Check) -> String {
        check.sentence(&self.body())
    }

    /// Whether `reply` confirms this command: it names the same command and, if the command has
    /// one, the same register.
    ///
    /// The fields in the reply to a write are not compared. A device error does not name the
    /// command that it answers, and does not confirm any.
    pub fn is_answered_by(&self, reply: &Reply) -> bool {
        match (self, reply) {
            (Self::ReadRegister(register), Reply::Register(contents))
            | (Self::WriteRegister { register, .. }, Reply::Written(contents)) => *register == contents.register,
            (_, Reply::Echo(body)) => *body == self.body(),
            _ => false,
        }
    }

    /// Whether sending the command twice has the same effect as sending it once.
    pub fn is_repeatable(&self) -> bool {
        matches!(self, Self::ReadRegister(_) | Self::WriteRegister { .. } | Self::Async(_))
    }

    /// The wait for the answer: 500 ms; 1.2 s for saving, 2.5 s for a restart.
    pub fn answer_time(&self) -> Duration {
        match self {
            Self::WriteSettings => SAVE_TIME,
            Self::RestoreFactorySettings | Self::Reset => RESTART_TIME,
            _ => ANSWER_TIME,
        }
    }

    /// The time after its answer in which the sensor receives no other command: 1.25 s while it
    /// restarts, half a second while it saves.
    pub fn busy_time(&self) -> Duration {
        match self {
            Self::WriteSettings => ANSWER_TIME,
            Self::RestoreFactorySettings | Self::Reset => BOOT_TIME,
            _ => Duration::ZERO,
        }
    }

    pub(super) fn line(&self, check: Check) -> String {
        self.sentence(check).trim_end().to_owned()
    }

    fn body(&self) -> String {
        match self {
            Self::ReadRegister(register) => format!("VNRRG,{register}"),
            Self::WriteRegister { register, fields } => format!("VNWRG,{register},{fields}"),
            Self::Async(on) => format!("VNASY,{}", u8::from(*on)),
            Self::WriteSettings => "VNWNV".to_owned(),
            Self::RestoreFactorySettings => "VNRFS".to_owned(),
            Self::Reset => "VNRST".to_owned(),
            Self::SetGyroBias => "VNSGB".to_owned(),
            Self::Tare => "VNTAR".to_owned(),
        }
    }
}

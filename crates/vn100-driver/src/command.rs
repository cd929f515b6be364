//! What can be asked of a sensor over a live link, what it answers, and why it does not.

use std::{fmt, time::Duration};

use thiserror::Error;
use vn100_protocol::{CheckDigits, xor8};

/// A command to the sensor.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Command {
    /// Read a register.
    ReadRegister(u8),
    /// Write a register until the sensor is switched off.
    WriteRegister {
        /// Its number.
        register: u8,
        /// Its fields with the commas between them.
        fields: String,
    },
    /// Pause, or resume, all that the sensor sends unasked on this port.
    Output(bool),
    /// Keep all registers through switching off. The sensor should stand still.
    SaveSettings,
}

impl Command {
    /// The command as it is sent.
    pub(crate) fn line(&self) -> String {
        let body = self.to_string();
        format!("${body}*{}\r\n", CheckDigits::Xor8(xor8(body.as_bytes())))
    }

    /// Whether it does no harm when it is carried out twice.
    pub(crate) fn is_repeatable(&self) -> bool {
        match self {
            Self::ReadRegister(_) | Self::WriteRegister { .. } | Self::Output(_) => true,
            // wears the flash
            Self::SaveSettings => false,
        }
    }

    /// How long the sensor may take, with the line before its answer.
    pub(crate) fn patience(&self) -> Duration {
        match self {
            // more than a long line under way at 9600 baud and the answer behind it
            Self::ReadRegister(_) | Self::WriteRegister { .. } | Self::Output(_) => Duration::from_millis(500),
            // about 0.5 s by the manual; the maker's library waits so long
            Self::SaveSettings => Duration::from_millis(1200),
        }
    }

    /// Whether what is sent is one command and nothing else.
    pub(crate) fn is_well_formed(&self) -> bool {
        match self {
            Self::WriteRegister { fields, .. } => {
                fields.len() <= 200
                    && fields.bytes().all(|byte| matches!(byte, b' '..=b'~') && byte != b'$' && byte != b'*')
            }
            Self::ReadRegister(_) | Self::Output(_) | Self::SaveSettings => true,
        }
    }

    /// What an answer's body says to this command; `None` when it answers another.
    pub(crate) fn answer(&self, body: &str) -> Option<Result<Answer, CommandError>> {
        let mut fields = body.splitn(3, ',');
        let (header, second, rest) = (fields.next()?, fields.next(), fields.next());
        // the sensor fills numbers up to two digits
        let is_register = |asked: u8| second.and_then(|number| number.parse::<u8>().ok()) == Some(asked);
        match self {
            Self::ReadRegister(register) if header == "VNRRG" && is_register(*register) => {
                Some(Ok(Answer { fields: rest.unwrap_or_default().to_owned() }))
            }
            Self::WriteRegister { register, fields } if header == "VNWRG" && is_register(*register) => {
                let got = rest.unwrap_or_default();
                Some(if same_fields(*register, fields, got) {
                    Ok(Answer { fields: got.to_owned() })
                } else {
                    Err(CommandError::EchoDiffers { asked: self.to_string(), got: body.to_owned() })
                })
            }
            Self::Output(on) if header == "VNASY" && is_register(u8::from(*on)) => Some(Ok(Answer::default())),
            Self::SaveSettings if header == "VNWNV" => Some(Ok(Answer::default())),
            _ => None,
        }
    }
}

/// The body of the command, without `$` and checksum.
impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ReadRegister(register) => write!(f, "VNRRG,{register:02}"),
            Self::WriteRegister { register, fields } => write!(f, "VNWRG,{register:02},{fields}"),
            Self::Output(on) => write!(f, "VNASY,{}", u8::from(*on)),
            Self::SaveSettings => f.write_str("VNWNV"),
        }
    }
}

/// Whether two texts of a register's fields say the same: numbers may be printed in several ways, and registers 5 to 7 may name the port
/// behind their value.
pub(crate) fn same_fields(register: u8, asked: &str, got: &str) -> bool {
    let same = |(asked, got): (&str, &str)| {
        asked == got
            || matches!((asked.parse::<f64>(), got.parse::<f64>()), (Ok(asked), Ok(got)) if asked.total_cmp(&got).is_eq())
    };
    let (asked_fields, got_fields) = (asked.split(',').count(), got.split(',').count());
    let port_told = (5..=7).contains(&register) && asked_fields.abs_diff(got_fields) == 1;
    (asked_fields == got_fields || port_told) && asked.split(',').zip(got.split(',')).all(same)
}

/// What the sensor answered.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Answer {
    /// The fields of the register that was read or written, with the commas between them; empty for other commands.
    pub fields: String,
}

/// Why a command was not carried out, or not for certain.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CommandError {
    /// No answer came.
    #[error("the sensor did not answer ${command} in {attempts} attempts of {} ms; it may be told not to name errors (register 30), or the way to it may be cut", patience.as_millis())]
    NoAnswer {
        /// The command.
        command: String,
        /// How often it was sent.
        attempts: u32,
        /// How long each answer was waited for.
        patience: Duration,
    },
    /// The sensor refused.
    #[error("the sensor refuses ${command}: {}", device_error(*code))]
    Refused {
        /// The command.
        command: String,
        /// The number behind `VNERR`.
        code: u8,
    },
    /// The sensor says that it has written something else.
    #[error("the sensor was asked for ${asked} and says ${got}")]
    EchoDiffers {
        /// The command.
        asked: String,
        /// The answer.
        got: String,
    },
    /// The command would not be one line.
    #[error("${command} is not one command: fields are printable text without $ and *, 200 characters at most")]
    Malformed {
        /// The command.
        command: String,
    },
    /// The link was lost before an answer came, or is not up.
    #[error("the link to the sensor is down")]
    LinkDown,
    /// The link was opened to send nothing.
    #[error("nothing is sent on this link: it was opened to listen only")]
    ListenOnly,
}

/// The code of a refusal: there is no such register.
pub(crate) const NO_SUCH_REGISTER: u8 = 8;

/// Codes by which the sensor tells of itself, and answers nothing: hard fault, watchdog, output overflow, error overflow.
pub(crate) fn is_unasked(code: u8) -> bool {
    matches!(code, 0x01 | 0x0A | 0x0B | 0xFF)
}

/// What a code says, and what to do about it.
pub(crate) fn device_error(code: u8) -> String {
    let text = match code {
        0x01 => "hard fault; it restarts",
        0x02 => "more came than it can take at once",
        0x03 => "the command came damaged; pause its output before writing",
        0x04 => "it does not know this command",
        0x05 => "too few parameters",
        0x06 => "too many parameters",
        0x07 => "a value is not allowed",
        NO_SUCH_REGISTER => "it has no such register",
        0x09 => "that is not permitted, as writing what can only be read",
        0x0A => "its watchdog restarted it",
        0x0B => "more output is asked for than the line carries",
        0x0C => "the line is too slow for the output asked for; raise the speed or lower the rate",
        0xFF => "more errors than it can tell",
        _ => return format!("VNERR,{code:02X}, which is not known"),
    };
    format!("VNERR,{code:02X}, {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(register: u8, fields: &str) -> Command {
        Command::WriteRegister { register, fields: fields.into() }
    }

    #[test]
    fn commands_are_sent_with_the_checksums_of_the_manual() {
        for (command, line) in [
            (Command::ReadRegister(1), "$VNRRG,01*72\r\n"),
            (Command::ReadRegister(239), "$VNRRG,239*4B\r\n"),
            (write(7, "200"), "$VNWRG,07,200*6F\r\n"),
            (write(85, "0,20,20,4,0,0,3,3,3,0"), "$VNWRG,85,0,20,20,4,0,0,3,3,3,0*7C\r\n"),
            (Command::Output(false), "$VNASY,0*4F\r\n"),
            (Command::Output(true), "$VNASY,1*4E\r\n"),
            (Command::SaveSettings, "$VNWNV*57\r\n"),
        ] {
            assert_eq!(command.line(), line);
        }
    }

    #[test]
    fn answers_are_known_by_command_and_register() {
        let fields = |command: &Command, body| command.answer(body).map(|answer| answer.map(|answer| answer.fields));
        let read = Command::ReadRegister(7);
        assert_eq!(fields(&read, "VNRRG,07,40"), Some(Ok("40".into())));
        assert_eq!(fields(&read, "VNRRG,7,40"), Some(Ok("40".into())));
        for other in ["VNRRG,08,40", "VNWRG,07,40", "VNYMR,07,40", "VNRRG", "VNRRG,seven,40"] {
            assert_eq!(fields(&read, other), None, "{other}");
        }
        assert_eq!(fields(&write(7, "50"), "VNWRG,07,50"), Some(Ok("50".into())));
        assert!(matches!(fields(&write(7, "50"), "VNWRG,07,40"), Some(Err(CommandError::EchoDiffers { .. }))));
        assert_eq!(fields(&Command::Output(true), "VNASY,1"), Some(Ok(String::new())));
        assert_eq!(fields(&Command::Output(true), "VNASY,0"), None, "the answer to the command before");
    }

    #[test]
    fn numbers_may_be_printed_in_several_ways() {
        assert!(same_fields(30, "1.002110,0,S", "1.00211,+0,S"));
        assert!(!same_fields(30, "1,0", "1"));
        assert!(!same_fields(30, "VN", "VX"));
        assert!(same_fields(7, "20", "20,1") && same_fields(7, "20,1", "20"));
        assert!(!same_fields(7, "20", "40,1") && !same_fields(7, "20", "20,1,2") && !same_fields(8, "20", "20,1"));
    }

    #[test]
    fn what_would_be_two_lines_is_not_sent() {
        assert!(write(0, "SENSOR_A").is_well_formed());
        for bad in ["40*59\r\n$VNWNV", "a\n", "a$b"] {
            assert!(!write(7, bad).is_well_formed());
        }
    }
}

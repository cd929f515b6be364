//! The replies of a sensor to commands.

use alloc::{borrow::ToOwned, string::String};

use thiserror::Error;

use crate::{
    framing::sentence::Sentence,
    register::fields::RegisterFields,
    register::{Register, RegisterContents},
    request::device_error::DeviceError,
};

/// An answer of the sensor, an unsolicited device error, or the echo of a read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reply {
    /// `VNRRG`: the contents of a register.
    Register(RegisterContents),
    /// `VNWRG`: the contents that were written to a register.
    Written(RegisterContents),
    /// Any other command, repeated by the sensor: the body of the sentence, such as `VNASY,0`.
    Echo(String),
    /// `VNERR`: a device error.
    Error(DeviceError),
    /// `VNRRG` with nothing after the register number. A sensor sends no such sentence: it is the
    /// read command of the host, on a line that echoes.
    Question(Register),
}

/// The reason why a sentence is no reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ReplyError {
    /// The header is that of a measurement, or unknown.
    #[error("the sentence is not a reply to a command")]
    NotAReply,
    /// No register number follows `VNRRG` or `VNWRG`.
    #[error("the reply does not begin with a register number from 0 to 255")]
    RegisterNumber,
    /// No field follows the register number of a write.
    #[error("the reply has no value behind the register number")]
    NoValue,
    /// `VNERR` is followed by no code, or by more than one.
    #[error("the error code is not one or two hexadecimal digits")]
    ErrorCode,
}

impl Reply {
    /// Reads a sentence. A register number may be padded with zeros.
    ///
    /// # Errors
    /// [`ReplyError`] for a sentence that is no reply.
    pub fn parse(sentence: &Sentence<'_>) -> Result<Self, ReplyError> {
        if !sentence.is_reply() {
            return Err(ReplyError::NotAReply);
        }
        let body = str::from_utf8(sentence.body).map_err(|_| ReplyError::NotAReply)?;
        let (header, fields) = body.split_once(',').unwrap_or((body, ""));
        match header {
            "VNRRG" if !fields.contains(',') => register(fields).map(Self::Question),
            "VNRRG" => contents(fields).map(Self::Register),
            "VNWRG" => contents(fields).map(Self::Written),
            "VNERR" => error_code(fields).map(|code| Self::Error(DeviceError::from_code(code))),
            _ => Ok(Self::Echo(body.to_owned())),
        }
    }
}

fn contents(fields: &str) -> Result<RegisterContents, ReplyError> {
    let (number, fields) = fields.split_once(',').map_or((fields, None), |(number, value)| (number, Some(value)));
    let register = register(number)?;
    let fields = RegisterFields::trusted(fields.ok_or(ReplyError::NoValue)?.to_owned());
    Ok(RegisterContents { register, fields })
}

fn register(number: &str) -> Result<Register, ReplyError> {
    // the standard library would accept a sign
    let is_number = number.bytes().all(|byte| byte.is_ascii_digit());
    number.parse().ok().filter(|_| is_number).map(Register).ok_or(ReplyError::RegisterNumber)
}

fn error_code(field: &str) -> Result<u8, ReplyError> {
    let is_code = field.len() <= 2 && field.bytes().all(|byte| byte.is_ascii_hexdigit());
    u8::from_str_radix(field, 16).ok().filter(|_| is_code).ok_or(ReplyError::ErrorCode)
}

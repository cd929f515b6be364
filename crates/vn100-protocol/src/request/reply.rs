//! The replies of a sensor to commands.

use alloc::{borrow::ToOwned, string::String};

use crate::{
    framing::sentence::Sentence,
    register::fields::{RegisterFields, integer},
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

impl Reply {
    /// Reads a sentence, whose register number may be padded with zeros; `None` if it is no reply, or
    /// a malformed one.
    pub fn parse(sentence: &Sentence<'_>) -> Option<Self> {
        let body = str::from_utf8(sentence.body).ok().filter(|_| sentence.is_reply())?;
        let (header, fields) = body.split_once(',').unwrap_or((body, ""));
        match header {
            "VNRRG" if !fields.contains(',') => register(fields).map(Self::Question),
            "VNRRG" => contents(fields).map(Self::Register),
            "VNWRG" => contents(fields).map(Self::Written),
            "VNERR" => error_code(fields).map(|code| Self::Error(DeviceError::from_code(code))),
            _ => Some(Self::Echo(body.to_owned())),
        }
    }
}

fn contents(fields: &str) -> Option<RegisterContents> {
    let (number, fields) = fields.split_once(',')?;
    Some(RegisterContents { register: register(number)?, fields: RegisterFields::trusted(fields.to_owned()) })
}

fn register(number: &str) -> Option<Register> {
    integer(number).map(Register)
}

fn error_code(field: &str) -> Option<u8> {
    let is_code = field.len() <= 2 && field.bytes().all(|byte| byte.is_ascii_hexdigit());
    u8::from_str_radix(field, 16).ok().filter(|_| is_code)
}

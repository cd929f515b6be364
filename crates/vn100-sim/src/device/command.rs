//! Incoming commands: lines from bytes, and the parts of a line.

use std::cmp::Ordering;

use vn100_protocol::{DeviceError, crc16, xor8};

/// The longest command in bytes.
pub(crate) const RECEIVE_BUFFER: usize = 256;

#[derive(Debug, Clone, Default)]
pub(crate) struct CommandBuffer {
    /// The bytes from the `$` on; empty between commands.
    bytes: Vec<u8>,
    overflown: bool,
}

impl CommandBuffer {
    /// Takes one byte; `Some` when it ends a command: its text between `$` and the line end, or the
    /// error in it.
    ///
    /// Bytes before a `$` are discarded; a `$` always begins a new command.
    pub(crate) fn push(&mut self, byte: u8) -> Option<Result<Vec<u8>, DeviceError>> {
        match byte {
            b'$' => (self.bytes, self.overflown) = (vec![byte], false),
            _ if self.bytes.is_empty() => {}
            b'\n' => {
                let mut line = std::mem::take(&mut self.bytes).split_off(1);
                if std::mem::take(&mut self.overflown) {
                    return None;
                }
                if line.last() == Some(&b'\r') {
                    line.pop();
                }
                return Some(Ok(line));
            }
            _ if self.overflown => {}
            _ if self.bytes.len() == RECEIVE_BUFFER => {
                self.overflown = true;
                return Some(Err(DeviceError::ReceiveBufferOverflow));
            }
            _ => self.bytes.push(byte),
        }
        None
    }
}

/// The parts of a command with correct check digits, from the text between `$` and the line end:
/// the letters after `VN`, and the parameters.
pub(super) fn split(line: &[u8]) -> Result<(&str, Vec<&str>), DeviceError> {
    let star = line.iter().rposition(|byte| *byte == b'*').ok_or(DeviceError::InvalidChecksum)?;
    let (body, digits) = (&line[..star], &line[star + 1..]);
    if !is_checked_by(body, digits) {
        return Err(DeviceError::InvalidChecksum);
    }
    let text = std::str::from_utf8(body).ok().filter(|text| text.bytes().all(|byte| matches!(byte, b' '..=b'~')));
    let mut parts = text.ok_or(DeviceError::InvalidCommand)?.split(',');
    let name = parts.next().and_then(|header| header.strip_prefix("VN")).ok_or(DeviceError::InvalidCommand)?;
    Ok((name, parts.collect()))
}

pub(super) fn check_count(parameters: &[&str], expected: usize) -> Result<(), DeviceError> {
    match parameters.len().cmp(&expected) {
        Ordering::Less => Err(DeviceError::TooFewParameters),
        Ordering::Equal => Ok(()),
        Ordering::Greater => Err(DeviceError::TooManyParameters),
    }
}

/// Two digits are an XOR, four a CRC; `XX` and `XXXX` skip the check.
fn is_checked_by(body: &[u8], digits: &[u8]) -> bool {
    let value = || {
        let digits =
            std::str::from_utf8(digits).ok().filter(|text| text.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
        u16::from_str_radix(digits, 16).ok()
    };
    match digits {
        b"XX" | b"XXXX" => true,
        [_, _] => value() == Some(u16::from(xor8(body))),
        [_, _, _, _] => value() == Some(crc16(body)),
        _ => false,
    }
}

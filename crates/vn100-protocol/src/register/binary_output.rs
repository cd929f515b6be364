//! Registers 75 to 77: the streams of binary packets.

use alloc::vec::Vec;

use super::{Register, RegisterValue, ValueError, fields::FieldReader};
use crate::framing::packet;

/// One stream of binary packets.
///
/// ```text
/// $VNWRG,75, 2, 4, 06, 0001, 001C
///            |  |  |   '------'-- a word of fields for each group, the lowest group first
///            |  |  '-- groups
///            |  '-- every fourth of 800 samples a second
///            '-- to port 2
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct BinaryOutput {
    /// Where packets go: 0 nowhere, 1 port 1, 2 port 2, 3 both. Firmware 3 takes it for a mask.
    pub async_mode: u16,
    /// A packet is sent every so many samples of the 800 in a second; 0 on request alone.
    pub rate_divisor: u16,
    /// A bit for each group of fields in the packet.
    pub groups: u8,
    /// The fields of each group, the lowest group first.
    pub field_words: Vec<u16>,
}

impl BinaryOutput {
    /// Packets per second to the ports in [`async_mode`](Self::async_mode); 0 where none are sent.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        if self.async_mode == 0 || self.rate_divisor == 0 { 0.0 } else { 800.0 / f64::from(self.rate_divisor) }
    }

    /// The bytes of a packet; `None` where a group or a field is not known, or their numbers do not
    /// go together.
    #[must_use]
    pub fn packet_length(&self) -> Option<usize> {
        packet::length(self.groups, &self.field_words)
    }
}

impl RegisterValue for BinaryOutput {
    const REGISTERS: &'static [Register] =
        &[Register::BINARY_OUTPUT_1, Register::BINARY_OUTPUT_2, Register::BINARY_OUTPUT_3];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        let async_mode = fields.integer("async mode")?;
        let rate_divisor = fields.integer("rate divisor")?;
        let groups = fields.value("groups", "two hexadecimal digits", |text| hexadecimal(text)?.try_into().ok())?;
        let mut field_words = Vec::new();
        while fields.has_more() {
            field_words.push(fields.value("fields", "four hexadecimal digits", hexadecimal)?);
        }
        Ok(Self { async_mode, rate_divisor, groups, field_words })
    }
}

/// Hexadecimal digits alone: the standard library would take a sign, too.
fn hexadecimal(text: &str) -> Option<u16> {
    text.bytes().all(|byte| byte.is_ascii_hexdigit()).then(|| u16::from_str_radix(text, 16).ok())?
}

//! Register 30: what a port adds to its lines.

use core::fmt;

use super::{
    Register, RegisterContents, RegisterValue, ValueError, WritableValue, field_reader::FieldReader, write_list,
};
use crate::framing::checksum::Check;

/// Suffix fields, checksums and error reports. The numbers are kept as they are, so that one that
/// is not known here survives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ProtocolControl {
    /// The number behind `T` on every line: 0 none, 1 SyncIn count, 2 microseconds since SyncIn, 3
    /// SyncOut count, 4 microseconds since the pulse of a satellite receiver.
    pub serial_count: u8,
    /// The word behind `S` on every line: 0 none, 1 status of the attitude filter; others on other
    /// products.
    pub serial_status: u8,
    /// The count on the SPI bus.
    pub spi_count: u8,
    /// The status on the SPI bus.
    pub spi_status: u8,
    /// The check of every line: 1 XOR-8, 3 CRC-16. The maker's documents disagree on other numbers.
    pub serial_checksum: u8,
    /// The check on the SPI bus.
    pub spi_checksum: u8,
    /// 0: errors are counted only, and a wrong command is never answered. 1: `VNERR` is sent. 2: it
    /// is sent and turns the port's message off.
    pub error_mode: u8,
}

impl ProtocolControl {
    /// What protects the lines of the sensor; `None` for a number that is not known.
    #[must_use]
    pub fn check(&self) -> Option<Check> {
        match self.serial_checksum {
            1 => Some(Check::Xor8),
            3 => Some(Check::Crc16),
            _ => None,
        }
    }
}

/// As sold.
impl Default for ProtocolControl {
    fn default() -> Self {
        Self {
            serial_count: 0,
            serial_status: 0,
            spi_count: 0,
            spi_status: 0,
            serial_checksum: 1,
            spi_checksum: 0,
            error_mode: 1,
        }
    }
}

impl RegisterValue for ProtocolControl {
    const REGISTERS: &'static [Register] = &[Register::PROTOCOL_CONTROL];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let control = Self {
            serial_count: fields.integer("serial count")?,
            serial_status: fields.integer("serial status")?,
            spi_count: fields.integer("SPI count")?,
            spi_status: fields.integer("SPI status")?,
            serial_checksum: fields.integer("serial checksum")?,
            spi_checksum: fields.integer("SPI checksum")?,
            error_mode: fields.integer("error mode")?,
        };
        fields.end()?;
        Ok(control)
    }
}

impl WritableValue for ProtocolControl {
    fn register(&self) -> Register {
        Register::PROTOCOL_CONTROL
    }
}

impl fmt::Display for ProtocolControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { serial_count, serial_status, spi_count, spi_status, serial_checksum, spi_checksum, error_mode } =
            self;
        write_list(f, [serial_count, serial_status, spi_count, spi_status, serial_checksum, spi_checksum, error_mode])
    }
}

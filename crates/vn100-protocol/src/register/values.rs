//! The registers of numbers: modes, averaging and mounting of the sensor, and the binary outputs. A
//! mode is kept even if its meaning is not known here.

use alloc::vec::Vec;
use core::fmt;

use super::{Register, RegisterValue, ValueError, WritableValue, fields::FieldReader};
use crate::{
    framing::{checksum::Check, packet},
    packet::{field, header::PacketHeader},
};

/// A register of integers: its type, with the name and the factory default of each field.
macro_rules! whole_numbers {
    ($(#[$doc:meta])* $name:ident = $register:ident {
        $($(#[$field_doc:meta])* $field:ident: $type:ty = $label:literal, $default:literal;)*
    }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }

        impl RegisterValue for $name {
            const REGISTERS: &'static [Register] = &[Register::$register];

            fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
                Ok(Self { $($field: fields.integer($label)?),* })
            }
        }

        impl WritableValue for $name {}

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let fields = [$(&self.$field as &dyn fmt::Display),*];
                for (index, field) in fields.iter().enumerate() {
                    write!(f, "{}{field}", if index > 0 { "," } else { "" })?;
                }
                Ok(())
            }
        }
    };
}

whole_numbers! {
    /// Register 30: suffix fields, checksums and error reports of a port.
    ProtocolControl = PROTOCOL_CONTROL {
        /// The number after `T` on every line: 0 none, 1 SyncIn count, 2 microseconds since SyncIn,
        /// 3 SyncOut count, 4 microseconds since the pulse of a satellite receiver.
        serial_count: u8 = "serial count", 0;
        /// The word after `S` on every line: 0 none, 1 status of the attitude filter; other values
        /// belong to other products.
        serial_status: u8 = "serial status", 0;
        /// The count on the SPI bus.
        spi_count: u8 = "SPI count", 0;
        /// The status on the SPI bus.
        spi_status: u8 = "SPI status", 0;
        /// The check of every line: 1 XOR-8, 3 CRC-16. The maker's documents disagree on other
        /// numbers.
        serial_checksum: u8 = "serial checksum", 1;
        /// The check on the SPI bus.
        spi_checksum: u8 = "SPI checksum", 0;
        /// 0: errors are only counted, and a wrong command is never answered. 1: `VNERR` is sent.
        /// 2: it is sent and turns the port's message off.
        error_mode: u8 = "error mode", 1;
    }
}

impl ProtocolControl {
    /// The check of the sentences of the sensor; `None` for a number that is not known.
    pub fn check(&self) -> Option<Check> {
        match self.serial_checksum {
            1 => Some(Check::Xor8),
            3 => Some(Check::Crc16),
            _ => None,
        }
    }
}

whole_numbers! {
    /// Register 32: the modes of SyncIn and SyncOut.
    SyncControl = SYNC_CONTROL {
        /// The effect of an edge on SyncIn: 3 counts, 4 starts a sample, 5 sends one line, 6 sends
        /// one line of every stream.
        in_mode: u8 = "SyncIn mode", 3;
        /// 0: a rising edge counts, 1: a falling edge.
        in_edge: u8 = "SyncIn edge", 0;
        /// Edges that are skipped between two that count.
        in_skip: u16 = "SyncIn skip factor", 0;
        /// Reserved, 0.
        reserved_in: u32 = "reserved", 0;
        /// The meaning of a pulse on SyncOut: 0 nothing, 1 a sample begins, 2 a sample is ready, 3
        /// an attitude is ready.
        out_mode: u8 = "SyncOut mode", 0;
        /// 0: pulses are low, 1: high.
        out_polarity: u8 = "SyncOut polarity", 0;
        /// Events that are skipped between two pulses: in modes 1 and 2 pulses come at 800 Hz /
        /// (`out_skip` + 1).
        out_skip: u16 = "SyncOut skip factor", 0;
        /// Length of a pulse in nanoseconds.
        out_pulse_ns: u32 = "SyncOut pulse width", 100_000_000;
        /// Reserved, 0.
        reserved_out: u32 = "reserved", 0;
    }
}

whole_numbers! {
    /// Register 85: the moving average of the 800 Hz samples, for each of the sensors inside. A
    /// window is the number of samples averaged; 0 and 1 mean no averaging. A mode tells which
    /// values are averaged: 0 none, 1 the uncompensated, 2 the compensated, 3 both.
    ImuFilter = IMU_FILTER {
        /// Window of the magnetometer, in samples.
        mag_window: u16 = "magnetometer window", 0;
        /// Window of the accelerometer, in samples.
        accel_window: u16 = "accelerometer window", 4;
        /// Window of the gyroscope, in samples.
        gyro_window: u16 = "gyro window", 4;
        /// Window of the thermometer, in samples.
        temperature_window: u16 = "temperature window", 4;
        /// Window of the barometer, in samples.
        pressure_window: u16 = "pressure window", 0;
        /// Mode of the magnetometer.
        mag_mode: u8 = "magnetometer mode", 0;
        /// Mode of the accelerometer.
        accel_mode: u8 = "accelerometer mode", 3;
        /// Mode of the gyroscope.
        gyro_mode: u8 = "gyro mode", 3;
        /// Mode of the thermometer.
        temperature_mode: u8 = "temperature mode", 3;
        /// Mode of the barometer.
        pressure_mode: u8 = "pressure mode", 0;
    }
}

/// Register 26: the rotation from the axes of the sensor to the axes of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceFrameRotation {
    /// The rotation matrix, by rows; it is multiplied by a vector in the axes of the sensor.
    pub matrix: [[f32; 3]; 3],
}

impl RegisterValue for ReferenceFrameRotation {
    const REGISTERS: &'static [Register] = &[Register::ROTATION];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { matrix: [fields.floats("matrix")?, fields.floats("matrix")?, fields.floats("matrix")?] })
    }
}

/// Registers 75 to 77: one output of binary packets.
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
    /// The ports that send packets: 0 none, 1 port 1, 2 port 2, 3 both. Firmware 3 reads the number
    /// as a mask.
    pub async_mode: u16,
    /// A packet is sent once in this many of the 800 samples per second; 0 for packets on request
    /// only.
    pub rate_divisor: u16,
    /// A bit for each group of fields in the packet.
    pub groups: u8,
    /// The fields of each group, the lowest group first.
    pub field_words: Vec<u16>,
}

impl BinaryOutput {
    /// Packets per second on the ports in [`async_mode`](Self::async_mode), in hertz; 0 if none are
    /// sent.
    pub fn rate_hz(&self) -> f64 {
        if self.async_mode == 0 || self.rate_divisor == 0 { 0.0 } else { 800.0 / f64::from(self.rate_divisor) }
    }

    /// The header of the packets: their groups and fields.
    pub fn header(&self) -> PacketHeader {
        PacketHeader::new(self.groups, &self.field_words)
    }

    /// The known fields of a packet by their names in the manual, in the order of the packet.
    pub fn field_names(&self) -> impl Iterator<Item = &'static str> {
        field::present(self.groups, &self.field_words).map(|field| field.name).filter(|name| !name.is_empty())
    }

    /// Length of a packet in bytes; `None` if a group or a field is not known, or if the numbers of
    /// groups and words differ.
    pub fn packet_length(&self) -> Option<usize> {
        packet::length(self.groups, &self.field_words)
    }
}

impl fmt::Display for BinaryOutput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{:02X}", self.async_mode, self.rate_divisor, self.groups)?;
        self.field_words.iter().try_for_each(|word| write!(f, ",{word:04X}"))
    }
}

impl WritableValue for BinaryOutput {}

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

/// A text of hexadecimal digits only: the standard library would accept a sign as well.
fn hexadecimal(text: &str) -> Option<u16> {
    text.bytes().all(|byte| byte.is_ascii_hexdigit()).then(|| u16::from_str_radix(text, 16).ok())?
}

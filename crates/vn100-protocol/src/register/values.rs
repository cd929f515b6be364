//! The registers of numbers: modes, averaging, how this sensor was calibrated and mounted, and the
//! streams of binary packets. A mode is kept even where its meaning is not known here.

use alloc::vec::Vec;
use core::fmt;

use super::{Register, RegisterValue, ValueError, WritableValue, fields::FieldReader};
use crate::{
    framing::{checksum::Check, packet},
    packet::{field, form::PacketHeader},
};

/// A register of whole numbers: its value, with the name and the factory default of each field.
macro_rules! whole_numbers {
    ($(#[$doc:meta])* $name:ident = $register:ident {
        $($(#[$field_doc:meta])* $field:ident: $type:ty = $label:literal, $default:literal;)*
    }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $type,)*
        }

        /// The factory default.
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
        /// The number behind `T` on every line: 0 none, 1 SyncIn count, 2 microseconds since
        /// SyncIn, 3 SyncOut count, 4 microseconds since the pulse of a satellite receiver.
        serial_count: u8 = "serial count", 0;
        /// The word behind `S` on every line: 0 none, 1 status of the attitude filter; others on
        /// other products.
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
        /// 0: errors are counted only, and a wrong command is never answered. 1: `VNERR` is sent.
        /// 2: it is sent and turns the port's message off.
        error_mode: u8 = "error mode", 1;
    }
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

whole_numbers! {
    /// Register 32: the modes of SyncIn and SyncOut.
    SyncControl = SYNC_CONTROL {
        /// What an edge on SyncIn does: 3 counts, 4 starts a sample, 5 sends one line, 6 sends one
        /// of every stream.
        in_mode: u8 = "SyncIn mode", 3;
        /// 0 a rising edge, 1 a falling one.
        in_edge: u8 = "SyncIn edge", 0;
        /// Edges passed over between two that count.
        in_skip: u16 = "SyncIn skip factor", 0;
        /// Reserved, 0.
        reserved_in: u32 = "reserved", 0;
        /// What an edge of SyncOut means: 0 nothing, 1 a sample begins, 2 a sample is ready, 3 an
        /// attitude is ready.
        out_mode: u8 = "SyncOut mode", 0;
        /// 0 pulses go low, 1 high.
        out_polarity: u8 = "SyncOut polarity", 0;
        /// Events passed over between two pulses: their count runs at 800 Hz / (`out_skip` + 1) in
        /// modes 1 and 2.
        out_skip: u16 = "SyncOut skip factor", 0;
        /// The length of a pulse in nanoseconds.
        out_pulse_ns: u32 = "SyncOut pulse width", 100_000_000;
        /// Reserved, 0.
        reserved_out: u32 = "reserved", 0;
    }
}

whole_numbers! {
    /// Register 35: the modes of the attitude filter.
    VpeControl = VPE_CONTROL {
        /// 1 on, 0 off; reserved in firmware 3.
        enable: u8 = "enable", 1;
        /// Where the heading comes from: 0 the magnetometer is trusted, 1 relative, 2 indoor.
        heading_mode: u8 = "heading mode", 1;
        /// Filtering: 0 none, 1 adaptive.
        filtering_mode: u8 = "filtering mode", 1;
        /// Tuning: 0 fixed, 1 adaptive.
        tuning_mode: u8 = "tuning mode", 1;
    }
}

whole_numbers! {
    /// Register 85: the moving average of the 800 Hz samples, for each sensor inside. A window is
    /// the samples averaged, of which 0 and 1 are none but the last; a mode says which values are
    /// averaged: 0 none, 1 the uncompensated, 2 the compensated, 3 both.
    ImuFilter = IMU_FILTER {
        /// Of the magnetometer.
        mag_window: u16 = "magnetometer window", 0;
        /// Of the accelerometer.
        accel_window: u16 = "accelerometer window", 4;
        /// Of the gyro.
        gyro_window: u16 = "gyro window", 4;
        /// Of the thermometer.
        temperature_window: u16 = "temperature window", 4;
        /// Of the barometer.
        pressure_window: u16 = "pressure window", 0;
        /// Of the magnetometer.
        mag_mode: u8 = "magnetometer mode", 0;
        /// Of the accelerometer.
        accel_mode: u8 = "accelerometer mode", 3;
        /// Of the gyro.
        gyro_mode: u8 = "gyro mode", 3;
        /// Of the thermometer.
        temperature_mode: u8 = "temperature mode", 3;
        /// Of the barometer.
        pressure_mode: u8 = "pressure mode", 0;
    }
}

/// Registers 23, 25 and 84: the user's calibration of one sensor, y = C (x - b).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// C by rows.
    pub matrix: [[f32; 3]; 3],
    /// b along x, y, z: gauss, m/s² or rad/s.
    pub offset: [f32; 3],
}

impl RegisterValue for Calibration {
    const REGISTERS: &'static [Register] =
        &[Register::MAG_CALIBRATION, Register::ACCEL_CALIBRATION, Register::GYRO_CALIBRATION];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { matrix: matrix(fields)?, offset: fields.floats("offset")? })
    }
}

/// Register 26: from the axes of the sensor to those of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceFrameRotation {
    /// The matrix by rows.
    pub matrix: [[f32; 3]; 3],
}

impl RegisterValue for ReferenceFrameRotation {
    const REGISTERS: &'static [Register] = &[Register::ROTATION];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { matrix: matrix(fields)? })
    }
}

/// Register 43: the bias of the angular rate that the attitude filter starts with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartupGyroBias {
    /// About x, y, z in rad/s.
    pub bias_rad_s: [f32; 3],
}

impl RegisterValue for StartupGyroBias {
    const REGISTERS: &'static [Register] = &[Register::STARTUP_GYRO_BIAS];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { bias_rad_s: fields.floats("bias")? })
    }
}

fn matrix(fields: &mut FieldReader<'_>) -> Result<[[f32; 3]; 3], ValueError> {
    Ok([fields.floats("matrix")?, fields.floats("matrix")?, fields.floats("matrix")?])
}

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

    /// What its packets begin with.
    #[must_use]
    pub fn header(&self) -> PacketHeader {
        PacketHeader::new(self.groups, &self.field_words)
    }

    /// The known fields of a packet by their names in the manual, in the order of the wire.
    pub fn field_names(&self) -> impl Iterator<Item = &'static str> {
        field::present(self.groups, &self.field_words).map(|field| field.name).filter(|name| !name.is_empty())
    }

    /// The bytes of a packet; `None` where a group or a field is not known, or their numbers do not
    /// go together.
    #[must_use]
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

/// Hexadecimal digits alone: the standard library would take a sign, too.
fn hexadecimal(text: &str) -> Option<u16> {
    text.bytes().all(|byte| byte.is_ascii_hexdigit()).then(|| u16::from_str_radix(text, 16).ok())?
}

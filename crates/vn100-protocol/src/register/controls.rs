//! Registers 30, 32 and 35: modes, each a whole number, which is kept even where its meaning is not
//! known here.

use core::fmt;

use super::{Register, RegisterValue, ValueError, WritableValue, field_reader::FieldReader, write_list};
use crate::framing::checksum::Check;

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
                write_list(f, [$(&self.$field as &dyn fmt::Display),*])
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

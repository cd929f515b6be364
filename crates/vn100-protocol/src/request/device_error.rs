//! The errors that the sensor reports: the codes of `$VNERR`.

use core::fmt;

/// Name, code and meaning of each error.
macro_rules! device_errors {
    ($($name:ident = $code:literal, $meaning:literal;)*) => {
        /// An error that the sensor reports, by its code in `$VNERR,cc` (two hexadecimal digits;
        /// UM001, 0A to 0C as sent by firmware 3).
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum DeviceError {
            $(#[doc = concat!(stringify!($code), ": ", $meaning, ".")]
            $name,)*
            /// A code that is in no edition of the manual.
            Unknown(u8),
        }

        impl DeviceError {
            /// The errors in the manual, by code.
            pub(crate) const KNOWN: [Self; [$($code),*].len()] = [$(Self::$name),*];

            /// The error with this code.
            pub fn from_code(code: u8) -> Self {
                match code {
                    $($code => Self::$name,)*
                    code => Self::Unknown(code),
                }
            }

            /// The code of the error.
            pub fn code(self) -> u8 {
                match self {
                    $(Self::$name => $code,)*
                    Self::Unknown(code) => code,
                }
            }

            /// The meaning, in a few words.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$name => $meaning,)*
                    Self::Unknown(_) => "an error code that no manual documents",
                }
            }
        }
    };
}

device_errors! {
    HardFault = 0x01, "the sensor had a fault and restarts";
    ReceiveBufferOverflow = 0x02, "the receive buffer of the sensor overflowed";
    InvalidChecksum = 0x03, "the command arrived with a wrong checksum";
    InvalidCommand = 0x04, "the sensor does not know the command";
    TooFewParameters = 0x05, "the command has too few fields";
    TooManyParameters = 0x06, "the command has too many fields";
    InvalidParameter = 0x07, "a value of the command is not allowed";
    InvalidRegister = 0x08, "the sensor does not have the register";
    Unauthorized = 0x09, "the sensor does not permit it";
    WatchdogReset = 0x0A, "the sensor was restarted by its watchdog";
    OutputBufferOverflow = 0x0B, "the output exceeds the baud rate";
    InsufficientBaudRate = 0x0C, "the baud rate is too low for the requested output";
    ErrorBufferOverflow = 0xFF, "the sensor had more errors than it could report";
}

impl DeviceError {
    /// Whether the sensor reports this error by itself; all other errors answer a command, as far
    /// as known.
    pub fn is_unsolicited(self) -> bool {
        matches!(self, Self::HardFault | Self::WatchdogReset | Self::OutputBufferOverflow | Self::ErrorBufferOverflow)
    }

    /// Whether the command was damaged in transmission, so that the sensor has not executed it but
    /// may execute it when it is sent again.
    pub(crate) fn is_transmission_fault(self) -> bool {
        matches!(self, Self::ReceiveBufferOverflow | Self::InvalidChecksum)
    }

    /// The possible remedy for the user, in words.
    pub fn advice(self) -> &'static str {
        match self {
            Self::HardFault | Self::WatchdogReset => {
                "check the supply voltage; settings that were not saved are lost, so write them again"
            }
            Self::ReceiveBufferOverflow => "send one command at a time, and at most 256 characters",
            Self::InvalidChecksum => "pause the output before writing",
            Self::InvalidCommand => "this firmware may not support the command",
            Self::TooFewParameters | Self::TooManyParameters => {
                "read the register first: its fields may differ in this firmware"
            }
            Self::InvalidParameter => "use values that the register accepts in this model and firmware",
            Self::InvalidRegister => "this model and firmware lack the feature",
            Self::Unauthorized => "the register may be read-only",
            Self::OutputBufferOverflow => "lower the output rate, choose a shorter message or raise the baud rate",
            Self::InsufficientBaudRate => {
                "bytes per second of all outputs may be a tenth of the baud rate at most: raise \
                 the baud rate before the output rate, and turn an output off before turning on another"
            }
            Self::ErrorBufferOverflow => "look at the errors before this one",
            Self::Unknown(_) => "look up the code in the manual of this firmware",
        }
    }
}

/// The code and the meaning: `VNERR 0C: the baud rate is too low for the requested output`; an
/// unknown code as `0x12`.
impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(code) => write!(f, "VNERR 0x{code:02X}: {}", self.meaning()),
            known => write!(f, "VNERR {:02X}: {}", known.code(), known.meaning()),
        }
    }
}

impl core::error::Error for DeviceError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_kept() {
        for code in 0..=u8::MAX {
            assert_eq!(DeviceError::from_code(code).code(), code);
        }
    }

    #[test]
    fn four_codes_are_unsolicited() {
        let unsolicited: Vec<_> = (0..=u8::MAX).filter(|&code| DeviceError::from_code(code).is_unsolicited()).collect();
        assert_eq!(unsolicited, [0x01, 0x0A, 0x0B, 0xFF]);
    }

    #[test]
    fn codes_are_shown_as_sent() {
        assert_eq!(
            DeviceError::from_code(0x0C).to_string(),
            "VNERR 0C: the baud rate is too low for the requested output"
        );
        assert!(DeviceError::from_code(0x12).to_string().starts_with("VNERR 0x12: "));
    }
}

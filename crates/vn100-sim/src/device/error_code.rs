//! What `$VNERR` reports.

/// An error as two hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ErrorCode {
    HardFault = 0x01,
    InputOverflow = 0x02,
    Checksum = 0x03,
    UnknownCommand = 0x04,
    TooFewParameters = 0x05,
    TooManyParameters = 0x06,
    Parameter = 0x07,
    Register = 0x08,
    NotPermitted = 0x09,
    OutputOverflow = 0x0B,
    InsufficientBaud = 0x0C,
}

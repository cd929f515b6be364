//! The load of a port: whether its sentences and packets fit the baud rate.

use core::{iter::Sum, ops::Add};

use crate::{
    framing::checksum::Check,
    message::layout::OUTPUT_RATES_HZ,
    register::{AsyncRate, AsyncType, BaudRate, BinaryOutput, ProtocolControl},
};

/// The load of the outputs of a port, in bytes per second.
///
/// The sensor refuses a setting with a load above a tenth of the baud rate, by
/// [`InsufficientBaudRate`](crate::DeviceError::InsufficientBaudRate): this rule explains all
/// accepted and refused settings on record for firmware 3.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct LinkLoad {
    /// Bytes per second, not negative.
    pub bytes_per_s: f64,
}

impl AsyncType {
    /// The usual length of a sentence in bytes, CR and LF included, with the count, the status and the
    /// check of register 30; an unknown kind of check is counted as the longer one. 0 for
    /// [`OFF`](Self::OFF), `None` if the length is not known.
    pub fn line_length(self, control: &ProtocolControl) -> Option<u32> {
        let check = if control.check() == Some(Check::Xor8) { 3 } else { 5 };
        let (has_count, has_status) = (control.serial_count != 0, control.serial_status != 0);
        match self.usual_length()? {
            0 => Some(0),
            length => Some(length - 3 + check + 12 * u32::from(has_count) + 6 * u32::from(has_status)),
        }
    }
}

impl LinkLoad {
    /// The load of no output.
    pub const NONE: Self = Self { bytes_per_s: 0.0 };

    /// The load of sentences of `length` bytes, CR and LF included.
    pub fn of_lines(length: u32, rate: AsyncRate) -> Self {
        Self { bytes_per_s: f64::from(length) * f64::from(rate.hz()) }
    }

    /// The load of the packets of a binary output on its port; `None` if packets of unknown length
    /// are sent.
    pub fn of_packets(output: &BinaryOutput) -> Option<Self> {
        match output.rate_hz() {
            0.0 => Some(Self::NONE),
            rate_hz => Some(Self { bytes_per_s: output.packet_length()? as f64 * rate_hz }),
        }
    }

    /// Whether the sensor accepts this load at `baud_rate`.
    pub fn fits(self, baud_rate: BaudRate) -> bool {
        self.bytes_per_s * 10.0 <= f64::from(baud_rate.bits_per_s())
    }

    /// The lowest baud rate with room for this load; `None` if there is none.
    pub fn lowest_baud_rate(self) -> Option<BaudRate> {
        BaudRate::ALL.into_iter().find(|&baud_rate| self.fits(baud_rate))
    }

    /// The highest rate at which sentences of `length` bytes fit in addition to this load; `None`
    /// if not even 1 Hz does.
    pub fn highest_rate_beside(self, length: u32, baud_rate: BaudRate) -> Option<AsyncRate> {
        let fits = |rate: &AsyncRate| (self + Self::of_lines(length, *rate)).fits(baud_rate);
        OUTPUT_RATES_HZ.into_iter().rev().filter_map(AsyncRate::new).find(fits)
    }
}

impl Add for LinkLoad {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { bytes_per_s: self.bytes_per_s + other.bytes_per_s }
    }
}

impl Sum for LinkLoad {
    fn sum<I: Iterator<Item = Self>>(loads: I) -> Self {
        loads.fold(Self::NONE, Add::add)
    }
}

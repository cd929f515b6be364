//! What a port carries: whether lines and packets fit its baud rate.

use core::{iter::Sum, ops::Add};

use crate::{
    framing::checksum::Check,
    message::layout::OUTPUT_RATES_HZ,
    register::{AsyncRate, AsyncType, BaudRate, BinaryOutput, ProtocolControl},
};

/// The bytes per second of the outputs of a port.
///
/// The sensor refuses a setting by which they would be more than a tenth of the baud rate, with
/// [`InsufficientBaudRate`](crate::DeviceError::InsufficientBaudRate): the rule that explains all
/// accepted and refused settings that are on record for firmware 3.
///
/// ```
/// use vn100_protocol::{AsyncRate, AsyncType, BaudRate, LineForm, LinkLoad};
///
/// let ymr = AsyncType::YMR.line_length(LineForm::default()).unwrap();
/// let load = LinkLoad::of_lines(ymr, AsyncRate::new(100).unwrap());
/// assert!(!load.fits(BaudRate::DEFAULT)); // 12200 bytes a second and room for 11520
/// assert_eq!(load.lowest_baud_rate(), BaudRate::new(128_000));
/// assert_eq!(LinkLoad::NONE.highest_rate_beside(ymr, BaudRate::DEFAULT), AsyncRate::new(50));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct LinkLoad {
    /// Bytes per second.
    pub bytes_per_s: f64,
}

/// What register 30 adds to every line; the default, no suffix and XOR-8, is that of the factory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LineForm {
    /// `,T` with ten digits.
    pub count: bool,
    /// `,S` with four digits.
    pub status: bool,
    /// What protects the line.
    pub check: Check,
}

/// An unknown kind of check counts as the longer one.
impl From<&ProtocolControl> for LineForm {
    fn from(control: &ProtocolControl) -> Self {
        Self {
            count: control.serial_count != 0,
            status: control.serial_status != 0,
            check: control.check().unwrap_or(Check::Crc16),
        }
    }
}

impl AsyncType {
    /// The usual length of a line of this form in bytes; 0 for [`OFF`](Self::OFF), `None` where it
    /// is not known.
    #[must_use]
    pub fn line_length(self, form: LineForm) -> Option<u32> {
        let check = match form.check {
            Check::Xor8 => 3,
            Check::Crc16 => 5,
            Check::None => 0,
        };
        match self.usual_length()? {
            0 => Some(0),
            length => Some(length - 3 + check + 12 * u32::from(form.count) + 6 * u32::from(form.status)),
        }
    }
}

impl LinkLoad {
    /// Nothing is sent.
    pub const NONE: Self = Self { bytes_per_s: 0.0 };

    /// Lines of `length` bytes, CR and LF included.
    #[must_use]
    pub fn of_lines(length: u32, rate: AsyncRate) -> Self {
        Self { bytes_per_s: f64::from(length) * f64::from(rate.hz()) }
    }

    /// The packets of a binary output on a port to which it goes; `None` where they are sent, but
    /// their length is not known.
    #[must_use]
    pub fn of_packets(output: &BinaryOutput) -> Option<Self> {
        match output.rate_hz() {
            0.0 => Some(Self::NONE),
            rate_hz => Some(Self { bytes_per_s: output.packet_length()? as f64 * rate_hz }),
        }
    }

    /// Whether the sensor takes so much at `baud_rate`.
    #[must_use]
    pub fn fits(self, baud_rate: BaudRate) -> bool {
        self.bytes_per_s * 10.0 <= f64::from(baud_rate.bits_per_s())
    }

    /// The lowest baud rate that carries it; `None` when none does.
    #[must_use]
    pub fn lowest_baud_rate(self) -> Option<BaudRate> {
        BaudRate::ALL.into_iter().find(|&baud_rate| self.fits(baud_rate))
    }

    /// The highest rate at which lines of `length` bytes fit beside this; `None` when not even 1 Hz
    /// does.
    #[must_use]
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

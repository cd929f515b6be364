//! The two ways in which firmware prints numbers.

use crate::message::layout::{Channel, Quantity};

/// How many digits the numbers of a sentence have.
///
/// | | angles | magnetic field | acceleration | angular rate |
/// |---|---|---|---|---|
/// | `Current` | `+ddd.ddd` | `+dd.dddd` | `+dd.ddd` | `+dd.dddddd` |
/// | `Old` (firmware 1 and earlier) | `+ddd.dd` | `+d.dddd` | `+dd.ddd` | `+dd.dddd` |
///
/// The whole digits are a minimum: a larger value takes more. Counts are always in the decimals of
/// the layout: those of an old sentence are multiplied by 10 or 100, which is exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PrintFormat {
    /// Firmware 2 and 3; also every sentence with a temperature or a pressure.
    Current,
    /// Old firmware.
    Old,
}

impl PrintFormat {
    /// The decimals printed for `channel`.
    #[must_use]
    pub const fn decimals(self, channel: &Channel) -> u8 {
        match (self, channel.quantity) {
            (Self::Old, Quantity::Angle) => 2,
            (Self::Old, Quantity::AngularRate) => 4,
            _ => channel.decimals,
        }
    }

    /// Whether a message of these channels is printed so: how old firmware printed temperature and
    /// pressure is not on record.
    pub(super) const fn covers(self, channels: &[Channel]) -> bool {
        let mut index = 0;
        while index < channels.len() {
            if matches!((self, channels[index].quantity), (Self::Old, Quantity::Temperature | Quantity::Pressure)) {
                return false;
            }
            index += 1;
        }
        true
    }
}

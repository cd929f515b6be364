//! The two ways in which firmware prints `$VNYMR`.

use crate::message::layout::Channel;

/// How many digits the numbers of a line have.
///
/// | | angles | magnetic field | acceleration | angular rate |
/// |---|---|---|---|---|
/// | `Current` | `+ddd.ddd` | `+dd.dddd` | `+dd.ddd` | `+dd.dddddd` |
/// | `Old` (firmware 1 and earlier) | `+ddd.dd` | `+d.dddd` | `+dd.ddd` | `+dd.dddd` |
///
/// The whole digits are a minimum: a larger value takes more. Counts are always in the decimals of
/// the layout: those of an old line are multiplied by 10 or 100, which is exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PrintFormat {
    /// Firmware 2 and 3; also everything in `$VNIMU`.
    Current,
    /// Old firmware.
    Old,
}

/// The digits of one printed number.
pub(crate) struct FieldForm {
    pub(crate) whole_digits: usize,
    pub(crate) decimals: u8,
}

impl PrintFormat {
    /// The decimals printed for `channel`, number `index` of its layout.
    #[must_use]
    pub fn decimals(self, index: usize, channel: &Channel) -> u8 {
        match self {
            Self::Current => channel.decimals,
            Self::Old => OLD_YMR.get(index).map_or(channel.decimals, |form| form.decimals),
        }
    }

    pub(crate) fn ymr_forms(self) -> &'static [FieldForm; 12] {
        match self {
            Self::Current => &CURRENT_YMR,
            Self::Old => &OLD_YMR,
        }
    }
}

const CURRENT_YMR: [FieldForm; 12] = {
    const A: FieldForm = form(3, 3);
    const M: FieldForm = form(2, 4);
    const F: FieldForm = form(2, 3);
    const R: FieldForm = form(2, 6);
    [A, A, A, M, M, M, F, F, F, R, R, R]
};

const OLD_YMR: [FieldForm; 12] = {
    const A: FieldForm = form(3, 2);
    const M: FieldForm = form(1, 4);
    const F: FieldForm = form(2, 3);
    const R: FieldForm = form(2, 4);
    [A, A, A, M, M, M, F, F, F, R, R, R]
};

const fn form(whole_digits: usize, decimals: u8) -> FieldForm {
    FieldForm { whole_digits, decimals }
}

//! The warnings for unsolicited device errors.

use vn100_protocol::DeviceError;
use vn100_protocol::stream::UnsolicitedErrors;

use super::counted;
use crate::warning::{Warning, WarningKind};

/// One for each code.
pub(super) fn warnings(errors: &UnsolicitedErrors) -> impl Iterator<Item = Warning> {
    errors.iter().map(|(error, count)| {
        let said = format!("the sensor said unasked, {}, {error}", counted(count, "time"));
        let (kind, text) = match error {
            DeviceError::OutputBufferOverflow => (
                WarningKind::LinkBudget,
                format!("{said}: it leaves out what finds no room, and the record lacks it. To cure it {}", error.advice()),
            ),
            _ if error.is_unsolicited() => (WarningKind::DeviceErrors, format!("{said}: {}", error.advice())),
            _ => (
                WarningKind::DeviceErrors,
                format!(
                    "{said}. That is what it says to a command, and none was sent from here: look for another program on the line, and for \
                     noise on the wire to the sensor"
                ),
            ),
        };
        Warning::new(kind, Vec::new(), text)
    })
}

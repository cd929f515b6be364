//! The question of the baud scan, and its copies on a line that echoes.

use vn100_protocol::{Register, SensorCommand};

/// The question: every firmware answers a read of register 1.
pub(crate) const QUESTION: SensorCommand = SensorCommand::ReadRegister(Register::MODEL);

/// Length of the question on the line, `$VNRRG,01*72\r\n`.
const QUESTION_BYTES: u64 = 14;

/// The number of bytes that are not part of these copies of the question.
pub(crate) const fn without_echoes(bytes: u64, echoes: u64) -> u64 {
    bytes.saturating_sub(echoes * QUESTION_BYTES)
}

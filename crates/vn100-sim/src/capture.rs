//! Many samples as a file.

use std::io::{self, Write};

use crate::{
    generator::Generator,
    sentence::{write_imu_sentence, write_sentence},
};

/// A message that a capture can hold.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum CaptureMessage {
    /// `$VNYMR`. The angular rates are those of the profile: no filter has its hand in them.
    #[default]
    Ymr,
    /// `$VNIMU`, with temperature and pressure of a sensor that has warmed up.
    Imu,
}

impl CaptureMessage {
    /// Appends the generator's next row as a sentence.
    pub fn write_next(self, line: &mut Vec<u8>, generator: &mut Generator) {
        let row = generator.next_row();
        match self {
            Self::Ymr => write_sentence(line, &row),
            Self::Imu => write_imu_sentence(line, &row, generator.next_surroundings()),
        }
    }
}

/// Writes the next `samples` rows of the generator, one sentence each; zero writes nothing.
///
/// Each sentence is one write: give a buffered writer, and flush it.
///
/// # Errors
/// The first error of the writer; what was written until then stays.
pub fn write_capture(
    out: &mut impl Write,
    generator: &mut Generator,
    message: CaptureMessage,
    samples: u64,
) -> io::Result<()> {
    let mut line = Vec::new();
    for _ in 0..samples {
        line.clear();
        message.write_next(&mut line, generator);
        out.write_all(&line)?;
    }
    Ok(())
}

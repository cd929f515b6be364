//! Many samples as a file.

use std::io::{self, Write};

use crate::{generator::Generator, sentence::write_sentence};

/// Writes the next `samples` rows of the generator, one sentence each; zero writes nothing.
///
/// Each sentence is one write: give a buffered writer, and flush it.
///
/// # Errors
/// The first error of the writer; what was written until then stays.
pub fn write_capture(out: &mut impl Write, generator: &mut Generator, samples: u64) -> io::Result<()> {
    let mut line = Vec::new();
    for _ in 0..samples {
        line.clear();
        write_sentence(&mut line, &generator.next_row());
        out.write_all(&line)?;
    }
    Ok(())
}

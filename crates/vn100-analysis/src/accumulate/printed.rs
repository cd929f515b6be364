//! How the sensor printed its numbers.

use state_bytes::{BadEncoding, ByteReader, Encoded};
use vn100_protocol::PrintFormat;

/// The formats of a stream: the format before its first row, and each change of it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Printed {
    /// The first format and the present one.
    formats: Option<(PrintFormat, PrintFormat)>,
    pub(super) coarsest: PrintFormat,
    pub(super) changes: u64,
}

impl Printed {
    /// Adds a format. Returns whether the format changes: values of different resolutions are not
    /// comparable in their last digits.
    pub(crate) fn push(&mut self, format: PrintFormat) -> bool {
        if format != PrintFormat::Current {
            self.coarsest = format;
        }
        let before = self.formats;
        self.formats = Some((before.map_or(format, |(first, _)| first), format));
        self.changes += u64::from(before.is_some());
        before.is_some()
    }

    /// Whether the first row of the next piece is printed in another format than the last row here.
    pub(crate) fn changes_to(&self, next: &Self) -> bool {
        self.formats.zip(next.formats).is_some_and(|((_, last), (first, _))| last != first)
    }

    /// Appends the next piece.
    pub(crate) fn append(&mut self, next: &Self) {
        self.changes += next.changes + u64::from(self.changes_to(next));
        if next.coarsest != PrintFormat::Current {
            self.coarsest = next.coarsest;
        }
        self.formats = match (self.formats, next.formats) {
            (Some((first, _)), Some((_, last))) => Some((first, last)),
            (ours, theirs) => ours.or(theirs),
        };
    }
}

/// The number of a format in bytes: whether it is the old one.
fn is_old(format: PrintFormat) -> bool {
    format == PrintFormat::Old
}

fn format(is_old: bool) -> PrintFormat {
    if is_old { PrintFormat::Old } else { PrintFormat::Current }
}

impl Encoded for Printed {
    fn encode(&self, out: &mut Vec<u8>) {
        self.formats.map(|(first, last)| (is_old(first), is_old(last))).encode(out);
        is_old(self.coarsest).encode(out);
        self.changes.encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        Ok(Self {
            formats: Option::<(bool, bool)>::decode(input)?.map(|(first, last)| (format(first), format(last))),
            coarsest: format(Encoded::decode(input)?),
            changes: Encoded::decode(input)?,
        })
    }
}

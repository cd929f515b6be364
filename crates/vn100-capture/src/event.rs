//! What a source of samples delivers to its owner.

use std::io;

use vn100_protocol::stream::{Batch, CsvReport, LinkEvent, SampleReader, StreamInput};

/// One thing that happened on a stream, in the order it happened.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly every event is a batch, and one is moved for each read")]
pub enum Event {
    /// What one read brought.
    Batch(Batch),
    /// A change of the link to a live sensor, or of the one that was recorded. The counts of the
    /// batch before it contain it.
    Link(LinkEvent),
    /// The stream is over; nothing follows.
    End(End),
}

impl Event {
    /// The events that follow from what a source delivered.
    pub fn from_input(reader: &mut SampleReader, input: StreamInput) -> impl Iterator<Item = Self> + use<> {
        let link_event = reader.take_input(input);
        reader.take_batches().into_iter().map(Self::Batch).chain(link_event.map(Self::Link))
    }
}

/// How a stream ended.
#[derive(Debug)]
pub struct End {
    /// The error that ended it; `None` at the end of the data, or when it was stopped.
    pub error: Option<io::Error>,
    /// What became of the lines, where the source is a CSV file.
    pub csv: Option<CsvReport>,
}

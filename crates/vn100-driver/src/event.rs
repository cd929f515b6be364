//! What a source of samples tells its owner.

use std::{fmt, io, sync::Arc};

use vn100_protocol::{Layout, PrintFormat, RegisterContents, Tally};

use crate::{csv::OddRowCounts, diagnostic::Diagnostic, source::LinkEvent, unasked_errors::UnaskedErrors};

/// One thing that happened on a stream, in the order it happened.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly every event is a batch, and one is moved for each read")]
pub enum Event {
    /// What one read brought.
    Batch(Batch),
    /// Something befell the link to a live sensor, or the one that a recording was made of. What it
    /// changes in the counts, the batch before it tells.
    Link(LinkEvent),
    /// The stream is over; nothing follows.
    End(End),
}

/// Everything that one read completed: samples, and between them the places where something else
/// was.
///
/// One batch per read, never one per sample: the price of handing it over is paid once.
#[derive(Debug, Clone, Default)]
pub struct Batch {
    /// The message these samples came in; `None` while the stream has shown none.
    pub layout: Option<Arc<Layout>>,
    /// The samples, one row of exact integer counts per line, in the order of `layout`; each count
    /// is in units of its channel's last decimal.
    pub counts: Vec<i32>,
    /// When the rows arrived, in the order of the rows; empty where the source does not know.
    pub arrivals: Vec<Arrival>,
    /// The counters of the rows that carry one, in order.
    pub counters: Vec<RowCounter>,
    /// What stood between the rows, by position.
    pub marks: Vec<Mark>,
    /// What the sensor said of its registers, in order.
    pub registers: Vec<RegisterValue>,
    /// What passed beside the samples, in order; empty unless [`ReadOptions`](crate::ReadOptions)
    /// ask for it.
    pub diagnostics: Vec<Diagnostic>,
    /// All that the stream has carried from its beginning to the end of this batch.
    pub link: LinkCounts,
}

impl Batch {
    /// The samples, one slice of counts each.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[i32]> {
        // a batch without a layout has no counts, so that the width of a row does not matter
        self.counts.chunks_exact(self.layout.as_ref().map_or(1, |layout| layout.channels.len()))
    }

    /// How many samples.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.rows().len()
    }
}

/// When rows of a [`Batch`] arrived: those from here to the next arrival came with one read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// The first of them.
    pub from_row: usize,
    /// The time of the read, in nanoseconds from an origin of the source's choice. A recording may
    /// hold stamps that go backwards.
    pub at_ns: i64,
}

/// The counter that a line carried behind its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowCounter {
    /// The row.
    pub row: usize,
    /// The counter; what it counts, register 30 of the sensor says.
    pub count: u64,
}

/// What the sensor said of one of its registers, in reply to a command: the value read, or the one
/// just written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RegisterValue {
    /// The row it stands before; the number of rows for the end of the batch.
    pub before_row: usize,
    /// The number of the register.
    pub register: u8,
    /// Its fields as printed, with the commas between them.
    pub fields: String,
}

impl RegisterValue {
    pub(crate) fn new(contents: &RegisterContents, before_row: usize) -> Self {
        Self { before_row, register: contents.register.0, fields: contents.fields.to_string() }
    }
}

/// Something between two rows of a [`Batch`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// The row it stands before; the number of rows for the end of the batch.
    pub before_row: usize,
    /// What it is.
    pub kind: MarkKind,
}

/// What a [`Mark`] marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkKind {
    /// A line that was not let in; the tally says why.
    BadLine,
    /// From here on the sensor prints so; stands before the first row, and wherever that changes.
    Printed(PrintFormat),
}

/// What a stream has carried so far, byte by byte and line by line.
///
/// In a CSV file a row is a line, good or bad, with all its columns and its line end; header,
/// comments and blank lines are skipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// The parser's own count; its byte classes add up to the bytes read.
    pub tally: Tally,
    /// Lines of a measurement other than the one this stream began with; part of the good lines,
    /// not of the samples.
    pub foreign_samples: u64,
    /// Bytes that came while the speed of the line was looked for; not in the tally.
    pub probed_bytes: u64,
    /// Bytes known to be lost between the port and this program.
    pub overrun_bytes: u64,
    /// Questions of the host that the line brought back; part of the tally's replies, and no
    /// answers.
    pub echoes: u64,
    /// Errors that the sensor told without having been asked anything they answer.
    pub unasked_errors: UnaskedErrors,
    /// How often its output was found paused by somebody else, and was made to go on.
    pub outputs_resumed: u64,
    /// How often the link came up; 0 for a capture that has no link.
    pub connects: u64,
    /// The first good sentence that is neither a sample of this stream nor a reply.
    pub other_message: Option<MessageName>,
    /// Rows of a CSV file that were not let in; they are part of the bad lines. `None` where the
    /// source is none.
    pub odd_rows: Option<OddRowCounts>,
}

impl LinkCounts {
    /// Samples handed out.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.tally.samples - self.foreign_samples
    }

    /// Bytes that came in.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.tally.bytes() + self.probed_bytes
    }

    /// Bytes in which no line was, or none was looked for.
    #[must_use]
    pub fn skipped_bytes(&self) -> u64 {
        self.tally.skipped_bytes + self.probed_bytes
    }

    /// What the sensor said to commands, or of an error.
    #[must_use]
    pub fn answers(&self) -> u64 {
        self.tally.replies - self.echoes
    }

    /// Good sentences that are neither samples of this stream nor replies.
    #[must_use]
    pub fn other_messages(&self) -> u64 {
        self.tally.other + self.foreign_samples
    }
}

/// The name of a message, such as `VNYPR`; at most eight bytes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MessageName {
    // printable ASCII, filled up with spaces
    bytes: [u8; 8],
}

impl MessageName {
    pub(crate) fn new(header: &[u8]) -> Self {
        let mut bytes = [b' '; 8];
        bytes.iter_mut().zip(header).for_each(|(to, from)| *to = *from);
        Self { bytes }
    }
}

impl fmt::Display for MessageName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(String::from_utf8_lossy(&self.bytes).trim_end())
    }
}

/// How a stream ended.
#[derive(Debug)]
pub struct End {
    /// The error that ended it; `None` at the end of the data, or when it was told to stop.
    pub error: Option<io::Error>,
    /// What became of the lines, where the source is a CSV file.
    pub csv: Option<CsvReport>,
}

/// The lines of a CSV file, each counted once: `lines = rows + skipped_lines + all odd`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CsvReport {
    /// All lines.
    pub lines: u64,
    /// Rows that were understood.
    pub rows: u64,
    /// Header, comments and blank lines.
    pub skipped_lines: u64,
    /// Rows that were not let in, by reason.
    pub odd: Vec<OddRows>,
    /// Columns that are not used, by their names in the file.
    pub ignored_columns: Vec<String>,
    /// Channels whose last digits are rounded away, because they have more than a count can hold.
    pub rounded: Vec<String>,
}

/// Rows of a CSV file that were not let in for one reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OddRows {
    /// `fields`, `number`, `decimals`, `range`, `stamp`, `length` or `truncated`.
    pub reason: String,
    /// How many.
    pub count: u64,
    /// Number of the first such line, from 1.
    pub first_line: u64,
    /// Its beginning.
    pub first_text: String,
}

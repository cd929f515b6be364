//! Batches: what one read completed.

use alloc::{boxed::Box, string::String, sync::Arc, vec::Vec};
use core::{fmt, mem};

use super::StreamCounts;
use crate::{Layout, PrintFormat, RegisterContents, Tally};

/// Everything that one read completed: samples, and between them the places where something else
/// was.
///
/// One batch per read, never one per sample: the price of handing it over is paid once.
#[derive(Debug, Clone, Default)]
pub struct Batch {
    /// The message these samples came in; `None` while the stream has shown none.
    pub layout: Option<Arc<Layout>>,
    /// The samples, one row of exact integer counts each, in the order of `layout`; what a count is
    /// worth stands in its channel.
    pub counts: Vec<i32>,
    /// The cells of `counts` that have no value, in the order of the rows and of their channels: an
    /// empty field of a CSV file, or one that is no number. Their counts are 0 and mean nothing.
    pub absent: Vec<AbsentCell>,
    /// When the rows arrived, in the order of the rows; empty where the source does not know.
    pub arrivals: Vec<Arrival>,
    /// The counters of the rows that carry one, in order.
    pub counters: Vec<RowCounter>,
    /// When the sensor measured each row, in nanoseconds since it started; empty where rows do not
    /// carry their device time.
    pub device_ns: Vec<u64>,
    /// What stood between the rows, by position.
    pub marks: Vec<Mark>,
    /// What the sensor said of its registers in reply to commands, in order: the values read, and
    /// those just written.
    pub registers: Vec<RegisterContents>,
    /// What passed beside the samples, in order; empty unless
    /// [`ReadOptions`](super::ReadOptions) ask for it.
    pub diagnostics: Vec<Diagnostic>,
    /// All that the stream has carried from its beginning to the end of this batch.
    pub link: StreamCounts,
    /// What the parser had counted at the end of each row, where
    /// [`ReadOptions`](super::ReadOptions) ask for it and there are two rows or more. Marks,
    /// registers and diagnostics are those before the first row then.
    pub tallies: Vec<Tally>,
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

    /// Whether the row lacks the channel at this place of the layout.
    #[must_use]
    pub fn is_absent(&self, row: usize, channel: usize) -> bool {
        self.absent.binary_search_by_key(&(row, channel), |cell| (cell.row, cell.channel)).is_ok()
    }

    /// Its rows, each as a batch of its own where there are [`tallies`](Self::tallies) of each;
    /// else all in one.
    #[must_use]
    pub fn lines(mut self) -> SingleRows {
        let line = match self.tallies.is_empty() {
            true => Self::default(),
            false => Self {
                layout: self.layout.clone(),
                marks: mem::take(&mut self.marks),
                registers: mem::take(&mut self.registers),
                diagnostics: mem::take(&mut self.diagnostics),
                link: self.link,
                ..Self::default()
            },
        };
        SingleRows { batch: self, next: 0, line }
    }
}

/// The rows of a [`Batch`] one by one.
#[derive(Debug)]
pub struct SingleRows {
    batch: Batch,
    next: usize,
    line: Batch,
}

impl SingleRows {
    /// The next one; `None` behind the last.
    pub fn next_line(&mut self) -> Option<&Batch> {
        let (batch, line, row) = (&self.batch, &mut self.line, self.next);
        self.next += 1;
        if batch.tallies.is_empty() {
            return (row == 0).then_some(batch);
        }
        line.link.tally = *batch.tallies.get(row)?;
        if row > 0 {
            line.marks.clear();
            line.registers.clear();
            line.diagnostics.clear();
        }
        let width = batch.layout.as_ref()?.channels.len();
        line.counts.clear();
        line.counts.extend_from_slice(&batch.counts[row * width..(row + 1) * width]);
        line.absent.clear();
        line.absent
            .extend(batch.absent.iter().filter(|cell| cell.row == row).map(|cell| AbsentCell { row: 0, ..*cell }));
        line.arrivals.clear();
        let arrived = batch.arrivals.iter().rfind(|arrival| arrival.from_row <= row);
        line.arrivals.extend(arrived.map(|arrival| Arrival { from_row: 0, ..*arrival }));
        line.counters.clear();
        line.device_ns.clear();
        line.device_ns.extend(batch.device_ns.get(row));
        let counter = batch.counters.binary_search_by_key(&row, |counter| counter.row);
        line.counters.extend(counter.ok().map(|place| RowCounter { row: 0, ..batch.counters[place] }));
        Some(line)
    }
}

/// A sample that a row of a [`Batch`] lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AbsentCell {
    /// The row.
    pub row: usize,
    /// The place of its channel in the layout.
    pub channel: usize,
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
    /// A rejected sentence, packet or row; the tally counts the reasons.
    Rejected,
    /// The row behind it was measured with axes at the end of their range; the bits are those of
    /// [`PacketForm::saturation`](crate::PacketForm::saturation).
    Saturated(u16),
    /// From here on the sensor prints so; stands before the first row, and wherever that changes.
    Printed(PrintFormat),
    /// The sensor answered with register 54: its temperature, in counts of that channel of
    /// [`VNIMU`](crate::VNIMU).
    Temperature(i32),
}

/// One thing that passed beside the samples. Printed, it is one line of ASCII that steers no
/// terminal, whatever came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Diagnostic {
    /// A command was written to the sensor.
    Sent(Box<[u8]>),
    /// The sensor answered, or reported an error.
    Reply(Box<[u8]>),
    /// A sentence or a packet was rejected.
    Refused {
        /// Why, in words.
        reason: String,
        /// Where it begins, in bytes from the beginning of the stream.
        offset: u64,
        /// Its bytes, as far as they were taken for a part of it.
        raw: Box<[u8]>,
    },
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sent(line) => write!(f, "sent {}", line.trim_ascii_end().escape_ascii()),
            Self::Reply(line) => write!(f, "reply {}", line.escape_ascii()),
            Self::Refused { reason, offset, raw } => {
                write!(f, "rejected at byte {offset}, {reason}: {}", raw.escape_ascii())
            }
        }
    }
}

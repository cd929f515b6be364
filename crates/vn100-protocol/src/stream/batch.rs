//! Batches: the rows of one read.

use alloc::{boxed::Box, string::String, sync::Arc, vec::Vec};
use core::{fmt, mem};

use super::{FileReport, StreamCounts};
use crate::{Layout, PrintFormat, RegisterContents, Tally};

/// The content of one read: samples, with marks for everything between them.
///
/// There is one batch per read and not one per sample, so that the cost of handing it over arises once.
#[derive(Debug, Clone, Default)]
pub struct Batch {
    /// The message of these samples; `None` before the first measurement of the stream.
    pub layout: Option<Arc<Layout>>,
    /// The samples, one row of exact integer counts each, in the order of `layout`; the channel
    /// gives the size of a count.
    pub counts: Vec<i32>,
    /// The cells of `counts` that have no value, in the order of the rows and of their channels: an
    /// empty field of a CSV file, or a field that is no number. Their counts are 0 and have no meaning.
    pub absent: Vec<AbsentCell>,
    /// The arrival times of the rows, in the order of the rows; empty if the source does not know them.
    pub arrivals: Vec<Arrival>,
    /// The counters of the rows that carry one, in order.
    pub counters: Vec<RowCounter>,
    /// The device time of each row, in nanoseconds since the sensor started; empty if rows do not
    /// carry it.
    pub device_ns: Vec<u64>,
    /// Marks for the items between the rows, by position.
    pub marks: Vec<Mark>,
    /// Contents of registers in replies to commands, in order: the values read, and those just
    /// written.
    pub registers: Vec<RegisterContents>,
    /// Diagnostics, in order; empty unless [`ReadOptions`](super::ReadOptions) request them.
    pub diagnostics: Vec<Diagnostic>,
    /// The counts of the stream from its beginning to the end of this batch.
    pub link: StreamCounts,
    /// The counts of the parser at the end of each row, if [`ReadOptions`](super::ReadOptions)
    /// request them and there are two rows or more. Marks, registers and diagnostics then precede
    /// the first row.
    pub tallies: Vec<Tally>,
    /// The counts of a file from its beginning to the end of this batch, if its rows or messages are read one
    /// by one; `None` for any other source.
    pub report: Option<Arc<FileReport>>,
}

impl Batch {
    /// The samples, one slice of counts each.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[i32]> {
        // a batch without a layout has no counts, so the width of a row has no effect
        self.counts.chunks_exact(self.layout.as_ref().map_or(1, |layout| layout.channels.len()))
    }

    /// The number of samples.
    pub fn row_count(&self) -> usize {
        self.rows().len()
    }

    /// Whether the row lacks the channel at this place of the layout.
    pub fn is_absent(&self, row: usize, channel: usize) -> bool {
        self.absent.binary_search_by_key(&(row, channel), |cell| (cell.row, cell.channel)).is_ok()
    }

    /// Its rows, each as a batch of its own if there are [`tallies`](Self::tallies) of each; else
    /// all in one batch.
    pub fn lines(mut self) -> SingleRows {
        let line = match self.tallies.is_empty() {
            true => Self::default(),
            false => Self {
                layout: self.layout.clone(),
                marks: mem::take(&mut self.marks),
                registers: mem::take(&mut self.registers),
                diagnostics: mem::take(&mut self.diagnostics),
                link: self.link,
                report: self.report.clone(),
                ..Self::default()
            },
        };
        SingleRows { batch: self, next: 0, line }
    }
}

/// The individual rows of a [`Batch`].
#[derive(Debug)]
pub struct SingleRows {
    batch: Batch,
    next: usize,
    line: Batch,
}

impl SingleRows {
    /// The next row; `None` after the last.
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

/// The arrival of rows of a [`Batch`]: the rows from here to the next arrival came with one read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// The first of these rows.
    pub from_row: usize,
    /// The time of the read, in nanoseconds from an origin of the source's choice. The times in a
    /// recording may decrease.
    pub at_ns: i64,
}

/// The counter that a line carries after its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowCounter {
    /// The row.
    pub row: usize,
    /// The counter; register 30 of the sensor determines its meaning.
    pub count: u64,
}

/// Something between two rows of a [`Batch`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// The row after the mark; the number of rows for the end of the batch.
    pub before_row: usize,
    /// The kind of mark.
    pub kind: MarkKind,
}

/// The item at a [`Mark`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkKind {
    /// A rejected sentence, packet or row; the tally counts the reasons.
    Rejected,
    /// The row after it was measured with axes at the end of their range; the bits are those of
    /// [`PacketForm::saturation`](crate::PacketForm::saturation).
    Saturated(u16),
    /// The print format of the sensor from here on; before the first row, and at each change.
    Printed(PrintFormat),
    /// The sensor replied with register 54: its temperature, in counts of that channel of
    /// [`VNIMU`](crate::VNIMU).
    Temperature(i32),
}

/// One item for the log. Printed, it is one line of ASCII without control characters for a
/// terminal, for any content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Diagnostic {
    /// A command was written to the sensor.
    Sent(Box<[u8]>),
    /// A reply or a device error of the sensor.
    Reply(Box<[u8]>),
    /// A sentence or a packet was rejected.
    Refused {
        /// The reason, in words.
        reason: String,
        /// The offset of its first byte, in bytes from the beginning of the stream.
        offset: u64,
        /// Its bytes, as far as they were counted to it.
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

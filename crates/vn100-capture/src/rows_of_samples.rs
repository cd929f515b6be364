//! The samples of a file of rows or messages: those of the sentences in them, or of their numbers.

use std::{mem, sync::Arc};

use vn100_protocol::{
    Layout,
    stream::{AbsentCell, AbsentValues, Arrival, Batch, Mark, MarkKind, SampleReader},
};

/// The samples that no batch has yet.
#[expect(clippy::large_enum_variant, reason = "there is one for each file")]
pub(crate) enum RowSamples {
    Sentences(SampleReader),
    Numbers(NumberRows),
}

impl RowSamples {
    pub(crate) fn mark_rejected_row(&mut self) {
        match self {
            Self::Sentences(reader) => reader.mark_rejected_row(),
            Self::Numbers(rows) => {
                rows.open.marks.push(Mark { before_row: rows.row_count(), kind: MarkKind::Rejected });
            }
        }
    }

    pub(crate) fn take_batches(&mut self) -> Vec<Batch> {
        match self {
            Self::Sentences(reader) => reader.take_batches(),
            Self::Numbers(rows) => {
                vec![Batch { layout: Some(Arc::clone(&rows.layout)), ..mem::take(&mut rows.open) }]
            }
        }
    }

    /// The last batches, after the last row.
    pub(crate) fn finish(&mut self) -> Vec<Batch> {
        match self {
            Self::Sentences(reader) => reader.finish(),
            Self::Numbers(_) => self.take_batches(),
        }
    }

    /// The channels that are absent in some rows.
    pub(crate) fn absent(&self) -> Vec<AbsentValues> {
        match self {
            Self::Sentences(_) => Vec::new(),
            Self::Numbers(rows) => rows.absences.iter().filter(|absences| absences.total() > 0).cloned().collect(),
        }
    }
}

pub(crate) struct NumberRows {
    layout: Arc<Layout>,
    /// The rows that no batch has.
    open: Batch,
    /// The counts of the current row, in the order of the layout; 0 for a missing channel.
    counts: Vec<i32>,
    /// The channels that the current row lacks.
    pub(crate) absent: Vec<(usize, Absence)>,
    absences: Vec<AbsentValues>,
}

/// The reason why a row lacks a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Absence {
    Empty,
    NotANumber,
    /// The number exceeds the range of the counts.
    OutOfRange,
}

impl NumberRows {
    pub(crate) fn new(layout: Arc<Layout>) -> Self {
        let absences = layout.channels.iter().map(|channel| channel.name.to_string());
        Self {
            open: Batch::default(),
            counts: vec![0; layout.channels.len()],
            absent: Vec::new(),
            absences: absences.map(|channel| AbsentValues { channel, ..AbsentValues::default() }).collect(),
            layout,
        }
    }

    fn row_count(&self) -> usize {
        self.open.counts.len() / self.counts.len()
    }

    /// Begins a row; each of its channels is [`set`](Self::set) once.
    #[inline]
    pub(crate) fn begin(&mut self) {
        self.absent.clear();
    }

    #[inline]
    pub(crate) fn set(&mut self, channel: usize, count: Result<i32, Absence>) {
        self.counts[channel] = count.unwrap_or_default();
        if let Err(absence) = count {
            self.absent.push((channel, absence));
        }
    }

    /// Whether the current row has no channel.
    #[inline]
    pub(crate) fn is_blank(&self) -> bool {
        self.absent.len() >= self.counts.len()
    }

    /// Adds the current row, the content of this line or message.
    #[inline]
    pub(crate) fn push(&mut self, at_ns: Option<i64>, device_ns: Option<u64>, line: u64) {
        let row = self.row_count();
        self.open.arrivals.extend(at_ns.map(|at_ns| Arrival { from_row: row, at_ns }));
        self.open.device_ns.extend(device_ns);
        self.open.counts.extend_from_slice(&self.counts);
        if !self.absent.is_empty() {
            self.push_absent(row, line);
        }
    }

    #[cold]
    fn push_absent(&mut self, row: usize, line: u64) {
        self.absent.sort_unstable_by_key(|(channel, _)| *channel);
        for &(channel, absence) in &self.absent {
            self.open.absent.push(AbsentCell { row, channel });
            let absences = &mut self.absences[channel];
            if absences.total() == 0 {
                absences.first_line = line;
            }
            *match absence {
                Absence::Empty => &mut absences.empty,
                Absence::NotANumber => &mut absences.not_a_number,
                Absence::OutOfRange => &mut absences.out_of_range,
            } += 1;
        }
    }
}

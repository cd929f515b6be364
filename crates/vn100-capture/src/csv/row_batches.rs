//! Rows of a CSV file in, batches of samples out.

use std::{
    io::{self, Read},
    sync::Arc,
};

use vn100_protocol::{
    Layout, Tally,
    stream::{Arrival, Batch, Mark, MarkKind, ReadOptions, RejectedRow, RejectedRowCounts, SampleReader},
};

use super::{
    plan::{Kind, Plan},
    reader::{CsvReader, LineBytes, Rows},
};
use crate::{
    event::{CsvReport, Event},
    read_samples::FileReader,
};

/// Reads the samples of a CSV file, some hundred rows at a time.
pub(crate) struct RowBatches<R> {
    csv: CsvReader<R>,
    rows: Rows,
    rejected: RejectedRowCounts,
    line_by_line: bool,
    content: Content,
}

/// What rows become.
enum Content {
    Values(Values),
    /// Sentences, to be decoded.
    Sentences(SampleReader),
}

/// Numbers, already counts.
struct Values {
    layout: Arc<Layout>,
    tally: Tally,
    open: Batch,
}

impl<R: Read> RowBatches<R> {
    pub(crate) fn new(plan: Plan, reader: R, options: ReadOptions) -> Self {
        let content = match plan.kind.clone() {
            Kind::Values(layout) => {
                Content::Values(Values { layout: Arc::new(layout), tally: Tally::default(), open: Batch::default() })
            }
            Kind::Sentences => Content::Sentences(SampleReader::new(options)),
        };
        Self {
            csv: CsvReader::new(plan, reader),
            rows: Rows::default(),
            rejected: RejectedRowCounts::default(),
            line_by_line: options.line_by_line,
            content,
        }
    }
}

impl<R: Read + Send + 'static> FileReader for RowBatches<R> {
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let Self { csv, rows, rejected, line_by_line, content } = self;
        if !csv.next_rows(rows)? {
            return Ok(None);
        }
        let mut batches = Vec::new();
        let mut rejected_rows = rows.rejected.iter().peekable();
        for row in 0..=rows.count {
            while let Some((_, reason)) = rejected_rows.next_if(|(before_row, _)| *before_row <= row) {
                rejected.count(*reason);
                content.mark_rejected();
            }
            if row < rows.count {
                content.push(rows, row);
                if *line_by_line {
                    batches.extend(with_file(content.take_batches(), *rejected, rows.bytes[row]));
                }
            }
        }
        batches.extend(with_file(content.take_batches(), *rejected, csv.bytes()));
        Ok(Some(batches.into_iter().map(Event::Batch).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<CsvReport>) {
        let batches = match &mut self.content {
            Content::Values(values) => vec![values.take_batch()],
            Content::Sentences(samples) => samples.finish(),
        };
        (with_file(batches, self.rejected, self.csv.bytes()), Some(self.csv.report().clone()))
    }
}

impl Content {
    fn mark_rejected(&mut self) {
        match self {
            Self::Values(values) => {
                let before_row = values.row();
                values.open.marks.push(Mark { before_row, kind: MarkKind::Rejected });
            }
            Self::Sentences(samples) => samples.mark_rejected_row(),
        }
    }

    fn push(&mut self, rows: &Rows, row: usize) {
        let at_ns = rows.stamps_ns.get(row).copied();
        match self {
            Self::Values(values) => {
                let channels = values.layout.channels.len();
                values.push(&rows.counts[channels * row..][..channels], at_ns);
            }
            Self::Sentences(samples) => samples.push(rows.sentence(row), at_ns),
        }
    }

    fn take_batches(&mut self) -> Vec<Batch> {
        match self {
            Self::Values(values) => vec![values.take_batch()],
            Self::Sentences(samples) => samples.take_batches(),
        }
    }
}

impl Values {
    fn push(&mut self, counts: &[i32], at_ns: Option<i64>) {
        if let Some(at_ns) = at_ns {
            let from_row = self.row();
            self.open.arrivals.push(Arrival { from_row, at_ns });
        }
        self.open.counts.extend_from_slice(counts);
        self.tally.samples += 1;
        // a row of numbers carries no checksum
        self.tally.unchecked_sentences += 1;
    }

    fn row(&self) -> usize {
        self.open.counts.len() / self.layout.channels.len()
    }

    fn take_batch(&mut self) -> Batch {
        let mut batch = std::mem::take(&mut self.open);
        batch.layout = Some(Arc::clone(&self.layout));
        batch.link.tally = self.tally;
        batch
    }
}

/// Adds what the file holds beside its samples. All bytes of a row are those of its line: stamp,
/// other columns and line end too, even where its sentence is damaged.
fn with_file(mut batches: Vec<Batch>, rejected: RejectedRowCounts, bytes: LineBytes) -> Vec<Batch> {
    for link in batches.iter_mut().map(|batch| &mut batch.link) {
        let tally = &mut link.tally;
        tally.valid_sentence_bytes += bytes.rows.saturating_sub(tally.bytes());
        tally.rejected_sentence_bytes += bytes.rejected;
        tally.skipped_bytes += bytes.skipped;
        for (reason, count) in rejected.iter() {
            *match reason {
                RejectedRow::Range => &mut tally.rejected.range,
                RejectedRow::Length => &mut tally.rejected.too_long,
                RejectedRow::Truncated => &mut tally.rejected.truncated,
                RejectedRow::Fields | RejectedRow::Number | RejectedRow::Decimals | RejectedRow::Stamp => {
                    &mut tally.rejected.grammar
                }
            } += count;
        }
        link.rejected_rows = Some(rejected);
    }
    batches
}

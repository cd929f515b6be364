//! The rows of a CSV file as batches of samples, some hundred at a time.

use std::{
    io::{self, Read},
    mem,
    sync::Arc,
};

use vn100_protocol::{
    Layout,
    stream::{AbsentCell, Arrival, Batch, FileReport, Mark, MarkKind, ReadOptions, SampleReader},
};

use super::{CsvPlan, lines::Lines, row_counts::Absence, row_parser::RowParser};
use crate::read_samples::{Event, FileReader};

/// Rows in one batch, accepted or rejected.
const MOST_ROWS: usize = 512;

/// Reads the samples of a CSV file, some hundred rows at a time.
pub(crate) struct CsvReader<R> {
    lines: Lines<R>,
    parser: RowParser,
    line_by_line: bool,
    content: Content,
}

/// The form to which the rows are converted.
#[expect(clippy::large_enum_variant, reason = "there is one for each file")]
enum Content {
    /// Numbers, already counts.
    Values { layout: Arc<Layout>, open: Batch },
    /// Sentences, to be decoded.
    Sentences(SampleReader),
}

impl<R: Read> CsvReader<R> {
    /// Reads `reader` from the first byte of the file on.
    pub(crate) fn new(plan: CsvPlan, reader: R, options: ReadOptions) -> Self {
        let content = match &plan.layout {
            Some(layout) => Content::Values { layout: Arc::clone(layout), open: Batch::default() },
            None => Content::Sentences(SampleReader::new(options)),
        };
        let lines = Lines::new(reader, plan.line_end);
        Self { lines, parser: RowParser::new(plan), line_by_line: options.line_by_line, content }
    }
}

impl<R: Read + Send + 'static> FileReader for CsvReader<R> {
    /// Up to 512 rows; fewer if the next rows would require waiting.
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let mut batches = Vec::new();
        let mut row_count = 0;
        while row_count == 0 {
            if let Some(line) = self.parser.other_table {
                let text =
                    format!("line {line} begins a table with other columns: it and the lines after it are not read");
                return Err(io::Error::other(text));
            }
            let Self { lines, parser, line_by_line, content, .. } = self;
            while row_count < MOST_ROWS
                && parser.other_table.is_none()
                && let Some(line) = lines.next_buffered()
            {
                let Some(row) = parser.push(&line) else { continue };
                row_count += 1;
                match row {
                    Ok(()) => content.push(parser),
                    Err(_) => content.mark_rejected(),
                }
                if row.is_ok() && *line_by_line {
                    batches.extend(content.take_batches(parser));
                }
            }
            if row_count == 0 && !lines.fill()? {
                return Ok(None);
            }
        }
        batches.extend(self.content.take_batches(&self.parser));
        Ok(Some(batches.into_iter().map(Event::from).collect()))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        let batches = match &mut self.content {
            Content::Sentences(samples) => self.parser.counted.complete(samples.finish()),
            values => values.take_batches(&self.parser),
        };
        (batches, Some(FileReport::Csv(self.parser.report())))
    }
}

impl Content {
    fn push(&mut self, row: &RowParser) {
        match self {
            Self::Values { layout, open } => {
                let from_row = open.counts.len() / layout.channels.len();
                open.arrivals.extend(row.stamp_ns.map(|at_ns| Arrival { from_row, at_ns }));
                open.device_ns.extend(row.device_ns);
                open.counts.extend_from_slice(&row.counts);
                let cell = |&(channel, _): &(usize, Absence)| AbsentCell { row: from_row, channel };
                open.absent.extend(row.absent.iter().map(cell));
            }
            Self::Sentences(samples) => samples.push(&row.sentence, row.stamp_ns),
        }
    }

    fn mark_rejected(&mut self) {
        match self {
            Self::Values { layout, open } => {
                let before_row = open.counts.len() / layout.channels.len();
                open.marks.push(Mark { before_row, kind: MarkKind::Rejected });
            }
            Self::Sentences(samples) => samples.mark_rejected_row(),
        }
    }

    fn take_batches(&mut self, parser: &RowParser) -> Vec<Batch> {
        parser.counted.complete(match self {
            Self::Values { layout, open } => {
                let mut batch = mem::take(open);
                batch.layout = Some(Arc::clone(layout));
                batch.link.tally.samples = parser.counted.report.rows;
                // a row of numbers carries no checksum
                batch.link.tally.unchecked_sentences = parser.counted.report.rows;
                vec![batch]
            }
            Self::Sentences(samples) => samples.take_batches(),
        })
    }
}

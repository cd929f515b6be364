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

use super::{
    CsvPlan,
    kept::Kept,
    lines::Lines,
    resolution::{ColumnScan, Scanned},
    row_counts::Absence,
    row_parser::RowParser,
    so_far::SoFar,
};
use crate::read_samples::{Event, FileReader};

/// Rows in one batch, accepted or rejected.
const MOST_ROWS: usize = 512;

/// Reads the samples of a CSV file, some hundred rows at a time.
pub(crate) struct CsvReader<R> {
    /// `Some` until all rows have shown what the columns print.
    first_pass: Option<FirstPass<R>>,
    lines: Lines<Kept<R>>,
    parser: RowParser,
    line_by_line: bool,
    content: Content,
}

/// The file from its beginning, and what its columns have printed so far.
struct FirstPass<R> {
    lines: Lines<R>,
    scans: Vec<ColumnScan>,
}

/// What the rows are converted to.
#[expect(clippy::large_enum_variant, reason = "there is one for each file")]
enum Content {
    /// Numbers, already counts.
    Values { layout: Arc<Layout>, open: Batch },
    /// Sentences, to be decoded.
    Sentences(SampleReader),
}

impl<R: Read> CsvReader<R> {
    /// Reads `reader` from the first byte of the file on. Where `again` is another reader of the
    /// same file, that is read first, because the size of a count depends on all rows. Without it
    /// the counts are those of the rows so far, and [`Event::ReadAgain`] is sent where the size of
    /// a count changes.
    pub(crate) fn new(plan: CsvPlan, reader: R, again: Option<R>, options: ReadOptions) -> Self {
        let content = match plan.layout() {
            Some(layout) => Content::Values { layout: Arc::new(layout), open: Batch::default() },
            None => Content::Sentences(SampleReader::new(options)),
        };
        let scans = vec![ColumnScan::default(); plan.priors.len()];
        let again = again.filter(|_| matches!(content, Content::Values { .. }));
        let is_kept = again.is_none() && matches!(content, Content::Values { .. });
        let reader = if is_kept { Kept::all(reader) } else { Kept::nothing(reader) };
        let so_far = is_kept.then(|| SoFar::new(scans.len()));
        Self {
            first_pass: again.map(|again| FirstPass { lines: Lines::new(again, plan.line_end), scans }),
            lines: Lines::new(reader, plan.line_end),
            parser: RowParser::new(plan, so_far),
            line_by_line: options.line_by_line,
            content,
        }
    }

    /// Continues the first pass, and ends it where the file ends or cannot be read: the second pass
    /// then ends at the same place.
    fn scan(&mut self) {
        let Some(FirstPass { lines, scans }) = &mut self.first_pass else { return };
        if lines.fill().unwrap_or(false) {
            while let Some(line) = lines.next_buffered() {
                self.parser.scan(&line, scans);
            }
            return;
        }
        self.parser.plan.quantize(scans, Scanned::Whole);
        if let (Content::Values { layout, .. }, Some(quantized)) = (&mut self.content, self.parser.plan.layout()) {
            *layout = Arc::new(quantized);
        }
        self.first_pass = None;
    }
}

impl<R: Read> CsvReader<R> {
    /// Rewinds to the first row where the rows so far require another size of a count.
    fn begins_again(&mut self) -> bool {
        let Some(mut so_far) = self.parser.so_far.take() else { return false };
        let other = so_far.other_counts(&self.parser.plan);
        let Some(plan) = other.filter(|_| self.lines.rewind()) else {
            self.parser.so_far = Some(so_far);
            return false;
        };
        so_far.count_reading();
        if let (Content::Values { layout, open }, Some(quantized)) = (&mut self.content, plan.layout()) {
            (*layout, *open) = (Arc::new(quantized), Batch::default());
        }
        self.parser = RowParser::new(plan, Some(so_far));
        true
    }
}

impl<R: Read + Send + 'static> FileReader for CsvReader<R> {
    /// Up to 512 rows; fewer where the next ones would have to be waited for.
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        if self.first_pass.is_some() {
            self.scan();
            return Ok(Some(Vec::new()));
        }
        let mut batches = Vec::new();
        let mut row_count = 0;
        while row_count == 0 {
            let Self { lines, parser, line_by_line, content, .. } = self;
            while row_count < MOST_ROWS
                && !parser.asks_for_other_counts()
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
            let is_due = parser.asks_for_other_counts();
            let is_over = !is_due && row_count == 0 && !lines.fill()?;
            if (is_due || is_over) && self.begins_again() {
                return Ok(Some(vec![Event::ReadAgain]));
            }
            if is_over {
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

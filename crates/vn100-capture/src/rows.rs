//! Rows of a CSV file in, batches of samples out: what `read_samples` does for bytes.

use std::{
    io::{self, Read},
    sync::Arc,
    thread,
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use vn100_protocol::{Layout, Tally};

use crate::{
    csv::CsvReader, csv::CsvTally, csv::Kind, csv::LineBytes, csv::Plan, csv::Rows, event::CsvReport, event::End,
    event::Event, event::RejectedRows, read_samples::WAITING_BATCHES,
};
use vn100_protocol::stream::{
    Arrival, Batch, Mark, MarkKind, ReadOptions, RejectedRow, RejectedRowCounts, SampleReader, StreamCounts,
};

/// Starts a thread that reads a CSV file to its end, or until `stop`; tells as
/// [`read_samples`](crate::read_samples) does.
pub(crate) fn read_rows(
    plan: Plan,
    reader: impl Read + Send + 'static,
    options: ReadOptions,
    stop: CancellationToken,
) -> io::Result<mpsc::Receiver<Event>> {
    let (events, inbox) = mpsc::channel(WAITING_BATCHES);
    let work = move || {
        let end = match plan.kind.clone() {
            Kind::Values(layout) => read(plan, reader, &stop, &events, &mut Values::new(layout, options)),
            Kind::Sentences => read(plan, reader, &stop, &events, &mut Sentences::new(options)),
        };
        if let Some(end) = end {
            // a receiver that left has no use for the end
            let _ = events.blocking_send(Event::End(end));
        }
    };
    // ends with the file, with `stop`, or when the inbox is dropped
    thread::Builder::new().name("csv-reader".into()).spawn(work)?;
    Ok(inbox)
}

/// What rows become.
trait Sink {
    fn take(&mut self, rows: &Rows, tally: &CsvTally) -> Vec<Batch>;
    fn finish(&mut self, csv: &CsvTally) -> Vec<Batch>;
}

/// How it ended; `None` when nobody listens any more.
fn read(
    plan: Plan,
    reader: impl Read,
    stop: &CancellationToken,
    events: &mpsc::Sender<Event>,
    sink: &mut impl Sink,
) -> Option<End> {
    let ignored_columns = plan.ignored_columns.clone();
    let rounded = plan.rounded.iter().map(|rounded| rounded.channel.to_owned()).collect();
    let mut csv = CsvReader::new(plan, reader);
    let mut rows = Rows::default();
    let send =
        |batches: Vec<Batch>| batches.into_iter().try_for_each(|batch| events.blocking_send(Event::Batch(batch)).ok());
    let error = loop {
        match csv.next_rows(&mut rows) {
            Ok(more) if more && !stop.is_cancelled() => send(sink.take(&rows, csv.tally()))?,
            Ok(_) => break None,
            Err(error) => break Some(error),
        }
    };
    let tally = csv.tally();
    send(sink.finish(tally))?;
    let odd = RejectedRow::ALL.into_iter().map(|kind| (kind, tally.odd(kind))).filter_map(|(kind, odd)| {
        let first = odd.first.as_ref()?;
        Some(RejectedRows {
            reason: kind.to_string(),
            count: odd.count,
            first_line: first.line,
            first_text: first.text.clone(),
        })
    });
    let report = CsvReport {
        lines: tally.lines,
        rows: tally.rows,
        skipped_lines: tally.skipped_lines,
        odd: odd.collect(),
        ignored_columns,
        rounded,
    };
    Some(End { error, csv: Some(report) })
}

/// Numbers, already counts.
struct Values {
    layout: Arc<Layout>,
    tally: Tally,
    odd: RejectedRowCounts,
    line_by_line: bool,
    open: Batch,
}

impl Values {
    fn new(layout: Layout, options: ReadOptions) -> Self {
        let layout = Arc::new(layout);
        let open = Batch { layout: Some(Arc::clone(&layout)), ..Batch::default() };
        Self {
            layout,
            tally: Tally::default(),
            odd: RejectedRowCounts::default(),
            line_by_line: options.line_by_line,
            open,
        }
    }

    fn count_odd(&mut self, odd: RejectedRow) {
        self.odd.count(odd);
        let before_row = self.open.row_count();
        self.open.marks.push(Mark { before_row, kind: MarkKind::Rejected });
    }

    fn seal(&mut self, bytes: LineBytes) -> Batch {
        let next = Batch { layout: Some(Arc::clone(&self.layout)), ..Batch::default() };
        self.open.link.tally = self.tally;
        add_file(&mut self.open.link, self.odd, bytes);
        std::mem::replace(&mut self.open, next)
    }
}

impl Sink for Values {
    fn take(&mut self, rows: &Rows, csv: &CsvTally) -> Vec<Batch> {
        let mut sealed = Vec::new();
        let mut odd = rows.odd.iter().peekable();
        for (row, counts) in rows.counts.chunks_exact(self.layout.channels.len()).enumerate() {
            while let Some((_, kind)) = odd.next_if(|(before_row, _)| *before_row <= row) {
                self.count_odd(*kind);
            }
            if let Some(&at_ns) = rows.stamps_ns.get(row) {
                let from_row = self.open.row_count();
                self.open.arrivals.push(Arrival { from_row, at_ns });
            }
            self.open.counts.extend_from_slice(counts);
            self.tally.samples += 1;
            // a row of numbers carries no checksum
            self.tally.unchecked_sentences += 1;
            if self.line_by_line {
                sealed.push(self.seal(rows.bytes[row]));
            }
        }
        odd.for_each(|(_, kind)| self.count_odd(*kind));
        sealed.push(self.seal(csv.bytes));
        sealed
    }

    fn finish(&mut self, csv: &CsvTally) -> Vec<Batch> {
        vec![self.seal(csv.bytes)]
    }
}

/// Sentences, to be decoded.
struct Sentences {
    parser: SampleReader,
    odd: RejectedRowCounts,
    line_by_line: bool,
}

impl Sentences {
    fn new(options: ReadOptions) -> Self {
        Self {
            parser: SampleReader::new(options),
            odd: RejectedRowCounts::default(),
            line_by_line: options.line_by_line,
        }
    }

    fn count_odd(&mut self, odd: RejectedRow) {
        self.odd.count(odd);
        self.parser.mark_rejected_row();
    }

    fn complete(&self, mut batches: Vec<Batch>, bytes: LineBytes) -> Vec<Batch> {
        batches.iter_mut().for_each(|batch| add_file(&mut batch.link, self.odd, bytes));
        batches
    }
}

impl Sink for Sentences {
    fn take(&mut self, rows: &Rows, csv: &CsvTally) -> Vec<Batch> {
        let mut sealed = Vec::new();
        let mut odd = rows.odd.iter().peekable();
        for (row, sentence) in rows.sentences().enumerate() {
            while let Some((_, kind)) = odd.next_if(|(before_row, _)| *before_row <= row) {
                self.count_odd(*kind);
            }
            self.parser.push(sentence, rows.stamps_ns.get(row).copied());
            if self.line_by_line {
                let batches = self.parser.take_batches();
                sealed.extend(self.complete(batches, rows.bytes[row]));
            }
        }
        odd.for_each(|(_, kind)| self.count_odd(*kind));
        let batches = self.parser.take_batches();
        sealed.extend(self.complete(batches, csv.bytes));
        sealed
    }

    fn finish(&mut self, csv: &CsvTally) -> Vec<Batch> {
        let batches = self.parser.finish();
        self.complete(batches, csv.bytes)
    }
}

/// Adds what the file holds beside its samples. All bytes of a row are those of its line: stamp,
/// other columns and line end too, even where its sentence is damaged.
fn add_file(link: &mut StreamCounts, odd: RejectedRowCounts, bytes: LineBytes) {
    let tally = &mut link.tally;
    tally.valid_sentence_bytes += bytes.rows.saturating_sub(tally.bytes());
    tally.rejected_sentence_bytes += bytes.odd;
    tally.skipped_bytes += bytes.skipped;
    for (kind, count) in odd.iter() {
        *match kind {
            RejectedRow::Range => &mut tally.rejected.range,
            RejectedRow::Length => &mut tally.rejected.too_long,
            RejectedRow::Truncated => &mut tally.rejected.truncated,
            RejectedRow::Fields | RejectedRow::Number | RejectedRow::Decimals | RejectedRow::Stamp => {
                &mut tally.rejected.grammar
            }
        } += count;
    }
    link.rejected_rows = Some(odd);
}

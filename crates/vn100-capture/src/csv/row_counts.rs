//! Counts of the lines of a CSV file: rows, rejected and skipped lines, absent values, bytes.

use vn100_protocol::{
    Channel, Tally,
    stream::{AbsentValues, Batch, CsvReport, RejectedRow, RejectedRowCounts, RejectedRows},
};

use super::{ColumnUse, CsvPlan, lines::CsvLine, shown};

/// Counts lines by their kind.
pub(super) struct RowCounts {
    /// Its absences have an entry for each channel.
    pub(super) report: CsvReport,
    /// The bytes of all lines, line ends included, and the rejected rows.
    pub(super) tally: Tally,
    rejected: RejectedRowCounts,
}

/// The reason why a row lacks a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Absence {
    Empty,
    NotANumber,
    OutOfRange,
}

impl RowCounts {
    pub(super) fn new(plan: &CsvPlan) -> Self {
        let channels = plan.layout.iter().flat_map(|layout| &*layout.channels).zip(&plan.quantizers);
        let rounded = channels.clone().filter(|(_, quantizer)| quantizer.is_rounded);
        let absent = |channel: &Channel| AbsentValues { channel: channel.name.to_string(), ..AbsentValues::default() };
        let report = CsvReport {
            ignored_columns: plan.ignored_columns.clone(),
            left_out: plan.left_out.clone(),
            times: plan.times.clone(),
            other_stream_rows: plan.columns.contains(&ColumnUse::OtherStream).then_some(0),
            rounded: rounded.map(|(channel, _)| channel.name.to_string()).collect(),
            absent: channels.map(|(channel, _)| absent(channel)).collect(),
            ..CsvReport::default()
        };
        Self { report, tally: Tally::default(), rejected: RejectedRowCounts::default() }
    }

    /// The counts of the lines so far.
    pub(super) fn report(&self) -> CsvReport {
        let mut report = self.report.clone();
        report.absent.retain(|absences| absences.total() > 0);
        report
    }

    /// Counts a line that is no row.
    pub(super) fn skip(&mut self, line: &CsvLine<'_>) {
        self.report.skipped_lines += 1;
        self.tally.skipped_bytes += line.bytes;
    }

    /// Counts a row that has values of other streams only.
    pub(super) fn leave_to_others(&mut self, line: &CsvLine<'_>) {
        *self.report.other_stream_rows.get_or_insert_default() += 1;
        self.tally.skipped_bytes += line.bytes;
    }

    /// Counts a valid row, which lacks the channels in `absent`.
    #[inline]
    pub(super) fn accept(&mut self, line: &CsvLine<'_>, absent: &[(usize, Absence)]) {
        self.report.rows += 1;
        self.tally.valid_sentence_bytes += line.bytes;
        if !absent.is_empty() {
            self.count_absent(line.number, absent);
        }
    }

    #[cold]
    fn count_absent(&mut self, line: u64, absent: &[(usize, Absence)]) {
        for &(channel, absence) in absent {
            let absences = &mut self.report.absent[channel];
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

    #[cold]
    pub(super) fn reject(&mut self, reason: RejectedRow, line: &CsvLine<'_>) {
        self.rejected.count(reason);
        self.tally.rejected_sentence_bytes += line.bytes;
        let tally = &mut self.tally.rejected;
        *match reason {
            RejectedRow::Length => &mut tally.too_long,
            RejectedRow::Truncated => &mut tally.truncated,
            RejectedRow::Fields | RejectedRow::Number | RejectedRow::Stamp => &mut tally.grammar,
        } += 1;
        let rejected = &mut self.report.rejected;
        let at = rejected.binary_search_by_key(&reason, |rows| rows.reason).unwrap_or_else(|at| {
            let first = RejectedRows { reason, count: 0, first_line: line.number, first_text: shown(line.text) };
            rejected.insert(at, first);
            at
        });
        rejected[at].count += 1;
    }

    /// Adds the counts of everything that is no sample to the batches. The bytes of a row are all bytes
    /// of its line, including stamp, other columns and line end, even if its sentence is damaged.
    pub(super) fn complete(&self, mut batches: Vec<Batch>) -> Vec<Batch> {
        let file = &self.tally;
        for link in batches.iter_mut().map(|batch| &mut batch.link) {
            let tally = &mut link.tally;
            tally.valid_sentence_bytes += file.valid_sentence_bytes.saturating_sub(tally.bytes());
            tally.rejected_sentence_bytes += file.rejected_sentence_bytes;
            tally.skipped_bytes += file.skipped_bytes;
            tally.rejected.too_long += file.rejected.too_long;
            tally.rejected.truncated += file.rejected.truncated;
            tally.rejected.grammar += file.rejected.grammar;
            link.rejected_rows = Some(self.rejected);
        }
        batches
    }
}

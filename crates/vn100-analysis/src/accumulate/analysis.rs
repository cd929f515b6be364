//! The analysis of one source: batches in, snapshots out.

mod reading;

use std::time::Duration;

use imu_noise::timebase::{ClockAfterOutage, GapDetector, LATEST_ARRIVAL, TimebaseSummary};
use vn100_protocol::stream::{Batch, LinkEvent, LinkEventKind, StreamCounts};
use vn100_protocol::{Layout, RegisterContents};

use super::{
    data_record::DataRecord, pending_rows::PendingRows, rate_authority::RateEffect, row_order::RowOrder,
    row_slice::RowSlice,
};
use crate::{
    settings::Settings,
    snapshot::{Outages, PlaceMark, Timing},
};

/// Pending rows that span less time than this do not show their rate if they arrive in bursts.
const MIN_PENDING: Duration = Duration::from_secs(1);

/// The statistics of one stream: the same, bit by bit, however the stream was split into batches.
#[derive(Debug, Default)]
pub struct Analysis {
    record: DataRecord,
    /// Rows with stamps or counters since the link was connected.
    pending: Option<PendingRows>,
    link: StreamCounts,
    outages: Outages,
    marks: Vec<PlaceMark>,
    port_shared_with: Option<String>,
    /// Whether the link was lost and no row has arrived since.
    is_interrupted: bool,
    /// While pending rows of an ended stream are taken: whether they were too few for a rate.
    finishing: Option<bool>,
    last_row_ns: Option<i64>,
}

/// Marks that are kept; further ones are not.
const MOST_MARKS: usize = 1000;

impl Analysis {
    /// An analysis without samples. Its snapshot has no channels.
    pub fn new(settings: Settings) -> Self {
        Self { record: DataRecord::new(settings), ..Self::default() }
    }

    fn order(&self) -> Option<&RowOrder> {
        self.pending.as_ref()?.order.as_ref()
    }

    fn arrivals(&self) -> Option<TimebaseSummary> {
        self.pending.as_ref().and_then(|pending| pending.detector.summary())
    }

    /// Takes the batch of one read. Rows whose place is not decided yet are kept pending.
    pub fn absorb(&mut self, batch: &Batch) {
        self.push(batch);
        while self.continue_to_second() {}
    }

    /// Takes a batch like [`absorb`](Self::absorb), but of the pending rows only those up to the next whole
    /// second of data time. Returns whether rows are left for [`continue_to_second`](Self::continue_to_second).
    #[must_use]
    pub fn absorb_to_second(&mut self, batch: &Batch) -> bool {
        self.push(batch);
        self.continue_to_second()
    }

    /// Takes rows that are left, up to the next whole second. Returns whether rows are left.
    #[must_use]
    pub fn continue_to_second(&mut self) -> bool {
        let next = self.seconds() + 1;
        while self.seconds() < next {
            let most = self.record.span.rows_until(next, self.record.rate.hz());
            let Some(resolved) = self.pending.as_mut().and_then(|pending| pending.next(most)) else { return false };
            self.record.push(resolved);
        }
        true
    }

    fn push(&mut self, batch: &Batch) {
        self.link = batch.link;
        if self.is_interrupted && !batch.counts.is_empty() {
            self.judge_outage(batch);
        }
        self.last_row_ns = batch.arrivals.last().map(|arrival| arrival.at_ns).or(self.last_row_ns);
        batch.registers.iter().for_each(|reply| self.push_reply(reply));
        if let Some(layout) = &batch.layout {
            self.record.set_layout(layout);
        }
        // a layout has channels; without one there are no rows
        let width = self.record.accumulators.width().max(1);
        let is_stamped = !batch.arrivals.is_empty();
        let is_timed = is_stamped || !batch.counters.is_empty() || !batch.device_ns.is_empty();
        if self.pending.is_some() || is_timed {
            let new = || {
                let detector = if is_stamped { self.record.rate.detector() } else { GapDetector::without_stamps() };
                let order = (is_stamped && self.record.rate.is_table()).then(RowOrder::default);
                PendingRows::new(width, detector, order)
            };
            self.pending.get_or_insert_with(new).push(batch);
        } else {
            let rows = RowSlice::new(&batch.counts, width, &batch.absent);
            let mut row = 0;
            for mark in &batch.marks {
                self.record.push_rows(rows.at(row..mark.before_row));
                row = mark.before_row;
                self.record.push_mark(mark.kind);
            }
            self.record.push_rows(rows.at(row..rows.len()));
        }
    }

    /// Takes an event of the link. How many samples were dropped while the link was down is known
    /// only from the device time of the first row after the outage.
    pub fn take_link_event(&mut self, event: &LinkEvent) {
        match &event.kind {
            LinkEventKind::Marked { text } => return self.mark(text),
            LinkEventKind::PortShared { program } => return self.port_shared_with = Some(program.clone()),
            _ => {}
        }
        // each row precedes one outage at most
        self.outages.take(event, self.last_row_ns.take());
        if matches!(event.kind, LinkEventKind::Down { .. }) {
            self.finish();
            self.record.mark_break();
            self.push_marks();
            self.is_interrupted = self.pending.as_ref().is_some_and(|pending| pending.detector.has_device_time());
            if !self.is_interrupted {
                self.end_connection(false);
            }
        }
    }

    /// After an outage, unless the clock of the sensor has kept running: no window spans the outage, and
    /// arrival times and device times start anew.
    fn judge_outage(&mut self, batch: &Batch) {
        self.is_interrupted = false;
        let device_ns = batch.device_ns.first().copied();
        let at_ns = batch.arrivals.first().map(|arrival| arrival.at_ns);
        let clock = match (&mut self.pending, at_ns) {
            (Some(pending), Some(at_ns)) => pending.after_outage(device_ns, at_ns),
            _ => ClockAfterOutage::Unknown,
        };
        if clock != ClockAfterOutage::RunsOn {
            let marks = self.pending.as_mut().map(PendingRows::take_marks).unwrap_or_default();
            self.end_connection(clock == ClockAfterOutage::Restarted);
            marks.into_iter().for_each(|mark| self.record.push_mark(mark));
        }
    }

    fn end_connection(&mut self, has_restarted: bool) {
        let ended = self.pending.take().and_then(|pending| pending.detector.summary());
        self.record.end_connection(ended, has_restarted);
    }

    fn mark(&mut self, text: &str) {
        let pending = self.pending.as_ref().map_or(Duration::ZERO, PendingRows::pending_duration);
        let at_s = self.record.span.data_time(self.record.rate.hz()).saturating_add(pending).as_secs_f64();
        if self.marks.len() < MOST_MARKS {
            self.marks.push(PlaceMark { at_s, text: text.to_owned() });
        }
    }

    /// Adds a gap that the reader of the stream knows of, such as one between two files; `None` for an
    /// unknown number of samples. Rows that are pending are decided first.
    pub fn gap(&mut self, missing: Option<u64>) {
        self.finish();
        self.record.push_known_gap(missing);
    }

    /// The stream has ended: the rows that are pending are decided.
    pub fn finish(&mut self) {
        while self.finish_to_second() {}
    }

    /// As [`finish`](Self::finish), up to the next whole second. Returns whether rows are left.
    #[must_use]
    pub fn finish_to_second(&mut self) -> bool {
        if let (Some(pending), None) = (&mut self.pending, self.finishing) {
            let are_few = pending.detector.summary().is_some_and(|summary| summary.samples_pending().is_some());
            self.finishing = Some(are_few && self.record.rate.is_open());
            pending.finish();
        }
        let has_more = self.continue_to_second();
        if let (false, Some(are_few)) = (has_more, self.finishing) {
            self.finishing = None;
            self.record.end(self.arrivals());
            if are_few {
                self.record.rate.doubt();
            }
        }
        has_more
    }

    /// Ends the record here: samples that are pending or follow do not count.
    pub fn end_here(&mut self) {
        self.record.end_here();
    }

    /// The settings of the analysis.
    pub const fn settings(&self) -> &Settings {
        &self.record.settings
    }

    /// The message that is measured; `None` before the first sample.
    pub fn layout(&self) -> Option<&Layout> {
        self.record.accumulators.layout.as_deref()
    }

    /// Rate, counts and gaps of the samples so far.
    pub fn timing(&self) -> Timing {
        self.record.timing()
    }

    /// Whether the data time asked for has passed: by the samples or, if their rate is not known, by their
    /// stamps and half a second later, for [`finish`](Self::finish) to decide.
    pub fn is_complete(&self) -> bool {
        let pending = self.pending.as_ref().map_or(Duration::ZERO, PendingRows::certain_duration);
        let passed = pending.saturating_sub(LATEST_ARRIVAL);
        self.record.is_complete(if pending < MIN_PENDING { Duration::ZERO } else { passed })
    }

    /// Data time so far, including that of missing and of excluded samples.
    pub fn data_time(&self) -> Duration {
        self.record.span.data_time(self.record.rate.hz())
    }

    /// The number of rows, those taken last, that are behind the end of the record or may be.
    pub fn rows_after_end(&self) -> u64 {
        self.record.span.after_end + self.pending.as_ref().map_or(0, PendingRows::pending)
    }

    /// The number of rows that were left out, each when it was taken, because they repeat others.
    pub fn repeated_rows(&self) -> u64 {
        self.order().map_or(0, |order| order.repeated)
    }

    /// Whole seconds of data time so far, including those missing or excluded.
    pub fn seconds(&self) -> u64 {
        self.record.span.seconds(self.record.rate.hz())
    }

    /// Excludes all data so far as warm-up. Returns the data time excluded.
    pub fn end_warm_up(&mut self) -> Duration {
        let so_far = self.data_time();
        self.record.end_warm_up();
        so_far
    }

    /// Starts the measurement over: data time, and the duration asked for, count from here. The counts
    /// of the link are kept. Returns the data time that had passed, which is excluded.
    pub fn start_over(&mut self) -> Duration {
        let so_far = self.data_time();
        self.record.start_over();
        self.marks.clear();
        if let Some(pending) = &mut self.pending {
            pending.detector.restart_intervals();
        }
        so_far
    }

    fn push_reply(&mut self, reply: &RegisterContents) {
        let now = || self.pending.as_ref().and_then(|pending| pending.detector.summary());
        let effect = self.record.push_reply(reply, now);
        match (effect, &mut self.pending) {
            (RateEffect::Known(rate_hz), Some(pending)) => pending.detector.set_reported_rate(rate_hz),
            (RateEffect::Replace(_), _) => {
                self.finish();
                self.pending = None;
            }
            _ => {}
        }
        self.record.apply(effect);
    }

    /// Adds the marks that no row follows.
    fn push_marks(&mut self) {
        let marks = self.pending.as_mut().map(PendingRows::take_marks).unwrap_or_default();
        marks.into_iter().for_each(|mark| self.record.push_mark(mark));
    }
}

//! One record: rows, gaps and replies of a stream to sums.

use std::{sync::Arc, time::Duration};

use imu_noise::timebase::{GapEvent, TimebaseSummary};
use vn100_protocol::{BINARY, Layout, RegisterContents, stream::MarkKind};

use super::{
    accumulators::Accumulators,
    gaps::Gaps,
    measured_span::MeasuredSpan,
    pending_rows::Resolved,
    rate_authority::{RateAuthority, RateEffect},
    row_slice::RowSlice,
    saturation::Saturation,
    sensor_replies::SensorReplies,
};
use crate::{
    rate_change::RateChange,
    settings::Settings,
    snapshot::{MissingFrom, Timing},
};

/// The parts of a record. Each row, gap and reply is passed to all parts that it concerns.
#[derive(Debug, Default)]
pub(crate) struct DataRecord {
    pub(crate) settings: Settings,
    pub(crate) rate: RateAuthority,
    pub(crate) span: MeasuredSpan,
    pub(crate) gaps: Gaps,
    pub(crate) replies: SensorReplies,
    pub(crate) accumulators: Accumulators,
    pub(crate) saturation: Saturation,
    /// The longest stretch before the last change of a rate that nothing tells.
    longest: Option<Box<Stretch>>,
    /// The first such change.
    pub(crate) parted: Option<RateChange>,
}

/// The samples at one rate.
#[derive(Debug)]
struct Stretch {
    hz: f64,
    arrivals: TimebaseSummary,
    span: MeasuredSpan,
    gaps: Gaps,
    accumulators: Accumulators,
    saturation: Saturation,
}

impl Stretch {
    fn duration_s(&self) -> f64 {
        (self.span.samples + self.gaps.missing) as f64 / self.hz
    }
}

impl DataRecord {
    pub(crate) fn new(settings: Settings) -> Self {
        Self {
            rate: RateAuthority::new(settings.rate_hz),
            span: MeasuredSpan::new(settings.skip, settings.duration),
            settings,
            ..Self::default()
        }
    }

    /// Sets the message of the samples; that of the first sample decides.
    pub(crate) fn set_layout(&mut self, layout: &Arc<Layout>) {
        if self.accumulators.layout.is_none() {
            self.rate.set_layout(layout);
            let layout = match self.settings.compensated {
                None => Arc::clone(layout),
                said => Arc::new(Layout { compensated: said, ..Layout::clone(layout) }),
            };
            self.accumulators.begin(layout, &self.settings);
        }
    }

    pub(crate) fn push(&mut self, resolved: Resolved<'_>) {
        match resolved {
            Resolved::Rows(rows) => self.push_rows(rows),
            // what follows the end tells nothing of the record
            _ if self.is_complete(Duration::ZERO) => {}
            Resolved::Mark(mark) => self.push_mark(mark),
            Resolved::Event(event) => self.push_event(event),
        }
    }

    /// Adds frame-major rows without a gap between them.
    pub(crate) fn push_rows(&mut self, rows: RowSlice<'_>) {
        if rows.counts.is_empty() {
            return;
        }
        let rejected = self.gaps.take_rejected();
        self.push_gap(rejected, true);
        let rate_hz = self.rate.hz();
        if let Some((measured, first_index)) = self.span.push(rows.len(), rate_hz, self.rate.is_excluding()) {
            self.accumulators.push(rows.at(measured), first_index, rate_hz);
        }
    }

    pub(crate) fn push_mark(&mut self, mark: MarkKind) {
        match mark {
            MarkKind::Rejected => self.gaps.push_rejected_row(),
            MarkKind::Printed(format) => {
                if self.accumulators.printed.push(format) {
                    self.break_segment(Some(0));
                }
            }
            // these count with the samples alone
            _ if self.rate.is_excluding() || self.is_complete(Duration::ZERO) => {}
            MarkKind::Saturated(axes) => self.saturation.push(axes, self.span.data_time(self.rate.hz())),
            MarkKind::Temperature(counts) => self.accumulators.push_reading(counts),
        }
    }

    fn push_event(&mut self, event: GapEvent) {
        match event {
            // these samples are added as rows, not as an event
            GapEvent::Samples(_) => {}
            GapEvent::Missing(missing) => self.push_gap(missing, false),
            GapEvent::UnknownGap => self.push_unknown_gap(),
            GapEvent::Restart => {
                self.gaps.restarts += 1;
                self.push_unknown_gap();
            }
            GapEvent::TimeStep => {
                self.gaps.time_steps += 1;
                self.push_unknown_gap();
            }
            GapEvent::FalseTime => self.gaps.false_times += 1,
            GapEvent::CounterInUse => self.gaps.use_evidence(MissingFrom::Counter),
            GapEvent::DeviceTimeInUse { rate_hz } => {
                self.gaps.use_evidence(MissingFrom::DeviceTime);
                let effect = self.rate.take_device_time(rate_hz, &self.span);
                self.apply(effect);
            }
            GapEvent::Rate(nominal) => {
                if self.rate.is_excluding() && nominal.hz() == self.rate.hz() {
                    let effect = self.rate.take_change(nominal.hz(), nominal.hz(), None, &self.span);
                    self.apply(effect);
                }
                let effect = self.rate.take_nominal(nominal, self.replies.rate_hz(), &self.span);
                self.apply(effect);
                self.gaps.use_evidence(MissingFrom::Arrival);
            }
            GapEvent::RateChanged { from_hz, to_hz, until } if self.rate.is_of_any_sensor() => {
                self.part(from_hz, to_hz, *until);
            }
            GapEvent::RateChanged { from_hz, to_hz, until } => {
                let effect = self.rate.take_change(from_hz, to_hz, Some(*until), &self.span);
                self.apply(effect);
            }
            GapEvent::Refused(_) => {
                self.gaps.refuse_arrivals(self.rate.is_excluding());
                self.rate.refuse_arrivals();
            }
        }
    }

    /// Begins a stretch at another rate; of those before it the longest is kept.
    fn part(&mut self, from_hz: f64, to_hz: f64, arrivals: TimebaseSummary) {
        let after_samples = self.span.samples;
        self.parted.get_or_insert(RateChange { after_samples, from_hz, to_hz });
        let (longest, mut span) = (self.longest.take(), self.span.clone());
        let layout = self.accumulators.layout.clone();
        let stretch = self.take_stretch(arrivals);
        self.accumulators.layout = layout;
        self.longest = Some(match longest {
            Some(longest) if longest.duration_s() >= stretch.duration_s() => longest,
            _ => Box::new(stretch),
        });
        span.rescale(from_hz, to_hz);
        self.span = span;
        self.rate.set_measured(to_hz);
        self.discard();
    }

    fn take_stretch(&mut self, arrivals: TimebaseSummary) -> Stretch {
        Stretch {
            hz: self.rate.hz(),
            arrivals,
            span: self.span.clone(),
            gaps: self.gaps.clone(),
            accumulators: std::mem::take(&mut self.accumulators),
            saturation: std::mem::take(&mut self.saturation),
        }
    }

    /// Ends the record with the samples so far, of this rate.
    pub(crate) fn end_here(&mut self) {
        self.span.end_here();
        self.longest = None;
    }

    /// The stream has ended. Of a record whose rate has changed, the longest stretch is the result.
    pub(crate) fn end(&mut self, arrivals: Option<TimebaseSummary>) {
        let (Some(longest), Some(arrivals)) = (self.longest.take(), arrivals) else { return };
        let (all, after_end) = (self.span.samples + self.span.excluded, self.span.after_end);
        let last = self.take_stretch(arrivals);
        let Stretch { hz, arrivals, span, gaps, accumulators, saturation } =
            if longest.duration_s() >= last.duration_s() { *longest } else { last };
        (self.span, self.gaps, self.accumulators, self.saturation) = (span, gaps, accumulators, saturation);
        (self.span.excluded, self.span.after_end) = (all - self.span.samples, after_end);
        self.rate.set_measured(hz);
        self.rate.measured = Some(arrivals);
    }

    /// Takes a reply; the effect of a reported rate is to be passed to [`apply`](Self::apply).
    pub(crate) fn push_reply(
        &mut self,
        reply: &RegisterContents,
        now: impl Fn() -> Option<TimebaseSummary>,
    ) -> RateEffect {
        let is_excluded = self.rate.is_excluding();
        self.replies.push(reply, self.span.samples, is_excluded);
        let is_of_sentences = self.accumulators.layout.as_ref().is_none_or(|layout| layout.message != BINARY);
        match self.replies.rate_hz().filter(|_| is_of_sentences && !is_excluded) {
            Some(device_hz) => self.rate.take_device_rate(device_hz, now, &self.span),
            None => RateEffect::None,
        }
    }

    pub(crate) fn apply(&mut self, effect: RateEffect) {
        match effect {
            RateEffect::None | RateEffect::Known(_) => {}
            RateEffect::Exclude => self.replies.exclude(self.span.samples),
            RateEffect::Resume => self.push_unknown_gap(),
            RateEffect::Discard { from_hz, to_hz } => {
                self.span.rescale(from_hz, to_hz);
                self.gaps.forget_rejected();
                self.discard();
            }
            RateEffect::Replace(device_hz) => {
                let samples = self.span.samples;
                self.span.rescale(self.rate.hz(), device_hz);
                self.rate.replace(device_hz, samples);
                self.gaps.forget_rejected();
                self.gaps.end_detection();
                self.discard();
            }
        }
    }

    /// Marks that the link is lost.
    pub(crate) fn mark_break(&mut self) {
        if !self.rate.is_excluding() {
            self.replies.mark_break(self.span.samples);
        }
    }

    /// Ends a connection: after an outage nothing that was known before is certain.
    pub(crate) fn end_connection(&mut self, ended: Option<TimebaseSummary>, has_restarted: bool) {
        self.gaps.restarts += u64::from(has_restarted);
        self.rate.end_connection(ended);
        self.gaps.end_detection();
        if !self.is_complete(Duration::ZERO) {
            self.push_unknown_gap();
        }
    }

    pub(crate) fn end_warm_up(&mut self) {
        self.span.end_warm_up(self.rate.hz());
        self.discard();
    }

    /// Starts the record over; the replies of the sensor are kept.
    pub(crate) fn start_over(&mut self) {
        self.span.start_over(self.settings.skip);
        self.gaps.forget_rejected();
        self.rate.start_over();
        self.accumulators.recent = None;
        self.discard();
    }

    /// Whether the data time asked for has passed, counting `pending` data time.
    pub(crate) fn is_complete(&self, pending: Duration) -> bool {
        self.span.is_complete(self.rate.hz(), pending)
    }

    pub(crate) fn timing(&self) -> Timing {
        Timing {
            rate_hz: self.rate.hz(),
            rate_from: self.rate.rate.from,
            samples: self.span.samples,
            excluded: self.span.excluded,
            missing: self.gaps.missing,
            missing_from: self.gaps.missing_from(),
            gaps: self.gaps.gaps,
            segments: self.span.segments,
        }
    }

    fn push_gap(&mut self, missing: u64, by_rejected: bool) {
        let counted = self.span.gap(missing, self.rate.hz(), self.rate.is_excluding());
        if counted > 0 {
            self.gaps.count(counted, by_rejected);
            self.accumulators.gap(Some(counted));
        }
    }

    pub(crate) fn push_known_gap(&mut self, missing: Option<u64>) {
        match missing {
            Some(missing) => self.push_gap(missing, false),
            None => self.push_unknown_gap(),
        }
    }

    fn push_unknown_gap(&mut self) {
        self.gaps.forget_rejected();
        self.break_segment(None);
    }

    /// Breaks the segment: no window spans this place. `None`: an unknown number is missing.
    fn break_segment(&mut self, missing: Option<u64>) {
        if self.span.has_begun() {
            self.span.break_segment();
            self.accumulators.gap(missing);
        }
    }

    fn discard(&mut self) {
        self.span.discard();
        self.gaps.discard();
        self.saturation = Saturation::default();
        if let Some(layout) = self.accumulators.layout.clone() {
            self.accumulators.begin(layout, &self.settings);
        }
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::timebase::{GapDetector, NominalRate, Refusal};
    use vn100_protocol::VNYMR;

    use super::*;
    use crate::snapshot::{MissingFrom, RateFrom};

    const WIDTH: usize = 12;

    fn record(settings: Settings) -> DataRecord {
        let mut record = DataRecord::new(settings);
        record.set_layout(&Arc::new(VNYMR.clone()));
        record
    }

    fn rows(record: &mut DataRecord, rows: usize) {
        record.push(Resolved::Rows(RowSlice::new(&vec![1; rows * WIDTH], WIDTH, &[])));
    }

    fn event(record: &mut DataRecord, event: GapEvent) {
        record.push(Resolved::Event(event));
    }

    /// Samples, missing, gaps and segments.
    fn counts(record: &DataRecord) -> (u64, u64, u64, u64) {
        let timing = record.timing();
        (timing.samples, timing.missing, timing.gaps, timing.segments)
    }

    #[test]
    fn a_detector_counts_what_rejected_rows_would() {
        let mut record = record(Settings::default());
        event(&mut record, GapEvent::Rate(NominalRate::Snapped(50.0)));
        rows(&mut record, 3);
        record.push(Resolved::Mark(MarkKind::Rejected));
        rows(&mut record, 3);
        let timing = record.timing();
        assert_eq!((timing.rate_hz, timing.rate_from, timing.missing), (50.0, RateFrom::Arrival, 0));
        event(&mut record, GapEvent::CounterInUse);
        event(&mut record, GapEvent::Refused(Refusal::NoTimePasses { samples: 9 }));
        assert_eq!(record.timing().missing_from, MissingFrom::Counter);
        record.end_connection(None, false);
        record.push(Resolved::Mark(MarkKind::Rejected));
        rows(&mut record, 1);
        assert_eq!(counts(&record), (7, 1, 1, 2), "rejected rows count again behind the break");
    }

    #[test]
    fn a_connection_at_the_rate_of_the_record_ends_an_exclusion() {
        let mut record = record(Settings { rate_hz: Some(40.0), ..Settings::default() });
        rows(&mut record, 4);
        record.end_connection(None, false);
        let until = Box::new(GapDetector::new(&[20.0, 40.0], Some(40.0)).summary().unwrap());
        event(&mut record, GapEvent::RateChanged { from_hz: 40.0, to_hz: 20.0, until });
        rows(&mut record, 5);
        record.end_connection(None, false);
        event(&mut record, GapEvent::Rate(NominalRate::Known(40.0)));
        rows(&mut record, 6);
        assert_eq!((counts(&record).0, record.timing().excluded, record.rate.other_rate_samples), (10, 5, 5));
    }

    #[test]
    fn temperatures_and_saturation_count_with_the_samples_alone() {
        let marks = |record: &mut DataRecord| {
            record.push(Resolved::Mark(MarkKind::Temperature(3000)));
            record.push(Resolved::Mark(MarkKind::Saturated(1)));
            record.accumulators.temperature.is_some()
        };
        let settings = Settings { rate_hz: Some(40.0), ..Settings::default() };
        let mut measuring = record(settings.clone());
        rows(&mut measuring, 4);
        assert!(marks(&mut measuring));
        let mut complete = record(Settings { duration: Some(Duration::from_millis(75)), ..settings.clone() });
        rows(&mut complete, 4);
        assert!(!marks(&mut complete));
        let mut excluding = record(settings);
        rows(&mut excluding, 4);
        let effect = excluding.rate.take_change(40.0, 20.0, None, &excluding.span);
        excluding.apply(effect);
        assert!(!marks(&mut excluding));
    }

    #[test]
    fn a_measurement_that_is_complete_has_no_gap_behind_it() {
        for (duration_ms, segments) in [(75, 1), (1000, 2)] {
            let duration = Some(Duration::from_millis(duration_ms));
            let mut record = record(Settings { duration, ..Settings::default() });
            rows(&mut record, 3);
            record.end_connection(None, false);
            rows(&mut record, 3);
            assert_eq!(record.timing().segments, segments, "{duration_ms} ms");
        }
    }
}

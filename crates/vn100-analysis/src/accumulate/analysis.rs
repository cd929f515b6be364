//! The owner of all accumulators: batches of rows in, snapshots out. Pure: no task, no clock.

mod placing;
mod rate;
mod restart;

use std::{collections::BTreeMap, sync::Arc, time::Duration};

use imu_noise::{Refusal, SpectrumPlan, TimebaseSummary};
use vn100_protocol::stream::{Batch, LinkEvent, LinkEventKind, MarkKind, RegisterReply, StreamCounts};
use vn100_protocol::{Layout, PrintFormat, Register};

use crate::{
    accumulate::{
        channel_state::ChannelState, norms::Norm, polled::Polled, recent::Recent, repeats::Repeats, waiting::Waiting,
    },
    settings::{DEFAULT_RATE_HZ, Settings},
    snapshot::{FalseRate, MissingFrom, Outages, RateChange, RateFrom, Snapshot, Timing},
    warning::{
        Warning, WarningKind,
        advice::{self, Findings},
    },
};

/// So many channels never repeat all at once while a sensor lives.
const TELLING_CHANNELS: usize = 9;

/// One stream's statistics, growing batch by batch. How the stream was cut into batches changes
/// nothing.
#[derive(Debug)]
pub struct Analysis {
    settings: Settings,
    /// Takes the place of the time to be skipped, once somebody has said that the warm-up is over.
    warm_up: Option<Duration>,
    timing: Timing,
    layout: Option<Arc<Layout>>,
    channels: Vec<ChannelState>,
    norms: Vec<Norm>,
    /// Only where asked for.
    recent: Option<Recent>,
    column: Vec<i32>,
    repeats: Repeats,
    registers: BTreeMap<u8, String>,
    /// What these were, and how many samples there were, when the link was lost last.
    before_break: Option<(BTreeMap<u8, String>, u64)>,
    /// The first two serial numbers that differ, in their order, and the samples before the second.
    two_serials: Option<(String, String, u64)>,
    polled: Polled,
    link: StreamCounts,
    /// Of a stream with arrival stamps.
    waiting: Option<Waiting>,
    /// Lines lost whole are told of, by counters or arrival times.
    missing_by_evidence: bool,
    /// Why the stamps of a stretch of the link that is over were no time base; the first such
    /// reason.
    refused_before: Option<Refusal>,
    rate_change: Option<RateChange>,
    /// What the stamps said until the rate changed; `None` where they said nothing, or it has not
    /// changed.
    arrivals_until: Option<TimebaseSummary>,
    /// What they said in the last stretch of the link that is over and bore out the rate.
    borne_out: Option<TimebaseSummary>,
    false_rate: Option<FalseRate>,
    /// Samples left out before the rate changed.
    left_out_before: u64,
    /// Samples left out for coming at another rate, until the rate was again that of the record.
    other_rate_lines: u64,
    outages: Outages,
    /// Of the missing, those that bad lines took the place of; the others were told by evidence.
    missing_by_bad_lines: u64,
    /// When the last row came.
    last_row_ns: Option<i64>,
    /// How many lines told the rate, where they were too few to be sure of it.
    rate_by_few: Option<u64>,
    /// Absolute index of the next sample, those missing counted in.
    index: u64,
    /// Whether the next sample goes on with the segment of the last one.
    in_segment: bool,
    /// Bad lines since the last good one: each takes the place of a sample, once a good one
    /// follows.
    bad_lines_pending: u64,
    printed: Option<PrintFormat>,
    coarsest: PrintFormat,
    print_changes: u64,
}

impl Analysis {
    /// An analysis that has seen nothing.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        let rate_hz = settings.rate_hz.unwrap_or(DEFAULT_RATE_HZ);
        let rate_from = if settings.rate_hz.is_some() { RateFrom::Option } else { RateFrom::Assumed };
        Self {
            settings,
            warm_up: None,
            timing: Timing {
                rate_hz,
                rate_from,
                samples: 0,
                left_out: 0,
                missing: 0,
                missing_from: MissingFrom::BadLines,
                gaps: 0,
                segments: 0,
            },
            layout: None,
            channels: Vec::new(),
            norms: Vec::new(),
            recent: None,
            column: Vec::new(),
            repeats: Repeats::default(),
            registers: BTreeMap::new(),
            before_break: None,
            two_serials: None,
            polled: Polled::new(),
            link: StreamCounts::default(),
            waiting: None,
            missing_by_evidence: false,
            refused_before: None,
            rate_change: None,
            arrivals_until: None,
            borne_out: None,
            false_rate: None,
            left_out_before: 0,
            other_rate_lines: 0,
            outages: Outages::default(),
            missing_by_bad_lines: 0,
            last_row_ns: None,
            rate_by_few: None,
            index: 0,
            in_segment: false,
            bad_lines_pending: 0,
            printed: None,
            coarsest: PrintFormat::Current,
            print_changes: 0,
        }
    }

    /// Takes what one read brought.
    pub fn absorb(&mut self, batch: &Batch) {
        self.link = batch.link;
        self.last_row_ns = batch.arrivals.last().map(|arrival| arrival.at_ns).or(self.last_row_ns);
        batch.registers.iter().for_each(|value| self.take_register(value));
        if let (None, Some(layout)) = (&self.layout, &batch.layout) {
            self.begin(Arc::clone(layout));
        }
        // a layout has channels; without one there are no rows
        let width = self.channels.len().max(1);
        if self.waiting.is_none() && batch.arrivals.is_empty() && batch.counters.is_empty() {
            let mut row = 0;
            for mark in &batch.marks {
                self.take_rows(&batch.counts[row * width..mark.before_row * width]);
                row = mark.before_row;
                self.take_mark(mark.kind);
            }
            self.take_rows(&batch.counts[row * width..]);
        } else {
            self.take_waiting(batch, width);
        }
    }

    /// Takes what befell the link. Nobody knows what went by while it was down: no window spans
    /// that, and arrival times start anew.
    pub fn take_link_event(&mut self, event: &LinkEvent) {
        // each row is before one outage
        self.outages.take(event, self.last_row_ns.take());
        if matches!(event.kind, LinkEventKind::Down { .. }) {
            self.finish();
            let ended = self.waiting.take().and_then(|waiting| waiting.summary());
            // what is left out is not judged
            if self.rate_change.is_none() {
                self.before_break = Some((self.registers.clone(), self.timing.samples));
                self.refused_before = self.refused_before.or_else(|| ended?.refusal);
                self.borne_out = ended.filter(|ended| ended.nominal.is_some()).or(self.borne_out);
            }
            self.missing_by_evidence = false;
            if !self.is_complete() {
                self.take_unknown_gap();
            }
        }
    }

    /// What was asked for.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Whether all the data time asked for has passed: by the samples, and by the stamps of lines
    /// that are held because their rate is not sure. For these [`finish`](Self::finish) decides.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        (self.index > 0 && self.index >= self.end_index()) || self.is_complete_by_lines_held()
    }

    /// Whole seconds of data time passed, those missing or left out counted in.
    #[must_use]
    pub fn seconds(&self) -> u64 {
        (self.index as f64 / self.timing.rate_hz) as u64
    }

    /// All results so far.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let layout_channels = self.layout.as_ref().map_or(&[][..], |layout| &layout.channels);
        let restarted = (self.channels.iter().zip(layout_channels))
            .filter(|(state, _)| state.has_restarted())
            .map(|(_, channel)| channel.name.to_string())
            .collect();
        let mut snapshot = Snapshot {
            layout: self.layout.clone(),
            timing: Timing { missing_from: self.missing_from(), ..self.timing },
            arrivals: match self.rate_change {
                Some(_) => self.arrivals_until,
                None => self.waiting.as_ref().and_then(Waiting::summary),
            },
            refused_before: self.refused_before,
            rate_change: self.rate_change,
            false_rate: self.false_rate,
            other_rate_lines: self.other_rate_lines,
            registers: self.registers.clone(),
            link: self.link,
            outages: self.outages,
            estimator: self.settings.estimator,
            deviation: self.settings.deviation,
            detrended: self.settings.detrend,
            quantization: self.settings.quantization,
            skipped: self.skipped(),
            channels: Vec::new(),
            norms: self.norms.clone(),
            polled: self.polled.snapshot(),
            warnings: Vec::new(),
            recent: self.recent.clone(),
        };
        let shape = snapshot.shape();
        snapshot.channels = (self.channels.iter().zip(layout_channels))
            .map(|(state, channel)| state.snapshot(self.coarsest.decimals(channel), &shape))
            .collect();
        let findings =
            Findings { repeated_lines: self.repeats.repeated(), print_changes: self.print_changes, restarted };
        snapshot.warnings = advice::warnings(&snapshot, findings);
        snapshot.warnings.extend(self.another_sensor());
        snapshot
    }
}

impl Analysis {
    fn begin(&mut self, layout: Arc<Layout>) {
        let plan = SpectrumPlan::new();
        self.channels =
            (layout.channels.iter()).map(|channel| ChannelState::new(channel, &self.settings, &plan)).collect();
        self.norms = Norm::all(&layout);
        self.layout = Some(layout);
    }

    fn take_mark(&mut self, mark: MarkKind) {
        match mark {
            MarkKind::BadLine => self.bad_lines_pending += 1,
            MarkKind::Printed(format) => self.change_print_format(format),
        }
    }

    /// Frame-major rows, nothing missing between them.
    fn take_rows(&mut self, counts: &[i32]) {
        if counts.is_empty() {
            return;
        }
        let width = self.channels.len();
        let rows = counts.len() / width;
        let bad_lines = std::mem::take(&mut self.bad_lines_pending);
        self.missing_by_bad_lines += self.take_gap(bad_lines);
        let rows_until = |index: u64| rows.min(usize::try_from(index.saturating_sub(self.index)).unwrap_or(usize::MAX));
        let end = if self.rate_change.is_some() { 0 } else { rows_until(self.end_index()) };
        let skipped = rows_until(self.samples_in(self.skipped())).min(end);
        let used = end - skipped;
        self.timing.left_out += (rows - used) as u64;
        self.index += rows as u64;
        if used == 0 {
            return;
        }
        if !self.in_segment {
            self.in_segment = true;
            self.timing.segments += 1;
        }
        self.timing.samples += used as u64;
        let first_index = self.index - (rows - skipped) as u64;
        if self.settings.recent && self.recent.is_none() {
            self.recent = Some(Recent::new(width, self.timing.rate_hz));
        }
        let counts = &counts[skipped * width..end * width];
        // a few coarse channels repeat by chance
        if width >= TELLING_CHANNELS {
            counts.chunks_exact(width).for_each(|row| self.repeats.push(row));
        }
        for (index, channel) in self.channels.iter_mut().enumerate() {
            self.column.clear();
            self.column.extend(counts.chunks_exact(width).map(|row| row[index]));
            channel.absorb(&mut self.column);
            if let Some(recent) = &mut self.recent {
                recent.push(index, first_index, &self.column);
            }
        }
        for norm in &mut self.norms {
            norm.push(counts, width, &mut self.column);
        }
    }

    /// So many samples are missing before the next row; before the first row of all nothing is.
    /// Gives how many of them count.
    fn take_gap(&mut self, missing: u64) -> u64 {
        if missing == 0 || self.index == 0 {
            return 0;
        }
        let counted = missing.min(self.end_index().saturating_sub(self.index));
        self.index += missing;
        if counted == 0 || self.timing.samples == 0 || self.rate_change.is_some() {
            return 0;
        }
        self.timing.missing += counted;
        self.timing.gaps += 1;
        self.break_segment(Some(counted));
        counted
    }

    /// Nobody knows how many samples are missing before the next row.
    fn take_unknown_gap(&mut self) {
        self.bad_lines_pending = 0;
        if self.timing.samples > 0 {
            self.break_segment(None);
        }
    }

    /// The index of the first sample at or behind this data time.
    fn samples_in(&self, time: Duration) -> u64 {
        // what a product of doubles adds to a whole number is no sample
        const ROUNDING: f64 = 1e-6;
        (time.as_secs_f64() * self.timing.rate_hz - ROUNDING).ceil() as u64
    }

    fn end_index(&self) -> u64 {
        self.settings.duration.map_or(u64::MAX, |duration| self.samples_in(duration))
    }

    fn take_register(&mut self, value: &RegisterReply) {
        self.polled.take(value);
        let before = self.registers.get(&value.register);
        if let Some(before) =
            before.filter(|before| value.register == Register::SERIAL_NUMBER.0 && **before != value.fields)
        {
            let samples = self.timing.samples;
            self.two_serials.get_or_insert_with(|| (before.clone(), value.fields.clone(), samples));
        }
        // what is left out is perhaps another sensor's, and set otherwise
        if self.rate_change.is_none() {
            self.registers.insert(value.register, value.fields.clone());
            self.take_device_rate();
        }
    }

    fn another_sensor(&self) -> Option<Warning> {
        let (before, then, samples) = self.two_serials.as_ref()?;
        let is_left_out = self.rate_change.is_some_and(|change| change.after_samples == *samples);
        let text = if is_left_out {
            format!(
                "the sensor with the serial number {before} answered at first and {then} behind it, whose samples are left out: the result \
                 is that of the first"
            )
        } else {
            format!(
                "the sensor with the serial number {before} answered at first and {then} behind it: the result mixes two sensors. Measure \
                 each of them alone"
            )
        };
        Some(Warning { kind: WarningKind::AnotherSensor, channels: Vec::new(), text })
    }

    /// Values of another resolution are not comparable at the level of the last digit: no window
    /// spans the change.
    fn change_print_format(&mut self, format: PrintFormat) {
        let before = self.printed.replace(format);
        if format != PrintFormat::Current {
            self.coarsest = format;
        }
        if before.is_some() {
            self.print_changes += 1;
            if self.timing.samples > 0 {
                self.break_segment(Some(0));
            }
        }
    }

    /// The next sample begins another segment, if one comes. `missing` is `None` where nobody
    /// knows.
    fn break_segment(&mut self, missing: Option<u64>) {
        self.in_segment = false;
        for channel in &mut self.channels {
            channel.gap(missing);
        }
    }
}

//! The results of an analysis, at any moment and at its end.

use super::Analysis;
use crate::{
    accumulate::{data_record::DataRecord, pending_rows::PendingRows},
    averaging_times::{AveragingTimes, without_window},
    snapshot::Snapshot,
    warning::checks,
};

impl Analysis {
    /// Adds the rows that wait for others of their block, so that snapshots copy no sums.
    pub fn settle(&mut self) {
        self.record.accumulators.settle();
    }

    /// All results so far; without a sample, a snapshot without channels.
    pub fn snapshot(&self) -> Snapshot {
        let DataRecord { settings, rate, span, replies, accumulators, .. } = &self.record;
        let accumulators = accumulators.settled();
        let mut snapshot = Snapshot {
            layout: accumulators.layout.as_ref().map(|layout| replies.layout_of(layout)),
            timing: self.record.timing(),
            arrivals: rate.arrivals(|| self.arrivals()),
            refused_before: rate.refused_before,
            rate_change: rate.change(),
            parted: self.record.parted,
            repeated_rows: self.repeated_rows(),
            moved_rows: self.order().map_or(0, |order| order.moved),
            pending_rows: self.pending.as_ref().map_or(0, PendingRows::pending),
            false_rate: rate.false_rate.clone(),
            false_report: rate.false_report.clone(),
            other_rate_samples: rate.other_rate_samples,
            registers: replies.registers.clone(),
            link: self.link,
            outages: self.outages,
            marks: self.marks.clone(),
            port_shared_with: self.port_shared_with.clone(),
            saturation: self.record.saturation.clone(),
            restarts: self.record.gaps.restarts,
            time_steps: self.record.gaps.time_steps,
            false_times: self.record.gaps.false_times,
            settings: settings.clone(),
            skipped: span.skip,
            missing_times: Vec::new(),
            channels: Vec::new(),
            magnitudes: accumulators.magnitudes.clone(),
            register_channels: replies.imu_channels(),
            fingerprint: accumulators.fingerprint.clone(),
            warnings: Vec::new(),
            temperature: accumulators.temperature.clone(),
            recent: accumulators.recent(rate.hz()),
        };
        snapshot.channels = accumulators.snapshot(&snapshot.shape());
        snapshot.warnings = checks::warnings(&snapshot, &accumulators.findings());
        snapshot.warnings.extend(replies.two_sensors(rate.change()));
        snapshot
    }

    /// All results of a measurement that has ended, including the deviations at the averaging times
    /// of the settings, which [`snapshot`](Self::snapshot) leaves empty.
    pub fn final_snapshot(&self) -> Snapshot {
        let mut snapshot = self.snapshot();
        let shape = snapshot.shape();
        let (factors, mut missing) = self.settings().averaging_times.factors(&shape);
        let points = self.record.accumulators.settled().points(&factors);
        if matches!(self.settings().averaging_times, AveragingTimes::List(_)) && !points.is_empty() {
            let strides = snapshot.channels.iter().map(|channel| channel.stride);
            let found: Vec<u64> = points
                .iter()
                .zip(strides)
                .flat_map(|(points, stride)| points.iter().map(move |p| p.m * stride))
                .collect();
            let is_missing = |m: &&u64| !found.contains(m);
            missing.extend(factors.iter().filter(is_missing).map(|m| without_window(*m, &shape)));
        }
        snapshot.missing_times = missing;
        for (channel, points) in snapshot.channels.iter_mut().zip(points) {
            channel.points = points;
        }
        snapshot
    }
}

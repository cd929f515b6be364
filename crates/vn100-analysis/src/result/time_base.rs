//! Rate, counts and gaps of the samples, and what the link or file carried.

use std::collections::BTreeMap;

use imu_noise::timebase::{Arrivals, TimebaseSummary};
use schemars::JsonSchema;
use serde::Serialize;
use vn100_protocol::RejectedCounts;

use crate::{
    rate_change::RateChange,
    snapshot::{MissingFrom, Outages, RateFrom, Snapshot},
};

/// Rate, counts and gaps of the samples.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct TimeBase {
    /// Nominal rate in Hz that all averaging times rest on; null if nothing tells it and there is no
    /// sample.
    pub rate_hz: Option<f64>,
    /// Source of the nominal rate; null without a rate.
    pub rate_from: Option<RateFrom>,
    /// Rate by the arrival times in Hz; null if they do not show it.
    pub measured_hz: Option<f64>,
    /// Measured over nominal rate less 1, in ppm; null if the measured rate is not known, and in the
    /// first minute of arrivals.
    pub offset_ppm: Option<f64>,
    /// Duration of the measured samples in seconds, missing ones included.
    pub duration_s: f64,
    /// Measured samples.
    pub samples: u64,
    /// Valid samples that were excluded, by the user's choice of data time or after a change of rate.
    #[serde(rename = "left_out")]
    pub excluded: u64,
    /// Data time excluded at the beginning, in seconds.
    pub skipped_s: f64,
    /// Stretches of samples without a gap or a change of the printed scale.
    pub segments: u64,
    /// Runs of missing samples.
    pub gaps: u64,
    /// Missing samples; null if samples may be missing unseen.
    pub missing: Option<u64>,
    /// Samples known to be missing.
    pub missing_at_least: u64,
    /// Samples that arrived and are not counted yet, until it is decided whether others are missing
    /// before them; 0 at the end.
    pub pending: u64,
    /// Evidence of missing samples.
    pub missing_from: MissingFrom,
    /// Times between arrivals in microseconds; null without arrival times.
    #[serde(rename = "interarrival_us")]
    pub arrivals: Option<Arrivals>,
    /// Change of rate after which samples are excluded; null without one.
    pub rate_change: Option<RateChange>,
    /// Whether the stream has arrival times.
    #[serde(skip)]
    pub has_stamps: bool,
    /// Averaging times that were asked for and that a final result does not have, in words.
    #[serde(skip)]
    pub missing_times: Vec<String>,
}

impl TimeBase {
    /// Those of a snapshot.
    pub fn of(snapshot: &Snapshot) -> Self {
        let (timing, arrivals) = (&snapshot.timing, snapshot.arrivals);
        let is_known = timing.samples + timing.excluded > 0 || timing.rate_from != RateFrom::Assumed;
        let sees_all = timing.samples > 0 && timing.missing_from != MissingFrom::RejectedRows;
        Self {
            rate_hz: is_known.then_some(timing.rate_hz),
            rate_from: is_known.then_some(timing.rate_from),
            measured_hz: arrivals.and_then(|arrivals| arrivals.measured_hz),
            offset_ppm: arrivals.and_then(|arrivals| offset_ppm(&arrivals)),
            duration_s: timing.duration_s(),
            samples: timing.samples,
            excluded: timing.excluded,
            skipped_s: snapshot.skipped.as_secs_f64(),
            segments: timing.segments,
            gaps: timing.gaps,
            missing: sees_all.then_some(timing.missing),
            missing_at_least: timing.missing,
            pending: snapshot.pending_rows,
            missing_from: timing.missing_from,
            arrivals: arrivals.and_then(|arrivals| arrivals.arrivals),
            rate_change: snapshot.rate_change,
            has_stamps: arrivals.is_some(),
            missing_times: snapshot.missing_times.clone(),
        }
    }

    /// Whether the rate is assumed, with samples or without.
    pub fn is_rate_assumed(&self) -> bool {
        self.rate_from.is_none_or(|from| from == RateFrom::Assumed)
    }

    /// Whether all samples so far are pending until their arrival times show the rate.
    pub fn awaits_rate(&self) -> bool {
        self.pending > 0 && self.samples + self.excluded == 0 && self.is_rate_assumed()
    }

    /// Whether all samples so far lie in the time excluded at the beginning.
    pub fn is_in_warm_up(&self) -> bool {
        self.samples == 0 && self.excluded > 0 && self.skipped_s > 0.0
    }
}

/// The offset of the sensor's clock, from samples of at least a minute: a host that reads a
/// millisecond late moves it by 1000 ppm in the first second, and by 17 ppm after a minute.
fn offset_ppm(arrivals: &TimebaseSummary) -> Option<f64> {
    const COMPARED_S: f64 = 60.0;
    let duration_s = (arrivals.samples + arrivals.missing) as f64 / arrivals.nominal?.hz();
    arrivals.offset_ppm.filter(|_| duration_s >= COMPARED_S)
}

/// What a link or file carried: bytes, sentences and packets, each counted once.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct LinkCounts {
    /// Bytes read.
    pub bytes: u64,
    /// Valid sentences.
    pub frames: u64,
    /// Replies to commands.
    pub replies: u64,
    /// Commands that the line echoed.
    pub echoes: u64,
    /// Valid sentences of other messages.
    pub other_messages: u64,
    /// Binary packets.
    pub binary_packets: u64,
    /// Measured packets with an impossible number.
    pub rejected_packets: u64,
    /// Measured packets with the device time of the one before.
    pub repeated_packets: u64,
    /// Packets that fail their checksum, counted if they begin with the groups and fields of an
    /// earlier valid packet; their bytes are in skipped_bytes, and they are not in binary_packets.
    pub damaged_packets: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes: u64,
    /// Bytes lost in the buffers of the host.
    pub overrun_bytes: u64,
    /// Unsolicited errors of the sensor by code (two hexadecimal digits): how often.
    #[serde(rename = "unasked_errors")]
    pub unsolicited_errors: BTreeMap<String, u64>,
    /// How often the output was found paused and was resumed.
    pub outputs_resumed: u64,
    /// How often the link was opened again.
    pub reconnects: u64,
    /// Seconds without a link, the outage at the end included; null if unknown.
    pub down_s: Option<f64>,
    /// Rejected sentences by reason.
    #[serde(rename = "bad_frames")]
    pub rejected: RejectedCounts,
    /// First sentence of another model of sensor; null without one.
    pub other_model: Option<String>,
    /// Outages of the link, in words of every face.
    #[serde(skip)]
    pub outages: Outages,
    /// Bytes of sentences and packets, and those between them.
    #[serde(skip)]
    pub framed_bytes: u64,
}

impl LinkCounts {
    /// Those of a snapshot.
    pub fn of(snapshot: &Snapshot) -> Self {
        let (link, tally) = (&snapshot.link, &snapshot.link.tally);
        let errors = link.unsolicited_errors.iter().map(|(error, count)| (format!("{:02X}", error.code()), count));
        Self {
            bytes: link.bytes(),
            frames: tally.valid_sentences(),
            replies: link.answers(),
            echoes: link.echoes,
            other_messages: link.other_messages(),
            binary_packets: tally.packets,
            rejected_packets: tally.measured_packets.rejected,
            repeated_packets: tally.measured_packets.repeated,
            damaged_packets: tally.damaged_packets,
            skipped_bytes: link.skipped_bytes(),
            overrun_bytes: link.overrun_bytes,
            unsolicited_errors: errors.collect(),
            outputs_resumed: link.outputs_resumed,
            reconnects: link.connects.saturating_sub(1),
            down_s: if snapshot.outages.times == 0 { Some(0.0) } else { snapshot.outages.seconds() },
            rejected: tally.rejected,
            other_model: link.other_model.map(|name| name.to_string()),
            outages: snapshot.outages,
            framed_bytes: tally.bytes(),
        }
    }
}

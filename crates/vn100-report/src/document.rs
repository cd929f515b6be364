//! The JSON document of one capture, schema `vn100.analysis/1`: a contract with scripts.

pub(crate) mod comparison;
mod graphical;
pub(crate) mod noise;
pub(crate) mod plan;
pub(crate) mod progress;
pub(crate) mod source;
mod stationarity;
mod temperature;

use std::collections::BTreeMap;

use serde::Serialize;
use vn100_analysis::noise::{Deviation, Estimator, Normality, NotJudged};
use vn100_analysis::protocol::{Quantity, RejectedCounts};
use vn100_analysis::{RemedyWords, Snapshot};

use crate::{
    codes::{code_of_end, code_of_missing, code_of_rate},
    measured::Measured,
    units::{BarValues, BlockValues, ChannelValues, NormValues, Point, SignalValues, channel_values, norm_values},
};
use crate::{remedies::RemedyDocument, warnings::in_words};
use noise::{GradeDocument, NoiseDocument, VerdictDocument};
use source::SourceDocument;
use stationarity::StationarityDocument;

/// The JSON Schema (2020-12) of [`Document`], with a description of every field. Written by hand: a
/// field is added to both.
pub const ANALYSIS_SCHEMA: &str = include_str!("../schemas/analysis.json");

/// The JSON document of one source.
#[derive(Debug, Serialize)]
pub struct Document {
    schema: &'static str,
    source: SourceDocument,
    timing: Timing,
    link: Link,
    channels: Vec<Channel>,
    norms: Vec<NormValues>,
    /// `None` while the measurement is under way.
    end_reason: Option<&'static str>,
    warnings: Vec<Warning>,
}

#[derive(Debug, Serialize)]
struct Timing {
    rate_hz: f64,
    rate_from: &'static str,
    measured_hz: Option<f64>,
    offset_ppm: Option<f64>,
    duration_s: f64,
    samples: u64,
    #[serde(rename = "left_out")]
    excluded: u64,
    segments: u64,
    gaps: u64,
    missing: u64,
    missing_from: &'static str,
    interarrival_us: Option<Interarrival>,
}

#[derive(Debug, Serialize)]
struct Interarrival {
    p50: u64,
    p99: u64,
    max: u64,
}

#[derive(Debug, Serialize)]
struct Link {
    bytes: u64,
    frames: u64,
    replies: u64,
    echoes: u64,
    other_messages: u64,
    binary_packets: u64,
    rejected_packets: u64,
    repeated_packets: u64,
    damaged_packets: u64,
    skipped_bytes: u64,
    overrun_bytes: u64,
    /// Unsolicited device errors: how often each code was reported.
    #[serde(rename = "unasked_errors")]
    unsolicited_errors: BTreeMap<String, u64>,
    /// How often its output was found paused, and was resumed.
    outputs_resumed: u64,
    reconnects: u64,
    down_s: Option<f64>,
    #[serde(with = "BadFrames")]
    bad_frames: RejectedCounts,
}

#[derive(Serialize)]
#[serde(remote = "RejectedCounts")]
struct BadFrames {
    checksum: u64,
    unchecked: u64,
    grammar: u64,
    range: u64,
    truncated: u64,
    too_long: u64,
}

#[derive(Debug, Serialize)]
struct Channel {
    name: String,
    unit: String,
    rate_hz: f64,
    statistics: Statistics,
    allan: Curve,
    noise: Option<NoiseDocument>,
    stationarity: Option<StationarityDocument>,
    /// These two only at the end.
    spectrum: Option<SpectrumDocument>,
    blocks: Option<Vec<BlockValues>>,
    /// Against each figure of the data sheet; only at the end.
    verdict: Option<Vec<VerdictDocument>>,
    /// Of a gyroscope; only at the end.
    grade: Option<GradeDocument>,
}

#[derive(Debug, Serialize)]
struct Statistics {
    count: u64,
    mean: Option<f64>,
    std: Option<f64>,
    skewness: Option<f64>,
    excess_kurtosis: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    resolution: f64,
    normality: Option<NormalityDocument>,
    /// In the unit of the channel, an angle's in the branch of its mean; only at the end.
    histogram: Option<BarValues>,
}

#[derive(Debug, Serialize)]
struct NormalityDocument {
    /// 99 of 100 normal records are said to be; `null` if it cannot be judged.
    consistent: Option<bool>,
    reason: Option<String>,
    /// If the values were normal.
    skewness_error: Option<f64>,
    excess_kurtosis_error: Option<f64>,
    /// Number of independent samples with as much information on the skewness.
    effective_samples: Option<f64>,
}

/// The power spectral density by Welch's method, and its peaks.
#[derive(Debug, Serialize)]
struct SpectrumDocument {
    sides: &'static str,
    segment_samples: Option<usize>,
    segments: Option<u64>,
    /// Of the first point, and from point to point.
    step_hz: Option<f64>,
    density: Vec<f64>,
    lines: Vec<LineDocument>,
}

#[derive(Debug, Serialize)]
struct LineDocument {
    frequency_hz: f64,
    amplitude: f64,
    share_of_variance: f64,
}

#[derive(Debug, Serialize)]
struct Curve {
    deviation: &'static str,
    estimator: &'static str,
    confidence: Option<f64>,
    /// Of a foreign series: what its numbers are taken for.
    #[serde(skip_serializing_if = "Option::is_none")]
    data: Option<&'static str>,
    /// Of the regression line over the record, in the unit per second.
    slope_s: Option<f64>,
    points: Vec<Point>,
}

#[derive(Debug, Serialize)]
struct Warning {
    kind: &'static str,
    severity: &'static str,
    channels: Vec<String>,
    text: String,
    remedies: Vec<RemedyDocument>,
}

impl Document {
    /// The document of a measurement that is under way, or has `ended`; remedies are put into
    /// `words`.
    #[must_use]
    pub fn new(measured: &Measured, ended: bool, words: RemedyWords) -> Self {
        let Measured { facts, snapshot, assessment, .. } = measured;
        let channels = channel_values(snapshot, assessment).into_iter().enumerate();
        Self {
            schema: "vn100.analysis/1",
            source: SourceDocument::new(facts, snapshot),
            timing: timing(snapshot),
            link: link(snapshot),
            channels: channels.map(|(place, values)| channel(place, values, measured, ended)).collect(),
            norms: norm_values(snapshot),
            end_reason: facts.end.map(|end| code_of_end(end).code),
            warnings: (measured.warnings().into_iter())
                .map(|w| Warning {
                    kind: w.kind.name(),
                    channels: w.channels.clone(),
                    severity: w.severity.name(),
                    text: in_words(w, words),
                    remedies: w.remedies.iter().map(RemedyDocument::new).collect(),
                })
                .collect(),
        }
    }
}

const fn deviation_name(deviation: Deviation) -> &'static str {
    match deviation {
        Deviation::Allan => "allan",
        Deviation::Hadamard => "hadamard",
    }
}

const fn estimator_name(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Strided => "strided",
        Estimator::Full => "full",
        Estimator::Plain => "plain",
    }
}

fn timing(snapshot: &Snapshot) -> Timing {
    let (timing, arrivals) = (&snapshot.timing, snapshot.arrivals);
    Timing {
        rate_hz: timing.rate_hz,
        rate_from: code_of_rate(timing.rate_from).code,
        measured_hz: arrivals.and_then(|arrivals| arrivals.measured_hz),
        offset_ppm: arrivals.and_then(|arrivals| arrivals.offset_ppm),
        duration_s: timing.duration_s(),
        samples: timing.samples,
        excluded: timing.excluded,
        segments: timing.segments,
        gaps: timing.gaps,
        missing: timing.missing,
        missing_from: code_of_missing(timing.missing_from).code,
        interarrival_us: (arrivals.and_then(|arrivals| arrivals.arrivals)).map(|times| Interarrival {
            p50: times.p50_us,
            p99: times.p99_us,
            max: times.max_us,
        }),
    }
}

fn link(snapshot: &Snapshot) -> Link {
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    Link {
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
        unsolicited_errors: link
            .unsolicited_errors
            .iter()
            .map(|(error, count)| (format!("{:02X}", error.code()), count))
            .collect(),
        outputs_resumed: link.outputs_resumed,
        reconnects: link.connects.saturating_sub(1),
        down_s: if snapshot.outages.times == 0 { Some(0.0) } else { snapshot.outages.seconds() },
        bad_frames: tally.rejected,
    }
}

fn channel(place: usize, values: ChannelValues, measured: &Measured, ended: bool) -> Channel {
    let Measured { snapshot, assessment, verdicts, .. } = measured;
    let skipped_s = snapshot.skipped.as_secs_f64();
    let noise = values.noise.as_ref();
    let signal_at_end = values.signal.as_ref().filter(|_| ended);
    let verdict = noise.zip(verdicts.as_ref()).and_then(|(noise, sheet)| {
        let figures = sheet.channels.get(place).filter(|figures| !figures.is_empty())?;
        let verdict = |figure| VerdictDocument::new(&sheet.datasheet, noise.sensor, figure);
        Some(figures.iter().map(verdict).collect())
    });
    Channel {
        name: values.name,
        unit: values.unit,
        rate_hz: values.rate_hz,
        statistics: Statistics {
            count: values.count,
            mean: values.mean,
            std: values.std,
            skewness: values.skewness,
            excess_kurtosis: values.excess_kurtosis,
            min: values.min,
            max: values.max,
            resolution: values.resolution,
            normality: (values.signal.as_ref().and_then(|signal| signal.normality)).map(NormalityDocument::new),
            histogram: values.bars.filter(|_| ended),
        },
        allan: Curve {
            deviation: deviation_name(snapshot.deviation),
            estimator: estimator_name(snapshot.estimator),
            confidence: Some(assessment.confidence),
            data: (values.quantity == Quantity::Value).then_some("rate"),
            slope_s: values.slope_s,
            points: values.deviations,
        },
        noise: noise.map(|noise| NoiseDocument::new(noise, assessment.samples, snapshot.timing.rate_hz)),
        stationarity: values.signal.as_ref().map(|signal| StationarityDocument::new(&signal.disturbed, skipped_s)),
        spectrum: signal_at_end.map(SpectrumDocument::new),
        blocks: signal_at_end.map(|signal| signal.blocks.clone()),
        verdict,
        grade: noise.filter(|_| ended).and_then(GradeDocument::new),
    }
}

impl NormalityDocument {
    fn new(normality: Result<Normality, NotJudged>) -> Self {
        let judged = normality.ok();
        Self {
            consistent: judged.map(|normality| normality.is_consistent()),
            reason: normality.err().map(|reason| reason.to_string()),
            skewness_error: judged.map(|normality| normality.skewness_error),
            excess_kurtosis_error: judged.map(|normality| normality.excess_kurtosis_error),
            effective_samples: judged.map(|normality| normality.effective_samples),
        }
    }
}

impl SpectrumDocument {
    fn new(signal: &SignalValues) -> Self {
        let density = signal.density.as_ref();
        Self {
            sides: "one",
            segment_samples: density.map(|density| density.segment_samples),
            segments: density.map(|density| density.segments),
            step_hz: density.and_then(|density| density.points.first()).map(|point| point.frequency_hz),
            density: density.iter().flat_map(|density| &density.points).map(|point| point.density_unit2_hz).collect(),
            lines: (signal.disturbed.lines.iter())
                .map(|line| LineDocument {
                    frequency_hz: line.frequency_hz,
                    amplitude: line.amplitude,
                    share_of_variance: line.share_of_variance,
                })
                .collect(),
        }
    }
}

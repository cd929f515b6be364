//! The JSON document of one capture, schema `vn100.analysis/1`: a contract with scripts.

pub(crate) mod comparison;
pub(crate) mod noise;
pub(crate) mod plan;
mod signal;
pub(crate) mod source;

use std::collections::BTreeMap;

use serde::Serialize;
use vn100_analysis::noise::{Deviation, Estimator};
use vn100_analysis::{Assessment, MissingFrom, RateFrom, RemedyWords, Snapshot, SourceFacts};

use crate::{
    measured::Measured,
    units::{BarValues, BlockValues, ChannelValues, NormValues, Point, channel_values, norm_values},
};
use noise::{GradeDocument, NoiseDocument, VerdictDocument};
use signal::{NormalityDocument, SpectrumDocument, StationarityDocument, blocks};
use source::SourceDocument;

/// The JSON document of one source.
#[derive(Debug, Serialize)]
pub struct Document {
    schema: &'static str,
    source: SourceDocument,
    timing: Timing,
    link: Link,
    channels: Vec<Channel>,
    norms: Vec<NormValues>,
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
    skipped_bytes: u64,
    overrun_bytes: u64,
    /// Unsolicited device errors: how often each code was reported.
    #[serde(rename = "unasked_errors")]
    unsolicited_errors: BTreeMap<String, u64>,
    /// How often its output was found paused, and was resumed.
    outputs_resumed: u64,
    reconnects: u64,
    down_s: Option<f64>,
    bad_frames: BadFrames,
}

#[derive(Debug, Serialize)]
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
struct Curve {
    deviation: &'static str,
    estimator: &'static str,
    confidence: Option<f64>,
    /// What was removed before.
    detrend: Option<&'static str>,
    /// Of the regression line over the record, in the unit per second.
    slope_s: Option<f64>,
    points: Vec<Point>,
}

#[derive(Debug, Serialize)]
struct Warning {
    kind: &'static str,
    channels: Vec<String>,
    text: String,
}

impl Document {
    /// Of a measurement under way, or of one that has `ended`; remedies are in these `words`.
    #[must_use]
    pub fn new(
        facts: &SourceFacts,
        snapshot: &Snapshot,
        assessment: &Assessment,
        ended: bool,
        words: RemedyWords,
    ) -> Self {
        Self {
            schema: "vn100.analysis/1",
            source: SourceDocument::new(facts, snapshot),
            timing: timing(snapshot),
            link: link(snapshot),
            channels: (channel_values(snapshot, assessment).into_iter())
                .map(|values| channel(values, snapshot, assessment, ended))
                .collect(),
            norms: norm_values(snapshot),
            warnings: (snapshot.warnings.iter().chain(&assessment.warnings))
                .map(|w| Warning { kind: w.kind.name(), channels: w.channels.clone(), text: w.text.in_words(words) })
                .collect(),
        }
    }

    /// The document of a result, with all that was made of it.
    #[must_use]
    pub fn of(measured: &Measured, words: RemedyWords) -> Self {
        let Measured { facts, snapshot, assessment, filter_models, verdicts, .. } = measured;
        let mut document = Self::new(facts, snapshot, assessment, true, words);
        let figures = verdicts.as_ref().map_or(&[][..], |verdicts| &verdicts.channels);
        for (place, (channel, assessed)) in document.channels.iter_mut().zip(&assessment.channels).enumerate() {
            let Some(noise) = &assessed.noise else { continue };
            if let (Some(document), Some(Some(models))) = (&mut channel.noise, filter_models.get(place)) {
                document.add_filter_models(models);
            }
            channel.grade = GradeDocument::new(noise);
            if let (Some(sheet), Some(figures)) = (verdicts, figures.get(place).filter(|figures| !figures.is_empty())) {
                let verdict = |figure| VerdictDocument::new(&sheet.datasheet, noise.sensor, figure);
                channel.verdict = Some(figures.iter().map(verdict).collect());
            }
        }
        document
    }
}

fn timing(snapshot: &Snapshot) -> Timing {
    let (timing, arrivals) = (&snapshot.timing, snapshot.arrivals);
    Timing {
        rate_hz: timing.rate_hz,
        rate_from: match timing.rate_from {
            RateFrom::Option => "option",
            RateFrom::Device => "device",
            RateFrom::Arrival => "arrival",
            RateFrom::Assumed => "assumed",
        },
        measured_hz: arrivals.and_then(|arrivals| arrivals.measured_hz),
        offset_ppm: arrivals.and_then(|arrivals| arrivals.offset_ppm),
        duration_s: timing.duration_s(),
        samples: timing.samples,
        excluded: timing.excluded,
        segments: timing.segments,
        gaps: timing.gaps,
        missing: timing.missing,
        missing_from: match snapshot.timing.missing_from {
            MissingFrom::Counter => "counter",
            MissingFrom::Arrival => "arrival",
            MissingFrom::RejectedRows => "bad-lines",
        },
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
        bad_frames: BadFrames {
            checksum: tally.rejected.checksum,
            unchecked: tally.rejected.unchecked,
            grammar: tally.rejected.grammar,
            range: tally.rejected.range,
            truncated: tally.rejected.truncated,
            too_long: tally.rejected.too_long,
        },
    }
}

fn channel(values: ChannelValues, snapshot: &Snapshot, assessment: &Assessment, ended: bool) -> Channel {
    let at_end = || values.signal.as_ref().filter(|_| ended);
    let skipped_s = snapshot.skipped.as_secs_f64();
    Channel {
        name: values.name,
        unit: values.unit,
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
            deviation: match snapshot.deviation {
                Deviation::Allan => "allan",
                Deviation::Hadamard => "hadamard",
            },
            estimator: match snapshot.estimator {
                Estimator::Strided => "strided",
                Estimator::Full => "full",
                Estimator::Plain => "plain",
            },
            confidence: Some(assessment.confidence),
            detrend: snapshot.detrended.then_some("linear"),
            slope_s: values.slope_s,
            points: values.deviations,
        },
        noise: values.noise.map(|noise| NoiseDocument::new(&noise, assessment.samples)),
        stationarity: values.signal.as_ref().map(|signal| StationarityDocument::new(signal, skipped_s)),
        spectrum: at_end().map(SpectrumDocument::new),
        blocks: at_end().map(|signal| blocks(signal, skipped_s)),
        verdict: None,
        grade: None,
    }
}

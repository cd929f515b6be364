//! The results of one channel, in its own unit.

use imu_noise::{
    Block, ChannelSignal, Deviation, Estimator, HistogramBars, Interval, NoiseFit, OctaveSum, Sensor, Sides,
    SpectralLine,
};
use schemars::JsonSchema;
use serde::Serialize;
use vn100_protocol::{Channel, Quantity};

use super::{Graded, Inflation, NoiseResult, Parts};
use crate::{
    accumulate::magnitude::Magnitude,
    assessment::{
        Assessment, ChannelAssessment, ChannelNoise, OctaveAssessment, Onboard, Stationarity, frequency_and_share,
        have_one_cause,
    },
    datasheet::FigureVerdict,
    sensor::{axes_name, sensor_of},
    snapshot::{ChannelSnapshot, Snapshot},
};

/// One channel, in its own unit; null if a number is not known.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct ChannelResult {
    /// Name, such as gyro_x.
    pub name: String,
    /// Quantity of the channel.
    #[serde(skip)]
    pub quantity: Quantity,
    /// Unit of the channel: rad/s, m/s^2, gauss, deg, degC, kPa.
    pub unit: String,
    /// Decimals that show one count in the unit.
    #[serde(skip)]
    pub decimals: usize,
    /// Sample rate of the channel in Hz: that of the rows, or a part of it if the sensor measures the
    /// channel more slowly.
    pub rate_hz: f64,
    /// Statistics of all samples.
    pub statistics: Statistics,
    /// Deviation over averaging times.
    pub allan: Curve,
    /// Noise model of an axis; null for channels that are no axis of a sensor.
    pub noise: Option<NoiseResult>,
    /// Averaging and decimation inside the sensor; null if they are not known.
    pub onboard: Option<Onboard>,
    /// What happened during the record; null for a channel that is not in the stream.
    pub stationarity: Option<Stationarity>,
    /// Power spectral density by Welch's method, and its peaks; only at the end.
    pub spectrum: Option<Spectrum>,
    /// Smallest N and K of a filter by the fitted density; only at the end, null if the record does not
    /// show it.
    pub inflation: Option<Inflation>,
    /// Consecutive blocks of the record, in time order; only at the end.
    pub blocks: Option<Vec<BlockValues>>,
    /// Verdicts on each figure of the data sheet; only at the end, null without figures.
    pub verdict: Option<Vec<FigureVerdict>>,
    /// Grade of a gyroscope; null for any other channel.
    pub grade: Option<Graded>,
    /// The deviation at each octave, if the curve has other averaging times.
    #[serde(skip)]
    octaves: Option<Vec<Point>>,
}

/// Statistics of all samples of a channel.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct Statistics {
    /// Number of samples.
    pub count: u64,
    /// Mean; of an angle the unwrapped one, in (-180, 180].
    pub mean: Option<f64>,
    /// Standard deviation, with n - 1 in the denominator.
    pub std: Option<f64>,
    /// Third standardised moment.
    pub skewness: Option<f64>,
    /// Fourth standardised moment less 3.
    pub excess_kurtosis: Option<f64>,
    /// Smallest sample.
    pub min: Option<f64>,
    /// Largest sample.
    pub max: Option<f64>,
    /// Step of the values.
    pub resolution: f64,
    /// Samples by value; only at the end.
    pub histogram: Option<HistogramBars>,
}

/// The deviation over averaging times.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct Curve {
    /// The deviation that it is.
    pub deviation: Deviation,
    /// Windows that enter it.
    pub estimator: Estimator,
    /// Two-sided level of all intervals, 0 to 1.
    pub confidence: f64,
    /// What the numbers of a foreign series are taken for; absent for a sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<&'static str>,
    /// One point for each averaging time.
    pub points: Vec<Point>,
}

/// The deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Point {
    /// Averaging factor: samples in a cluster.
    pub m: u64,
    /// Averaging time in seconds, m / rate_hz.
    pub tau_s: f64,
    /// Deviation in the unit of the channel.
    pub deviation: Option<f64>,
    /// Squared differences in the sum.
    pub terms: u64,
    /// Equivalent degrees of freedom; null below two, as the interval.
    pub edf: Option<f64>,
    /// Exponent of the power law of the spectrum at this averaging time: 0 white, -1 flicker, -2
    /// walk; null with too few blocks.
    pub alpha: Option<i8>,
    /// Lower end of the pointwise confidence interval.
    pub lower: Option<f64>,
    /// Upper end of the pointwise confidence interval.
    pub upper: Option<f64>,
    /// Deviation of the whole fitted model; null if the fit has no part of it.
    pub fitted: Option<f64>,
}

/// The power spectral density of a channel.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct Spectrum {
    /// Frequencies over which the density is spread.
    pub sides: Sides,
    /// Samples of a segment; null without a segment.
    pub segment_samples: Option<usize>,
    /// Number of segments; null without a segment.
    pub segments: Option<u64>,
    /// Frequency of the first point, and step from point to point, in Hz.
    pub step_hz: Option<f64>,
    /// Density of each point, in the unit squared per hertz.
    pub density: Vec<f64>,
    /// Peaks, in rising frequency.
    pub lines: Vec<SpectralLine>,
}

/// One of the consecutive blocks of a record.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct BlockValues {
    /// Data time from the first sample to the block in seconds, skipped time included.
    pub start_s: f64,
    /// Length in seconds of data time.
    pub duration_s: f64,
    /// Number of samples.
    pub count: u64,
    /// Mean of the samples.
    pub mean: f64,
    /// Standard deviation of the samples; null for one sample.
    pub std: Option<f64>,
    /// Smallest sample.
    pub min: f64,
    /// Largest sample.
    pub max: f64,
}

/// The magnitude of the vector of a sensor, sample by sample.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct Norm {
    /// Name, such as gyro_norm.
    pub name: String,
    /// Quantity of the vector.
    #[serde(skip)]
    pub quantity: Quantity,
    /// Unit of all values.
    pub unit: String,
    /// Decimals that show one count in the unit.
    #[serde(skip)]
    pub decimals: usize,
    /// Magnitude of the mean vector.
    pub of_mean: Option<f64>,
    /// Number of samples.
    pub count: u64,
    /// Mean of the magnitudes.
    pub mean: Option<f64>,
    /// Standard deviation of the magnitudes.
    pub std: Option<f64>,
    /// Smallest magnitude.
    pub min: Option<f64>,
    /// Largest magnitude.
    pub max: Option<f64>,
}

/// All channels of a snapshot, in order, followed by those of register 54.
pub(super) fn of(snapshot: &Snapshot, assessment: &Assessment, parts: Parts) -> Vec<ChannelResult> {
    let result = |channel, results, assessed| Maker { channel, results, snapshot, parts }.result(assessed, assessment);
    let streamed = snapshot.assessed(&assessment.channels);
    let streamed = streamed.map(|(channel, results, assessed)| result(channel, results, Some(assessed)));
    let polled = snapshot.register_channels.iter().map(|(channel, results)| result(channel, results, None));
    streamed.chain(polled).collect()
}

impl ChannelResult {
    /// Whether the channel is in the stream, and not read from a register between the samples.
    pub fn is_streamed(&self) -> bool {
        self.stationarity.is_some()
    }

    /// The deviation at each octave.
    pub fn octaves(&self) -> &[Point] {
        self.octaves.as_ref().unwrap_or(&self.allan.points)
    }

    /// Whether the curve has other averaging times than the octaves.
    pub fn has_other_times(&self) -> bool {
        self.octaves.is_some()
    }

    /// The channel with its deviations in a unit of which one of its own is `factor`.
    pub fn in_unit(&self, unit: &str, factor: f64) -> Self {
        let mut channel = Self { unit: unit.into(), ..self.clone() };
        let points = channel.allan.points.iter_mut().chain(channel.octaves.iter_mut().flatten());
        points.for_each(|point| *point = point.times(factor));
        channel
    }

    /// The verdicts on figures of the data sheet; none without a sheet.
    pub fn verdicts(&self) -> &[FigureVerdict] {
        self.verdict.as_deref().unwrap_or_default()
    }

    /// The blocks of the record; none where they are no part of the result.
    pub fn blocks(&self) -> &[BlockValues] {
        self.blocks.as_deref().unwrap_or_default()
    }

    /// The peaks of the spectrum; none where it is no part of the result.
    pub fn lines(&self) -> &[SpectralLine] {
        self.spectrum.as_ref().map_or(&[], |spectrum| &spectrum.lines)
    }

    /// The vibrations of the channel, the strongest first: frequency in hertz, and share of the
    /// short-term variance, from 0 to 1.
    pub fn vibrations(&self) -> Vec<(f64, f64)> {
        let together = |lines: &[SpectralLine]| frequency_and_share(lines.iter());
        let mut vibrations: Vec<(f64, f64)> = self.lines().chunk_by(have_one_cause).map(together).collect();
        vibrations.sort_by(|a, b| b.1.total_cmp(&a.1));
        vibrations
    }
}

impl Point {
    /// The point in a unit of which `factor` are one of the present unit.
    pub fn times(self, factor: f64) -> Self {
        let [deviation, lower, upper, fitted] =
            [self.deviation, self.lower, self.upper, self.fitted].map(|value| value.map(|value| value * factor));
        Self { deviation, lower, upper, fitted, ..self }
    }

    /// Whether the deviation is known well enough for an interval.
    pub fn is_known(&self) -> bool {
        self.edf.is_some()
    }
}

impl Spectrum {
    /// Frequency in hertz and density of each point.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let step_hz = self.step_hz.unwrap_or(0.0);
        self.density.iter().enumerate().map(move |(place, density)| ((place + 1) as f64 * step_hz, *density))
    }
}

impl Norm {
    pub(super) fn of(norm: &Magnitude, snapshot: &Snapshot) -> Self {
        Self {
            name: format!("{}_norm", sensor_of(norm.quantity).map_or("", axes_name)),
            quantity: norm.quantity,
            unit: norm.unit.clone(),
            decimals: converted_decimals(norm.decimals, norm.scale),
            of_mean: snapshot.mean_magnitude(norm.quantity),
            count: norm.count,
            mean: norm.mean(),
            std: norm.std(),
            min: norm.extremes().map(|(min, _)| min),
            max: norm.extremes().map(|(_, max)| max),
        }
    }
}

/// The decimals that resolve one count of 10^-`decimals` in a unit `scale` times as small.
fn converted_decimals(decimals: u8, scale: f64) -> usize {
    // of a power of ten, no more for what its logarithm was rounded by
    (f64::from(decimals) - scale.abs().log10() - 1e-9).ceil().max(0.0) as usize
}

/// Bins of a histogram at most.
const MOST_BARS: usize = 64;

struct Maker<'a> {
    channel: &'a Channel,
    results: &'a ChannelSnapshot,
    snapshot: &'a Snapshot,
    parts: Parts,
}

impl Maker<'_> {
    fn value(&self, counts: f64) -> f64 {
        self.channel.in_unit(counts)
    }

    /// A channel that is not in the stream has no assessment.
    fn result(&self, assessed: Option<&ChannelAssessment>, assessment: &Assessment) -> ChannelResult {
        let Self { channel, results, snapshot, parts } = *self;
        let rate_hz = snapshot.rate_of(results);
        let noise = assessed.and_then(|assessed| assessed.noise.as_ref());
        let fit = noise.map(|noise| &noise.fit);
        let of_octaves = assessed.map_or(&[][..], |assessed| &assessed.octaves);
        let mut points = self.points(&results.octaves, of_octaves, fit);
        let octaves = assessed
            .filter(|_| !results.points.is_empty())
            .map(|assessed| std::mem::replace(&mut points, self.points(&results.points, &assessed.points, fit)));
        let signal = results.signal.as_ref().zip(assessed);
        let whole = signal.filter(|_| parts == Parts::All);
        let mut found = ChannelResult {
            name: channel.name.to_string(),
            quantity: channel.quantity,
            unit: channel.unit.to_string(),
            decimals: converted_decimals(channel.decimals, channel.scale),
            rate_hz,
            statistics: self.statistics(),
            allan: Curve {
                deviation: snapshot.settings.deviation,
                estimator: snapshot.settings.estimator,
                confidence: assessment.confidence,
                data: (channel.quantity == Quantity::Value).then_some("rate"),
                points,
            },
            noise: noise.map(|noise| NoiseResult::of(noise, assessment.samples, rate_hz)),
            onboard: assessed.and_then(|assessed| assessed.onboard),
            stationarity: signal.map(|(_, assessed)| assessed.stationarity.clone()),
            spectrum: whole.map(|(signal, assessed)| self.spectrum(signal, &assessed.stationarity.lines)),
            inflation: None,
            blocks: whole.map(|(signal, _)| signal.blocks().iter().map(|block| self.block(block)).collect()),
            verdict: None,
            grade: noise.and_then(ChannelNoise::grade).map(Graded::of),
            octaves,
        };
        let shows_sensor = assessment.motion.is_none() && snapshot.settings.deviation == Deviation::Allan;
        let noise = found
            .noise
            .as_ref()
            .filter(|noise| noise.of_sensor().is_ok() && noise.sensor != Sensor::Magnetometer && shows_sensor);
        let octaves = found.octaves().iter().map_while(|point| Some((point.tau_s, point.upper.and(point.fitted)?)));
        let octaves: Vec<(f64, f64)> = octaves.collect();
        found.inflation = noise.filter(|_| whole.is_some()).and_then(|noise| Inflation::of(&octaves, noise));
        found
    }

    fn statistics(&self) -> Statistics {
        let Self { channel, results, parts, .. } = *self;
        let (moments, branch) = (&results.moments, results.branch_counts);
        let sample = |counts: Option<i32>| counts.map(|counts| self.value((i64::from(counts) - branch) as f64));
        let bars = (parts == Parts::All).then(|| results.histogram.bars(MOST_BARS)).flatten();
        Statistics {
            count: moments.count(),
            mean: moments.mean_counts().map(|counts| self.value(counts - branch as f64)),
            std: moments.std_counts().map(|counts| self.value(counts)),
            skewness: moments.skewness(),
            excess_kurtosis: moments.excess_kurtosis(),
            min: sample(moments.min_counts()),
            max: sample(moments.max_counts()),
            resolution: results.step(channel),
            histogram: bars.map(|bars| HistogramBars {
                first: self.value(bars.first - branch as f64),
                width: self.value(bars.width),
                ..bars
            }),
        }
    }

    fn points(&self, sums: &[OctaveSum], assessed: &[OctaveAssessment], fit: Option<&NoiseFit>) -> Vec<Point> {
        let rate_hz = self.snapshot.rate_of(self.results);
        let point = |(place, sum): (usize, &OctaveSum)| {
            let assessed = assessed.get(place);
            let deviation = sum.deviation_counts().map(|counts| self.value(counts));
            let relative = assessed.and_then(|assessed| assessed.relative);
            let bound = |of: fn(&Interval) -> f64| Some(deviation? * of(&relative?));
            Point {
                m: sum.m,
                tau_s: sum.m as f64 / rate_hz,
                deviation,
                terms: sum.terms,
                edf: relative.map(|relative| relative.edf),
                alpha: assessed.and_then(|assessed| assessed.alpha),
                lower: bound(|relative| relative.lower),
                upper: bound(|relative| relative.upper),
                fitted: fit.and_then(|fit| fit.deviation(sum.m)),
            }
        };
        sums.iter().enumerate().map(point).collect()
    }

    fn spectrum(&self, signal: &ChannelSignal, lines: &[SpectralLine]) -> Spectrum {
        let Self { channel, results, snapshot, .. } = *self;
        let interval_s = snapshot.shape_of(results).interval_s;
        let density = signal.spectrum().density(Sides::One, interval_s, channel.decimals);
        let points = density.iter().flat_map(|density| &density.points_unit2_hz);
        Spectrum {
            sides: Sides::One,
            segment_samples: density.as_ref().map(|density| density.segment_samples),
            segments: density.as_ref().map(|density| density.segments),
            step_hz: density.as_ref().map(|density| density.step_hz),
            density: points.map(|point| point * (channel.scale * channel.scale)).collect(),
            lines: lines.to_vec(),
        }
    }

    fn block(&self, block: &Block) -> BlockValues {
        let interval_s = self.snapshot.shape_of(self.results).interval_s;
        let branch = self.results.branch_counts as f64;
        BlockValues {
            start_s: self.snapshot.skipped.as_secs_f64() + block.first_sample as f64 * interval_s,
            duration_s: block.length as f64 * interval_s,
            count: block.count,
            mean: self.value(block.mean_counts - branch),
            std: block.std_counts.map(|counts| self.value(counts)),
            min: self.value(f64::from(block.min_counts) - branch),
            max: self.value(f64::from(block.max_counts) - branch),
        }
    }
}

//! From exact counts to values in the unit of each channel, for display and documents.

use serde::Serialize;
use vn100_analysis::holm;
use vn100_analysis::noise::{
    Block, Density, Interval, NoiseFit, Normality, NotJudged, OctaveSum, Sensor, Sides, SpectralLine, Term,
    conventions, counts_to_unit,
};
use vn100_analysis::protocol::{Channel, Quantity};
use vn100_analysis::{
    Assessment, ChannelAssessment, ChannelNoise, ChannelSnapshot, Disturbed, Magnitude, OctaveAssessment, OctaveTest,
    Snapshot,
};

use crate::names::names_of;

/// The rotation rate of the Earth, in rad/s (IERS Conventions, 2010).
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// The results of one channel in its own unit. `None` stands for what is not known.
#[derive(Debug, Clone)]
pub struct ChannelValues {
    /// Name of the channel, such as `gyro_x`.
    pub name: String,
    /// Quantity of the channel.
    pub quantity: Quantity,
    /// Unit of all values below, unless noted otherwise.
    pub unit: String,
    /// Decimals that show one count in the unit.
    pub decimals: usize,
    /// Sample rate of the channel in hertz.
    pub rate_hz: f64,
    /// Number of samples.
    pub count: u64,
    /// Mean of all samples.
    pub mean: Option<f64>,
    /// Standard deviation of all samples, with n - 1 in the denominator.
    pub std: Option<f64>,
    /// Third standardised moment.
    pub skewness: Option<f64>,
    /// Fourth standardised moment less 3.
    pub excess_kurtosis: Option<f64>,
    /// The smallest sample.
    pub min: Option<f64>,
    /// The largest sample.
    pub max: Option<f64>,
    /// The last digit that the source prints, in the unit.
    pub resolution: f64,
    /// The histogram, as bars.
    pub bars: Option<BarValues>,
    /// The deviation at each octave.
    pub octaves: Vec<Point>,
    /// The deviations to be shown: at the octaves, or at the averaging times of the settings.
    pub deviations: Vec<Point>,
    /// Results over time and frequency; `None` for a channel that is not in the stream.
    pub signal: Option<SignalValues>,
    /// Slope of the regression line, in the unit per second.
    pub slope_s: Option<f64>,
    /// Noise parameters in SI units; `None` for a channel that is no axis of a sensor.
    pub noise: Option<ChannelNoise>,
}

/// A histogram as bars, for a drawing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BarValues {
    /// Lower edge of the first bar.
    pub first: f64,
    /// Width of every bar.
    pub width: f64,
    /// Samples in each bar.
    pub counts: Vec<u64>,
}

const MOST_BARS: usize = 64;

/// Results of a channel over time and frequency.
#[derive(Debug, Clone)]
pub struct SignalValues {
    /// The one-sided power spectral density, in the unit squared per hertz.
    pub density: Option<Density>,
    /// The blocks of the record, in time order.
    pub blocks: Vec<BlockValues>,
    /// Vibration, disturbances and changes of level.
    pub disturbed: Disturbed,
    /// Whether the values are normally distributed; `None` if that was not assessed.
    pub normality: Option<Result<Normality, NotJudged>>,
}

impl SignalValues {
    /// The vibrations of the channel, the strongest first: frequency in hertz, and share of the
    /// short-term variance, from 0 to 1. Spectral lines within 3 % of their neighbour are one
    /// vibration, as in the warnings: what turns is never quite steady.
    #[must_use]
    pub fn vibrations(&self) -> Vec<(f64, f64)> {
        const APART: f64 = 1.03;
        let near = |a: &SpectralLine, b: &SpectralLine| b.frequency_hz < APART * a.frequency_hz;
        let together = |lines: &[SpectralLine]| {
            let share: f64 = lines.iter().map(|line| line.share_of_variance).sum();
            let weighted: f64 = lines.iter().map(|line| line.share_of_variance * line.frequency_hz).sum();
            (weighted / share, share)
        };
        let mut vibrations: Vec<(f64, f64)> = self.disturbed.lines.chunk_by(near).map(together).collect();
        vibrations.sort_by(|a, b| b.1.total_cmp(&a.1));
        vibrations
    }
}

/// One of the consecutive blocks of a record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BlockValues {
    /// Data time from the first sample to the block in seconds, including what was skipped.
    pub start_s: f64,
    /// Length of the block in seconds of data time.
    pub duration_s: f64,
    /// Number of samples.
    pub count: u64,
    /// Mean of the samples.
    pub mean: f64,
    /// Standard deviation of the samples; `None` for one sample.
    pub std: Option<f64>,
    /// The smallest sample.
    pub min: f64,
    /// The largest sample.
    pub max: f64,
}

/// The deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// Averaging factor: samples in a cluster.
    pub m: u64,
    /// Averaging time in seconds.
    pub tau_s: f64,
    /// Allan or Hadamard deviation, in the unit; `None` if the sum is not known.
    pub deviation: Option<f64>,
    /// Number of squared differences in the sum.
    pub terms: u64,
    /// Equivalent degrees of freedom; `None` below two, if there is no interval either.
    pub edf: Option<f64>,
    /// Exponent of the spectrum at this averaging time; `None` with too few blocks.
    pub alpha: Option<i8>,
    /// Lower limit of the confidence interval.
    pub lower: Option<f64>,
    /// Upper limit of the confidence interval.
    pub upper: Option<f64>,
    /// Deviation of the fitted model; `None` if no model was fitted at this point.
    pub fitted: Option<f64>,
}

impl Point {
    /// The point in a unit of which `factor` are one of the present unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        let [deviation, lower, upper, fitted] =
            [self.deviation, self.lower, self.upper, self.fitted].map(|value| value.map(|value| value * factor));
        Self { deviation, lower, upper, fitted, ..self }
    }

    /// Whether the deviation is known well enough for an interval.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.edf.is_some()
    }
}

/// All channels of a snapshot, in order, followed by those of register 54.
#[must_use]
pub fn channel_values(snapshot: &Snapshot, assessment: &Assessment) -> Vec<ChannelValues> {
    let channels = snapshot.layout_channels();
    let streamed = (channels.iter().zip(&snapshot.channels).zip(&assessment.channels))
        .map(|((channel, results), assessed)| values(channel, results, Some(assessed), snapshot));
    let polled =
        snapshot.register_channels.iter().map(|polled| values(&polled.channel, &polled.results, None, snapshot));
    streamed.chain(polled).collect()
}

/// The magnitude of the vector of a sensor, sample by sample.
#[derive(Debug, Clone, Serialize)]
pub struct NormValues {
    /// Name of the magnitude, such as `gyro_norm`.
    pub name: String,
    /// Quantity of the vector.
    #[serde(skip)]
    pub quantity: Quantity,
    /// Unit of all values below.
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

/// The magnitudes of all vectors, in the order of the channels.
#[must_use]
pub fn norm_values(snapshot: &Snapshot) -> Vec<NormValues> {
    let norm = |norm: &Magnitude| {
        let value = |counts| counts_to_unit(counts, norm.decimals) * norm.scale;
        let moments = &norm.moments;
        NormValues {
            name: format!("{}_norm", names_of(norm.quantity).short),
            quantity: norm.quantity,
            unit: norm.unit.clone(),
            decimals: converted_decimals(norm.decimals, norm.scale),
            of_mean: snapshot.mean_vector(norm.quantity).map(|[x, y, z]| x.hypot(y).hypot(z)),
            count: moments.count(),
            mean: moments.mean_counts().map(value),
            std: moments.std_counts().map(value),
            min: moments.min_counts().map(|counts| value(counts.into())),
            max: moments.max_counts().map(|counts| value(counts.into())),
        }
    };
    snapshot.magnitudes.iter().map(norm).collect()
}

/// The names of the channels whose values are not normally distributed, by all tests of the record
/// together (Holm): true of one normal record in a hundred.
#[must_use]
pub fn not_normal(channels: &[ChannelValues]) -> Vec<&str> {
    let tested = |channel: &ChannelValues| channel.signal.as_ref()?.normality?.ok().map(|normality| normality.p());
    rejected(channels.iter().filter_map(|channel| Some((channel.name.as_str(), tested(channel)?))))
}

fn rejected<'a>(tested: impl Iterator<Item = (&'a str, f64)>) -> Vec<&'a str> {
    const RISK: f64 = 0.01;
    let (names, p): (Vec<&str>, Vec<f64>) = tested.unzip();
    names.into_iter().zip(holm(&p)).filter(|(_, p)| *p < RISK).map(|(name, _)| name).collect()
}

/// The SI unit of a noise parameter.
#[must_use]
pub fn si_unit(sensor: Sensor, term: Term) -> &'static str {
    conventions(sensor, term).first().map_or("", |si| si.unit)
}

/// A unit as people write it: `rad/s/sqrt(Hz)` as `rad/s/√Hz`, `m/s^2` as `m/s²`, `deg/h^1.5` as
/// `°/h/√h`.
#[must_use]
pub fn pretty_unit(unit: &str) -> String {
    let unit = match unit.strip_prefix('u') {
        Some(rest) if rest.starts_with("g/") || rest == "g" || rest == "rad" => format!("µ{rest}"),
        _ => unit.to_owned(),
    };
    let written = [
        ("sqrt(Hz)", "√Hz"),
        ("sqrt(h)", "√h"),
        ("sqrt(s)", "√s"),
        ("/h^1.5", "/h/√h"),
        ("^2", "²"),
        ("^3", "³"),
        ("deg", "°"),
    ];
    written.into_iter().fold(unit, |unit, (plain, pretty)| unit.replace(plain, pretty))
}

/// The decimals that resolve one count of 10^-`decimals` in a unit `scale` times as small.
fn converted_decimals(decimals: u8, scale: f64) -> usize {
    // of a power of ten, no more for what its logarithm was rounded by
    (f64::from(decimals) - scale.abs().log10() - 1e-9).ceil().max(0.0) as usize
}

/// A value with `decimals` decimals. If the text is wider than `width`, with fewer decimals as
/// long as three digits remain, else with a power of ten. What rounds to 0 has no minus.
#[must_use]
pub fn fitted(value: f64, decimals: usize, width: usize) -> String {
    let keeps_digits = |places: usize| value == 0.0 || value.abs() * 10_f64.powi(places as i32) >= 100.0;
    let fixed = (0..=decimals).rev().filter(|places| *places == decimals || keeps_digits(*places));
    let fixed = fixed.map(|places| format!("{value:.places$}"));
    let is_zero = |text: &str| text.contains('0') && !text.bytes().any(|digit| matches!(digit, b'1'..=b'9'));
    let fixed = fixed.map(|text| if is_zero(&text) { text.replace('-', "") } else { text });
    let powers = (0..=5).rev().map(|places| format!("{value:.places$e}"));
    fixed.chain(powers).find(|text| text.len() <= width).unwrap_or_else(|| format!("{value:.0e}"))
}

fn values(
    channel: &Channel,
    results: &ChannelSnapshot,
    assessed: Option<&ChannelAssessment>,
    snapshot: &Snapshot,
) -> ChannelValues {
    let value = |counts| channel.in_unit(counts);
    let moments = &results.moments;
    let fit = assessed.and_then(|assessed| Some(&assessed.noise.as_ref()?.fit));
    let points = |sums: &[OctaveSum], assessments: Option<&Vec<OctaveAssessment>>| -> Vec<Point> {
        let assessments = assessments.map_or(&[][..], Vec::as_slice);
        let assessment = |index| assessments.get(index);
        let points = sums.iter().enumerate();
        points.map(|(index, sum)| point(channel, sum, assessment(index), fit, snapshot.rate_of(results))).collect()
    };
    let octaves = points(&results.octaves, assessed.map(|assessed| &assessed.octaves));
    let sample = |counts: Option<i32>| counts.map(|counts| value((i64::from(counts) - results.branch_counts) as f64));
    ChannelValues {
        name: channel.name.to_string(),
        quantity: channel.quantity,
        unit: channel.unit.to_string(),
        decimals: converted_decimals(channel.decimals, channel.scale),
        rate_hz: snapshot.rate_of(results),
        count: moments.count(),
        mean: moments.mean_counts().map(|counts| value(counts - results.branch_counts as f64)),
        std: moments.std_counts().map(value),
        skewness: moments.skewness(),
        excess_kurtosis: moments.excess_kurtosis(),
        min: sample(moments.min_counts()),
        max: sample(moments.max_counts()),
        resolution: results.step(channel),
        bars: results.histogram.bars(MOST_BARS).map(|bars| BarValues {
            first: value(bars.first_counts - results.branch_counts as f64),
            width: value(bars.width_counts),
            counts: bars.frequencies,
        }),
        deviations: match &results.points[..] {
            [] => octaves.clone(),
            asked => points(asked, assessed.map(|assessed| &assessed.points)),
        },
        octaves,
        slope_s: results.slope_counts.map(|slope| value(slope) * snapshot.rate_of(results)),
        signal: assessed.zip(results.signal.as_ref()).map(|(assessed, signal)| {
            let interval_s = snapshot.shape_of(results).interval_s;
            let mut density = signal.spectrum().density(Sides::One, interval_s, channel.decimals);
            for point in density.iter_mut().flat_map(|density| &mut density.points) {
                point.density_unit2_hz *= channel.scale * channel.scale;
            }
            let (offset, skipped_s) = (results.branch_counts as f64, snapshot.skipped.as_secs_f64());
            let block = |block: &Block| BlockValues {
                start_s: skipped_s + block.first_sample as f64 * interval_s,
                duration_s: block.length as f64 * interval_s,
                count: block.count,
                mean: value(block.mean_counts - offset),
                std: block.std_counts.map(value),
                min: value(f64::from(block.min_counts) - offset),
                max: value(f64::from(block.max_counts) - offset),
            };
            SignalValues {
                density,
                blocks: signal.blocks().iter().map(block).collect(),
                disturbed: assessed.disturbed.clone(),
                normality: assessed.normality,
            }
        }),
        noise: assessed.and_then(|assessed| assessed.noise.clone()),
    }
}

fn point(
    channel: &Channel,
    sum: &OctaveSum,
    assessed: Option<&OctaveAssessment>,
    fit: Option<&NoiseFit>,
    rate_hz: f64,
) -> Point {
    let deviation = sum.deviation_counts().map(|counts| channel.in_unit(counts));
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
}

/// The tests grouped by channel, in the order in which the channels first occur.
#[must_use]
pub fn tests_by_channel(tests: &[OctaveTest]) -> Vec<Vec<&OctaveTest>> {
    let mut channels: Vec<Vec<&OctaveTest>> = Vec::new();
    for test in tests {
        let same = |others: &&mut Vec<&OctaveTest>| {
            others.first().is_some_and(|other| (&other.channel, &other.unit) == (&test.channel, &test.unit))
        };
        match channels.iter_mut().find(same) {
            Some(others) => others.push(test),
            None => channels.push(vec![test]),
        }
    }
    channels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_several_tests_is_held_to_what_all_of_them_may_show() {
        let rejected = |p: [f64; 3]| rejected(["x", "y", "z"].into_iter().zip(p));
        assert_eq!(rejected([0.005, 0.5, 0.5]), [""; 0]);
        assert_eq!(rejected([0.003, 0.5, 0.5]), ["x"]);
        assert_eq!(rejected([0.003, 0.009, 0.004]), ["x", "y", "z"]);
    }

    #[test]
    fn one_count_shows_in_the_unit_it_was_converted_to() {
        let degree = 1_f64.to_radians();
        for (decimals, scale, shown) in [
            (4, 1.0, 4),
            (0, 1.0, 0),
            (3, degree, 5),
            (1, degree / 3600.0, 7),
            (3, 9.806_65, 3),
            (2, 0.01, 4),
            (1, 1e4, 0),
        ] {
            assert_eq!(converted_decimals(decimals, scale), shown, "{decimals} {scale}");
        }
    }

    #[test]
    fn a_number_never_is_wider_than_its_column_nor_without_digits() {
        for (value, decimals, width, text) in [
            (-9.8066, 4, 9, "-9.8066"),
            (0.0, 4, 9, "0.0000"),
            (0.0, 12, 9, "0.0000000"),
            (4.848e-5, 6, 9, "0.000048"),
            (4.8481e-5, 9, 9, "0.0000485"),
            (-4.8481e-6, 12, 14, "-0.00000484810"),
            (-4.8481e-6, 12, 9, "-4.848e-6"),
            (9.9996, 4, 5, "10.00"),
            (-1.5e12, 3, 9, "-1.500e12"),
            (-1.9e-6, 4, 7, "0.0000"),
            (-0.0, 3, 9, "0.000"),
        ] {
            assert_eq!(fitted(value, decimals, width), text);
        }
    }

    #[test]
    fn units_are_written_as_people_do() {
        for (unit, pretty) in [
            ("rad/s/sqrt(Hz)", "rad/s/√Hz"),
            ("m/s^2", "m/s²"),
            ("deg/h^1.5", "°/h/√h"),
            ("m/s/h^1.5", "m/s/h/√h"),
            ("ug/sqrt(Hz)", "µg/√Hz"),
            ("gauss", "gauss"),
            ("urad", "µrad"),
        ] {
            assert_eq!(pretty_unit(unit), pretty);
        }
    }
}

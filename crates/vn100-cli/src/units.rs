//! From exact counts to values in each channel's own unit, for display and documents.

use imu_noise::{Block, Density, Normality, NotJudged, Sides, counts_to_unit};
use vn100_analysis::{
    Assessment, ChannelAssessment, ChannelNoise, ChannelSnapshot, Disturbed, Norm, OctaveTest, Snapshot,
};
use vn100_protocol::{Channel, Quantity};

/// One channel's results in its own unit. `None` is what the samples do not tell.
#[derive(Debug, Clone)]
pub(crate) struct ChannelValues {
    pub(crate) name: String,
    pub(crate) quantity: Quantity,
    pub(crate) unit: String,
    /// That resolve one count in the unit.
    pub(crate) decimals: usize,
    pub(crate) count: u64,
    pub(crate) mean: Option<f64>,
    pub(crate) std: Option<f64>,
    pub(crate) skewness: Option<f64>,
    pub(crate) excess_kurtosis: Option<f64>,
    pub(crate) min: Option<f64>,
    pub(crate) max: Option<f64>,
    pub(crate) resolution: f64,
    pub(crate) bars: Option<BarValues>,
    pub(crate) deviations: Vec<Point>,
    pub(crate) signal: Option<SignalValues>,
    /// Of the regression line, in the unit per second.
    pub(crate) slope_s: Option<f64>,
    pub(crate) noise: Option<ChannelNoise>,
}

/// A histogram as it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BarValues {
    /// Lower end of the first bar.
    pub(crate) first: f64,
    pub(crate) width: f64,
    pub(crate) counts: Vec<u64>,
}

/// Most bars of a histogram.
const MOST_BARS: usize = 64;

/// How the channel went through time and frequency.
#[derive(Debug, Clone)]
pub(crate) struct SignalValues {
    /// One-sided, in the unit squared per hertz.
    pub(crate) density: Option<Density>,
    pub(crate) blocks: Vec<BlockValues>,
    pub(crate) disturbed: Disturbed,
    pub(crate) normality: Option<Result<Normality, NotJudged>>,
}

/// One of the consecutive blocks of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BlockValues {
    /// In data time, behind what was skipped.
    pub(crate) start_s: f64,
    pub(crate) duration_s: f64,
    pub(crate) count: u64,
    pub(crate) mean: f64,
    pub(crate) std: Option<f64>,
    pub(crate) min: f64,
    pub(crate) max: f64,
}

/// With fewer degrees of freedom an interval spans more than a factor of ten, and is left to the
/// document.
pub(crate) const LEAST_EDF: f64 = 2.0;

/// The deviation at one octave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) m: u64,
    pub(crate) tau_s: f64,
    pub(crate) deviation: Option<f64>,
    pub(crate) terms: u64,
    pub(crate) edf: Option<f64>,
    pub(crate) alpha: Option<i8>,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
}

impl Point {
    /// Whether it is known well enough for its interval to be shown.
    pub(crate) fn is_known(&self) -> bool {
        self.edf.is_some_and(|edf| edf >= LEAST_EDF)
    }
}

/// All channels of a snapshot, in its order, and those asked for between the lines behind them.
pub(crate) fn channel_values(snapshot: &Snapshot, assessment: &Assessment) -> Vec<ChannelValues> {
    let channels = snapshot.layout.as_ref().map_or(&[][..], |layout| &layout.channels);
    let streamed = (channels.iter().zip(&snapshot.channels).zip(&assessment.channels))
        .map(|((channel, results), assessed)| values(channel, results, Some(assessed), snapshot));
    let polled = snapshot.polled.iter().map(|polled| values(&polled.channel, &polled.results, None, snapshot));
    streamed.chain(polled).collect()
}

/// The length of a sensor's vector, sample by sample.
#[derive(Debug, Clone)]
pub(crate) struct NormValues {
    pub(crate) name: &'static str,
    pub(crate) quantity: Quantity,
    pub(crate) unit: String,
    /// That resolve one count in the unit.
    pub(crate) decimals: usize,
    /// Of the mean vector.
    pub(crate) of_mean: Option<f64>,
    pub(crate) count: u64,
    pub(crate) mean: Option<f64>,
    pub(crate) std: Option<f64>,
    pub(crate) min: Option<f64>,
    pub(crate) max: Option<f64>,
}

/// The lengths of all vectors, in the order of the channels.
pub(crate) fn norm_values(snapshot: &Snapshot) -> Vec<NormValues> {
    let norm = |norm: &Norm| {
        let value = |counts| counts_to_unit(counts, norm.decimals) * norm.scale;
        let moments = &norm.moments;
        NormValues {
            name: match norm.quantity {
                Quantity::MagneticField => "mag_norm",
                Quantity::Acceleration => "accel_norm",
                Quantity::AngularRate => "gyro_norm",
                Quantity::Angle | Quantity::Temperature | Quantity::Pressure => "norm",
            },
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
    snapshot.norms.iter().map(norm).collect()
}

/// The decimals that resolve one count of 10^-`decimals` in a unit of which it is so many times
/// more.
fn converted_decimals(decimals: u8, scale: f64) -> usize {
    // of a power of ten, no more for what its logarithm was rounded by
    (f64::from(decimals) - scale.abs().log10() - 1e-9).ceil().max(0.0) as usize
}

/// A value with so many decimals. Where these are wider than `width`, with fewer as long as three
/// digits stay, or with a power of ten.
pub(crate) fn fitted(value: f64, decimals: usize, width: usize) -> String {
    let keeps_digits = |places: usize| value == 0.0 || value.abs() * 10_f64.powi(places as i32) >= 100.0;
    let fixed = (0..=decimals).rev().filter(|places| *places == decimals || keeps_digits(*places));
    let fixed = fixed.map(|places| format!("{value:.places$}"));
    let powers = (0..=5).rev().map(|places| format!("{value:.places$e}"));
    fixed.chain(powers).find(|text| text.len() <= width).unwrap_or_else(|| format!("{value:.0e}"))
}

fn values(
    channel: &Channel,
    results: &ChannelSnapshot,
    assessed: Option<&ChannelAssessment>,
    snapshot: &Snapshot,
) -> ChannelValues {
    let value = |counts| counts_to_unit(counts, channel.decimals) * channel.scale;
    let moments = &results.moments;
    let sample = |counts: Option<i32>| counts.map(|counts| value((i64::from(counts) - results.branch_counts) as f64));
    ChannelValues {
        name: channel.name.to_string(),
        quantity: channel.quantity,
        unit: channel.unit.to_string(),
        decimals: converted_decimals(channel.decimals, channel.scale),
        count: moments.count(),
        mean: moments.mean_counts().map(|counts| value(counts - results.branch_counts as f64)),
        std: moments.std_counts().map(value),
        skewness: moments.skewness(),
        excess_kurtosis: moments.excess_kurtosis(),
        min: sample(moments.min_counts()),
        max: sample(moments.max_counts()),
        resolution: counts_to_unit(1.0, results.printed_decimals) * channel.scale,
        bars: results.histogram.bars(MOST_BARS).map(|bars| BarValues {
            // a printed number stands for the half digit on either side
            first: value((bars.first_counts - results.branch_counts) as f64 - 0.5),
            width: value(bars.width_counts as f64),
            counts: bars.frequencies,
        }),
        deviations: points(results, assessed, snapshot, value),
        slope_s: results.slope_counts.map(|slope| value(slope) * snapshot.timing.rate_hz),
        signal: assessed.zip(results.signal.as_ref()).map(|(assessed, signal)| {
            let interval_s = snapshot.shape().interval_s;
            let mut density = signal.spectrum().density(Sides::One, interval_s, channel.decimals);
            for point in density.iter_mut().flat_map(|density| &mut density.points) {
                point.density_unit2_hz *= channel.scale * channel.scale;
            }
            let offset = results.branch_counts as f64;
            let block = |block: &Block| BlockValues {
                start_s: block.first_sample as f64 * interval_s,
                duration_s: block.length as f64 * interval_s,
                count: block.count(),
                mean: value(block.mean_counts() - offset),
                std: block.std_counts().map(value),
                min: value(f64::from(block.min_counts()) - offset),
                max: value(f64::from(block.max_counts()) - offset),
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

fn points(
    results: &ChannelSnapshot,
    assessed: Option<&ChannelAssessment>,
    snapshot: &Snapshot,
    value: impl Fn(f64) -> f64,
) -> Vec<Point> {
    (results.octaves.iter().enumerate())
        .map(|(index, octave)| {
            let deviation = octave.deviation_counts().map(&value);
            let assessed = assessed.and_then(|assessed| assessed.octaves.get(index));
            let relative = assessed.and_then(|assessed| assessed.relative);
            let bound = |of: fn(&imu_noise::Interval) -> f64| Some(deviation? * of(&relative?));
            Point {
                m: octave.m,
                tau_s: octave.m as f64 / snapshot.timing.rate_hz,
                deviation,
                terms: octave.terms,
                edf: relative.map(|relative| relative.edf),
                alpha: assessed.and_then(|assessed| assessed.alpha),
                lower: bound(|relative| relative.lower),
                upper: bound(|relative| relative.upper),
            }
        })
        .collect()
}

/// The tests of one channel, by the order in which its octaves first come.
pub(crate) struct TestsOfChannel<'a> {
    pub(crate) name: &'a str,
    pub(crate) unit: &'a str,
    pub(crate) tests: Vec<&'a OctaveTest>,
}

/// The tests of all channels, those of one together.
pub(crate) fn tests_by_channel(tests: &[OctaveTest]) -> Vec<TestsOfChannel<'_>> {
    let mut channels: Vec<TestsOfChannel<'_>> = Vec::new();
    for test in tests {
        let same = |channel: &&mut TestsOfChannel<'_>| (channel.name, channel.unit) == (&*test.channel, &*test.unit);
        match channels.iter_mut().find(same) {
            Some(channel) => channel.tests.push(test),
            None => channels.push(TestsOfChannel { name: &test.channel, unit: &test.unit, tests: vec![test] }),
        }
    }
    channels
}

/// What the axes of one sensor are called together.
pub(crate) fn sensor_group(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Angle => "attitude",
        Quantity::MagneticField => "mag",
        Quantity::Acceleration => "accel",
        Quantity::AngularRate => "gyro",
        Quantity::Temperature => "temperature",
        Quantity::Pressure => "pressure",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        ] {
            assert_eq!(fitted(value, decimals, width), text);
        }
    }
}

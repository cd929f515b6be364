//! The means of each channel, their differences, and whether noise alone explains the differences.

use imu_noise::{Status, Term};
use vn100_protocol::{Channel, Quantity, Register};

use super::two_sample::{SquaredAmplitude, Stretch, mean_difference_test, standard_error_of_mean};
use super::{Chance, ComparedRecord, SameSamples, chances, pairs};
use crate::hypothesis_tests::{Spread, VarianceEstimate};
use crate::{ChannelNoise, LongTauValidity, sensor::sensor_of};

/// The means of one channel of a sensor over all records.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMeans {
    /// Name of the channel.
    pub channel: String,
    /// Quantity of the channel.
    pub quantity: Quantity,
    /// Unit of the channel.
    pub unit: String,
    /// One for each record that has samples of the channel and in which the sensor was not moved.
    pub means: Vec<RecordMean>,
    /// The spread of the means; `None` for fewer than two means, and where the records are of
    /// several sensors.
    pub spread: Option<Spread>,
    /// The differences of every pair of these means.
    pub differences: Vec<MeanDifference>,
    /// Whether a filter removes the bias in at least one of the records: the spread is then not
    /// that of the bias.
    pub bias_removed: bool,
}

/// The mean of a channel in one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordMean {
    /// Number of the record.
    pub record: usize,
    /// The mean, in the unit of the channel.
    pub mean: f64,
    /// The standard error of the mean; `None` where the noise at the averaging time of the whole
    /// record is not known.
    pub error: Option<MeanError>,
}

/// The standard error of a mean under the N, B and K of its record: √½ of the standard error of the
/// difference between this mean and that of a record as long directly after it. Under flicker noise
/// and a random walk the error of a single mean is not defined, only that of a difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanError {
    /// Standard error, in the unit of the channel.
    pub standard_error: f64,
    /// Equivalent degrees of freedom of the standard error.
    pub edf: f64,
    /// Length of the record in seconds.
    pub tau_s: f64,
}

/// The difference of two means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanDifference {
    /// The numbers of the two records.
    pub records: [usize; 2],
    /// The second mean less the first, in the unit of the channel.
    pub difference: f64,
    /// Whether noise explains the difference, or why that is not known.
    pub test: Result<MeanTest, Untested>,
}

/// A test of a difference of means against the difference expected from noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanTest {
    /// Standard error of the difference, under the N, B and K of both records and the time between
    /// them, in the unit of the channel.
    pub standard_error: f64,
    /// Equivalent degrees of freedom of that standard error.
    pub edf: f64,
    /// Probability that noise alone makes a difference as large; corrected for all channels and
    /// pairs.
    pub chance: Chance,
}

/// Why it is not known whether noise explains the difference of two means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Untested {
    /// The records are of several sensors.
    SeveralSensors,
    /// The records hold the same samples.
    SameSamples,
    /// The start of a record is not known, and flicker noise and random walk grow with the time
    /// between.
    StartUnknown,
    /// Each record is a connection of its own: the sensor may have been switched off between them,
    /// and starts with another bias after that.
    MayHaveBeenOff,
    /// The records were made at the same time.
    SameTime,
    /// N, B or K of the channel is not known in one of the records.
    NoiseUnknown,
}

impl Untested {
    /// Its name in results: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SeveralSensors => "several-sensors",
            Self::SameSamples => "same-samples",
            Self::StartUnknown => "start-unknown",
            Self::MayHaveBeenOff => "may-have-been-off",
            Self::SameTime => "same-time",
            Self::NoiseUnknown => "noise-unknown",
        }
    }
}

/// The noise of one channel at all averaging times, as estimated from a record.
#[derive(Debug, Clone, Copy)]
struct RecordNoise {
    white: VarianceEstimate,
    flicker: SquaredAmplitude,
    walk: SquaredAmplitude,
}

/// The mean of one channel in one record.
#[derive(Debug, Clone, Copy)]
struct Mean {
    record: usize,
    value: f64,
    noise: Option<RecordNoise>,
}

/// One channel in all records.
struct ComparedChannel {
    name: String,
    unit: String,
    quantity: Quantity,
    means: Vec<Mean>,
    bias_removed: bool,
}

pub(super) fn means(
    records: &[ComparedRecord<'_>],
    same: &[SameSamples],
    stayed_on: bool,
    confidence: f64,
) -> Vec<ChannelMeans> {
    let of_several = are_of_several_sensors(records);
    let channels = channels(records).into_iter().map(|channel| {
        let of_record = |mean: &Mean| RecordMean {
            record: mean.record,
            mean: mean.value,
            error: mean.noise.and_then(|noise| error(&noise, &records[mean.record])),
        };
        let values: Vec<f64> = channel.means.iter().map(|mean| mean.value).collect();
        let difference = |[a, b]: [usize; 2]| {
            let [first, second] = [&channel.means[a], &channel.means[b]];
            let pair = [first.record, second.record];
            let test = may_be_tested(pair, records, same, stayed_on).and_then(|()| test(first, second, records));
            MeanDifference { records: pair, difference: second.value - first.value, test }
        };
        ChannelMeans {
            spread: Spread::of(&values, confidence).filter(|_| !of_several),
            differences: pairs(channel.means.len()).map(difference).collect(),
            means: channel.means.iter().map(of_record).collect(),
            channel: channel.name,
            quantity: channel.quantity,
            unit: channel.unit,
            bias_removed: channel.bias_removed,
        }
    });
    let mut channels: Vec<_> = channels.collect();
    let tested = |channels: &mut [ChannelMeans], take: &mut dyn FnMut(&mut Chance)| {
        let tests = channels.iter_mut().flat_map(|channel| &mut channel.differences);
        tests.filter_map(|difference| difference.test.as_mut().ok()).for_each(|test| take(&mut test.chance));
    };
    let mut probabilities = Vec::new();
    tested(&mut channels, &mut |chance| probabilities.push(chance.p));
    let mut corrected = chances(&probabilities).into_iter();
    tested(&mut channels, &mut |chance| *chance = corrected.next().unwrap_or(*chance));
    channels
}

fn channels(records: &[ComparedRecord<'_>]) -> Vec<ComparedChannel> {
    let mut found: Vec<ComparedChannel> = Vec::new();
    // the mean of a sensor that moves is not its bias
    let at_rest = records.iter().enumerate().filter(|(_, record)| record.assessment.motion.is_none());
    for (number, record) in at_rest {
        let Some(layout) = &record.snapshot.layout else { continue };
        for (index, channel) in layout.channels.iter().enumerate() {
            // an angle has no bias, and a mean of temperature, pressure or field is that of the
            // surroundings
            if sensor_of(channel.quantity).is_none() {
                continue;
            }
            let Some(mean) = mean(record, number, index, channel) else { continue };
            let bias_removed = layout.compensated == Some(true) && channel.quantity == Quantity::AngularRate;
            match found.iter_mut().find(|found| found.name == channel.name && found.unit == channel.unit) {
                Some(found) => {
                    found.means.push(mean);
                    found.bias_removed |= bias_removed;
                }
                None => found.push(ComparedChannel {
                    name: channel.name.to_string(),
                    unit: channel.unit.to_string(),
                    quantity: channel.quantity,
                    means: vec![mean],
                    bias_removed,
                }),
            }
        }
    }
    found
}

fn mean(record: &ComparedRecord<'_>, number: usize, index: usize, channel: &Channel) -> Option<Mean> {
    let results = record.snapshot.channels.get(index)?;
    let value = channel.in_unit(results.moments.mean_counts()? - results.branch_counts as f64);
    let noise = record.assessment.channels.get(index).and_then(|assessed| assessed.noise.as_ref());
    let noise = noise.and_then(|noise| RecordNoise::of(noise, record.assessment.confidence));
    Some(Mean { record: number, value, noise })
}

impl RecordNoise {
    fn of(noise: &ChannelNoise, confidence: f64) -> Option<Self> {
        if noise.long_taus != LongTauValidity::Sensor {
            return None;
        }
        let of = |term| SquaredAmplitude::of(&noise.parameter(term)?, confidence);
        let white = noise.parameter(Term::White).filter(|white| white.status == Status::Estimated)?;
        let mut squared = SquaredAmplitude::of(&white, confidence)?.estimate();
        // correlated noise averages like white noise over the length of a record
        if let Some((apparent, white)) = noise.fit.apparent_white().zip(white.value) {
            squared.variance *= (apparent / white).powi(2);
        }
        Some(Self { white: squared, flicker: of(Term::BiasInstability)?, walk: of(Term::RateRandomWalk)? })
    }

    /// Slow noise as estimated from both records together; the white noise of each record is its
    /// own.
    fn slow(&self, other: &Self) -> [(Term, VarianceEstimate); 2] {
        [
            (Term::BiasInstability, self.flicker.and(other.flicker).estimate()),
            (Term::RateRandomWalk, self.walk.and(other.walk).estimate()),
        ]
    }
}

/// The noise of the difference between the means of two stretches; the white noise of each is
/// averaged over its own samples.
fn noise_of_difference(
    white: [(VarianceEstimate, &ComparedRecord<'_>); 2],
    slow: [(Term, VarianceEstimate); 2],
    stretches: [Stretch; 2],
) -> Option<VarianceEstimate> {
    let [a, b] = stretches;
    let white = white.map(|(squared, record)| {
        let timing = &record.snapshot.timing;
        (timing.rate_hz / timing.samples as f64, squared)
    });
    let slow = slow.map(|(term, squared)| Some((a.mean_difference_variance(b, term, 1.0)?, squared)));
    VarianceEstimate::sum(white.into_iter().chain(slow.into_iter().flatten()))
}

fn error(noise: &RecordNoise, record: &ComparedRecord<'_>) -> Option<MeanError> {
    let duration_s = record.snapshot.timing.duration_s();
    let stretches = [0.0, duration_s].map(|start_s| Stretch { start_s, duration_s });
    let slow = [(Term::BiasInstability, noise.flicker.estimate()), (Term::RateRandomWalk, noise.walk.estimate())];
    let of_difference = noise_of_difference([(noise.white, record); 2], slow, stretches)?;
    let standard_error = standard_error_of_mean(of_difference.variance);
    Some(MeanError { standard_error, edf: of_difference.edf, tau_s: duration_s })
}

/// Whether the means of two records can be tested, for all of their channels.
fn may_be_tested(
    pair: [usize; 2],
    records: &[ComparedRecord<'_>],
    same: &[SameSamples],
    stayed_on: bool,
) -> Result<(), Untested> {
    let [a, b] = pair.map(|number| &records[number]);
    if are_of_several_sensors(&[*a, *b]) {
        return Err(Untested::SeveralSensors);
    }
    if same.iter().any(|same| same.records == pair) {
        return Err(Untested::SameSamples);
    }
    let (first, second) = stretch(a).zip(stretch(b)).ok_or(Untested::StartUnknown)?;
    first.dead_time_s(second).ok_or(Untested::SameTime)?;
    if stayed_on { Ok(()) } else { Err(Untested::MayHaveBeenOff) }
}

fn test(first: &Mean, second: &Mean, records: &[ComparedRecord<'_>]) -> Result<MeanTest, Untested> {
    let [a, b] = [first, second].map(|mean| &records[mean.record]);
    let tested = || {
        let (of_a, of_b) = first.noise.zip(second.noise)?;
        let stretches = stretch(a).zip(stretch(b))?;
        let white = [(of_a.white, a), (of_b.white, b)];
        let noise = noise_of_difference(white, of_a.slow(&of_b), stretches.into())?;
        let p = mean_difference_test(second.value - first.value, noise)?;
        let chance = Chance { p, corrected: p };
        Some(MeanTest { standard_error: noise.variance.sqrt(), edf: noise.edf, chance })
    };
    tested().ok_or(Untested::NoiseUnknown)
}

/// The measured stretch of time, in seconds since 1970-01-01 UTC; `None` where that is not known.
fn stretch(record: &ComparedRecord<'_>) -> Option<Stretch> {
    let start_s = record.start_ns()? as f64 * 1e-9 + record.snapshot.skipped.as_secs_f64();
    Some(Stretch { start_s, duration_s: record.snapshot.timing.duration_s() })
}

/// Whether two of the records name different serial numbers.
pub(super) fn are_of_several_sensors(records: &[ComparedRecord<'_>]) -> bool {
    let mut serials = records.iter().filter_map(|record| record.snapshot.registers.get(&Register::SERIAL_NUMBER.0));
    let first = serials.next();
    serials.any(|serial| Some(serial) != first)
}

//! Which record has the least white noise, sensor by sensor.

use imu_noise::{Interval, Sensor, Term, si_unit};
use serde::Serialize;
use vn100_protocol::Quantity;

use super::{Chance, SameSamples, correct, fold_alike, pairs};
use crate::hypothesis_tests::{VarianceEstimate, f_test};
use crate::{ChannelResult, Onboard, SENSORS, SourceResult, axes_name};

/// The records in ascending order of the white noise of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ranking {
    /// The sensor: `gyro`, `accel` or `mag`.
    pub sensor: &'static str,
    /// Quantity of the sensor.
    #[serde(skip)]
    pub quantity: Quantity,
    /// Unit of N.
    pub unit: &'static str,
    /// The records whose N is estimated on every axis, the quietest first.
    #[serde(rename = "ranked")]
    pub records: Vec<RankedRecord>,
    /// Whether white noise aliases in the same way in all records, so that N can be compared.
    pub folds_alike: bool,
    /// The tests of every pair whose noise aliases alike, corrected for all pairs of all sensors.
    pub tests: Vec<WhiteTest>,
    /// The quietest record, if it is significantly quieter than the next one.
    pub quietest: Option<usize>,
    /// The records with this sensor whose N is not estimated on every axis.
    pub not_ranked: Vec<usize>,
}

/// The white noise of one sensor in one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedRecord {
    /// The number of the record.
    pub record: usize,
    /// N of the sensor: the root of the mean of N² over the axes.
    pub white: f64,
    /// Lower limit of the confidence interval of `white`.
    pub lower: f64,
    /// Upper limit of the confidence interval of `white`.
    pub upper: f64,
    /// N of each axis.
    pub axes: Vec<AxisWhite>,
    /// White noise of the stream over that of the sensor itself, if the averaging window is known.
    pub white_factor: Option<f64>,
}

/// N of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisWhite {
    /// Name of the axis.
    pub name: String,
    /// N of the axis.
    pub white: f64,
}

impl RankedRecord {
    /// N without aliasing, to within [`Onboard::UNCERTAINTY`](crate::Onboard::UNCERTAINTY); `white`
    /// itself if the effect of aliasing is not known.
    pub fn own(&self) -> f64 {
        self.white / self.white_factor.unwrap_or(1.0)
    }
}

/// The white noise of two records, compared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WhiteTest {
    /// The numbers of the two records.
    pub records: [usize; 2],
    /// Probability that they differ as much by chance.
    #[serde(flatten)]
    pub chance: Chance,
}

impl Ranking {
    /// Probability that the quietest record is quieter than the next one by chance. `None` for one
    /// record alone, if white noise does not alias in the same way (the factors are known less well
    /// than N), and for two records with the same samples.
    pub fn lead(&self) -> Option<Chance> {
        let [first, second, ..] = &self.records[..] else { return None };
        let is_of_both =
            |test: &&WhiteTest| test.records.contains(&first.record) && test.records.contains(&second.record);
        self.tests.iter().find(is_of_both).filter(|_| self.folds_alike).map(|test| test.chance)
    }
}

pub(super) fn rankings(records: &[SourceResult], same: &[SameSamples], confidence: f64) -> Vec<Ranking> {
    // in the order of the channels of a message
    let sensors = SENSORS.into_iter().rev();
    let mut rankings: Vec<Ranking> =
        sensors.filter_map(|(quantity, sensor)| ranking(quantity, sensor, records, same, confidence)).collect();
    let tests = rankings.iter_mut().flat_map(|ranking| &mut ranking.tests);
    correct(tests.map(|test| &mut test.chance), confidence);
    for ranking in &mut rankings {
        let leads = ranking.lead().is_some_and(|lead| lead.differs);
        ranking.quietest = ranking.records.first().filter(|_| leads).map(|first| first.record);
    }
    rankings
}

/// The records with this sensor; `None` without one.
fn ranking(
    quantity: Quantity,
    sensor: Sensor,
    records: &[SourceResult],
    same: &[SameSamples],
    confidence: f64,
) -> Option<Ranking> {
    let mut ranked: Vec<(RankedRecord, VarianceEstimate)> = Vec::new();
    let mut not_ranked = Vec::new();
    let of_sensor = |record| SourceResult::streamed(record).filter(|channel| channel.quantity == quantity);
    let all: Vec<Vec<_>> = records.iter().map(|record| of_sensor(record).collect()).collect();
    let has = |axes: &[&ChannelResult], name: &str| axes.iter().any(|channel| channel.name == name);
    for (number, axes) in all.iter().enumerate() {
        // an axis that another record lacks would decide without being compared
        let is_common = |axis: &&ChannelResult| all.iter().all(|other| other.is_empty() || has(other, &axis.name));
        let common: Vec<_> = axes.iter().copied().filter(is_common).collect();
        match ranked_record(number, &common, confidence) {
            _ if axes.is_empty() => {}
            Some(known) => ranked.push(known),
            None => not_ranked.push(number),
        }
    }
    if ranked.is_empty() && not_ranked.is_empty() {
        return None;
    }
    ranked.sort_by(|(a, _), (b, _)| a.own().total_cmp(&b.own()));
    let of_pair = |[a, b]: [usize; 2]| [&ranked[a], &ranked[b]];
    let (alike, others): (Vec<_>, Vec<_>) = pairs(ranked.len()).map(of_pair).partition(|pair| {
        let [a, b] = pair.map(|(ranked, _)| &records[ranked.record]);
        fold_alike(quantity, a, b)
    });
    let test = |[(a, of_a), (b, of_b)]: [&(RankedRecord, VarianceEstimate); 2]| {
        let pair = [a.record, b.record];
        let share = |same: &SameSamples| pair.iter().all(|record| same.records.contains(record));
        let p = f_test((of_a.variance, of_a.edf), (of_b.variance, of_b.edf)).filter(|_| !same.iter().any(share))?;
        Some(WhiteTest { records: pair, chance: Chance::new(p) })
    };
    Some(Ranking {
        sensor: axes_name(sensor),
        quantity,
        unit: si_unit(sensor, Term::White),
        folds_alike: others.is_empty(),
        tests: alike.into_iter().filter_map(test).collect(),
        quietest: None,
        records: ranked.into_iter().map(|(record, _)| record).collect(),
        not_ranked,
    })
}

/// The record in the ranking; `None` without axes, or if N is not estimated on every one.
fn ranked_record(record: usize, axes: &[&ChannelResult], confidence: f64) -> Option<(RankedRecord, VarianceEstimate)> {
    let mut known = Vec::new();
    for channel in axes {
        let white = channel.noise.as_ref()?.parameter(Term::White)?;
        let (value, lower, upper) = (white.value?, white.lower?, white.upper?);
        let estimate = VarianceEstimate::of_interval(value, lower, upper, confidence)?;
        known.push((channel.name.clone(), value, estimate));
    }
    let share = 1.0 / known.len() as f64;
    let mean_square = VarianceEstimate::sum(known.iter().map(|(.., estimate)| (share, *estimate)))?;
    let interval = Interval::new(mean_square.variance, mean_square.edf, confidence)?;
    let ranked = RankedRecord {
        record,
        white: mean_square.variance.sqrt(),
        lower: interval.lower,
        upper: interval.upper,
        axes: known.into_iter().map(|(name, white, _)| AxisWhite { name, white }).collect(),
        white_factor: axes.first()?.onboard.filter(Onboard::window_known).map(|onboard| onboard.window.white_factor()),
    };
    Some((ranked, mean_square))
}

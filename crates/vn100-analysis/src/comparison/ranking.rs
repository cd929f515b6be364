//! Which record has the least white noise, sensor by sensor.

use crate::hypothesis_tests::{VarianceEstimate, f_test};
use imu_noise::{Interval, Term, conventions};
use vn100_protocol::{Channel, Quantity};

use super::{Chance, ComparedRecord, SameSamples, chances, fold_alike, pairs};
use crate::{ChannelAssessment, SENSORS};

/// The records in ascending order of the white noise of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// Quantity of the sensor.
    pub quantity: Quantity,
    /// Unit of N.
    pub unit: &'static str,
    /// The quietest record first, by [`RankedRecord::own`]; only records whose N is estimated on
    /// every axis.
    pub records: Vec<RankedRecord>,
    /// Whether white noise aliases in the same way in all records, so that N can be compared.
    pub folds_alike: bool,
    /// The tests of every pair of records, where white noise aliases alike and the samples are not
    /// the same; corrected for all pairs of all sensors.
    pub tests: Vec<WhiteTest>,
    /// The records with this sensor whose N is not estimated on every axis.
    pub not_ranked: Vec<usize>,
}

/// The white noise of one sensor in one record.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedRecord {
    /// The number of the record.
    pub record: usize,
    /// N of the sensor: the root of the mean of N² over the axes.
    pub white: f64,
    /// Lower limit of the confidence interval of `white`.
    pub lower: f64,
    /// Upper limit of the confidence interval of `white`.
    pub upper: f64,
    /// Name of each axis, and its N.
    pub axes: Vec<(String, f64)>,
    /// Density of the white noise in the stream over that of the sensor itself; `None` where that
    /// is not known.
    pub white_factor: Option<f64>,
}

impl RankedRecord {
    /// N without aliasing, to within [`Onboard::UNCERTAINTY`](crate::Onboard::UNCERTAINTY); `white`
    /// itself where the effect of aliasing is not known.
    #[must_use]
    pub fn own(&self) -> f64 {
        self.white / self.white_factor.unwrap_or(1.0)
    }
}

/// The white noise of two records, compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiteTest {
    /// The numbers of the two records.
    pub records: [usize; 2],
    /// Probability that they differ as much by chance.
    pub chance: Chance,
}

impl Ranking {
    /// Probability that the quietest record is quieter than the next one by chance. `None` for one
    /// record alone, where white noise does not alias in the same way (the factors are known less
    /// well than N), and for two records with the same samples.
    #[must_use]
    pub fn lead(&self) -> Option<Chance> {
        if !self.folds_alike {
            return None;
        }
        let [first, second, ..] = &self.records[..] else { return None };
        let test = (self.tests.iter())
            .find(|test| test.records.contains(&first.record) && test.records.contains(&second.record));
        test.map(|test| test.chance)
    }
}

pub(super) fn rankings(records: &[ComparedRecord<'_>], same: &[SameSamples], confidence: f64) -> Vec<Ranking> {
    let mut rankings = Vec::new();
    let mut probabilities = Vec::new();
    // in the order of the channels of a message
    for (quantity, sensor) in SENSORS.into_iter().rev() {
        let mut ranked: Vec<(RankedRecord, VarianceEstimate)> = Vec::new();
        let mut not_ranked = Vec::new();
        for (number, record) in records.iter().enumerate() {
            let axes: Vec<_> = (record.snapshot.layout_channels().iter().zip(&record.assessment.channels))
                .filter(|(channel, _)| channel.quantity == quantity)
                .collect();
            if axes.is_empty() {
                continue;
            }
            match ranked_record(number, &axes, confidence) {
                Some(known) => ranked.push(known),
                None => not_ranked.push(number),
            }
        }
        ranked.sort_by(|(a, _), (b, _)| a.own().total_cmp(&b.own()));
        let alike =
            |[a, b]: [usize; 2]| fold_alike(quantity, &records[ranked[a].0.record], &records[ranked[b].0.record]);
        let folds_alike = pairs(ranked.len()).all(alike);
        let are_others = |[a, b]: &[usize; 2]| {
            let pair = [ranked[*a].0.record, ranked[*b].0.record];
            same.iter().all(|same| !pair.iter().all(|record| same.records.contains(record)))
        };
        let tests = pairs(ranked.len()).filter(are_others).filter(|pair| alike(*pair)).filter_map(|[a, b]| {
            let of = |(_, estimate): &(RankedRecord, VarianceEstimate)| (estimate.variance, estimate.edf);
            let p = f_test(of(&ranked[a]), of(&ranked[b]))?;
            Some(WhiteTest { records: [ranked[a].0.record, ranked[b].0.record], chance: Chance { p, corrected: p } })
        });
        let tests: Vec<_> = tests.collect();
        probabilities.extend(tests.iter().map(|test| test.chance.p));
        if !ranked.is_empty() || !not_ranked.is_empty() {
            let unit = conventions(sensor, Term::White).first().map_or("", |si| si.unit);
            let records = ranked.into_iter().map(|(record, _)| record).collect();
            rankings.push(Ranking { quantity, unit, records, folds_alike, tests, not_ranked });
        }
    }
    let all_tests = rankings.iter_mut().flat_map(|ranking| &mut ranking.tests);
    for (test, chance) in all_tests.zip(chances(&probabilities)) {
        test.chance = chance;
    }
    rankings
}

/// The record in the ranking; `None` where N is not estimated on every one of the `axes`.
fn ranked_record(
    record: usize,
    axes: &[(&Channel, &ChannelAssessment)],
    confidence: f64,
) -> Option<(RankedRecord, VarianceEstimate)> {
    let mut known = Vec::new();
    for (channel, assessed) in axes {
        let white = assessed.noise.as_ref()?.parameter(Term::White)?;
        let (value, lower, upper) = (white.value?, white.lower?, white.upper?);
        let estimate = VarianceEstimate::of_interval(value, lower, upper, confidence)?;
        known.push((channel.name.to_string(), value, estimate));
    }
    let share = 1.0 / known.len() as f64;
    let mean_square = VarianceEstimate::sum(known.iter().map(|(.., estimate)| (share, *estimate)))?;
    let interval = Interval::new(mean_square.variance, mean_square.edf, confidence)?;
    let ranked = RankedRecord {
        record,
        white: mean_square.variance.sqrt(),
        lower: interval.lower,
        upper: interval.upper,
        axes: known.into_iter().map(|(name, value, _)| (name, value)).collect(),
        white_factor: axes.first()?.1.onboard.map(|onboard| onboard.window.white_factor()),
    };
    Some((ranked, mean_square))
}

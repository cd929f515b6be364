//! N, B and K over three recordings or more: what units have, and what the next one will have.

use imu_noise::{Parameter, Sensor, Status, Term, chi_squared, si_unit};
use serde::Serialize;

use super::{SameSamples, have_same_rate};
use crate::{SourceResult, sensor::sensor_of};

/// Fewer values show no spread worth a number.
const LEAST: usize = 3;

/// Longest over shortest recording: recordings beyond this ratio see other parts of the noise.
const MOST_LENGTH_RATIO: f64 = 2.0;

/// One parameter of one channel over all recordings that say something of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Population {
    /// Name of the channel.
    pub channel: String,
    /// The sensor of the channel.
    #[serde(skip)]
    pub sensor: Sensor,
    /// The parameter: N, B or K.
    #[serde(rename = "parameter")]
    pub term: Term,
    /// SI unit of the parameter.
    pub unit: &'static str,
    /// The units, in the order of their first recordings.
    #[serde(rename = "sensors")]
    pub units: Vec<UnitValue>,
    /// The median over units; over the recordings if all are of one unit. With a bound among them this and
    /// the next two are bounds.
    pub median: f64,
    /// The lowest value of a recording.
    pub lowest: f64,
    /// The highest value of a recording.
    pub highest: f64,
    /// Standard deviation of the logarithm between recordings, 0.05 for 5 %; `None` if a recording
    /// only bounds the parameter.
    pub spread: Option<f64>,
    /// Lower end of the interval in which the next unit will lie, or the next recording if all are
    /// of one unit: by Student's t on the logarithms of the means of units.
    pub next_lower: Option<f64>,
    /// Upper end of that interval.
    pub next_upper: Option<f64>,
    /// Why there is no such interval; `None` if there is one.
    pub no_interval: Option<NoPrediction>,
}

/// A sensor among several, and the parameter over its recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnitValue {
    /// Its name: a serial number, a folder, or what the user calls it.
    pub name: String,
    /// The numbers of its recordings.
    pub records: Vec<usize>,
    /// Geometric mean of its estimates, or of the bounds too if there is any.
    pub value: f64,
    /// Whether a recording of it only bounds the parameter.
    #[serde(rename = "bound")]
    pub is_bound: bool,
}

/// Why there is no prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoPrediction {
    /// A recording only bounds the parameter.
    Bound,
    /// The recordings are not of like lengths.
    Lengths,
    /// The recordings differ in message or rate.
    Streams,
    /// There are two units, or too few recordings of one.
    Few,
}

/// A recording that says something of a parameter.
struct Reading<'a> {
    record: usize,
    unit: &'a str,
    value: f64,
    is_bound: bool,
}

/// Of each axis N, B and K, if three recordings or more say something of it. `units` names the
/// sensor of each record; of records with the same samples the first counts alone.
pub(super) fn populations(
    records: &[SourceResult],
    units: &[String],
    same_samples: &[SameSamples],
    confidence: f64,
) -> Vec<Population> {
    let copies = copies(same_samples);
    let counted: Vec<usize> = (0..records.len()).filter(|record| !copies.contains(record)).collect();
    let Some(first) = counted.iter().find(|record| !records[**record].channels.is_empty()) else {
        return Vec::new();
    };
    let mut populations = Vec::new();
    for channel in records[*first].streamed() {
        let Some(sensor) = sensor_of(channel.quantity) else { continue };
        for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
            let reading = |record: &usize| {
                let found = parameter(&records[*record], &channel.name, term)?;
                let (value, is_bound) = match found.status {
                    Status::Estimated => (found.value?, false),
                    Status::Bounded => (found.upper?, true),
                    Status::NotObservable | Status::NotMeasurable | Status::ModelRejected | Status::Moved => {
                        return None;
                    }
                };
                let unit = units.get(*record).map_or("", String::as_str);
                (value > 0.0).then_some(Reading { record: *record, unit, value, is_bound })
            };
            let readings: Vec<Reading<'_>> = counted.iter().filter_map(reading).collect();
            if readings.len() >= LEAST {
                let why_none = why_no_prediction(records, &readings);
                populations.push(population(&channel.name, sensor, term, &readings, why_none, confidence));
            }
        }
    }
    populations
}

/// Of two records of which one holds all samples of the other, that one, or the later.
fn copies(same_samples: &[SameSamples]) -> Vec<usize> {
    let copy = |same: &SameSamples| {
        let [first, second] = same.records;
        let is_whole = |part: f64| part >= SameSamples::WHOLE;
        is_whole(same.of_second).then_some(second).or(is_whole(same.of_first).then_some(first))
    };
    same_samples.iter().filter_map(copy).collect()
}

fn parameter(record: &SourceResult, channel: &str, term: Term) -> Option<Parameter> {
    record.streamed().find(|own| own.name == channel)?.noise.as_ref()?.parameter(term)
}

fn why_no_prediction(records: &[SourceResult], readings: &[Reading<'_>]) -> Option<NoPrediction> {
    let of = |reading: &Reading<'_>| &records[reading.record];
    let lengths = || readings.iter().map(|reading| of(reading).timing.duration_s);
    let (shortest, longest) = (lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max));
    let first = of(&readings[0]);
    let is_other = |reading: &Reading<'_>| {
        let own = of(reading);
        own.source.message != first.source.message || !have_same_rate(own, first)
    };
    match () {
        () if readings.iter().any(|reading| reading.is_bound) => Some(NoPrediction::Bound),
        () if readings.iter().any(is_other) => Some(NoPrediction::Streams),
        () if longest > MOST_LENGTH_RATIO * shortest => Some(NoPrediction::Lengths),
        () => None,
    }
}

fn population(
    channel: &str,
    sensor: Sensor,
    term: Term,
    readings: &[Reading<'_>],
    why_none: Option<NoPrediction>,
    confidence: f64,
) -> Population {
    let mut units: Vec<(UnitValue, Vec<f64>)> = Vec::new();
    for reading in readings {
        let place = units.iter().position(|(unit, _)| unit.name == reading.unit).unwrap_or_else(|| {
            let name = reading.unit.to_owned();
            units.push((UnitValue { name, records: Vec::new(), value: 0.0, is_bound: false }, Vec::new()));
            units.len() - 1
        });
        let (unit, logs) = &mut units[place];
        unit.records.push(reading.record);
        unit.is_bound |= reading.is_bound;
        logs.push(reading.value.ln());
        unit.value = mean(logs).exp();
    }
    let logs: Vec<f64> = readings.iter().map(|reading| reading.value.ln()).collect();
    let units: Vec<UnitValue> = units.into_iter().map(|(unit, _)| unit).collect();
    let independent = if units.len() > 1 { units.iter().map(|unit| unit.value.ln()).collect() } else { logs.clone() };
    let prediction = match why_none {
        Some(why) => Err(why),
        None => next(&independent, confidence).ok_or(NoPrediction::Few),
    };
    let extreme = |pick: fn(f64, f64) -> f64| readings.iter().map(|reading| reading.value).reduce(pick);
    Population {
        channel: channel.to_owned(),
        sensor,
        term,
        unit: si_unit(sensor, term),
        median: median(independent).exp(),
        lowest: extreme(f64::min).unwrap_or(f64::NAN),
        highest: extreme(f64::max).unwrap_or(f64::NAN),
        spread: (!readings.iter().any(|reading| reading.is_bound)).then(|| deviation(&logs)),
        units,
        next_lower: prediction.ok().map(|[lower, _]| lower),
        next_upper: prediction.ok().map(|[_, upper]| upper),
        no_interval: prediction.err(),
    }
}

fn mean(logs: &[f64]) -> f64 {
    logs.iter().sum::<f64>() / logs.len() as f64
}

fn deviation(logs: &[f64]) -> f64 {
    let mean = mean(logs);
    let squares: f64 = logs.iter().map(|log| (log - mean).powi(2)).sum();
    (squares / (logs.len() - 1) as f64).sqrt()
}

fn median(mut logs: Vec<f64>) -> f64 {
    logs.sort_by(f64::total_cmp);
    let half = logs.len() / 2;
    if logs.len() % 2 == 1 { logs[half] } else { (logs[half - 1] + logs[half]) / 2.0 }
}

/// The interval of one more of these, by Student's t; `None` below three.
fn next(logs: &[f64], confidence: f64) -> Option<[f64; 2]> {
    let count = logs.len() as f64;
    let t = chi_squared::student_two_sided(confidence, count - 1.0).filter(|_| logs.len() >= LEAST)?;
    let reach = t * deviation(logs) * (1.0 + 1.0 / count).sqrt();
    Some([mean(logs) - reach, mean(logs) + reach].map(f64::exp))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(readings: &[(&str, f64, bool)]) -> Population {
        let readings: Vec<Reading<'_>> = (0..)
            .zip(readings)
            .map(|(record, (unit, value, is_bound))| Reading { record, unit, value: *value, is_bound: *is_bound })
            .collect();
        let why = readings.iter().any(|reading| reading.is_bound).then_some(NoPrediction::Bound);
        population("gyro_x", Sensor::Gyroscope, Term::White, &readings, why, 0.95)
    }

    #[test]
    fn the_next_recording_lies_in_the_interval_of_students_t_on_logarithms() {
        let found = of(&[("a", 1.0, false), ("a", 2.0, false), ("a", 4.0, false)]);
        assert!(
            (found.median - 2.0).abs() < 1e-12 && (found.lowest, found.highest) == (1.0, 4.0) && found.units.len() == 1
        );
        assert!((found.spread.unwrap() - 2_f64.ln()).abs() < 1e-12);
        // t of two degrees of freedom at 95 % is 4.302653 (tables)
        let reach = 4.302_652_73 * 2_f64.ln() * (4.0_f64 / 3.0).sqrt();
        let (lower, upper) = found.next_lower.zip(found.next_upper).unwrap();
        assert!((lower.ln() - (2_f64.ln() - reach)).abs() < 1e-6 && (upper.ln() - (2_f64.ln() + reach)).abs() < 1e-6);
    }

    #[test]
    fn units_count_by_their_means_and_two_are_too_few() {
        let three =
            of(&[("a", 1.0, false), ("a", 4.0, false), ("b", 2.0, false), ("c", 3.0, false), ("b", 2.0, false)]);
        let means: Vec<_> = three.units.iter().map(|unit| (unit.name.as_str(), unit.records.clone())).collect();
        assert_eq!(means, [("a", vec![0, 1]), ("b", vec![2, 4]), ("c", vec![3])]);
        assert!((three.units[0].value - 2.0).abs() < 1e-12 && (three.median - 2.0).abs() < 1e-12);
        assert!(three.no_interval.is_none());
        let two = of(&[("a", 1.0, false), ("a", 2.0, false), ("b", 2.0, false)]);
        assert_eq!((two.no_interval, two.next_lower), (Some(NoPrediction::Few), None));
        let bound = of(&[("a", 1.0, false), ("b", 2.0, true), ("c", 2.0, false)]);
        assert_eq!((bound.no_interval, bound.spread), (Some(NoPrediction::Bound), None));
        assert!(bound.units[1].is_bound && (bound.lowest, bound.highest) == (1.0, 2.0));
    }

    #[test]
    fn a_copy_counts_once() {
        let same = |records, of_first, of_second| SameSamples { records, of_first, of_second };
        assert_eq!(copies(&[same([0, 1], 1.0, 1.0), same([2, 3], 1.0, 0.3), same([4, 5], 0.5, 0.5)]), [1, 2]);
    }
}

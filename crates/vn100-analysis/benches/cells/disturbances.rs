//! What is found where a record is disturbed, and what its noise is then said to be.

use std::collections::BTreeMap;

use imu_noise::{Parameter, Status, Term};
use vn100_analysis::WarningKind;

use super::{
    clean, families,
    generators::{Flicker, Part},
    random::Random,
    record::{self, Assessed, Record},
    scoring::limits,
};
use crate::{Arguments, figures, in_parallel};

#[derive(Clone, Copy)]
enum Disturbance {
    /// Of the white part, from this share of the record on.
    LouderFrom {
        share: f64,
        factor: f64,
    },
    /// Of the white part, for seconds.
    LouderFor {
        seconds: f64,
        factor: f64,
    },
    /// The same value again and again, for seconds.
    Frozen {
        seconds: f64,
    },
    Spikes {
        count: usize,
        height: f64,
    },
    Cycle {
        period_s: f64,
        deviation: f64,
    },
    Step(f64),
    WarmUp {
        height: f64,
        time_s: f64,
    },
}

const DISTURBANCES: [(&str, Disturbance); 7] = [
    ("x1.1 in the second half", Disturbance::LouderFrom { share: 0.5, factor: 1.1 }),
    ("x2 for 20 s", Disturbance::LouderFor { seconds: 20.0, factor: 2.0 }),
    ("frozen for 5 s", Disturbance::Frozen { seconds: 5.0 }),
    ("20 spikes of 8 sd", Disturbance::Spikes { count: 20, height: 8.0 }),
    ("cycle of 300 s, 0.3 sd", Disturbance::Cycle { period_s: 300.0, deviation: 0.3 }),
    ("step of 0.5 sd", Disturbance::Step(0.5)),
    ("warm-up of 3 sd, 300 s", Disturbance::WarmUp { height: 3.0, time_s: 300.0 }),
];

/// What was found, and which parameters were called estimated that the noise does not have.
struct Found {
    kinds: Vec<&'static str>,
    false_walk: bool,
    /// A bias instability whose interval does not hold the true one.
    wrong_bias_instability: bool,
}

pub(crate) fn measure(arguments: &Arguments) {
    for minutes in arguments.minutes_or(&[60]) {
        let duration_s = 60.0 * *minutes as f64;
        let white = families::Cell { duration_s, ..families::clean() };
        beside(arguments, *minutes, "white noise", &white);
        beside(arguments, *minutes, "flicker noise", &families::disturbed(duration_s));
    }
}

/// In noise like that of `cell`.
fn beside(arguments: &Arguments, minutes: usize, noise: &str, cell: &families::Cell) {
    let records = arguments.records;
    println!("### Stationarity records, {minutes} min, {noise}, {records} records\n");
    println!("One of six channels is disturbed; flicker noise crosses the white noise at 5 s.\n");
    println!("| disturbance | found % | 95 % limits | K estimated % | B missed % | as, records |");
    println!("|---|---:|---:|---:|---:|---|");
    let truth = cell.truth().bias_instability / (cell.step * record::counts_per_unit());
    let flicker = Flicker::new(cell.samples());
    for (name, disturbance) in DISTURBANCES {
        let found = in_parallel(arguments.threads, records, |number| {
            let mut random = Random::of_record(arguments.seed, name, cell.samples(), number);
            let mut record = Record::of(cell, &flicker, &mut random);
            let (place, channel) = record::scored().nth(number % record::SCORED).unwrap();
            record.series[number % record::SCORED] = disturbance.series(cell, &flicker, &mut random);
            let assessed = record.assess(cell, &mut random);
            let parameter = |term| {
                let noise = assessed.assessment.channels[place].noise.as_ref()?;
                noise.parameter(term).filter(|parameter| parameter.status == Status::Estimated)
            };
            let misses = |parameter: Parameter| {
                parameter.lower.is_some_and(|lower| lower > truth) || parameter.upper.is_some_and(|upper| upper < truth)
            };
            Found {
                kinds: findings(&assessed, channel, place),
                false_walk: parameter(Term::RateRandomWalk).is_some(),
                wrong_bias_instability: parameter(Term::BiasInstability).is_some_and(misses),
            }
        });
        let share = |of: fn(&Found) -> bool| found.iter().filter(|found| of(found)).count();
        let percent = |count: usize| 100.0 * count as f64 / records as f64;
        let seen = share(|found| !found.kinds.is_empty());
        let (lower, upper) = limits(seen, records);
        let values = [
            ("found %", percent(seen)),
            ("K estimated %", percent(share(|found| found.false_walk))),
            ("B missed %", percent(share(|found| found.wrong_bias_instability))),
        ];
        let values = values.map(|(name, percent)| (name, format!("{percent:.1}")));
        figures::record(&format!("disturbances in {noise}"), &format!("{name}, {minutes} min"), &values);
        println!(
            "| {name} | {:.1} | {:.1}-{:.1} | {:.1} | {:.1} | {} |",
            percent(seen),
            100.0 * lower,
            100.0 * upper,
            percent(share(|found| found.false_walk)),
            percent(share(|found| found.wrong_bias_instability)),
            kinds(found.iter().flat_map(|found| &found.kinds))
        );
    }
}

/// The names of what is found in the channel at `place`, each once.
fn findings(assessed: &Assessed, channel: &str, place: usize) -> Vec<&'static str> {
    let mut found = clean::names(&assessed.assessment.channels[place].stationarity);
    for warning in assessed.snapshot.warnings.iter().chain(&assessed.assessment.warnings) {
        let of_disturbance =
            [WarningKind::NotStationary, WarningKind::WarmUp, WarningKind::VibrationLine].contains(&warning.kind);
        if !of_disturbance && warning.channels.iter().any(|name| name == channel) {
            found.push(warning.kind.name());
        }
    }
    found.dedup();
    found
}

/// How many records show each.
pub(crate) fn kinds<'a>(found: impl Iterator<Item = &'a &'static str>) -> String {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for kind in found {
        *kinds.entry(kind).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.into_iter().map(|(kind, records)| format!("{kind} {records}")).collect();
    kinds.join(", ")
}

impl Disturbance {
    /// Of the noise of `cell`, disturbed.
    fn series(self, cell: &families::Cell, flicker: &Flicker, random: &mut Random) -> Vec<f64> {
        let mut series = cell.white.series(cell.samples(), random);
        let samples = series.len();
        let at = |seconds: f64| (seconds * cell.rate_hz) as usize;
        // neither at the beginning nor at the end
        let mut within = |length: usize| {
            let free = (samples - length) as f64;
            (free * (0.1 + 0.8 * random.uniform())) as usize
        };
        let (begin, end) = match self {
            Self::LouderFrom { share, .. } => ((share * samples as f64) as usize, samples),
            Self::LouderFor { seconds, .. } | Self::Frozen { seconds } => {
                let begin = within(at(seconds));
                (begin, begin + at(seconds))
            }
            Self::Step(_) => (within(0), samples),
            Self::Spikes { .. } | Self::Cycle { .. } | Self::WarmUp { .. } => (0, samples),
        };
        if let Self::LouderFrom { factor, .. } | Self::LouderFor { factor, .. } = self {
            series[begin..end].iter_mut().for_each(|value| *value *= factor);
        }
        let phase = random.uniform();
        for part in &cell.parts {
            part.add_to(&mut series, cell.rate_hz, flicker, phase, random);
        }
        match self {
            Self::LouderFrom { .. } | Self::LouderFor { .. } => {}
            Self::Frozen { .. } => {
                let value = series[begin];
                series[begin..end].fill(value);
            }
            Self::Spikes { count, height } => {
                for _ in 0..count {
                    let place = (samples as f64 * random.uniform()) as usize;
                    series[place] += height * random.sign();
                }
            }
            Self::Cycle { period_s, deviation } => {
                let cycle = Part::Cycle { period_s, deviation };
                cycle.add_to(&mut series, cell.rate_hz, flicker, phase, random);
            }
            Self::Step(height) => series[begin..end].iter_mut().for_each(|value| *value += height),
            Self::WarmUp { height, time_s } => {
                let decay = |i: usize| (-(i as f64) / (cell.rate_hz * time_s)).exp();
                series.iter_mut().enumerate().for_each(|(i, value)| *value += height * decay(i));
            }
        }
        series
    }
}

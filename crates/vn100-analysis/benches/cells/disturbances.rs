//! What is found where a record is disturbed, and where it is not.

use std::collections::BTreeMap;

use vn100_analysis::WarningKind;

use super::{
    families,
    generators::{Flicker, Part, White},
    random::Random,
    record::{self, Assessed, Record},
};
use crate::{Arguments, in_parallel};

/// What a clean record of this stream shows too.
const OF_THE_STREAM: [WarningKind; 1] = [WarningKind::DecimatedStream];

/// Minutes of the disturbed records, and of the clean ones.
const DISTURBED_MIN: usize = 60;
const CLEAN_MIN: usize = 10;

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

const TAILS: [(&str, White); 3] =
    [("Gaussian", White::Gaussian), ("Student t5", White::Student5), ("Laplace", White::Laplace)];

pub(crate) fn measure(arguments: &Arguments) {
    let records = arguments.records;
    println!(
        "### Disturbed records, {DISTURBED_MIN} min, white noise and flicker noise crossing at 5 s, {records} records\n"
    );
    println!("One of six channels is disturbed.\n");
    println!("| disturbance | found % | as, records |");
    println!("|---|---:|---|");
    let seconds = |minutes: usize| 60.0 * minutes as f64;
    let mut cell = families::disturbed(seconds(DISTURBED_MIN));
    let flicker = Flicker::new(cell.samples());
    for (name, disturbance) in DISTURBANCES {
        let found = in_parallel(arguments.threads, records, |number| {
            let mut random = Random::of_record(arguments.seed, name, cell.samples(), number);
            let mut record = Record::of(&cell, &flicker, &mut random);
            let (place, channel) = record::scored().nth(number % record::SCORED).unwrap();
            record.series[number % record::SCORED] = disturbance.series(&cell, &flicker, &mut random);
            findings(&record.assess(&cell, &mut random), |name| name == channel, &[place])
        });
        row(name, &found);
    }
    println!("\n### Clean records, {CLEAN_MIN} min, {records} records\n");
    println!("Findings in any of six channels.\n");
    println!("| noise | found % | as, records |");
    println!("|---|---:|---|");
    cell.duration_s = seconds(CLEAN_MIN);
    let flicker = Flicker::new(cell.samples());
    for (name, white) in TAILS {
        for (with, parts) in [("", Vec::new()), (" and flicker", cell.parts.clone())] {
            let name = format!("{name}{with}");
            let cell = families::Cell { white, parts, ..cell.clone() };
            let found = in_parallel(arguments.threads, records, |number| {
                let mut random = Random::of_record(arguments.seed, &name, cell.samples(), number);
                let assessed = Record::of(&cell, &flicker, &mut random).assess(&cell, &mut random);
                let places: Vec<usize> = record::scored().map(|(place, _)| place).collect();
                findings(&assessed, |name| record::scored().any(|(_, scored)| scored == name), &places)
            });
            row(&name, &found);
        }
    }
}

/// The names of what is found in the channels that are meant, each once.
fn findings(assessed: &Assessed, is_meant: impl Fn(&str) -> bool, places: &[usize]) -> Vec<&'static str> {
    let mut found = Vec::new();
    for warning in assessed.snapshot.warnings.iter().chain(&assessed.assessment.warnings) {
        if warning.channels.iter().any(|name| is_meant(name)) && !OF_THE_STREAM.contains(&warning.kind) {
            found.push(warning.kind.name());
        }
    }
    let disturbed = |place: &usize| {
        let disturbed = &assessed.assessment.channels[*place].disturbed;
        !disturbed.disturbances.is_empty() || disturbed.level_change.is_some()
    };
    // reported nowhere
    if found.is_empty() && places.iter().any(disturbed) {
        found.push("no warning");
    }
    found.sort_unstable();
    found.dedup();
    found
}

fn row(name: &str, found: &[Vec<&'static str>]) {
    let share = found.iter().filter(|found| !found.is_empty()).count() as f64 / found.len() as f64;
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for kind in found.iter().flatten() {
        *kinds.entry(kind).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.into_iter().map(|(kind, records)| format!("{kind} {records}")).collect();
    println!("| {name} | {:.1} | {} |", 100.0 * share, kinds.join(", "));
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

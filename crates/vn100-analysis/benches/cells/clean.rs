//! What is found where nothing disturbs a record.

use imu_noise::{ChannelSignal, Histogram, LevelSearch, LevelShape, SpectrumPlan};
use vn100_analysis::Stationarity;

use super::{
    disturbances::kinds,
    families,
    generators::{Flicker, Part, White},
    random::Random,
    record::SCORED,
    scoring::limits,
};
use crate::{Arguments, figures, in_parallel};

const WHITES: [(&str, White); 5] = [
    ("Gaussian", White::Gaussian),
    ("Student t5", White::Student5),
    ("Laplace", White::Laplace),
    ("low-passed", White::LowPass { order: 2, corner: 0.2 }),
    ("mean of 4", White::Window(4)),
];

/// Correlated over five seconds.
const PROCESS: [Part; 1] = [Part::GaussMarkov { time_s: 5.0, deviation: 0.3 }];

/// Findings in any of six channels, by the accumulators and searches alone.
pub(crate) fn measure(arguments: &Arguments) {
    arguments.minutes_or(&[10]).iter().for_each(|minutes| of_length(arguments, *minutes));
}

fn of_length(arguments: &Arguments, minutes: usize) {
    let records = arguments.records;
    println!("### Clean records of six channels, {minutes} min, {records} records\n");
    println!("| noise | disturbed % | 95 % limits | as, records |");
    println!("|---|---:|---:|---|");
    let cell = families::disturbed(60.0 * minutes as f64);
    let walking = families::walking();
    let flicker = Flicker::new(cell.samples());
    let plan = SpectrumPlan::new();
    let mut of_this_length = ChannelSignal::new(&plan);
    of_this_length.push(&vec![0; cell.samples()]);
    let search = LevelSearch::of([&of_this_length]);
    for (name, white) in WHITES {
        let all: [(&str, &[Part]); 4] =
            [("", &[]), (" and flicker", &cell.parts), (" and a walk", &walking.parts), (" and a process", &PROCESS)];
        for (with, parts) in all {
            let name = format!("{name}{with}");
            let found = in_parallel(arguments.threads, records, |number| {
                let mut random = Random::of_record(arguments.seed, &name, cell.samples(), number);
                let mut found = Vec::new();
                for _ in 0..SCORED {
                    let mut series = white.series(cell.samples(), &mut random);
                    for part in parts {
                        part.add_to(&mut series, cell.rate_hz, &flicker, 0.0, &mut random);
                    }
                    let counts: Vec<i32> = series.iter().map(|value| (value / cell.step).round() as i32).collect();
                    found.extend(names(&disturbed(&counts, cell.rate_hz, &plan, &search)));
                }
                found.sort_unstable();
                found.dedup();
                found
            });
            let disturbed = found.iter().filter(|found| !found.is_empty()).count();
            let (lower, upper) = limits(disturbed, records);
            println!(
                "| {name} | {:.2} | {:.2}-{:.2} | {} |",
                100.0 * disturbed as f64 / records as f64,
                100.0 * lower,
                100.0 * upper,
                kinds(found.iter().flatten())
            );
            let percent = format!("{:.2}", 100.0 * disturbed as f64 / records as f64);
            let limits = format!("{:.2} to {:.2}", 100.0 * lower, 100.0 * upper);
            figures::record(
                "clean",
                &format!("{name}, {minutes} min"),
                &[("disturbed %", percent), ("limits", limits)],
            );
        }
    }
}

fn disturbed(counts: &[i32], rate_hz: f64, plan: &SpectrumPlan, search: &LevelSearch) -> Stationarity {
    let mut signal = ChannelSignal::new(plan);
    let mut histogram = Histogram::new();
    signal.push(counts);
    histogram.push(counts);
    let interval_s = 1.0 / rate_hz;
    Stationarity {
        lines: signal.narrow_bands(1.0, interval_s).iter().filter_map(|band| band.line).collect(),
        disturbances: signal.disturbances(interval_s),
        noise: signal.noise_changes(&histogram, interval_s),
        level_change: search.find(&signal, interval_s, 0).change,
        ..Stationarity::default()
    }
}

/// Of what disturbs a channel, each once.
pub(crate) fn names(disturbed: &Stationarity) -> Vec<&'static str> {
    let level = disturbed.level_change.map(|change| match change.shape {
        LevelShape::WarmUp { .. } => "warm-up",
        LevelShape::Step { .. } => "step",
        LevelShape::Cycle { .. } => "cycle",
    });
    let named = |is_found: bool, name| is_found.then_some(name);
    let all = [
        named(!disturbed.lines.is_empty(), "line"),
        named(!disturbed.disturbances.is_empty(), "disturbance"),
        named(disturbed.noise.change.is_some(), "noise change"),
        named(disturbed.noise.bursts.is_some(), "bursts"),
        named(disturbed.noise.frozen.is_some(), "frozen"),
        named(disturbed.noise.spikes.is_some(), "spikes"),
        level,
    ];
    all.into_iter().flatten().collect()
}

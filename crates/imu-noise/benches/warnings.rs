//! How often clean records warn, and disturbed ones are found: seeded records of known noise at 40
//! Hz.
//!
//! `cargo bench -p imu-noise --bench warnings -- --records 70 --minutes 60`. Prints for each noise
//! and length how many clean records of twelve channels show a line, a disturbance, a change of
//! level, or any of them, and for each disturbance the share of records in which it is found where
//! it is; a warm-up must be gone after the skip that is to cure it.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "a program for the terminal")]

#[path = "../tests/synthetic/disturbed.rs"]
mod disturbed;
#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use disturbed::{Channel, Disturbance, Findings, NOISES, RATE_HZ};
use imu_noise::SpectrumPlan;
use synthetic::{Random, Synthesis};

const CHANNELS: usize = 12;

const DISTURBANCES: [Disturbance; 7] = [
    Disturbance::Slam,
    Disturbance::Push,
    Disturbance::Line,
    Disturbance::LateLine,
    Disturbance::WarmUp { sigmas: 12.0, time_constant_s: 300.0 },
    Disturbance::WarmUp { sigmas: 24.0, time_constant_s: 300.0 },
    Disturbance::WarmUp { sigmas: 48.0, time_constant_s: 300.0 },
];

/// Counts of one noise and length.
#[derive(Clone, Default)]
struct Tally {
    /// Clean records with lines, with disturbances, with changes of level, with any of them.
    warned: [usize; 4],
    found: [usize; DISTURBANCES.len()],
}

fn main() {
    let argument = |name: &str| {
        let mut arguments = std::env::args().skip_while(move |argument| argument != name);
        arguments.nth(1).map(|value| value.parse::<f64>().unwrap())
    };
    let records = argument("--records").unwrap_or(70.0) as usize;
    let lengths = argument("--minutes").map_or(vec![10.0, 60.0, 300.0], |minutes| vec![minutes]);
    println!("{records} records each: clean ones that warn, of lines, disturbances, changes of level; any");
    println!(
        "disturbed ones found, %: slam, push, line, late line, warm-up of 5 min by 12, 24, 48 sigma of block means"
    );
    let plan = SpectrumPlan::new();
    for minutes in lengths {
        let mut random = Random(2);
        let mut synthesis = Synthesis::new((minutes * 60.0 * RATE_HZ) as usize, 1);
        let mut tallies = vec![Tally::default(); NOISES.len()];
        for _ in 0..records {
            // Of lines, of disturbances, of changes of level, at all.
            let mut warned = vec![[false; 4]; NOISES.len()];
            for number in 0..CHANNELS {
                let record = synthesis.next_record();
                for ((noise, tally), warned) in NOISES.iter().zip(&mut tallies).zip(&mut warned) {
                    let channel = Channel::new(noise, number, &record, &mut random);
                    let found = Findings::of(&channel.clean(), &plan);
                    warned[0] |= !found.lines_hz.is_empty();
                    warned[1] |= !found.disturbances_s.is_empty();
                    warned[2] |= found.change.is_some();
                    warned[3] |= !found.is_clean();
                    if number == 1 {
                        for (disturbance, count) in DISTURBANCES.into_iter().zip(&mut tally.found) {
                            *count += usize::from(channel.shows(disturbance, &plan, &mut random));
                        }
                    }
                }
            }
            for (tally, warned) in tallies.iter_mut().zip(warned) {
                tally.warned.iter_mut().zip(warned).for_each(|(count, warned)| *count += usize::from(warned));
            }
        }
        println!("\n{minutes} min");
        for (noise, tally) in NOISES.iter().zip(&tallies) {
            print!("{:16}", noise.name);
            tally.warned.iter().for_each(|warned| print!("{warned:4}"));
            tally.found.iter().for_each(|found| print!("{:7.1}", 100.0 * *found as f64 / records as f64));
            println!();
        }
    }
}

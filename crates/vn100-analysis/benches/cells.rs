//! How often the intervals of N, B and K hold: records of known noise, read as a stream is.
//!
//! with `--seed 1` and `--threads 2`; `--disturbances` for what is found in disturbed records
//! instead and `--clean` for what is found in clean ones, `--plans` for how many records of the
//! planned length show what was wanted, `--temperature` for the temperature coefficient, `--random SEED` for cells that are drawn from
//! ranges, for at most `--minutes` minutes, `--channels` of each.
//! Families: model-class, lines, correlated, filters, tails, mixtures, gaps, quantised; all of
//! them, ten minutes and an hour, unless the arguments say otherwise.
//!
//! A record is a `Batch` of `$VNIMU` at 40 Hz through `Analysis`, `Snapshot` and `Assessment`; its
//! three accelerations and three angular rates have noise of one kind, each from random numbers of
//! its own, and all are scored. The generators share nothing with the emulated sensor or with
//! `imu-noise`. Noise is counted in standard deviations of its white part, a count is a hundredth
//! of that but in the quantised cells.
//!
//! The truth of N is the density of the white part: of all of it where it has tails or spikes,
//! rounding included, and at long averaging times where a window or a low pass is in the way. B and
//! K are not scored where a Gauss-Markov process has no place in the model.
//!
//! A table has one row per cell and parameter. *Held*: the interval or the bound at 95 % holds the
//! truth, of all channels, with Clopper-Pearson limits. *Missed*: nothing is said, for what reason
//! in the next columns. Bias, errors and half widths are those of estimated values, relative; *of
//! bound* is the error of N over 1/√(2n), the Cramér-Rao bound for white noise alone. *False*: the
//! share of records with the parameter estimated in any channel though it is absent; in the row of
//! N, with any of B, K and the ramp. A fixed seed gives the same tables with any number of
//! threads; with one of them the CPU time of an assessment stands below each.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "a program for the terminal")]

#[path = "../../../benches/figures.rs"]
mod figures;
mod cells {
    pub(super) mod clean;
    pub(super) mod disturbances;
    pub(super) mod drawn;
    pub(super) mod efficiency;
    pub(super) mod families;
    pub(super) mod generators;
    pub(super) mod plans;
    pub(super) mod printing;
    pub(super) mod random;
    pub(super) mod record;
    pub(super) mod scoring;
    pub(super) mod temperature;
}

use std::{
    process::ExitCode,
    sync::atomic::{AtomicUsize, Ordering},
};

use cells::{
    clean, disturbances, drawn, efficiency, families, generators::Flicker, plans, printing, random::Random,
    scoring::RecordScore, temperature,
};

/// Of the records in the table of families.
const RATE_HZ: f64 = 40.0;

struct Arguments {
    records: usize,
    /// None unless given.
    minutes: Vec<usize>,
    family: Option<String>,
    cell: Option<String>,
    seed: u64,
    threads: usize,
    /// The seed of cells that are drawn, and how many.
    random: Option<u64>,
    cells: usize,
    channels: usize,
    disturbances: bool,
    clean: bool,
    efficiency: bool,
    plans: bool,
    temperature: bool,
}

fn main() -> ExitCode {
    let Some(arguments) = Arguments::read(std::env::args().skip(1)) else {
        println!("--records N, --minutes M,M, --family NAME, --cell PART, --seed S, --threads T");
        println!("--disturbances, --clean, --efficiency, --plans, --temperature");
        println!("--random SEED, --cells N, --channels N, --minutes BUDGET");
        return ExitCode::from(2);
    };
    if let Some(seed) = arguments.random {
        drawn::measure(&arguments, seed);
        return ExitCode::SUCCESS;
    }
    if arguments.disturbances {
        disturbances::measure(&arguments);
        return ExitCode::SUCCESS;
    }
    if arguments.efficiency {
        efficiency::measure(&arguments);
        return ExitCode::SUCCESS;
    }
    if arguments.clean {
        clean::measure(&arguments);
        return ExitCode::SUCCESS;
    }
    if arguments.temperature {
        temperature::measure(&arguments);
        return ExitCode::SUCCESS;
    }
    if arguments.plans {
        plans::measure(&arguments);
        return ExitCode::SUCCESS;
    }
    let mut was_found = false;
    for minutes in arguments.minutes_or(&[10, 60]) {
        let samples = minutes * 60 * RATE_HZ as usize;
        let flicker = Flicker::new(samples);
        let mut families = families::all(*minutes as f64 * 60.0);
        for family in &mut families {
            let is_meant = |name: &str| arguments.cell.as_deref().is_none_or(|part| name.contains(part));
            family.cells.retain(|cell| is_meant(&cell.name));
        }
        families.retain(|family| !family.cells.is_empty());
        for family in
            families.iter().filter(|family| arguments.family.as_deref().is_none_or(|name| family.name == name))
        {
            was_found = true;
            let jobs = family.cells.len() * arguments.records;
            let scores = in_parallel(arguments.threads, jobs, |job| {
                let (cell, number) = (&family.cells[job / arguments.records], job % arguments.records);
                let mut random = Random::of_record(arguments.seed, &cell.name, samples, number);
                RecordScore::of(cell, &flicker, &mut random)
            });
            printing::family(family, *minutes, &arguments, &scores);
        }
    }
    if !was_found {
        println!("no such family or cell");
        return ExitCode::from(2);
    }
    ExitCode::SUCCESS
}

impl Arguments {
    /// How long the records are.
    fn minutes_or<'a>(&'a self, usual: &'a [usize]) -> &'a [usize] {
        if self.minutes.is_empty() { usual } else { &self.minutes }
    }

    /// `None` for arguments that are none of these.
    fn read(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let threads = std::thread::available_parallelism().map_or(1, Into::into);
        let mut read = Self {
            records: 50,
            minutes: Vec::new(),
            family: None,
            seed: 1,
            threads,
            random: None,
            cells: 200,
            channels: 300,
            disturbances: false,
            clean: false,
            cell: None,
            efficiency: false,
            plans: false,
            temperature: false,
        };
        while let Some(name) = arguments.next() {
            match name.as_str() {
                // cargo's own
                "--bench" => {}
                "--random" => read.random = Some(arguments.next()?.parse().ok()?),
                "--cells" => read.cells = arguments.next()?.parse().ok()?,
                "--channels" => read.channels = arguments.next()?.parse().ok()?,
                "--disturbances" => read.disturbances = true,
                "--clean" => read.clean = true,
                "--cell" => read.cell = Some(arguments.next()?),
                "--efficiency" => read.efficiency = true,
                "--plans" => read.plans = true,
                "--temperature" => read.temperature = true,
                "--family" => read.family = Some(arguments.next()?),
                "--records" => read.records = arguments.next()?.parse().ok()?,
                "--seed" => read.seed = arguments.next()?.parse().ok()?,
                "--threads" => read.threads = arguments.next()?.parse().ok()?,
                "--minutes" => {
                    let minutes = arguments.next()?;
                    read.minutes = minutes.split(',').map(|minutes| minutes.parse().ok()).collect::<Option<_>>()?;
                }
                _ => return None,
            }
        }
        Some(read)
    }
}

/// The results of `jobs` in their order, whichever thread did them.
fn in_parallel<T: Send>(threads: usize, jobs: usize, job: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= jobs {
                return done;
            }
            done.push((number, job(number)));
        }
    };
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

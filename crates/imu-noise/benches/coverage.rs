//! How often intervals and bounds hold: seeded records of known noise, every record scored.
//!
//! `cargo bench -p imu-noise --bench coverage -- --records 500 --minutes 60`, with `--plain`,
//! `--full` or `--hadamard` for other estimators, `--confidence 0.68` for another level than 0.95.
//! Prints per noise the share of records whose interval or bound holds the truth, with the share in
//! which the parameter is called estimated, and the share of octave intervals (degrees of freedom
//! above 10) that hold. The minimum is that of the curve, in brackets where it has a lower end. The
//! last column is N of the same records with the bias tracked out of them, as an attitude filter
//! does, and then the number of records that seem to fall below their own white noise. All noises
//! of a record share its random numbers.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "a program for the terminal")]

use std::time::{Duration, Instant};

#[path = "../../../benches/figures.rs"]
mod figures;
#[path = "../tests/synthetic/score.rs"]
mod score;
#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use imu_noise::{Deviation, Estimator};
use score::{CONFIDENCE, Cell, NOISES, Noise, RATE_HZ, ReadOut, counts, tracked};
use synthetic::Synthesis;

fn main() {
    let argument = |name: &str| {
        let mut arguments = std::env::args().skip_while(move |argument| argument != name);
        arguments.nth(1).map(|value| value.parse::<f64>().unwrap())
    };
    let records = argument("--records").unwrap_or(200.0) as usize;
    let minutes = argument("--minutes").map_or(vec![10.0, 60.0, 300.0], |minutes| vec![minutes]);
    let confidence = argument("--confidence").unwrap_or(CONFIDENCE);
    let has = |name: &str| std::env::args().any(|argument| argument == name);
    let estimator = match (has("--plain"), has("--full")) {
        (true, _) => Estimator::Plain,
        (_, true) => Estimator::Full,
        _ => Estimator::Strided,
    };
    let deviation = if has("--hadamard") { Deviation::Hadamard } else { Deviation::Allan };
    println!("share of {records} records that holds at {confidence} (share estimated), %");
    for minutes in minutes {
        let samples = (minutes * 60.0 * RATE_HZ) as usize;
        println!(
            "\n{minutes} min at {RATE_HZ} Hz      N          B          K          R      minimum   octaves  rejected  N, tracked  below"
        );
        let mut cells = vec![Cell::default(); NOISES.len()];
        let (mut in_model, mut in_fit) = (Duration::ZERO, Duration::ZERO);
        let mut synthesis = Synthesis::new(samples, 1);
        for _ in 0..records {
            let record = synthesis.next_record();
            for (cell, noise) in cells.iter_mut().zip(&NOISES) {
                let counts = counts(noise, &record);
                let read_out = ReadOut::new(&counts, estimator, deviation).at(confidence);
                let start = Instant::now();
                let model = read_out.model();
                in_model += start.elapsed();
                let start = Instant::now();
                let fit = read_out.fit(&model);
                in_fit += start.elapsed();
                cell.score(noise, &read_out, &fit);
                cell.score_tracked(&ReadOut::new(&tracked(&counts), estimator, deviation).at(confidence));
            }
        }
        for (cell, noise) in cells.iter().zip(&NOISES) {
            print!("{:24}", noise.name);
            for score in cell.terms.iter().chain([&cell.minimum]) {
                print!("{:5.1} ({:3.0})", score.held_percent(), score.estimated_percent());
            }
            let rejected = 100.0 * cell.rejected as f64 / records as f64;
            let tracked = cell.tracked_white;
            print!("{:9.1} {rejected:9.1}", cell.octaves.held_percent());
            print!("{:7.1} ({:3.0})", tracked.held_percent(), tracked.estimated_percent());
            println!("{:8}", cell.below_white);
        }
        record(&format!("{minutes} min at {confidence}"), &cells);
        let runs = (records * NOISES.len()) as u32;
        println!("{:?} for a model of all channels, {:?} for the fit of one", in_model / runs, in_fit / runs);
    }
}

/// The lowest and the highest coverage of all noises, and how often an absent parameter is called
/// estimated at most.
fn record(row: &str, cells: &[Cell]) {
    let range = |percents: &[f64]| {
        let (lowest, highest) = percents.iter().fold((100.0, 0.0), |(low, high), p| (p.min(low), p.max(high)));
        format!("{lowest:.1} to {highest:.1}")
    };
    let held = |of: fn(&Cell) -> f64| range(&cells.iter().map(of).collect::<Vec<_>>());
    let is_absent = |noise: &Noise| [false, noise.flicker == 0.0, noise.step == 0.0, noise.ramp == 0.0];
    let of_cell = |(cell, noise): (&Cell, &Noise)| {
        let absent = cell.terms.iter().zip(is_absent(noise)).filter(|(_, is_absent)| *is_absent);
        absent.map(|(score, _)| score.estimated_percent()).fold(0.0, f64::max)
    };
    let highest_false = cells.iter().zip(&NOISES).map(of_cell).fold(0.0, f64::max);
    figures::record(
        "fits",
        row,
        &[
            ("N", held(|cell| cell.terms[0].held_percent())),
            ("B", held(|cell| cell.terms[1].held_percent())),
            ("K", held(|cell| cell.terms[2].held_percent())),
            ("R", held(|cell| cell.terms[3].held_percent())),
            ("octaves", held(|cell| cell.octaves.held_percent())),
            ("false", format!("{highest_false:.0}")),
        ],
    );
}

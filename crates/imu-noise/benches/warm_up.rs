//! Whether a warm-up that spoils a noise model is seen: seeded records of known noise at 40 Hz,
//! each clean and with a level that relaxes.
//!
//! `cargo bench -p imu-noise --bench warm_up -- --records 200`. Prints for each noise, length, time
//! constant and amplitude, in standard deviations of the block means, the share of records in which
//! the fit is spoilt, that is, N, B or K lies outside its interval in the clean record; in which
//! the warm-up is found; and in which it spoils and is not found.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "a program for the terminal")]

#[path = "../tests/synthetic/disturbed.rs"]
#[allow(dead_code, reason = "other benchmarks use the rest")]
mod disturbed;
#[path = "../tests/synthetic/score.rs"]
#[allow(dead_code, reason = "other benchmarks use the rest")]
mod score;
#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use disturbed::{Channel, Findings, NOISES};
use imu_noise::{Deviation, Estimator, NoiseFit, NoiseModel, SpectrumPlan};
use score::{RATE_HZ, ReadOut, TERMS};
use synthetic::{Random, Synthesis};

/// Minutes of data, and time constants in seconds.
const LENGTHS: [(f64, [f64; 2]); 2] = [(10.0, [60.0, 300.0]), (60.0, [300.0, 1200.0])];

const SIGMAS: [f64; 6] = [3.0, 6.0, 9.0, 12.0, 18.0, 24.0];

/// Rounding is out of sight in this one.
const FINE_CHANNEL: usize = 3;

fn main() {
    let mut arguments = std::env::args().skip_while(|argument| argument != "--records");
    let records: usize = arguments.nth(1).map_or(200, |records| records.parse().unwrap());
    let plan = SpectrumPlan::new();
    println!(
        "{records} records each, %: spoilt, found, spoilt but not found; a warm-up from so many sigma of block means"
    );
    for (minutes, time_constants_s) in LENGTHS {
        let mut random = Random(8);
        let mut synthesis = Synthesis::new((minutes * 60.0 * RATE_HZ) as usize, 9);
        let mut counted = vec![[[[0_usize; 3]; SIGMAS.len()]; 2]; NOISES.len()];
        let mut model = None;
        for _ in 0..records {
            let record = synthesis.next_record();
            for (noise, counted) in NOISES.iter().zip(&mut counted) {
                let channel = Channel::new(noise, FINE_CHANNEL, &record, &mut random);
                let clean = fit(&channel.clean(), &mut model);
                for (time_constant_s, counted) in time_constants_s.into_iter().zip(counted) {
                    for (sigmas, counts) in SIGMAS.into_iter().zip(counted) {
                        let warmed = channel.warmed_up(sigmas, time_constant_s, &plan);
                        let is_spoilt = is_spoilt(&clean, &fit(&warmed, &mut model));
                        let is_found = Findings::of(&warmed, &plan).warm_up_skip_s().is_some();
                        for (count, holds) in counts.iter_mut().zip([is_spoilt, is_found, is_spoilt && !is_found]) {
                            *count += usize::from(holds);
                        }
                    }
                }
            }
        }
        for (noise, counted) in NOISES.iter().zip(&counted) {
            for (time_constant_s, counted) in time_constants_s.iter().zip(counted) {
                print!("{minutes:3} min {:16} {time_constant_s:5} s", noise.name);
                for (sigmas, counts) in SIGMAS.iter().zip(counted) {
                    let percent = counts.map(|count| 100.0 * count as f64 / records as f64);
                    print!("  {sigmas:2}: {:3.0} {:3.0} {:3.0}", percent[0], percent[1], percent[2]);
                }
                println!();
            }
        }
    }
}

/// All records of a length share their model.
fn fit(counts: &[i32], model: &mut Option<(usize, NoiseModel)>) -> NoiseFit {
    let read_out = ReadOut::new(counts, Estimator::Strided, Deviation::Allan);
    if model.as_ref().is_none_or(|(samples, _)| *samples != counts.len()) {
        *model = Some((counts.len(), read_out.model()));
    }
    read_out.fit(&model.as_ref().unwrap().1)
}

/// Whether N, B or K is not what the clean record says of it.
fn is_spoilt(clean: &NoiseFit, warmed: &NoiseFit) -> bool {
    TERMS[..3].iter().any(|term| {
        let [clean, warmed] = [clean, warmed].map(|fit| fit.parameter(*term).unwrap());
        match warmed.value {
            Some(value) => {
                clean.lower.is_some_and(|lower| value < lower) || clean.upper.is_some_and(|upper| value > upper)
            }
            // no longer seen
            None => warmed.upper.zip(clean.lower).is_some_and(|(upper, lower)| upper < lower) || warmed.upper.is_none(),
        }
    })
}

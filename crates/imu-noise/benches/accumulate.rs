//! CPU time of the accumulators per line of 12 channels, beside the streaming `allan` crate.
//!
//! Thread CPU clock; kernels take turns within each round, so that a slow spell hits all; medians
//! over the rounds.
#![allow(clippy::print_stdout, missing_docs)]

#[path = "../../../benches/figures.rs"]
mod figures;

use std::hint::black_box;

use allan::{Allan, DataType, Style};
use imu_noise::{ChannelSignal, Deviation, Estimator, Histogram, Moments, Octaves, SpectrumPlan, TemperatureBlocks};
use rustix::time::{ClockId, clock_gettime};

const CHANNELS: usize = 12;
/// Lines per push, as a reader of files hands them over.
const BATCH: usize = 256;
const ROUNDS: usize = 41;
/// The reference is an order of magnitude slower.
const REFERENCE_ROUNDS: usize = 5;

type Kernel = (&'static str, usize, fn(&[Vec<i32>]));

const KERNELS: [Kernel; 8] = [
    ("octaves, strided", ROUNDS, |columns| {
        each_channel(columns, || Octaves::new(Estimator::Strided, Deviation::Allan), Octaves::push);
    }),
    ("octaves, strided, Hadamard", ROUNDS, |columns| {
        each_channel(columns, || Octaves::new(Estimator::Strided, Deviation::Hadamard), Octaves::push);
    }),
    ("octaves, full", ROUNDS, |columns| {
        each_channel(columns, || Octaves::new(Estimator::Full, Deviation::Allan), Octaves::push);
    }),
    ("moments", ROUNDS, |columns| each_channel(columns, Moments::new, Moments::push)),
    ("histogram", ROUNDS, |columns| each_channel(columns, Histogram::new, Histogram::push)),
    ("channel signal: spectrum, blocks, watch", ROUNDS, |columns| {
        let plan = SpectrumPlan::new();
        each_channel(columns, || ChannelSignal::new(&plan), ChannelSignal::push);
    }),
    ("six axes beside their temperature", ROUNDS, |columns| {
        let mut blocks = TemperatureBlocks::new(6);
        for start in (0..columns[0].len()).step_by(BATCH) {
            let end = columns[0].len().min(start + BATCH);
            for axis in 0..6 {
                blocks.push_axis(axis, start as u64, &columns[6 + axis][start..end]);
            }
            blocks.push_temperature(start as u64, &columns[3][start..end]);
        }
        black_box(blocks);
    }),
    ("allan crate, streaming", REFERENCE_ROUNDS, |columns| {
        let longest = 1 << (columns[0].len() / 2).ilog2();
        let config = || Allan::builder().style(Style::Decade124).max_tau(longest).data_type(DataType::Frequency);
        each_channel(
            columns,
            || config().build_allan(),
            |allan, counts| {
                for &count in counts {
                    allan.record(count.into());
                }
            },
        );
    }),
];

fn main() {
    for (lines, finer) in [(98_000, 1), (720_000, 1), (98_000, 1024)] {
        let columns = columns(lines, finer);
        let mut ns_per_line = [const { Vec::new() }; KERNELS.len()];
        for round in 0..ROUNDS {
            for ((_, rounds, kernel), times) in KERNELS.iter().zip(&mut ns_per_line) {
                if round < *rounds {
                    let start_ns = thread_cpu_ns();
                    kernel(&columns);
                    times.push((thread_cpu_ns() - start_ns) / lines as f64);
                }
            }
        }
        let counts = if finer == 1 { "of sentences" } else { "1024 times finer, as those of packets" };
        println!("{lines} lines of {CHANNELS} channels, counts {counts}, median ns of CPU per line");
        let medians: Vec<_> = ns_per_line.iter_mut().map(|times| median(times)).collect();
        let reference = medians[KERNELS.len() - 1];
        for ((name, ..), ns) in KERNELS.iter().zip(medians) {
            println!("{ns:8.1}  {:6.3} of the reference  {name}", ns / reference);
            let row = if finer == 1 { format!("{name}, {lines} lines") } else { format!("{name}, finer counts") };
            figures::record("sums", &row, &[("ns per line", format!("{ns:.1}"))]);
            if *name == "octaves, strided" && finer == 1 {
                let values = [
                    ("vn100", format!("{ns:.1} ns")),
                    ("the other", format!("{reference:.1} ns")),
                    ("ratio", format!("{:.1}", reference / ns)),
                ];
                figures::record("peers", &format!("octaves of {lines} lines, the crate `allan`"), &values);
            }
        }
    }
}

fn each_channel<A>(columns: &[Vec<i32>], new: impl Fn() -> A, push: impl Fn(&mut A, &[i32])) {
    let mut accumulators: Vec<_> = columns.iter().map(|_| new()).collect();
    for start in (0..columns[0].len()).step_by(BATCH) {
        for (accumulator, column) in accumulators.iter_mut().zip(columns) {
            push(accumulator, &column[start..column.len().min(start + BATCH)]);
        }
    }
    black_box(accumulators);
}

/// A resting sensor: angles, magnetic field, acceleration, angular rate, three of each.
fn columns(lines: usize, finer: i32) -> Vec<Vec<i32>> {
    // mean, standard deviation of white noise and of a random walk's step, in counts
    const NOISE: [(f64, f64, f64); 4] =
        [(45_000.0, 3.0, 2.0), (2531.0, 6.0, 0.02), (-9800.0, 12.0, 0.01), (1200.0, 300.0, 2.0)];
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let columns = (0..CHANNELS).map(|channel| {
        let (mean, white, step) = NOISE[channel / 3];
        let mut walk = mean;
        let counts = (0..lines).map(|_| {
            walk += step * normal(&mut state);
            ((walk + white * normal(&mut state)) * f64::from(finer)).round() as i32
        });
        counts.collect()
    });
    columns.collect()
}

/// Nearly normal, standard deviation 1: the sum of 12 uniform numbers.
fn normal(state: &mut u64) -> f64 {
    let uniform = |state: &mut u64| {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(|_| uniform(state)).sum::<f64>() - 6.0
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn thread_cpu_ns() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

//! Errors of N, B and K beside those of maximum likelihood from every sample.
//!
//! The likelihood is Whittle's (1953), of the coefficients of the cosine transform of the record,
//! which is exact for white noise and a random walk whose level is free: k = 1, 2, ..., n - 1 have
//! the variances N²/τ₀ + B²/s + K²τ₀/s², s = 2 sin(πk/2n). A ramp is fitted with them, and the
//! Gauss-Markov processes of the fit join them where the likelihood rises enough.

use std::{f64::consts::PI, sync::Arc};

use imu_noise::{Parameter, Status, Term};
use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use super::{
    families::{self, Cell},
    generators::Flicker,
    random::Random,
    record::{self, Record},
};
use crate::{Arguments, RATE_HZ, figures, in_parallel};

const TERMS: [Term; 3] = [Term::White, Term::BiasInstability, Term::RateRandomWalk];

/// χ² with one degree of freedom, at zero half of the time, exceeds it in 2.5 % of records without
/// the term: as often as the fit takes one for found.
const FOUND: f64 = 3.84;

/// The same for the fit, before other channels count.
const FOUND_P: f64 = 0.025;

/// False rates at which the two methods are compared, in any cell without the term.
const FALSE_RATES: [f64; 3] = [0.005, 0.01, 0.025];

/// Twice what the log-likelihood must rise by for Gauss-Markov processes to join the terms, and
/// their correlation times in samples, each four times the one before: those of the fit.
const PROCESS: f64 = 8.0;
const SHORTEST_CORRELATION: f64 = 16.0;
const LONGEST_CORRELATION: f64 = 1.0 / 16.0;

pub(crate) fn measure(arguments: &Arguments) {
    for minutes in arguments.minutes_or(&[10, 60]) {
        let samples = minutes * 60 * RATE_HZ as usize;
        let likelihood = Likelihood::new(samples);
        let flicker = Flicker::new(samples);
        println!("### Efficiency, {minutes} min, {} records of 6 channels\n", arguments.records);
        println!("| cell | | rms error % | of likelihood | of its true terms | found % | by likelihood |");
        println!("|---|---|---:|---:|---:|---:|---:|");
        let cells =
            families::all(*minutes as f64 * 60.0).into_iter().next().map_or_else(Vec::new, |family| family.cells);
        let mut by_cell = Vec::new();
        for cell in cells.iter().filter(|cell| cell.truth().white > 0.0) {
            let compared = in_parallel(arguments.threads, arguments.records, |number| {
                let mut random = Random::of_record(arguments.seed, &cell.name, samples, number);
                likelihood.compare(cell, &flicker, &mut random)
            });
            let channels: Vec<_> = compared.into_iter().flatten().collect();
            rows(cell, &channels);
            by_cell.push((cell, channels));
        }
        println!();
        at_the_same_false_rate(&by_cell);
    }
}

/// How often each method finds a term where its threshold is such that no cell without the term
/// exceeds the false rate.
fn at_the_same_false_rate(by_cell: &[(&Cell, Vec<[Compared; 3]>)]) {
    print!("| cell | |");
    FALSE_RATES.iter().for_each(|rate| print!(" {} % false: fit | likelihood |", 100.0 * rate));
    println!("\n|---|---|{}", "---:|---:|".repeat(FALSE_RATES.len()));
    for (term, name) in [(1, "B"), (2, "K")] {
        let has_term = |cell: &Cell| [0.0, cell.truth().bias_instability, cell.truth().walk][term] > 0.0;
        for (cell, channels) in by_cell.iter().filter(|(cell, _)| has_term(cell)) {
            print!("| {} | {name} |", cell.name);
            for rate in FALSE_RATES {
                for method in [|it: &Compared| it.evidence, |it: &Compared| it.likelihood_ratio] {
                    let sorted = |channels: &[[Compared; 3]]| {
                        let mut evidence: Vec<f64> = channels.iter().map(|terms| method(&terms[term])).collect();
                        evidence.sort_by(|a, b| b.total_cmp(a));
                        evidence
                    };
                    let without = by_cell.iter().filter(|(cell, _)| !has_term(cell));
                    let threshold = without
                        .map(|(_, channels)| sorted(channels)[(rate * channels.len() as f64) as usize])
                        .fold(0.0, f64::max);
                    let found = sorted(channels).partition_point(|evidence| *evidence > threshold);
                    print!(" {:.1} |", 100.0 * found as f64 / channels.len() as f64);
                }
            }
            println!();
        }
    }
    println!();
}

/// One term in one channel, in standard deviations of the white part and seconds.
struct Compared {
    fitted: Option<f64>,
    free: f64,
    true_terms: f64,
    /// -ln p of the fit.
    evidence: f64,
    /// Twice its logarithm.
    likelihood_ratio: f64,
}

fn rows(cell: &Cell, channels: &[[Compared; 3]]) {
    let truth = cell.truth();
    let truths = [truth.white, truth.bias_instability, truth.walk];
    for (term, truth) in truths.into_iter().enumerate() {
        let of = || channels.iter().map(move |terms| &terms[term]);
        let percent = |found: usize| format!("{:.1}", 100.0 * found as f64 / channels.len() as f64);
        let found = percent(of().filter(|compared| compared.evidence > -FOUND_P.ln()).count());
        let by_likelihood = percent(of().filter(|compared| compared.likelihood_ratio > FOUND).count());
        // all on the channels where the fit has a value
        let rms = |value: fn(&Compared) -> f64| {
            let errors: Vec<f64> =
                of().filter(|compared| compared.fitted.is_some()).map(|it| (value(it) / truth - 1.0).powi(2)).collect();
            (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
        };
        let errors = if truth > 0.0 {
            let fitted = rms(|compared| compared.fitted.unwrap_or_default());
            let (free, true_terms) = (rms(|compared| compared.free), rms(|compared| compared.true_terms));
            format!("{:.2} | {:.3} | {:.3}", 100.0 * fitted, fitted / free, fitted / true_terms)
        } else {
            " | | ".into()
        };
        let letter = ["N", "B", "K"][term];
        let mut values = vec![("found %", found.clone()), ("by likelihood %", by_likelihood.clone())];
        if truth > 0.0 {
            let names = ["rms error %", "of likelihood", "of its true terms"];
            values.extend(names.into_iter().zip(errors.split(" | ").map(str::to_owned)));
        }
        figures::record("efficiency", &format!("{}, {letter}", cell.name), &values);
        let name = if term == 0 { &*cell.name } else { "" };
        println!("| {name} | {} | {errors} | {found} | {by_likelihood} |", letter);
    }
}

struct Likelihood {
    samples: usize,
    transform: Arc<dyn RealToComplex<f64>>,
    /// Numbers of coefficients: of one each at first, later of a hundredth and a half of them.
    bins: Vec<std::ops::Range<usize>>,
    /// By bin: mean of what each term with parameter 1 adds, the processes behind N, B and K.
    columns: Vec<Vec<f64>>,
    /// By coefficient: a ramp from -1/2 to 1/2.
    ramp: Vec<f64>,
}

struct Fitted {
    /// Squared: variances per sample.
    parameters: Vec<f64>,
    /// By bin.
    expected: Vec<f64>,
    /// By bin, less the shapes.
    powers: Vec<f64>,
    log_likelihood: f64,
}

/// Of a record and of what may be in it beside noise.
struct Coefficients {
    each: Vec<f64>,
    /// A ramp, and the cosine and the sine of a cycle that the fit to the octaves has too.
    shapes: Vec<Vec<f64>>,
}

/// Which of the terms are free.
#[derive(Clone, Copy)]
struct Free {
    terms: [bool; 3],
    processes: bool,
}

impl Free {
    fn is_free(self, column: usize) -> bool {
        self.terms.get(column).copied().unwrap_or(self.processes)
    }
}

impl Likelihood {
    fn new(samples: usize) -> Self {
        const SINGLE: usize = 120;
        const WIDTH: f64 = 0.015;
        let mut bins = Vec::new();
        let mut first = 1;
        while first < samples {
            let width = if first <= SINGLE { 1 } else { (WIDTH * first as f64) as usize };
            bins.push(first..(first + width.max(1)).min(samples));
            first += width.max(1);
        }
        let mean = |at: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let at = |k: usize| at(2.0 * (PI * k as f64 / (2 * samples) as f64).sin());
            bins.iter().map(|bin| bin.clone().map(at).sum::<f64>() / bin.len() as f64).collect()
        };
        // first-order: (1 - φ²)/(1 - 2φ cos ω + φ²), where 2 - 2 cos ω = s²
        let process = |time: f64| {
            let phi = (-1.0 / time).exp();
            mean(&|s| (1.0 - phi * phi) / ((1.0 - phi).powi(2) + phi * s * s))
        };
        let times = std::iter::successors(Some(SHORTEST_CORRELATION), |time| Some(4.0 * time));
        let times = times.take_while(|time| *time <= LONGEST_CORRELATION * samples as f64);
        let terms = [0, 1, 2].map(|power| mean(&|s| s.powi(-power)));
        let columns = terms.into_iter().chain(times.map(process)).collect();
        let transform = RealFftPlanner::new().plan_fft_forward(2 * samples);
        let mut made = Self { samples, transform, bins, columns, ramp: Vec::new() };
        made.ramp = made.coefficients(&(0..samples).map(|i| i as f64 / samples as f64 - 0.5).collect::<Vec<_>>());
        made
    }

    /// Of the orthonormal cosine transform, the type of even symmetry about half samples.
    fn coefficients(&self, series: &[f64]) -> Vec<f64> {
        let mut mirrored: Vec<f64> = series.iter().chain(series.iter().rev()).copied().collect();
        let mut transformed = self.transform.make_output_vec();
        self.transform.process(&mut mirrored, &mut transformed).unwrap();
        let scale = (2.0 / self.samples as f64).sqrt() / 2.0;
        let turned = |(k, value): (usize, &Complex<f64>)| {
            scale * (value * Complex::from_polar(1.0, -PI * k as f64 / (2 * self.samples) as f64)).re
        };
        transformed.iter().take(self.samples).enumerate().map(turned).collect()
    }

    /// With the terms of `free` and multiples of `shapes`, by Fisher's scoring, each step shortened
    /// until the likelihood rises; the best of those from each of `starts` on and from the powers
    /// themselves.
    fn fit(&self, record: &Coefficients, free: Free, starts: &[&Fitted]) -> Fitted {
        let powers = self.powers(&record.each, |_| 0.0);
        let smallest = 1e-3 * powers.iter().sum::<f64>() / powers.len() as f64;
        let own: Vec<f64> = powers.iter().map(|power| power.max(smallest)).collect();
        let first = self.at(record, self.least_squares(&powers, &self.weights(&own), free));
        let starts = starts.iter().map(|start| self.at(record, start.parameters.clone()));
        let fits = starts.chain([first]).map(|start| self.scored(record, free, start));
        let finite = fits.filter(|fit| fit.log_likelihood.is_finite());
        finite.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood)).unwrap()
    }

    fn scored(&self, record: &Coefficients, free: Free, start: Fitted) -> Fitted {
        const ROUNDS: usize = 60;
        const HALVINGS: i32 = 12;
        const TOLERANCE: f64 = 1e-6;
        let mut best = start;
        for _ in 0..ROUNDS {
            let aim = self.least_squares(&best.powers, &self.weights(&best.expected), free);
            let step = |halvings: i32| {
                let towards = |(now, aim): (&f64, &f64)| now + 0.5_f64.powi(halvings) * (aim - now);
                self.at(record, best.parameters.iter().zip(&aim).map(towards).collect())
            };
            let better = (0..HALVINGS).map(step).find(|next| next.log_likelihood > best.log_likelihood);
            let Some(next) = better else { break };
            let rise = next.log_likelihood - best.log_likelihood;
            best = next;
            if rise < TOLERANCE {
                break;
            }
        }
        best
    }

    /// At these parameters, the shapes at their likeliest multiples.
    fn at(&self, record: &Coefficients, parameters: Vec<f64>) -> Fitted {
        let expected = |i: usize| parameters.iter().zip(&self.columns).map(|(square, column)| square * column[i]).sum();
        let expected: Vec<f64> = (0..self.bins.len()).map(expected).collect();
        let multiples = self.multiples(record, &expected);
        let shape = |k: usize| record.shapes.iter().zip(&multiples).map(|(shape, multiple)| multiple * shape[k]).sum();
        let powers = self.powers(&record.each, shape);
        let of = |((bin, power), expected): ((&std::ops::Range<usize>, &f64), &f64)| {
            -0.5 * bin.len() as f64 * (expected.ln() + power / expected)
        };
        let log_likelihood = self.bins.iter().zip(&powers).zip(&expected).map(of).sum();
        Fitted { parameters, expected, powers, log_likelihood }
    }

    fn weights(&self, expected: &[f64]) -> Vec<f64> {
        self.bins.iter().zip(expected).map(|(bin, expected)| bin.len() as f64 / (expected * expected)).collect()
    }

    /// Of the shapes, by least squares in the coefficients that are alone in their bin: by the
    /// normal equations and the elimination of Gauss.
    fn multiples(&self, record: &Coefficients, expected: &[f64]) -> Vec<f64> {
        let alone: Vec<(usize, f64)> = (self.bins.iter().zip(expected))
            .take_while(|(bin, _)| bin.len() == 1)
            .map(|(bin, expected)| (bin.start, *expected))
            .collect();
        let product = |a: &[f64], b: &[f64]| alone.iter().map(|(k, expected)| a[*k] * b[*k] / expected).sum::<f64>();
        let count = record.shapes.len();
        let row = |shape: &Vec<f64>| -> Vec<f64> {
            record.shapes.iter().chain([&record.each]).map(|other| product(shape, other)).collect()
        };
        let mut rows: Vec<Vec<f64>> = record.shapes.iter().map(row).collect();
        for pivot in 0..count {
            let of_pivot = rows[pivot].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(place, _)| *place != pivot) {
                let factor = row[pivot] / of_pivot[pivot];
                row.iter_mut().zip(&of_pivot).for_each(|(value, other)| *value -= factor * other);
            }
        }
        rows.iter().enumerate().map(|(place, row)| row[count] / row[place]).collect()
    }

    fn powers(&self, coefficients: &[f64], shape: impl Fn(usize) -> f64) -> Vec<f64> {
        let power = |(bin, k): (&std::ops::Range<usize>, usize)| {
            let shape = if bin.len() == 1 { shape(k) } else { 0.0 };
            (coefficients[k] - shape).powi(2)
        };
        let of = |bin: &std::ops::Range<usize>| bin.clone().map(|k| power((bin, k))).sum::<f64>() / bin.len() as f64;
        self.bins.iter().map(of).collect()
    }

    /// Not negative, one coordinate after the other.
    fn least_squares(&self, powers: &[f64], weights: &[f64], free: Free) -> Vec<f64> {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(weights).map(|((a, b), w)| a * b * w).sum::<f64>();
        let columns: Vec<usize> = (0..self.columns.len()).filter(|column| free.is_free(*column)).collect();
        let of = |p: &usize| columns.iter().map(|q| product(&self.columns[*p], &self.columns[*q])).collect();
        let matrix: Vec<Vec<f64>> = columns.iter().map(of).collect();
        let target: Vec<f64> = columns.iter().map(|p| product(&self.columns[*p], powers)).collect();
        let mut found = vec![0.0_f64; columns.len()];
        for _ in 0..500 {
            let before = found.clone();
            for p in 0..found.len() {
                let others: f64 = (0..found.len()).filter(|q| *q != p).map(|q| matrix[p][q] * found[q]).sum();
                found[p] = ((target[p] - others) / matrix[p][p]).max(0.0);
            }
            if found.iter().zip(before).all(|(now, before)| (now - before).abs() <= 1e-9 * now) {
                break;
            }
        }
        let mut parameters = vec![0.0; self.columns.len()];
        columns.into_iter().zip(found).for_each(|(column, value)| parameters[column] = value);
        parameters
    }

    fn compare(&self, cell: &Cell, flicker: &Flicker, random: &mut Random) -> Vec<[Compared; 3]> {
        let record = Record::of(cell, flicker, random);
        let assessed = record.assess(cell, random);
        let truth = cell.truth();
        let has = [true, truth.bias_instability > 0.0, truth.walk > 0.0];
        let unit = cell.step * record::counts_per_unit();
        let interval_s = 1.0 / cell.rate_hz;
        let scales = [interval_s.sqrt(), 1.0, interval_s.sqrt().recip()];
        let channels = record::scored().zip(&record.series).map(|((place, _), series)| {
            let record = Coefficients { each: self.coefficients(series), shapes: vec![self.ramp.clone()] };
            let true_terms = self.fit(&record, Free { terms: has, processes: false }, &[]);
            let channel = &assessed.assessment.channels[place];
            let fit_with = |terms, processes, starts: &[&Fitted]| self.fit(&record, Free { terms, processes }, starts);
            let without_processes = fit_with([true; 3], false, &[]);
            let with_processes = fit_with([true; 3], true, &[&without_processes]);
            let processes = 2.0 * (with_processes.log_likelihood - without_processes.log_likelihood) > PROCESS;
            let without: [Fitted; 3] =
                std::array::from_fn(|term| fit_with(std::array::from_fn(|other| other != term), processes, &[]));
            let first = if processes { with_processes } else { without_processes };
            let [white, flicker, walk] = &without;
            let free = fit_with([true; 3], processes, &[&first, white, flicker, walk]);
            let fit = channel.noise.as_ref().map(|noise| &noise.fit);
            std::array::from_fn(|term| {
                let parameter = fit.and_then(|fit| fit.parameter(TERMS[term]));
                let value = |of: Parameter| of.value.filter(|_| of.status == Status::Estimated);
                Compared {
                    fitted: parameter.and_then(value).map(|value| value * unit),
                    free: free.parameters[term].sqrt() * scales[term],
                    true_terms: true_terms.parameters[term].sqrt() * scales[term],
                    evidence: parameter.and_then(|parameter| parameter.p).map_or(0.0, |p| -p.ln()),
                    likelihood_ratio: 2.0 * (free.log_likelihood - without[term].log_likelihood),
                }
            })
        });
        channels.collect()
    }
}

//! Errors of N, B and K beside those of maximum likelihood from every sample.
//!
//! The likelihood is Whittle's (1953), of the coefficients of the cosine transform of the record,
//! which is exact for white noise and a random walk whose level is free: k = 1, 2, ..., n - 1 have
//! the variances N²/τ₀ + B²/s + K²τ₀/s², s = 2 sin(πk/2n). A ramp is fitted with them.

use std::{f64::consts::PI, sync::Arc};

use imu_noise::{Parameter, Status, Term};
use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use super::{
    families::{self, Cell},
    generators::Flicker,
    random::Random,
    record::{self, Record},
};
use crate::{Arguments, RATE_HZ, in_parallel};

const TERMS: [Term; 3] = [Term::White, Term::BiasInstability, Term::RateRandomWalk];

/// χ² with one degree of freedom, at zero half of the time, exceeds it in 2.5 % of records without
/// the term: as often as the octaves take one for found.
const FOUND: f64 = 3.84;

/// The same for the octaves, before other channels count.
const FOUND_P: f64 = 0.025;

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
        for cell in cells.iter().filter(|cell| cell.truth().white > 0.0) {
            let compared = in_parallel(arguments.threads, arguments.records, |number| {
                let mut random = Random::of_record(arguments.seed, &cell.name, samples, number);
                likelihood.compare(cell, &flicker, &mut random)
            });
            rows(cell, &compared.into_iter().flatten().collect::<Vec<_>>());
        }
        println!();
    }
}

/// One term in one channel, in standard deviations of the white part and seconds.
struct Compared {
    octaves: Option<f64>,
    free: f64,
    true_terms: f64,
    is_found: bool,
    is_found_by_likelihood: bool,
}

fn rows(cell: &Cell, channels: &[[Compared; 3]]) {
    let truth = cell.truth();
    let truths = [truth.white, truth.bias_instability, truth.walk];
    for (term, truth) in truths.into_iter().enumerate() {
        let of = || channels.iter().map(move |terms| &terms[term]);
        let percent = |found: usize| format!("{:.1}", 100.0 * found as f64 / channels.len() as f64);
        let found = percent(of().filter(|compared| compared.is_found).count());
        let by_likelihood = percent(of().filter(|compared| compared.is_found_by_likelihood).count());
        // all on the channels where the octaves have a value
        let rms = |value: fn(&Compared) -> f64| {
            let errors: Vec<f64> = of()
                .filter(|compared| compared.octaves.is_some())
                .map(|it| (value(it) / truth - 1.0).powi(2))
                .collect();
            (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
        };
        let errors = if truth > 0.0 {
            let octaves = rms(|compared| compared.octaves.unwrap_or_default());
            let (free, true_terms) = (rms(|compared| compared.free), rms(|compared| compared.true_terms));
            format!("{:.2} | {:.3} | {:.3}", 100.0 * octaves, octaves / free, octaves / true_terms)
        } else {
            " | | ".into()
        };
        let name = if term == 0 { &*cell.name } else { "" };
        println!("| {name} | {} | {errors} | {found} | {by_likelihood} |", ["N", "B", "K"][term]);
    }
}

struct Likelihood {
    samples: usize,
    transform: Arc<dyn RealToComplex<f64>>,
    /// Numbers of coefficients: of one each at first, later of a hundredth and a half of them.
    bins: Vec<std::ops::Range<usize>>,
    /// By bin: mean of what each term with parameter 1 adds.
    columns: [Vec<f64>; 3],
    /// By coefficient: a ramp from -1/2 to 1/2.
    ramp: Vec<f64>,
}

struct Fitted {
    /// Squared: variances per sample.
    parameters: [f64; 3],
    log_likelihood: f64,
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
        let column = |term: i32| -> Vec<f64> {
            let at = |k: usize| (2.0 * (PI * k as f64 / (2 * samples) as f64).sin()).powi(-term);
            bins.iter().map(|bin| bin.clone().map(at).sum::<f64>() / bin.len() as f64).collect()
        };
        let columns = [column(0), column(1), column(2)];
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

    /// With the terms of `free` and a ramp, by Fisher's scoring.
    fn fit(&self, coefficients: &[f64], free: [bool; 3]) -> Fitted {
        const ROUNDS: usize = 60;
        let mut slope = 0.0;
        let mut parameters = [0.0; 3];
        let mut powers = self.powers(coefficients, slope);
        let mut expected: Vec<f64> = powers.clone();
        let smallest = 1e-3 * powers.iter().sum::<f64>() / powers.len() as f64;
        expected.iter_mut().for_each(|expected| *expected = expected.max(smallest));
        for _ in 0..ROUNDS {
            let weights: Vec<f64> = self
                .bins
                .iter()
                .zip(&expected)
                .map(|(bin, expected)| bin.len() as f64 / (expected * expected))
                .collect();
            parameters = self.least_squares(&powers, &weights, free);
            for (i, expected) in expected.iter_mut().enumerate() {
                *expected = (0..3).map(|term| parameters[term] * self.columns[term][i]).sum();
            }
            let bins = || self.bins.iter().zip(&expected).filter(|(bin, _)| bin.len() == 1);
            let product = bins().map(|(bin, e)| coefficients[bin.start] * self.ramp[bin.start] / e).sum::<f64>();
            slope = product / bins().map(|(bin, e)| self.ramp[bin.start].powi(2) / e).sum::<f64>();
            powers = self.powers(coefficients, slope);
        }
        let of = |((bin, power), expected): ((&std::ops::Range<usize>, &f64), &f64)| {
            -0.5 * bin.len() as f64 * (expected.ln() + power / expected)
        };
        let log_likelihood = self.bins.iter().zip(&powers).zip(&expected).map(of).sum();
        Fitted { parameters, log_likelihood }
    }

    fn powers(&self, coefficients: &[f64], slope: f64) -> Vec<f64> {
        let power = |k: usize| (coefficients[k] - slope * self.ramp[k]).powi(2);
        self.bins.iter().map(|bin| bin.clone().map(power).sum::<f64>() / bin.len() as f64).collect()
    }

    /// Not negative, one coordinate after the other.
    fn least_squares(&self, powers: &[f64], weights: &[f64], free: [bool; 3]) -> [f64; 3] {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(weights).map(|((a, b), w)| a * b * w).sum::<f64>();
        let matrix: [[f64; 3]; 3] =
            std::array::from_fn(|p| std::array::from_fn(|q| product(&self.columns[p], &self.columns[q])));
        let target: [f64; 3] = std::array::from_fn(|p| product(&self.columns[p], powers));
        let mut parameters = [0.0_f64; 3];
        for _ in 0..500 {
            let before = parameters;
            for p in (0..3).filter(|p| free[*p]) {
                let others: f64 = (0..3).filter(|q| *q != p).map(|q| matrix[p][q] * parameters[q]).sum();
                parameters[p] = ((target[p] - others) / matrix[p][p]).max(0.0);
            }
            if parameters.iter().zip(before).all(|(now, before)| (now - before).abs() <= 1e-9 * now) {
                break;
            }
        }
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
            let coefficients = self.coefficients(series);
            let free = self.fit(&coefficients, [true; 3]);
            let true_terms = self.fit(&coefficients, has);
            let fit = assessed.assessment.channels[place].noise.as_ref().map(|noise| &noise.fit);
            std::array::from_fn(|term| {
                let parameter = fit.and_then(|fit| fit.parameter(TERMS[term]));
                let without = self.fit(&coefficients, std::array::from_fn(|other| other != term));
                let value = |of: Parameter| of.value.filter(|_| of.status == Status::Estimated);
                Compared {
                    octaves: parameter.and_then(value).map(|value| value * unit),
                    free: free.parameters[term].sqrt() * scales[term],
                    true_terms: true_terms.parameters[term].sqrt() * scales[term],
                    is_found: parameter.and_then(|parameter| parameter.p).is_some_and(|p| p < FOUND_P),
                    is_found_by_likelihood: 2.0 * (free.log_likelihood - without.log_likelihood) > FOUND,
                }
            })
        });
        channels.collect()
    }
}

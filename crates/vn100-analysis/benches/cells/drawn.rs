//! Cells drawn at random from ranges: a family or a mixture of two, amplitudes, length and rate, each
//! seed another sheet.
//!
//! What is true of each family, and what is scored (densities are those of a sample, in variances of
//! the white part; the corner of a slow process is 1/(2π times its correlation time)):
//!
//! | family | N² | B | K | R |
//! |---|---|---|---|---|
//! | white, modulated, tails, gaps | the mean variance, spikes included | absent | absent | absent |
//! | rounding | with step²/12 of steps up to one deviation; of longer ones with or without | absent | absent | absent |
//! | low pass, mean window | the density at zero | absent | absent | absent |
//! | flicker | the white part | true | absent | absent |
//! | walk | the white part | absent | true | absent |
//! | ramp | the white part | absent | absent | true |
//! | line, warm-up, cycle (with its temperature) | the white part | absent | absent | absent |
//! | Gauss-Markov, one or two; popcorn | the white part, up to the mean density from five corners on; of fewer than 20 samples either that or the density at zero | not scored | absent; not scored if the time is a tenth of the record | absent |
//! | resonance | the white part, up to its skirt at zero | not scored | absent | absent |
//!
//! Of a mixture each part adds what it has; what one part leaves open stays open. *Held* for a bound
//! says that the truth is not above it. The bound of the error is that of Cramér and Rao for the
//! spectrum with all its parts known but for their powers.

use std::{f64::consts::TAU, time::Instant};

use imu_noise::{Parameter, Status, Term};
use statrs::distribution::{Beta, ContinuousCDF};

use super::{
    families::Cell,
    generators::{Drift, Flicker, Loss, LowPass, Part, White, resonance},
    random::Random,
    record::{self, Record},
};
use crate::{Arguments, figures, in_parallel};

/// Of a cell that may be wrong so many times the channels are measured, unless these are few.
const AGAIN: usize = 10;
const FEWEST_TO_DOUBT: usize = 300;

const MOST_SAMPLES: f64 = 2e6;
const LEAST_SAMPLES: f64 = 100.0;

/// Processes with a correlation time of fewer samples may stand for white noise.
const SHORT: f64 = 20.0;

const FAMILIES: [&str; 18] = [
    "white",
    "flicker",
    "walk",
    "ramp",
    "low pass",
    "mean window",
    "Gauss-Markov",
    "two Gauss-Markov",
    "line",
    "resonance",
    "popcorn",
    "warm-up",
    "cycle",
    "modulated",
    "gaps",
    "rounding",
    "tails",
    "flicker and walk",
];

/// A cell, with what is true of it.
struct Drawn {
    cell: Cell,
    /// The family, or both of a mixture.
    families: Vec<&'static str>,
    /// Densities of a sample beyond that of the white part; the white part comes first.
    parts: Vec<Spectrum>,
    /// What N² may be, in order: whatever lies between counts as true, or only its ends.
    white: (f64, f64),
    only_ends: bool,
    /// B and K in the unit of the cell; `None` if they are not scored.
    bias_instability: Option<f64>,
    walk: Option<f64>,
}

/// The density of a part, by the frequency over the rate.
#[derive(Clone, Copy)]
enum Spectrum {
    White(f64),
    Flicker(f64),
    Walk(f64),
    GaussMarkov { phi: f64, variance: f64 },
    Resonance { coefficients: [f64; 3], variance: f64 },
}

impl Spectrum {
    fn density(self, frequency: f64) -> f64 {
        let s_squared = 4.0 * (TAU * frequency / 2.0).sin().powi(2);
        match self {
            Self::White(variance) => variance,
            Self::Flicker(b) => b * b / s_squared.sqrt(),
            Self::Walk(step) => step * step / s_squared,
            Self::GaussMarkov { phi, variance } => {
                variance * (1.0 - phi * phi) / ((1.0 - phi).powi(2) + phi * s_squared)
            }
            Self::Resonance { coefficients: [first, second, kick], variance } => {
                let (one, two) = (TAU * frequency, 2.0 * TAU * frequency);
                let real = 1.0 - first * one.cos() - second * two.cos();
                let imaginary = first * one.sin() + second * two.sin();
                variance * kick * kick / (real * real + imaginary * imaginary)
            }
        }
    }
}

pub(crate) fn measure(arguments: &Arguments, seed: u64) {
    let begin = Instant::now();
    let budget_s = arguments.minutes.first().map_or(f64::INFINITY, |minutes| 60.0 * *minutes as f64);
    let cells: Vec<Drawn> = (0..arguments.cells).map(|number| Drawn::new(seed, number)).collect();
    println!("### {} cells drawn with seed {seed}, {} channels each\n", cells.len(), arguments.channels);
    println!(
        "| cell | samples | N held % | 99 % limits | estimated % | rms % | bound % | B estimated % | of these held % | bound % | \
         K estimated % | of these held % | bound % | false B, K, R % |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let mut scored = Vec::new();
    for (number, drawn) in cells.iter().enumerate() {
        if begin.elapsed().as_secs_f64() > budget_s {
            println!("\nThe time is over after {number} cells.");
            break;
        }
        let mut score = drawn.score(arguments, seed, number, arguments.channels);
        if arguments.channels >= FEWEST_TO_DOUBT && score.white.limits().1 < LEAST_HELD {
            score = drawn.score(arguments, seed, number, AGAIN * arguments.channels);
        }
        score.print(drawn);
        scored.push((drawn, score));
    }
    summary(&scored, seed);
}

impl Drawn {
    fn new(seed: u64, number: usize) -> Self {
        let random = &mut Random::of_record(seed, "drawn", 0, number);
        let (duration_s, rate_hz) = loop {
            let drawn = (log_uniform(random, 30.0, 18_000.0), log_uniform(random, 1.0, 1000.0));
            if (LEAST_SAMPLES..MOST_SAMPLES).contains(&(drawn.0 * drawn.1)) {
                break drawn;
            }
        };
        let cell = Cell {
            name: String::new(),
            duration_s,
            rate_hz,
            white: White::Gaussian,
            parts: Vec::new(),
            loss: None,
            step: 0.01,
            known_window: None,
        };
        let mut drawn = Self {
            cell,
            families: Vec::new(),
            parts: vec![Spectrum::White(1.0)],
            white: (1.0, 1.0),
            only_ends: false,
            bias_instability: Some(0.0),
            walk: Some(0.0),
        };
        let pick = |random: &mut Random| FAMILIES[(random.uniform() * FAMILIES.len() as f64) as usize];
        let first = pick(random);
        let mut names = vec![drawn.add(first, random)];
        // a third are mixtures; two parts that shape the white part exclude each other
        let second = pick(random);
        let shapes = |family: &str| ["low pass", "mean window", "modulated", "tails"].contains(&family);
        if random.uniform() < 1.0 / 3.0 && first != second && !(shapes(first) && shapes(second)) {
            names.push(drawn.add(second, random));
        }
        drawn.finish();
        drawn.cell.name = format!("{} ({:.3} s at {:.2} Hz)", names.join(", "), duration_s, rate_hz);
        drawn
    }

    /// Adds a part of this family; gives its name with its figures.
    fn add(&mut self, family: &'static str, random: &mut Random) -> String {
        self.families.push(family);
        let (samples, rate_hz) = (self.cell.samples() as f64, self.cell.rate_hz);
        let duration_s = samples / rate_hz;
        let crossing = |random: &mut Random, longest: f64| log_uniform(random, 10.0, (samples / longest).max(20.0));
        match family {
            "flicker" => self.add_flicker(crossing(random, 5.0)),
            "walk" => self.add_walk(crossing(random, 2.0)),
            "flicker and walk" => {
                let flicker = self.add_flicker(crossing(random, 20.0));
                format!("{flicker}, {}", self.add_walk(crossing(random, 2.0)))
            }
            "ramp" => {
                let total = log_uniform(random, 0.03, 10.0);
                self.cell.parts.push(Part::Ramp(total));
                format!("ramp of {total:.3} sd")
            }
            "low pass" => {
                let (order, corner) = ((1.0 + 6.0 * random.uniform()) as u8, log_uniform(random, 0.05, 0.49));
                self.cell.white = White::LowPass { order, corner };
                format!("low pass of order {order} at {corner:.3}")
            }
            "mean window" => {
                let length = log_uniform(random, 2.0, 40.0) as u32;
                self.cell.white = White::Window(20 * length);
                format!("mean of {length}")
            }
            "Gauss-Markov" => self.add_process(random),
            "two Gauss-Markov" => format!("{}, {}", self.add_process(random), self.add_process(random)),
            "line" => {
                let hz = log_uniform(random, (5.0 / duration_s).min(0.1 * rate_hz), 0.5 * rate_hz);
                let share = log_uniform(random, 0.003, 0.5);
                self.cell.parts.push(Part::Line { hz, share, drift: Drift::None });
                format!("line at {:.4} of the rate, {:.1} %", hz / rate_hz, 100.0 * share)
            }
            "resonance" => {
                let (frequency, quality) = (log_uniform(random, 0.02, 0.45), log_uniform(random, 2.0, 50.0));
                let deviation = log_uniform(random, 0.05, 1.0);
                self.cell.parts.push(Part::Resonance { hz: frequency * rate_hz, quality, deviation });
                let variance = deviation * deviation;
                self.parts.push(Spectrum::Resonance { coefficients: resonance(frequency, quality), variance });
                self.bias_instability = None;
                format!("resonance at {frequency:.3}, Q {quality:.1}, {deviation:.3} sd")
            }
            "popcorn" => {
                let dwell = log_uniform(random, 4.0, samples / 2.0);
                let deviation = log_uniform(random, 0.03, 1.0);
                self.cell.parts.push(Part::Popcorn { dwell_s: dwell / rate_hz, deviation });
                // of two changes in a row the second undoes the first
                self.add_slow(2.0 * (-1.0 / dwell).exp() - 1.0, dwell / 2.0, deviation);
                format!("popcorn of {dwell:.0} samples, {deviation:.3} sd")
            }
            "warm-up" => {
                let (time_s, deviation) =
                    (log_uniform(random, 0.01, 1.0) * duration_s, log_uniform(random, 0.03, 10.0));
                self.cell.parts.push(Part::WarmUp { time_s, deviation });
                format!("warm-up of {:.3} of the record, {deviation:.3} sd", time_s / duration_s)
            }
            "cycle" => {
                let period_s = log_uniform(random, 0.05, 2.0) * duration_s;
                let deviation = log_uniform(random, 0.03, 3.0);
                self.cell.parts.push(Part::Cycle { period_s, deviation });
                format!("cycle of {:.3} of the record, {deviation:.3} sd", period_s / duration_s)
            }
            "modulated" => {
                let (depth, period) = (0.1 + 0.7 * random.uniform(), log_uniform(random, 0.05, 2.0));
                self.cell.white = White::Modulated { depth, period };
                format!("modulated by {depth:.2} in {period:.2} of the record")
            }
            "gaps" => {
                let share = log_uniform(random, 0.001, 0.3);
                let is_bunched = random.uniform() < 0.5;
                self.cell.loss = Some(if is_bunched { Loss::Bunched(share) } else { Loss::Random(share) });
                format!("{:.2} % lost, {}", 100.0 * share, if is_bunched { "bunched" } else { "random" })
            }
            "rounding" => {
                self.cell.step = log_uniform(random, 0.01, 2.0);
                format!("step of {:.3} sd", self.cell.step)
            }
            "tails" => {
                let (probability, height) = (log_uniform(random, 1e-4, 1e-2), 4.0 + 8.0 * random.uniform());
                let tails = [White::Student5, White::Laplace, White::Spikes { probability, height }];
                let names =
                    ["Student t5".into(), "Laplace".into(), format!("{probability:.5} spikes of {height:.1} sd")];
                let place = (3.0 * random.uniform()) as usize;
                self.cell.white = tails[place];
                names[place].clone()
            }
            _ => "white".into(),
        }
    }

    /// With the Allan variance of the white part after this many samples.
    fn add_flicker(&mut self, crossing: f64) -> String {
        let b = (1.0 / crossing / (2.0 * std::f64::consts::LN_2 / std::f64::consts::PI)).sqrt();
        self.cell.parts.push(Part::Flicker(b));
        self.parts.push(Spectrum::Flicker(b));
        self.bias_instability = self.bias_instability.map(|sum: f64| sum.hypot(b));
        format!("flicker crossing after {crossing:.0} samples")
    }

    fn add_walk(&mut self, crossing: f64) -> String {
        let step = 3_f64.sqrt() / crossing;
        self.cell.parts.push(Part::Walk(step));
        self.parts.push(Spectrum::Walk(step));
        self.walk = self.walk.map(|sum: f64| sum.hypot(step * self.cell.rate_hz.sqrt()));
        format!("walk crossing after {crossing:.0} samples")
    }

    fn add_process(&mut self, random: &mut Random) -> String {
        let time = log_uniform(random, 4.0, self.cell.samples() as f64 / 3.0);
        let deviation = log_uniform(random, 0.03, 1.0);
        self.cell.parts.push(Part::GaussMarkov { time_s: time / self.cell.rate_hz, deviation });
        self.add_slow((-1.0 / time).exp(), time, deviation);
        format!("Gauss-Markov of {time:.0} samples, {deviation:.3} sd")
    }

    fn add_slow(&mut self, phi: f64, time: f64, deviation: f64) {
        self.parts.push(Spectrum::GaussMarkov { phi, variance: deviation * deviation });
        self.bias_instability = None;
        if time >= self.cell.samples() as f64 / 10.0 {
            self.walk = None;
        }
        self.only_ends |= time < SHORT;
    }

    /// What N² may be, when all parts are known.
    fn finish(&mut self) {
        let mut floor = self.cell.white.variance();
        self.parts[0] = Spectrum::White(floor);
        let rounding = self.cell.step * self.cell.step / 12.0;
        if self.cell.step <= 1.0 {
            floor += rounding;
        }
        let mut most = if self.cell.step <= 1.0 { floor } else { floor + rounding };
        // what filters and resonances leave for the band of the white part
        let lowest = self.parts.iter().filter_map(|part| match part {
            Spectrum::Resonance { coefficients: [first, second, _], .. } => {
                Some((first / (2.0 * (-second).sqrt())).acos() / TAU)
            }
            _ => None,
        });
        let corner = match self.cell.white {
            White::LowPass { corner, .. } => corner,
            White::Window(length) => 0.44 * 20.0 / f64::from(length),
            _ => 0.5,
        };
        let end = 0.5 * lowest.fold(corner, f64::min);
        for part in &self.parts {
            most += match *part {
                Spectrum::Resonance { .. } => part.density(1e-9),
                Spectrum::GaussMarkov { phi, .. } => {
                    let time = -1.0 / phi.ln();
                    let begin = 5.0 / (TAU * time);
                    if time < SHORT || begin >= end { part.density(1e-9) } else { mean_density(*part, begin, end) }
                }
                _ => 0.0,
            };
        }
        // less than 3 % apart the two are one
        self.only_ends &= most > floor * 1.06;
        self.white = (floor, most);
    }

    fn score(&self, arguments: &Arguments, seed: u64, number: usize, channels: usize) -> Score {
        let samples = self.cell.samples();
        let has_flicker = self.cell.parts.iter().any(|part| matches!(part, Part::Flicker(_)));
        let flicker = Flicker::new(if has_flicker { samples } else { 2 });
        let records = channels / record::SCORED;
        let said = in_parallel(arguments.threads, records, |of| {
            let mut random = Random::of_record(seed, "record", number, of);
            let assessed = Record::of(&self.cell, &flicker, &mut random).assess(&self.cell, &mut random);
            let of_channel = |(place, _): (usize, &str)| {
                let noise = assessed.assessment.channels[place].noise.as_ref();
                TERMS.map(|term| noise.and_then(|noise| noise.parameter(term)))
            };
            record::scored().map(of_channel).collect::<Vec<_>>()
        });
        let unit = self.cell.step * record::counts_per_unit();
        let mut score = Score { bounds: self.error_bounds(), ..Score::default() };
        for terms in said.into_iter().flatten() {
            score.channels += 1;
            score.take(self, terms, unit);
        }
        score
    }

    fn holds_white(&self, parameter: &Parameter, unit: f64) -> bool {
        let interval_s = 1.0 / self.cell.rate_hz;
        let squared = |value: f64| (value * unit).powi(2) / interval_s;
        let (floor, most) = self.white;
        match (parameter.status, parameter.lower.map(squared), parameter.upper.map(squared)) {
            (Status::Bounded, _, Some(upper)) => floor <= upper,
            (Status::Estimated, Some(lower), Some(upper)) if self.only_ends => {
                [floor, most].iter().any(|end| (lower..=upper).contains(end))
            }
            (Status::Estimated, Some(lower), Some(upper)) => lower <= most && floor <= upper,
            _ => false,
        }
    }

    /// Bounds of the relative errors of N, B and K; infinite for those that are not there.
    fn error_bounds(&self) -> [f64; 3] {
        const SINGLE: usize = 120;
        const WIDTH: f64 = 0.015;
        let samples = self.cell.samples();
        let kept = match self.cell.loss {
            Some(Loss::Random(share) | Loss::Bunched(share)) => 1.0 - share,
            None => 1.0,
        };
        let size = self.parts.len();
        let mut information = vec![vec![0.0; size]; size];
        let mut first = 1;
        while first < samples {
            let width = if first <= SINGLE { 1 } else { (WIDTH * first as f64) as usize }.min(samples - first);
            let frequency = (first as f64 + (width as f64 - 1.0) / 2.0) / (2 * samples) as f64;
            let gain: f64 = match self.cell.white {
                White::LowPass { order, corner } => {
                    LowPass::sections(order, corner).iter().map(|section| section.squared_gain(frequency)).product()
                }
                White::Window(length) => {
                    let length = f64::from(length) / 20.0;
                    ((TAU / 2.0 * frequency * length).sin() / (length * (TAU / 2.0 * frequency).sin())).powi(2)
                }
                _ => 1.0,
            };
            let rounding = self.cell.step * self.cell.step / 12.0;
            // by the power of each part
            let columns: Vec<f64> = self
                .parts
                .iter()
                .enumerate()
                .map(|(place, part)| part.density(frequency) * if place == 0 { gain } else { 1.0 })
                .collect();
            let sum = columns.iter().sum::<f64>() + rounding;
            for (row, a) in information.iter_mut().zip(&columns) {
                for (entry, b) in row.iter_mut().zip(&columns) {
                    *entry += 0.5 * kept * width as f64 * a * b / (sum * sum);
                }
            }
            first += width;
        }
        let place_of = |is: fn(&Spectrum) -> bool| self.parts.iter().position(is);
        let variances = inverse_diagonal(information);
        let error = |place: Option<usize>| place.map_or(f64::INFINITY, |place| 0.5 * variances[place].sqrt());
        [
            error(Some(0)),
            error(place_of(|part| matches!(part, Spectrum::Flicker(_)))),
            error(place_of(|part| matches!(part, Spectrum::Walk(_)))),
        ]
    }
}

const TERMS: [Term; 4] = [Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];

/// The aims: shares that hold, of N and of estimated B and K; median of N; false terms.
const LEAST_HELD: f64 = 0.88;
const LEAST_HELD_SLOW: f64 = 0.85;
const FEWEST_ESTIMATES: usize = 50;
/// Errors of the bound below which N, and B and K, should be estimated, and in which share.
const CLEAR_WHITE: (f64, f64) = (0.05, 0.9);
const CLEAR_SLOW: (f64, f64) = (0.15, 0.8);
const MOST_FALSE: f64 = 0.1;

#[derive(Default)]
struct Score {
    channels: usize,
    white: Held,
    white_estimated: usize,
    /// Relative, of estimated values.
    errors: Vec<f64>,
    /// B and K: of those estimated, these hold. Only of cells that have them.
    slow: [Held; 2],
    false_terms: usize,
    bounds: [f64; 3],
}

#[derive(Default, Clone, Copy)]
struct Held {
    of: usize,
    held: usize,
}

impl Held {
    fn add(&mut self, holds: bool) {
        self.of += 1;
        self.held += usize::from(holds);
    }

    fn share(self) -> f64 {
        self.held as f64 / self.of as f64
    }

    /// At 99 % (Clopper and Pearson, 1934).
    fn limits(self) -> (f64, f64) {
        let (held, missed) = (self.held as f64, (self.of - self.held) as f64);
        let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
        let lower = if held == 0.0 { 0.0 } else { quantile(held, missed + 1.0, 0.005) };
        let upper = if missed == 0.0 { 1.0 } else { quantile(held + 1.0, missed, 0.995) };
        (lower, upper)
    }
}

impl Score {
    fn take(&mut self, drawn: &Drawn, [white, bias, walk, ramp]: [Option<Parameter>; 4], unit: f64) {
        let is_estimated =
            |parameter: &Option<Parameter>| parameter.is_some_and(|parameter| parameter.status == Status::Estimated);
        // a channel without a word about N claims nothing that could be wrong
        if let Some(white) = white.filter(|white| matches!(white.status, Status::Estimated | Status::Bounded)) {
            self.white.add(drawn.holds_white(&white, unit));
        }
        if let Some(value) = white.filter(|_| is_estimated(&white)).and_then(|white| white.value) {
            self.white_estimated += 1;
            let truth = (drawn.white.0 / drawn.cell.rate_hz).sqrt();
            self.errors.push(value * unit / truth - 1.0);
        }
        let truths = [drawn.bias_instability, drawn.walk];
        let mut is_false = is_estimated(&ramp) && !drawn.families.contains(&"ramp");
        for ((parameter, truth), held) in [bias, walk].into_iter().zip(truths).zip(&mut self.slow) {
            let (Some(parameter), Some(truth)) = (parameter.filter(|_| is_estimated(&parameter)), truth) else {
                continue;
            };
            if truth == 0.0 {
                is_false = true;
            } else if let (Some(lower), Some(upper)) = (parameter.lower, parameter.upper) {
                held.add((lower * unit..=upper * unit).contains(&truth));
            }
        }
        self.false_terms += usize::from(is_false);
    }

    fn rms_error(&self) -> f64 {
        (self.errors.iter().map(|error| error * error).sum::<f64>() / self.errors.len() as f64).sqrt()
    }

    fn share(&self, count: usize) -> f64 {
        count as f64 / self.channels as f64
    }

    fn print(&self, drawn: &Drawn) {
        let (lower, upper) = self.white.limits();
        print!(
            "| {} | {} | {} | {}-{} | {} | {} | {} |",
            drawn.cell.name,
            drawn.cell.samples(),
            percent(self.white.share()),
            percent(lower),
            percent(upper),
            percent(self.share(self.white_estimated)),
            percent(self.rms_error()),
            percent(self.bounds[0])
        );
        for (held, bound) in self.slow.iter().zip(&self.bounds[1..]) {
            if bound.is_finite() {
                print!(" {} | {} | {} |", percent(self.share(held.of)), percent(held.share()), percent(*bound));
            } else {
                print!(" | | |");
            }
        }
        println!(" {} |", percent(self.share(self.false_terms)));
    }
}

fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.1}", 100.0 * share) } else { "-".into() }
}

/// By family and as a whole, and which cells miss an aim.
fn summary(scored: &[(&Drawn, Score)], seed: u64) {
    println!("\n| family | cells | N held %: median | worst tenth | worst cell | 99 % limits | false, worst % |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for family in FAMILIES.into_iter().chain(["all"]) {
        let cells = scored.iter().filter(|(drawn, _)| family == "all" || drawn.families.contains(&family));
        let mut cells: Vec<&Score> = cells.map(|(_, score)| score).filter(|score| score.white.of > 0).collect();
        if cells.is_empty() {
            continue;
        }
        cells.sort_by(|a, b| a.white.share().total_cmp(&b.white.share()));
        let at = |part: f64| percent(cells[(part * (cells.len() - 1) as f64).round() as usize].white.share());
        let (lower, upper) = cells[0].white.limits();
        let worst_false = cells.iter().map(|score| score.share(score.false_terms)).fold(0.0, f64::max);
        let values = [
            ("cells", cells.len().to_string()),
            ("median %", at(0.5)),
            ("worst tenth %", at(0.1)),
            ("worst cell %", at(0.0)),
            ("its 99 % limits", format!("{}-{}", percent(lower), percent(upper))),
            ("false, worst %", percent(worst_false)),
        ];
        println!("| {family} | {} |", values.each_ref().map(|(_, value)| value.as_str()).join(" | "));
        if family == "all" {
            figures::record("drawn", &format!("seed {seed}: {family}"), &values);
        }
    }
    println!();
    let mut missed = Vec::new();
    let mut miss = |aim: &'static str, is_missed: &dyn Fn(&Score) -> bool| {
        let names: Vec<&str> =
            scored.iter().filter(|(_, score)| is_missed(score)).map(|(drawn, _)| &*drawn.cell.name).collect();
        println!("{} of {} cells miss: {aim}", names.len(), scored.len());
        names.iter().for_each(|name| println!("- {name}"));
        missed.push((aim, names.len().to_string()));
    };
    miss("N holds", &|score| score.white.of > 0 && score.white.limits().1 < LEAST_HELD);
    miss("N estimated", &|score| score.bounds[0] < CLEAR_WHITE.0 && score.share(score.white_estimated) < CLEAR_WHITE.1);
    for (place, [holds, estimated]) in [["B holds", "B estimated"], ["K holds", "K estimated"]].into_iter().enumerate()
    {
        miss(holds, &|score| {
            score.slow[place].of >= FEWEST_ESTIMATES && score.slow[place].limits().1 < LEAST_HELD_SLOW
        });
        miss(estimated, &|score| {
            score.bounds[1 + place] < CLEAR_SLOW.0 && score.share(score.slow[place].of) < CLEAR_SLOW.1
        });
    }
    miss("false terms", &|score| score.share(score.false_terms) > MOST_FALSE);
    figures::record("drawn-aims", &format!("seed {seed}"), &missed);
}

fn log_uniform(random: &mut Random, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.uniform())
}

fn mean_density(part: Spectrum, begin: f64, end: f64) -> f64 {
    const STEPS: u32 = 200;
    let at = |step: u32| part.density(begin + (end - begin) * (f64::from(step) + 0.5) / f64::from(STEPS));
    (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
}

/// The diagonal of the inverse of a symmetric positive matrix, by Gauss and Jordan; infinite if it has none.
fn inverse_diagonal(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let size = matrix.len();
    let mut inverse: Vec<Vec<f64>> =
        (0..size).map(|row| (0..size).map(|column| f64::from(u8::from(row == column))).collect()).collect();
    for pivot in 0..size {
        let scale = matrix[pivot][pivot];
        if scale <= 0.0 {
            return vec![f64::INFINITY; size];
        }
        for column in 0..size {
            matrix[pivot][column] /= scale;
            inverse[pivot][column] /= scale;
        }
        for row in (0..size).filter(|row| *row != pivot) {
            let factor = matrix[row][pivot];
            for column in 0..size {
                matrix[row][column] -= factor * matrix[pivot][column];
                inverse[row][column] -= factor * inverse[pivot][column];
            }
        }
    }
    (0..size).map(|place| inverse[place][place]).collect()
}

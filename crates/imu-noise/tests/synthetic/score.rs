//! The intervals of a record with known noise that contain the truth.

use imu_noise::{
    ChannelCurve, Deviation, Estimator, Interval, NoiseFit, NoiseModel, Octaves, Parameter, PowerLaw, RecordShape,
    Status, Term, curve_minimum, white_deficit,
};

pub(crate) const RATE_HZ: f64 = 40.0;
pub(crate) const CONFIDENCE: f64 = 0.95;
/// Counts per standard deviation of white noise, so that rounding is negligible.
const COUNTS: f64 = 10_000.0;

pub(crate) const TERMS: [Term; 4] = [Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];

/// Amplitudes in standard deviations of white noise: flicker, step of the walk, ramp over the whole
/// record.
pub(crate) struct Noise {
    pub(crate) name: &'static str,
    pub(crate) flicker: f64,
    pub(crate) step: f64,
    pub(crate) ramp: f64,
}

pub(crate) const NOISES: [Noise; 8] = [
    Noise { name: "white", flicker: 0.0, step: 0.0, ramp: 0.0 },
    Noise { name: "white + flicker", flicker: 0.1, step: 0.0, ramp: 0.0 },
    Noise { name: "white + walk", flicker: 0.0, step: 1e-3, ramp: 0.0 },
    Noise { name: "all", flicker: 0.1, step: 1e-3, ramp: 0.0 },
    Noise { name: "white, ramp", flicker: 0.0, step: 0.0, ramp: 1.0 },
    Noise { name: "white + flicker, ramp", flicker: 0.1, step: 0.0, ramp: 1.0 },
    Noise { name: "white + walk, ramp", flicker: 0.0, step: 1e-3, ramp: 1.0 },
    Noise { name: "all, ramp", flicker: 0.1, step: 1e-3, ramp: 1.0 },
];

/// Number of intervals and bounds that held, of parameters that were called estimated, and of all.
#[derive(Clone, Copy, Default)]
pub(crate) struct Score {
    pub(crate) held: usize,
    pub(crate) estimated: usize,
    pub(crate) of: usize,
}

impl Score {
    pub(crate) fn held_percent(&self) -> f64 {
        100.0 * self.held as f64 / self.of as f64
    }

    pub(crate) fn estimated_percent(&self) -> f64 {
        100.0 * self.estimated as f64 / self.of as f64
    }
}

/// The results for the records of one noise.
#[derive(Clone, Default)]
pub(crate) struct Cell {
    /// Scores in the order of [`TERMS`].
    pub(crate) terms: [Score; TERMS.len()],
    /// The score of octaves with more than 10 degrees of freedom.
    pub(crate) octaves: Score,
    pub(crate) rejected: usize,
    /// Records that seem to fall below their own white noise, by 3.7 standard deviations.
    pub(crate) below_white: usize,
    /// N of the same records after a filter that tracks the bias.
    pub(crate) tracked_white: Score,
    /// The minimum of the curve, as given in data sheets; estimated if it has a lower end.
    pub(crate) minimum: Score,
}

/// The record as counts, in a unit in which white noise has the standard deviation 1.
pub(crate) fn counts(noise: &Noise, (white, flicker, walk): &(Vec<f64>, Vec<f64>, Vec<f64>)) -> Vec<i32> {
    let slope = noise.ramp / white.len() as f64;
    let samples = white.iter().zip(flicker).zip(walk).enumerate();
    let value = |(i, ((white, flicker), walk))| {
        let value: f64 = white + noise.flicker * flicker + noise.step * walk + slope * f64::from(i as u32);
        (COUNTS * value).round() as i32
    };
    samples.map(value).collect()
}

/// The output of a filter that tracks the bias, with a time constant of half a minute: a
/// first-order high-pass that leaves the highest frequency unchanged.
pub(crate) fn tracked(counts: &[i32]) -> Vec<i32> {
    let half_step = 1.0 / (2.0 * 30.0 * RATE_HZ);
    let (memory, gain) = ((1.0 - half_step) / (1.0 + half_step), 1.0 / (1.0 + half_step));
    let (mut before, mut left) = (0.0, 0.0);
    let filtered = counts.iter().map(|count| {
        left = memory * left + gain * (f64::from(*count) - before);
        before = f64::from(*count);
        left.round() as i32
    });
    filtered.collect()
}

/// The results from a record.
pub(crate) struct ReadOut {
    pub(crate) shape: RecordShape,
    pub(crate) octaves: Vec<imu_noise::Octave>,
    pub(crate) variances: Vec<f64>,
    /// The level of every interval.
    confidence: f64,
}

impl ReadOut {
    pub(crate) fn new(counts: &[i32], estimator: Estimator, deviation: Deviation) -> Self {
        let shape = RecordShape { samples: counts.len() as u64, interval_s: 1.0 / RATE_HZ, estimator, deviation };
        let mut sums = Octaves::new(shape.estimator, shape.deviation);
        sums.push(counts);
        Self {
            shape,
            octaves: sums.sums().map(|sum| sum.octave()).collect(),
            variances: sums.sums().map(|sum| sum.variance_counts2().unwrap() / (COUNTS * COUNTS)).collect(),
            confidence: CONFIDENCE,
        }
    }

    /// The same with intervals at another level.
    pub(crate) fn at(self, confidence: f64) -> Self {
        Self { confidence, ..self }
    }

    pub(crate) fn model(&self) -> NoiseModel {
        NoiseModel::new(&self.octaves, &self.shape, None, false)
    }

    pub(crate) fn fit(&self, model: &NoiseModel) -> NoiseFit {
        model.fit(&ChannelCurve::new(&self.variances, true), self.confidence)
    }

    /// N from the averaging times without the effect of a filter that tracks the bias.
    pub(crate) fn white(&self) -> Parameter {
        let before_filter = |octave: &&imu_noise::Octave| octave.m as f64 / RATE_HZ <= 10.0;
        let octaves = self.octaves.iter().take_while(before_filter).count();
        let model = NoiseModel::new(&self.octaves, &self.shape, None, false);
        model
            .fit_part(&ChannelCurve::new(&self.variances, false), octaves, self.confidence)
            .parameter(Term::White)
            .unwrap()
    }
}

impl Score {
    fn count(&mut self, parameter: &Parameter, truth: f64) {
        let above = parameter.lower.is_none_or(|lower| lower <= truth);
        self.of += 1;
        self.estimated += usize::from(parameter.status == Status::Estimated);
        self.held += usize::from(above && parameter.upper.is_none_or(|upper| truth <= upper));
    }
}

impl Cell {
    pub(crate) fn score_tracked(&mut self, read_out: &ReadOut) {
        self.tracked_white.count(&read_out.white(), read_out.shape.interval_s.sqrt());
    }

    pub(crate) fn score(&mut self, noise: &Noise, read_out: &ReadOut, fit: &NoiseFit) {
        let interval_s = read_out.shape.interval_s;
        let ramp = noise.ramp / read_out.shape.samples as f64;
        let truths = [interval_s.sqrt(), noise.flicker, noise.step / interval_s.sqrt(), ramp / interval_s];
        for ((term, truth), score) in TERMS.into_iter().zip(truths).zip(&mut self.terms) {
            score.count(&fit.parameter(term).unwrap(), truth);
        }
        let [white, bias, walk] = [0, 1, 2].map(|term| fit.parameter(TERMS[term]).unwrap());
        let plateau = 2.0 * std::f64::consts::LN_2 / std::f64::consts::PI;
        let truth = (plateau * truths[1] * truths[1] + 2.0 * truths[0] * truths[2] / 3_f64.sqrt()).sqrt();
        let minimum = curve_minimum(&white, &bias, &walk, fit.likeliest.rate_random_walk);
        self.minimum.count(&minimum, truth);
        self.minimum.estimated += usize::from(minimum.status != Status::Estimated && minimum.lower.is_some());
        self.rejected += usize::from(fit.quality.is_none());
        let deficit = |white| white_deficit(&read_out.octaves, &read_out.variances, &read_out.shape, white, None);
        self.below_white += usize::from(read_out.white().value.map_or(0.0, deficit) > 3.7);
        for (octave, variance) in read_out.octaves.iter().zip(&read_out.variances) {
            let of = |law: PowerLaw| law.variance(read_out.shape.deviation, octave.m);
            let truth = of(PowerLaw::White)
                + noise.flicker.powi(2) * of(PowerLaw::Flicker)
                + noise.step.powi(2) * of(PowerLaw::RandomWalk)
                + if read_out.shape.deviation == Deviation::Allan {
                    (ramp * octave.m as f64).powi(2) / 2.0
                } else {
                    0.0
                };
            if let Some(edf) = fit.edf(octave.m).filter(|edf| *edf > 10.0) {
                let interval = Interval::new(*variance, edf, read_out.confidence).unwrap();
                self.octaves.of += 1;
                self.octaves.held += usize::from((interval.lower..=interval.upper).contains(&truth.sqrt()));
            }
        }
    }
}

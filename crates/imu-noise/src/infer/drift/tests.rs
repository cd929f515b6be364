//! The drift of known noises by textbook formulas, and the share of drifts in records cut in two that lies within its limits.

use std::f64::consts::{LN_2, PI, TAU};

use proptest::prelude::*;

use super::*;
use crate::{Deviation, Estimator, Octaves, counts_to_unit};

/// Amplitudes of white noise N, flicker B and walk K.
#[derive(Debug, Clone, Copy)]
struct Truth {
    n: f64,
    b: f64,
    k: f64,
}

impl Truth {
    fn variance(self, tau: f64) -> f64 {
        self.n.powi(2) / tau + self.b.powi(2) * 2.0 * LN_2 / PI + self.k.powi(2) * tau / 3.0
    }

    fn curve(self, octaves: u32) -> Vec<CurvePoint> {
        let point = |tau_s: f64| CurvePoint { tau_s, deviation: self.variance(tau_s).sqrt(), edf: 100.0 };
        (0..octaves).map(|octave| point(0.005 * f64::from(1 << octave))).collect()
    }

    /// T² Var(mean over T less mean over T0), each term in closed form.
    fn once(self, rest: f64, coast: f64) -> f64 {
        let white = self.n.powi(2) * coast * (1.0 + coast / rest);
        let walk = self.k.powi(2) * coast.powi(2) * (rest + coast) / 3.0;
        let flicker = {
            let g = |tau: f64| self.b.powi(2) / TAU * tau * tau * tau.ln();
            let (start, middle, end) = (coast / rest, -1.0 - coast / rest, 1.0);
            2.0 * (start * middle * g(rest) + middle * end * g(coast) + start * end * g(rest + coast))
        };
        white + walk + flicker
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_curve_gives_the_drift_of_the_textbook(
        n in 1e-5_f64..1e-2, b in 0.0_f64..1e-3, k in 0.0_f64..1e-3,
        rest in 0.3_f64..600.0, coast in 0.3_f64..600.0,
    ) {
        let truth = Truth { n, b, k };
        let drift = Drift::new(&truth.curve(18), Integral::Once, rest, coast).unwrap();
        let expected = truth.once(rest, coast).sqrt();
        prop_assert!((drift.std / expected - 1.0).abs() < 0.03, "{} for {expected}", drift.std);
    }

    #[test]
    fn a_rest_as_long_as_the_coast_needs_the_curve_at_one_point(octave in 1_u32..16, n in 1e-5_f64..1e-2, k in 1e-6_f64..1e-2) {
        let truth = Truth { n, b: 0.0, k };
        let tau = 0.005 * f64::from(1 << octave);
        let drift = Drift::new(&truth.curve(18), Integral::Once, tau, tau).unwrap();
        let expected = (2.0 * truth.variance(tau)).sqrt() * tau;
        prop_assert!((drift.std / expected - 1.0).abs() < 1e-9);
        prop_assert!((drift.edf / 100.0 - 1.0).abs() < 1e-3, "of that point alone: {}", drift.edf);
    }

    /// The white part of a tilt: g N √(T³/3 + T⁴/(4 T0)) in velocity.
    #[test]
    fn white_noise_of_a_tilt_and_of_a_position(rest in 1.0_f64..300.0, coast in 1.0_f64..60.0) {
        let curve = Truth { n: 1.0, b: 0.0, k: 0.0 }.curve(18);
        let of = |integral| Drift::new(&curve, integral, rest, coast).unwrap().std;
        let velocity = (coast.powi(3) / 3.0 + coast.powi(4) / (4.0 * rest)).sqrt();
        prop_assert!((of(Integral::Twice) / velocity - 1.0).abs() < 2e-3);
        let position = (coast.powi(5) / 20.0 + coast.powi(6) / (36.0 * rest)).sqrt();
        prop_assert!((of(Integral::ThreeTimes) / position - 1.0).abs() < 5e-3);
    }
}

#[test]
fn what_the_record_does_not_reach_is_not_observable() {
    let mut curve = Truth { n: 1e-3, b: 0.0, k: 0.0 }.curve(12);
    let longest = curve[11].tau_s;
    let of = |curve: &[CurvePoint], rest, coast| Drift::new(curve, Integral::Once, rest, coast).is_some();
    assert!(of(&curve, longest, longest) && !of(&curve, longest, 1.1 * longest));
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(!of(&curve, wrong, 1.0) && !of(&curve, 1.0, wrong) && !of(&[], 1.0, 1.0), "{wrong}");
    }
    curve[11].edf = 1.5;
    assert!(!of(&curve, longest, longest), "one degree of freedom and a half");
    curve[3].deviation = 0.0;
    assert!(!of(&curve, 1.0, 1.0), "a part of the curve is not known");
}

/// Seeded normal deviates: PCG, then Marsaglia's polar method.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        f64::from(word.rotate_right((self.0 >> 59) as u32)) / 4_294_967_296.0
    }

    fn next(&mut self) -> f64 {
        loop {
            let (a, b) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let r = a * a + b * b;
            if r > 0.0 && r < 1.0 {
                return a * (-2.0 * r.ln() / r).sqrt();
            }
        }
    }
}

/// A record of one of four families, in counts at 10 Hz: white noise, with a walk, with flicker as a sum
/// of relaxations, with one relaxation.
fn record(seed: u64, samples: usize) -> Vec<i32> {
    let mut normal = Normal(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let strength = 10.0_f64.powf(2.0 + normal.uniform());
    let times: Vec<f64> = match seed % 4 {
        2 => (1..9).map(|octave| 2.0_f64.powi(2 * octave)).collect(),
        3 => vec![10.0_f64.powf(1.0 + 2.0 * normal.uniform())],
        _ => Vec::new(),
    };
    let step = if seed % 4 == 1 { strength * 0.01 } else { 0.0 };
    let mut states: Vec<f64> = times.iter().map(|_| normal.next()).collect();
    let mut walk = 0.0;
    (0..samples)
        .map(|_| {
            walk += step * normal.next();
            for (state, time) in states.iter_mut().zip(&times) {
                let kept = (-1.0 / time).exp();
                *state = kept * *state + (1.0 - kept * kept).sqrt() * normal.next();
            }
            let bias: f64 = walk + 0.3 * strength * states.iter().sum::<f64>();
            (3.0 * strength * normal.next() + bias).round() as i32
        })
        .collect()
}

/// The first half of a record foretells the drifts of the second.
#[test]
fn the_prediction_interval_contains_95_of_100_drifts_of_the_other_half() {
    const SAMPLES: usize = 8192;
    const INTERVAL_S: f64 = 0.1;
    for (rest, coast) in [(200, 200), (100, 600), (600, 100), (50, 1000)] {
        let (mut inside, mut tried) = (0.0, 0.0);
        for seed in 0..240 {
            let record = record(seed, 2 * SAMPLES);
            let (seen, later) = record.split_at(SAMPLES);
            let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
            sums.push(seen);
            let point = |octave: crate::OctaveSum| {
                let variance = counts_to_unit(octave.variance_counts2()?, 0);
                let tau_s = octave.m as f64 * INTERVAL_S;
                // half as many as pairs of windows: an interval that is rather wide
                let edf = (SAMPLES as f64 / octave.m as f64 - 1.0).max(1.0);
                Some(CurvePoint { tau_s, deviation: variance.sqrt(), edf })
            };
            let curve: Vec<CurvePoint> = sums.sums().filter_map(point).collect();
            let of = |samples: usize| samples as f64 * INTERVAL_S;
            let drift = Drift::new(&curve, Integral::Once, of(rest), of(coast)).unwrap();
            let half = drift.half_width(0.95).unwrap();
            for start in (0..SAMPLES - rest - coast).step_by(rest + coast) {
                let mean = |from: usize, length: usize| {
                    later[from..from + length].iter().map(|count| f64::from(*count)).sum::<f64>() / length as f64
                };
                let found = of(coast) * (mean(start + rest, coast) - mean(start, rest));
                tried += 1.0;
                inside += f64::from(u8::from(found.abs() <= half));
            }
        }
        let share = inside / tried;
        assert!((0.90..0.98).contains(&share), "rest {rest}, coast {coast}: {share} of {tried}");
    }
}

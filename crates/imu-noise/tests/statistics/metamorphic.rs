//! What must not change, or only so far, when a record is scaled, shifted, reversed, cut or thinned.

use imu_noise::{
    BoxcarWindow, ChannelCurve, ChannelSignal, Deviation, Estimator, NoiseFit, NoiseModel, Octave, Octaves, Parameter,
    PowerLaw, RecordShape, SpectrumPlan, Status, Term, chi_squared, edf,
};
use proptest::prelude::*;

/// A multiple of all strides and blocks, so that a reversed record has the same windows.
const SAMPLES: usize = 8192;
const TERMS: [Term; 4] = [Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];

/// Noise in units of its white part.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// With a walk of steps of this size.
    Walk(f64),
    /// With noise correlated over so many samples, with this deviation.
    Slow(f64, f64),
    /// The mean of so many samples.
    Mean(usize),
}

/// One of each kind and white noise, by a number.
fn kind(number: u64) -> Kind {
    let part = (number / 4) as f64 / 8.0 % 1.0;
    match number % 4 {
        0 => Kind::Walk(0.0),
        1 => Kind::Walk((-8.0 + 4.0 * part).exp()),
        2 => Kind::Slow((4.0 + 3.0 * part).exp(), 0.05 + 0.4 * part),
        _ => Kind::Mean(2 + (9.0 * part) as usize),
    }
}

/// By a congruence, in sums of twelve uniform numbers.
fn record(kind: Kind, seed: u64) -> Vec<i32> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut normal = || {
        let uniform = (0..12).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 2_f64.powi(53)
        });
        uniform.sum::<f64>() - 6.0
    };
    let length = if let Kind::Mean(length) = kind { length } else { 1 };
    let white: Vec<f64> = (1..SAMPLES + length).map(|_| normal()).collect();
    let mut level = 0.0;
    let value = |window: &[f64]| {
        level = match kind {
            Kind::Mean(_) => 0.0,
            Kind::Walk(step) => level + step * normal(),
            Kind::Slow(time, deviation) => level * (1.0 - 1.0 / time) + deviation * (2.0 / time).sqrt() * normal(),
        };
        (1e4 * (window.iter().sum::<f64>() / (length as f64).sqrt() + level)).round() as i32
    };
    white.windows(length).map(value).collect()
}

struct Fitted {
    fit: NoiseFit,
    octaves: Vec<Octave>,
    variances: Vec<f64>,
    shape: RecordShape,
}

/// Of runs of values, each followed by so many lost samples.
fn fitted_runs(runs: &[(&[i32], u64)], window: Option<BoxcarWindow>) -> Fitted {
    let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    for (values, lost) in runs {
        sums.push(values);
        signal.push(values);
        if *lost > 0 {
            sums.gap(Some(*lost));
            signal.gap(Some(*lost));
        }
    }
    let samples = runs.iter().map(|(values, lost)| values.len() as u64 + lost).sum();
    let shape = RecordShape { samples, interval_s: 1.0, estimator: Estimator::Strided, deviation: Deviation::Allan };
    let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
    let variances: Vec<_> = sums.sums().map(|sum| sum.variance_counts2().unwrap() * 1e-8).collect();
    let bands = signal.narrow_bands(1e-4, 1.0);
    let curve = ChannelCurve {
        bands: &bands,
        signal: Some((&signal, 1e-4)),
        is_averaging_known: window.is_some(),
        ..ChannelCurve::new(&variances, true)
    };
    let fit = NoiseModel::new(&octaves, &shape, window, false).fit(&curve, 0.95);
    Fitted { fit, octaves, variances, shape }
}

fn fitted(counts: &[i32]) -> Fitted {
    fitted_runs(&[(counts, 0)], None)
}

impl Fitted {
    fn of(&self, term: Term) -> Parameter {
        self.fit.parameter(term).unwrap()
    }

    fn white(&self) -> (f64, f64) {
        let white = self.of(Term::White);
        (white.lower.unwrap_or(0.0), white.upper.unwrap())
    }

    /// Of the interval of N, on a logarithmic scale.
    fn width(&self) -> f64 {
        let (lower, upper) = self.white();
        (upper / lower).ln()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn parameters_scale_with_the_values_and_ignore_an_offset(number in 0..32_u64, seed: u64, offset in -1_000_000..1_000_000) {
        let counts = record(kind(number), seed);
        let changed = |of: &dyn Fn(i32) -> i32| fitted(&counts.iter().map(|count| of(*count)).collect::<Vec<_>>());
        let (one, shifted, scaled) = (fitted(&counts), changed(&|count| count + offset), changed(&|count| -4 * count));
        let near = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a.abs() - b.abs()).abs() <= 1e-6 * a.abs(),
            (a, b) => a == b,
        };
        for term in TERMS {
            let (one, shifted, scaled) = (one.of(term), shifted.of(term), scaled.of(term));
            prop_assert_eq!((one.status, one.status), (shifted.status, scaled.status));
            prop_assert!(near(one.upper, shifted.upper) && near(one.value, shifted.value), "{:?} {:?}", one, shifted);
            prop_assert!(near(one.value.map(|value| 4.0 * value), scaled.value), "{:?} {:?}", one, scaled);
        }
    }
}

#[test]
fn white_noise_is_the_same_backwards_and_with_a_sample_less() {
    let mut wider = 0;
    for number in 0..16 {
        let counts = record(kind(number), number + 100);
        let (forwards, less) = (fitted(&counts), fitted(&counts[1..]));
        let backwards = fitted(&counts.iter().rev().copied().collect::<Vec<_>>());
        let status = |of: &Fitted| of.of(Term::White).status;
        assert_eq!([status(&forwards); 2], [status(&backwards), status(&less)], "{number}");
        let [backwards, less] = [backwards, less].map(|of| (of.width() / forwards.width()).ln().abs());
        assert!(backwards < 1.05_f64.ln(), "{number}: {backwards}");
        wider += usize::from(less > 1.15_f64.ln());
    }
    // other windows and segments weigh the possible filters anew
    assert!(wider <= 2, "{wider}");
}

#[test]
fn halves_agree_and_the_whole_is_known_better() {
    let (mut disjoint, mut wider) = (0, 0);
    for number in 0..16 {
        let counts = record(kind(number), number + 200);
        let (first, second) = counts.split_at(SAMPLES / 2);
        let [whole, first, second] = [&counts[..], first, second].map(fitted);
        disjoint += usize::from(first.white().0 > second.white().1 || second.white().0 > first.white().1);
        wider += usize::from(whole.width() > 1.05 * first.width().max(second.width()));
    }
    assert!(disjoint <= 1 && wider <= 2, "{disjoint} {wider}");
}

#[test]
fn a_known_window_widens_nothing() {
    for length in 2..12 {
        let counts = record(Kind::Mean(length as usize), length.into());
        let window = BoxcarWindow { length, decimation: 1.0 };
        let (known, unknown) = (fitted_runs(&[(&counts, 0)], Some(window)), fitted(&counts));
        assert!(known.width() < 1.05 * unknown.width(), "{length}: {} {}", known.width(), unknown.width());
    }
}

#[test]
fn lost_samples_widen_by_what_they_took() {
    let numbers = || (0..16).filter(|number| number % 4 < 3);
    let records: Vec<_> = numbers().map(|number| record(kind(number), number + 300)).collect();
    let whole: Vec<f64> = records.iter().map(|counts| fitted(counts).width()).collect();
    // without a whole segment of the spectrum a fifth costs more than its share
    for (run, lost, most) in [(99, 1, 1.3), (380, 20, 1.3), (400, 100, 1.3), (16, 4, 1.5)] {
        let width = |counts: &Vec<i32>| {
            let runs = counts.chunks(run + lost).map(|run| (&run[..run.len() - lost], lost as u64));
            fitted_runs(&runs.collect::<Vec<_>>(), None).width()
        };
        let mut changes: Vec<f64> = records.iter().zip(&whole).map(|(counts, whole)| width(counts) / whole).collect();
        changes.sort_unstable_by(f64::total_cmp);
        let median = changes[changes.len() / 2];
        assert!((0.8..most).contains(&median), "{median} after {lost} lost of {run}");
    }
}

/// N²/m is never above an octave: the bound holds for all octaves together, and no filter that is
/// looked for is remembered by these.
#[test]
fn white_noise_is_not_above_what_the_curve_leaves() {
    for number in 0..16 {
        let found = fitted(&record(kind(number), number + 400));
        let freedom = |octave: &Octave| edf(octave, &found.shape, PowerLaw::RandomWalk).filter(|edf| *edf >= 10.0);
        let long = found.octaves.iter().zip(&found.variances).filter(|(octave, _)| octave.m >= 256);
        let long: Vec<(f64, f64)> =
            long.filter_map(|(octave, variance)| Some((octave.m as f64 * variance, freedom(octave)?))).collect();
        let each = 0.01 / long.len() as f64;
        let bound = |(square, edf): &(f64, f64)| square * edf / chi_squared::quantile(each, *edf).unwrap();
        let least = long.iter().map(bound).fold(f64::INFINITY, f64::min).sqrt();
        let (lower, upper) = found.white();
        assert!(upper <= least.max(lower) * (1.0 + 1e-9), "{number}: {lower} to {upper}, the curve leaves {least}");
        assert!(found.of(Term::White).status != Status::ModelRejected, "{number}");
    }
}

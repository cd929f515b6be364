//! The effect of missing samples on the variance of noise in windows that lack some.

use imu_noise::{
    ChannelCurve, Deviation, Estimator, NoiseModel, Octave, OctaveSum, Octaves, PowerLaw, RecordShape, Term, Terms,
};

use crate::synthetic::Synthesis;

const SAMPLES: usize = 1 << 13;

/// Pseudo-random numbers from 0 to 1.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// The samples that arrive, if `share` of them are lost in runs of this mean length; losses are
/// independent of each other if it is 1 / (1 - share).
fn arrived(samples: usize, share: f64, run: f64, state: &mut u64) -> Vec<bool> {
    let mut is_lost = false;
    let begins = share / (1.0 - share) / run;
    let arrived = (0..samples).map(|_| {
        is_lost = uniform(state) < if is_lost { 1.0 - 1.0 / run } else { begins };
        !is_lost
    });
    arrived.collect()
}

/// Of the values in counts of a thousandth.
fn sums(values: &[f64], arrived: &[bool]) -> Vec<OctaveSum> {
    let mut octaves = Octaves::new(Estimator::Strided, Deviation::Allan);
    let mut rest = values;
    for run in arrived.chunk_by(|a, b| a == b) {
        let (now, later) = rest.split_at(run.len());
        if run[0] {
            octaves.push(&now.iter().map(|value| (value * 1000.0).round() as i32).collect::<Vec<_>>());
        } else {
            octaves.gap(Some(run.len() as u64));
        }
        rest = later;
    }
    octaves.sums().collect()
}

fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64)
}

const LAWS: [PowerLaw; 3] = [PowerLaw::White, PowerLaw::Flicker, PowerLaw::RandomWalk];

/// Octaves that are tested: the longest have too few degrees of freedom for a hundred records.
const OCTAVES: usize = 10;

#[test]
fn one_percent_lost_loses_at_most_a_tenth_of_the_information() {
    const RECORDS: usize = 300;
    let mut synthesis = Synthesis::new(SAMPLES, 3);
    let mut state = 1;
    let mut variances = vec![[const { (Vec::new(), Vec::new()) }; OCTAVES]; 3];
    for _ in 0..RECORDS {
        let (white, flicker, walk) = synthesis.next_record();
        let lossy = arrived(SAMPLES, 0.01, 1.0 / 0.99, &mut state);
        for ((noise, law), variances) in [white, flicker, walk].iter().zip(&LAWS).zip(&mut variances) {
            let of = |arrived: &[bool]| sums(noise, arrived);
            for ((all, left), variances) in of(&[true; SAMPLES]).iter().zip(of(&lossy)).zip(variances) {
                variances.0.push(all.variance_counts2().unwrap());
                // relative to the expected variance of the noise in these windows
                let octave = left.octave();
                let expected = octave.expected_variance(Deviation::Allan, *law)
                    / Octave::whole(octave.m, 1).expected_variance(Deviation::Allan, *law);
                variances.1.push(left.variance_counts2().unwrap() / expected);
            }
        }
    }
    for (law, variances) in LAWS.iter().zip(&variances) {
        for (k, (all, left)) in variances.iter().enumerate() {
            let ((mean, variance), (mean_left, variance_left)) = (mean_and_variance(all), mean_and_variance(left));
            let kept = variance / variance_left * (mean_left / mean).powi(2);
            println!("{law:?}, m = {}: {kept:.3} of the information, bias {:+.4}", 1 << k, mean_left / mean - 1.0);
            // 300 pairs of records, which differ in few windows, show it to 2 %
            assert!(kept > 0.9, "{law:?}, m = {}: {kept}", 1 << k);
            assert!((mean_left / mean - 1.0).abs() < 0.003, "{law:?}, m = {}: {mean_left}, not {mean}", 1 << k);
        }
    }
}

/// The expected difference of a random walk over these samples, squared and halved, from the
/// distances of all pairs of samples.
fn of_walk(window: &[bool]) -> Option<(f64, f64)> {
    let m = window.len() / 2;
    let places = |range: std::ops::Range<usize>| range.filter(|i| window[*i]).map(|i| i as f64).collect::<Vec<_>>();
    let [first, second] = [places(0..m), places(m..2 * m)];
    if 2 * first.len().min(second.len()) < m {
        return None;
    }
    let distance = |a: &[f64], b: &[f64]| {
        let sum: f64 = a.iter().flat_map(|a| b.iter().map(move |b| (a - b).abs())).sum();
        sum / (a.len() * b.len()) as f64
    };
    let square = distance(&first, &second) - (distance(&first, &first) + distance(&second, &second)) / 2.0;
    let share = 2.0 / m as f64 / (1.0 / first.len() as f64 + 1.0 / second.len() as f64);
    Some((share, share * square / 2.0))
}

#[test]
fn a_random_walk_agrees_with_its_distances_within_the_stated_bounds() {
    let mut state = 5;
    // share lost, mean length of a run, and the tolerance of the expectation from the share alone
    for (lost, run, bound) in
        [(0.01, 1.0 / 0.99, 0.002), (0.3, 1.0 / 0.7, 0.005), (0.05, 10.0, 0.005), (0.1, 30.0, 0.01), (0.3, 10.0, 0.03)]
    {
        let arrived = arrived(1 << 16, lost, run, &mut state);
        for m in [4, 16, 64] {
            let windows: Vec<_> = arrived.windows(2 * m).step_by(5 + m / 4).filter_map(of_walk).collect();
            let mean = |of: fn(&(f64, f64)) -> f64| windows.iter().map(of).sum::<f64>() / windows.len() as f64;
            let share_present = mean(|window| window.0);
            let octave = Octave { m: m as u64, terms: windows.len() as u64, share_present };
            let expected = octave.expected_variance(Deviation::Allan, PowerLaw::RandomWalk);
            let off = mean(|window| window.1) / expected - 1.0;
            println!("{lost} lost in runs of {run}, m = {m}: share {share_present:.3}, {off:+.4}");
            assert!(off.abs() < bound, "{lost} lost in runs of {run}, m = {m}: {off}");
        }
    }
}

#[test]
fn records_that_lack_three_of_ten_samples_are_fitted_all_the_same() {
    const RECORDS: usize = 40;
    let (mut synthesis, mut state) = (Synthesis::new(SAMPLES, 7), 11);
    let mut held = [0; 2];
    for _ in 0..RECORDS {
        let (white, _, walk) = synthesis.next_record();
        let values: Vec<f64> = white.iter().zip(&walk).map(|(white, walk)| white + 0.02 * walk).collect();
        let sums = sums(&values, &arrived(SAMPLES, 0.3, 1.0 / 0.7, &mut state));
        let octaves: Vec<_> = sums.iter().map(OctaveSum::octave).collect();
        let variances: Vec<_> = sums.iter().map(|sum| sum.variance_counts2().unwrap() / 1e6).collect();
        let shape = RecordShape {
            samples: SAMPLES as u64,
            interval_s: 1.0,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let model = NoiseModel::new(&octaves, &shape, Terms::RATE, None);
        let fit = model.fit(&ChannelCurve::new(&variances, true), 0.95);
        assert!(fit.quality.is_some(), "{fit:?}");
        for (held, (term, truth)) in held.iter_mut().zip([(Term::White, 1.0), (Term::RateRandomWalk, 0.02)]) {
            let parameter = fit.parameter(term).unwrap();
            let (lower, upper) = (parameter.lower.unwrap_or(0.0), parameter.upper.unwrap_or(f64::INFINITY));
            *held += usize::from((lower..=upper).contains(&truth));
        }
    }
    // 95 %; fewer occur by chance once in a thousand
    assert!(held.iter().all(|held| *held >= RECORDS - 7), "{held:?}");
}

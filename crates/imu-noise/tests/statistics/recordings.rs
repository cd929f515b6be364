//! Real recordings. One at rest with a vibration line: white noise is found in spite of it, and no
//! false term. One shaken by hand: detected.
//!
//! Reads the folder named by `VN100_CAPTURES`; skipped if there is none.

use std::{env, fs, path::Path};

use imu_noise::{
    ChannelCurve, ChannelSignal, Deviation, Estimator, FitQuality, LevelSearch, NoiseModel, Octaves, RecordShape,
    SpectrumPlan, Status, Term, Terms, counts_to_unit,
};

#[test]
fn white_noise_is_measured_with_a_vibration_line() {
    let Some(text) = recording("vn100-static-kiran-330s.vnymr") else { return };
    // (field of the line, decimals, N of the spectrum between the lines)
    for (field, decimals, white) in [(11, 6, 1.21e-4), (8, 3, 2.0e-3)] {
        let counts = counts(&text, field);
        assert!(counts.len() > 13_000, "{} samples", counts.len());
        let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
        sums.push(&counts);
        let shape = RecordShape {
            samples: counts.len() as u64,
            interval_s: 0.025,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
        let variances: Vec<_> =
            sums.sums().map(|sum| counts_to_unit(sum.variance_counts2().unwrap(), 2 * decimals)).collect();
        let signal = signal(&counts);
        let bands = signal.narrow_bands(counts_to_unit(1.0, decimals));
        let signal_and_unit = Some((&signal, counts_to_unit(1.0, decimals)));
        let curve = ChannelCurve { bands: &bands, signal: signal_and_unit, ..ChannelCurve::new(&variances, true) };
        let fit = NoiseModel::new(&octaves, &shape, Terms::RATE, None).fit(&curve, 0.95);
        let found = fit.parameter(Term::White).unwrap();
        let quality: FitQuality = fit.quality.unwrap();
        assert_eq!(found.status, Status::Estimated);
        assert!((found.value.unwrap() / white - 1.0).abs() < 0.1, "{found:?}");
        assert!(quality.p >= 0.01, "{quality:?}");
    }
}

/// First field of acceleration and of angular rate, three each.
const INERTIAL: std::ops::RangeInclusive<usize> = 7..=12;

#[test]
fn the_vibration_line_is_the_only_finding_of_a_record_at_rest() {
    let Some(text) = recording("vn100-static-kiran-330s.vnymr") else { return };
    for field in INERTIAL {
        let signal = signal(&counts(&text, field));
        assert_eq!(signal.disturbances(0.025), [], "field {field}");
        assert_eq!(LevelSearch::of([&signal]).find(&signal, 0.025, 0).change, None, "field {field}");
    }
    let bands = signal(&counts(&text, 11)).narrow_bands(1e-6);
    let lines: Vec<_> = bands.iter().filter_map(|band| band.line(0.025)).collect();
    let strongest = lines.iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).unwrap();
    assert!((strongest.frequency_hz - 18.4).abs() < 0.3, "{lines:?}");
    // half a standard deviation is 0.00055 rad/s
    assert!((5e-4..1.1e-3).contains(&strongest.amplitude), "{lines:?}");
}

#[test]
fn a_record_shaken_by_hand_is_not_of_one_piece() {
    let Some(text) = recording("vn100-shake-iwale-153s.vnymr") else { return };
    let disturbed = INERTIAL.filter(|&field| {
        let signal = signal(&counts(&text, field));
        !signal.disturbances(0.025).is_empty() || LevelSearch::of([&signal]).find(&signal, 0.025, 0).change.is_some()
    });
    assert!(disturbed.count() >= 2);
}

fn recording(file: &str) -> Option<String> {
    let folder = env::var_os("VN100_CAPTURES").filter(|folder| Path::new(folder).is_dir());
    let Some(folder) = folder else {
        println!("skipped: no captures, VN100_CAPTURES names no folder of them");
        return None;
    };
    Some(fs::read_to_string(Path::new(&folder).join(file)).unwrap())
}

fn counts(text: &str, field: usize) -> Vec<i32> {
    let lines = text.lines();
    lines.filter_map(|line| line.split('*').next()?.split(',').nth(field)?.replace('.', "").parse().ok()).collect()
}

fn signal(counts: &[i32]) -> ChannelSignal {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    signal.push(counts);
    signal
}

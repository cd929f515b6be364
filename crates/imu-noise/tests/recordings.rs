//! A real static recording with a vibration line: white noise is found beside it, and nothing is invented.
//!
//! Reads the folder named by `VN100_CAPTURES`; skipped where there is none.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::{env, fs, path::Path};

use imu_noise::{
    ChannelAccumulator, Deviation, Estimator, FitQuality, NoiseModel, RecordShape, Status, Term, Terms, counts_to_unit,
};

#[test]
fn white_noise_is_read_beside_a_vibration_line() {
    let folder = env::var_os("VN100_CAPTURES").filter(|folder| Path::new(folder).is_dir());
    let Some(folder) = folder else {
        println!("skipped: no captures, VN100_CAPTURES names no folder of them");
        return;
    };
    let text = fs::read_to_string(Path::new(&folder).join("vn100-static-kiran-330s.vnymr")).unwrap();
    // (field of the line, decimals, N of the octaves that do not show the line, shortest averaging time at most)
    for (field, decimals, white, tau_min_s) in [(11, 6, 1.26e-4, 0.2), (8, 3, 2.0e-3, 0.8)] {
        let counts: Vec<i32> = text
            .lines()
            .filter_map(|line| line.split('*').next()?.split(',').nth(field)?.replace('.', "").parse().ok())
            .collect();
        assert!(counts.len() > 13_000, "{} samples", counts.len());
        let mut channel = ChannelAccumulator::new(Estimator::Strided, Deviation::Allan);
        channel.push(&counts);
        let shape = RecordShape {
            samples: counts.len() as u64,
            interval_s: 0.025,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let octaves: Vec<_> = channel.octaves().sums().map(|sum| sum.octave()).collect();
        let variances: Vec<_> =
            channel.octaves().sums().map(|sum| counts_to_unit(sum.variance_counts2().unwrap(), 2 * decimals)).collect();
        let slope = channel.slope_counts().map(|slope| counts_to_unit(slope, decimals) / shape.interval_s);
        let fit = NoiseModel::new(&octaves, &shape, Terms::RATE, None).fit(&variances, slope, 0.95);
        let found = fit.parameter(Term::White).unwrap();
        let quality: FitQuality = fit.quality.unwrap();
        assert_eq!(found.status, Status::Estimated);
        assert!((found.value.unwrap() / white - 1.0).abs() < 0.1, "{found:?}");
        assert!(quality.tau_min_s > 0.025 && quality.tau_min_s <= tau_min_s, "{quality:?}");
    }
}

//! The cascade at every number of windows per averaging time, against exact tables.

use super::Cascade;
use crate::accumulate::{octaves::window_plan::WindowPlans, record::Deviation, stretch::Stretch};
use crate::oracle;

/// Compares with the rows `sadevR` and `shdevR` of `stream`; returns their number.
fn check(file: &str, stream: &str, runs: &[(u64, &[i32])]) -> usize {
    let rows = oracle::rows(file);
    let mut used = 0;
    for (prefix, deviation) in [("sadev", Deviation::Allan), ("shdev", Deviation::Hadamard)] {
        for windows_per_tau in [2, 4, 8, 16] {
            let stat = format!("{prefix}{windows_per_tau}");
            let mut cascade = Cascade::new(windows_per_tau, deviation);
            for &(missing, counts) in runs {
                cascade.gap(Some(missing));
                for counts in counts.chunks(Stretch::MOST) {
                    cascade.push(counts, &Stretch::full(counts.len()), &mut WindowPlans::new());
                }
            }
            for row in rows.iter().filter(|row| row.stat == stat && row.stream == stream) {
                let (squares, ..) = cascade.octave(row.m.ilog2() as usize).unwrap();
                assert_eq!(squares.terms, row.terms, "windows of {stat} at m = {}", row.m);
                assert_eq!(squares.sum, Some(row.sum_squares), "{stat} at m = {}", row.m);
                used += 1;
            }
        }
    }
    used
}

#[test]
fn nist1000_exact() {
    assert_eq!(check("nist1000_exact.csv", "", &[(0, &oracle::nist1000())]), 72);
}

#[test]
fn imu_b_gyro_white_flicker_rrw_devs() {
    let counts = oracle::series("imu_b_gyro_white_flicker_rrw.txt");
    assert_eq!(check("imu_b_gyro_white_flicker_rrw_devs.csv", "", &[(0, &counts)]), 100);
}

#[test]
fn imu_a_gaps() {
    let counts = oracle::series("imu_a_acc_white.txt");
    assert_eq!(check("imu_a_gaps.csv", "", &oracle::with_gaps(&counts)), 84);
}

#[test]
fn lcg_long() {
    assert_eq!(check("lcg_long.csv", "acc", &[(0, &oracle::long_acc())]), 105);
    assert_eq!(check("lcg_long.csv", "gyro", &[(0, &oracle::long_gyro())]), 105);
}

//! Octave sums against exact tables, published tables, and the definition.

use imu_noise::{Deviation, Estimator, OctaveSum, Octaves};

use crate::oracle::{self, Row, rows, series};

const STATISTICS: [(&str, Estimator, Deviation); 6] = [
    ("adev", Estimator::Plain, Deviation::Allan),
    ("oadev", Estimator::Full, Deviation::Allan),
    ("sadev16", Estimator::Strided, Deviation::Allan),
    ("hdev", Estimator::Plain, Deviation::Hadamard),
    ("ohdev", Estimator::Full, Deviation::Hadamard),
    ("shdev16", Estimator::Strided, Deviation::Hadamard),
];

fn one_pass(estimator: Estimator, deviation: Deviation, counts: &[i32]) -> Vec<OctaveSum> {
    let mut octaves = Octaves::new(estimator, deviation);
    octaves.push(counts);
    octaves.sums().collect()
}

/// Compares with all rows of the six statistics, both ways; returns the number of rows.
fn check(rows: &[Row], scale: f64, sums_of: impl Fn(Estimator, Deviation) -> Vec<OctaveSum>) -> usize {
    let mut used = 0;
    for (stat, estimator, deviation) in STATISTICS {
        let rows: Vec<_> = rows.iter().filter(|row| row.stat == stat).collect();
        if rows.is_empty() {
            continue;
        }
        let sums = sums_of(estimator, deviation);
        assert_eq!(sums.len(), rows.len(), "number of octaves of {stat}");
        for (sum, row) in sums.iter().zip(rows) {
            assert_eq!((sum.m, sum.whole_terms()), (row.m, row.terms), "{stat}: m, windows");
            assert_eq!(sum.sum_squares, Some(row.sum_squares), "{stat} at m = {}", row.m);
            if let Some(expected) = row.deviation {
                let found = sum.deviation_counts().unwrap() * scale;
                let error = (found / expected - 1.0).abs();
                assert!(error <= 1e-13, "{stat} at m = {}: {found}, not {expected}", row.m);
            }
            used += 1;
        }
    }
    used
}

fn check_series(name: &str, scale: f64) -> usize {
    let counts = series(&format!("{name}.txt"));
    check(&rows(&format!("{name}_devs.csv")), scale, |estimator, deviation| one_pass(estimator, deviation, &counts))
}

#[test]
fn nist1000_exact() {
    let counts = oracle::nist1000();
    let scale = 1.0 / 2_147_483_647.0;
    let used =
        check(&rows("nist1000_exact.csv"), scale, |estimator, deviation| one_pass(estimator, deviation, &counts));
    assert_eq!(used, 54);
}

#[test]
fn nbs14_exact() {
    let used =
        check(&rows("nbs14_exact.csv"), 1.0, |estimator, deviation| one_pass(estimator, deviation, &oracle::NBS14));
    assert_eq!(used, 15);
}

#[test]
fn any_factor_has_the_exact_and_the_published_sum() {
    let (mut exact, mut printed) = (0, 0);
    for (name, counts, scale, tolerance) in
        [("nist1000", oracle::nist1000(), 1.0 / 2_147_483_647.0, 5e-7), ("nbs14", oracle::NBS14.to_vec(), 1.0, 1e-6)]
    {
        for (stat, estimator, deviation) in
            STATISTICS.into_iter().filter(|(_, estimator, _)| *estimator == Estimator::Full)
        {
            let mut octaves = Octaves::new(estimator, deviation);
            octaves.push(&counts);
            for row in oracle::rows_of_any_factor(&format!("{name}_exact.csv")).iter().filter(|row| row.stat == stat) {
                let sum = octaves.sum_at(row.m).unwrap();
                assert_eq!((sum.m, sum.terms, sum.sum_squares), (row.m, row.terms, Some(row.sum_squares)), "{stat}");
                exact += 1;
            }
            for (_, m, expected) in
                oracle::published(&format!("{name}_published.csv")).iter().filter(|row| row.0 == stat)
            {
                let found = octaves.sum_at(*m).and_then(|sum| sum.deviation_counts()).unwrap() * scale;
                assert!((found / expected - 1.0).abs() <= tolerance, "{stat} at m = {m}: {found}, not {expected}");
                printed += 1;
            }
        }
    }
    assert_eq!((exact, printed), (29, 10));
}

#[test]
fn imu_a_acc_white_devs() {
    assert_eq!(check_series("imu_a_acc_white", 1e-3), 75);
}

#[test]
fn imu_b_gyro_white_flicker_rrw_devs() {
    assert_eq!(check_series("imu_b_gyro_white_flicker_rrw", 1e-6), 75);
}

#[test]
fn imu_c_mag_white_flicker_ramp_devs() {
    assert_eq!(check_series("imu_c_mag_white_flicker_ramp", 1e-4), 75);
}

#[test]
fn imu_a_gaps() {
    let counts = series("imu_a_acc_white.txt");
    let used = check(&rows("imu_a_gaps.csv"), 1.0, |estimator, deviation| {
        let mut octaves = Octaves::new(estimator, deviation);
        for (missing, run) in oracle::with_gaps(&counts) {
            octaves.gap(Some(missing));
            octaves.push(run);
        }
        // the table has no windows with missing samples
        octaves.sums().filter(|sum| sum.whole_terms() > 0).collect()
    });
    assert_eq!(used, 62);
}

#[test]
fn lcg_long() {
    let rows = rows("lcg_long.csv");
    let (acc, gyro): (Vec<_>, Vec<_>) = rows.into_iter().partition(|row| row.stream == "acc");
    let mut used = 0;
    for (rows, counts) in [(acc, oracle::long_acc()), (gyro, oracle::long_gyro())] {
        used += check(&rows, 1.0, |estimator, deviation| up_to_2_20(one_pass(estimator, deviation, &counts)));
    }
    assert_eq!(used, 210);
}

/// The table of the long streams ends at this factor.
fn up_to_2_20(sums: Vec<OctaveSum>) -> Vec<OctaveSum> {
    sums.into_iter().filter(|sum| sum.m <= 1 << 20).collect()
}

//! Reads the reference tables and series of `tests/data`.
#![allow(dead_code, reason = "each test target uses a part")]
#![allow(clippy::panic, reason = "a test fails by panicking")]

use std::{fs, path::Path};

/// One row of a table of exact sums.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) stream: String,
    pub(crate) stat: String,
    pub(crate) m: u64,
    pub(crate) terms: u64,
    pub(crate) sum_squares: u128,
    /// Absent in tables of sums.
    pub(crate) deviation: Option<f64>,
}

pub(crate) fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

pub(crate) fn json(file: &str) -> serde_json::Value {
    serde_json::from_str(&text(file)).unwrap()
}

/// Rows of a table as (column name, field) pairs.
pub(crate) fn table(file: &str) -> Vec<Vec<(String, String)>> {
    let text = text(file);
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<_> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| names.iter().zip(line.split(',')).map(|(&name, field)| (name.into(), field.into())).collect())
        .collect()
}

pub(crate) fn field<'a>(row: &'a [(String, String)], name: &str) -> Option<&'a str> {
    row.iter().find(|(column, _)| column == name).map(|(_, field)| field.as_str())
}

/// The rows of a table whose averaging factor is a power of two and that have a window.
pub(crate) fn rows(file: &str) -> Vec<Row> {
    rows_of_any_factor(file).into_iter().filter(|row| row.m.is_power_of_two()).collect()
}

/// The rows of a table that have a window.
pub(crate) fn rows_of_any_factor(file: &str) -> Vec<Row> {
    let rows = table(file).into_iter().map(|row| Row {
        stream: field(&row, "stream").unwrap_or_default().to_string(),
        stat: field(&row, "stat").unwrap().to_string(),
        m: field(&row, "m").unwrap().parse().unwrap(),
        terms: field(&row, "n_terms").unwrap().parse().unwrap(),
        sum_squares: field(&row, "sum_sq_counts").unwrap().parse().unwrap_or(u128::MAX),
        deviation: field(&row, "deviation").map(|field| field.parse().unwrap()),
    });
    rows.filter(|row| row.terms > 0).collect()
}

/// (statistic, m, deviation) of a published table.
pub(crate) fn published(file: &str) -> Vec<(String, u64, f64)> {
    let rows = table(file).into_iter().map(|row| {
        let number = |name| field(&row, name).unwrap().to_string();
        (number("stat"), number("m").parse().unwrap(), number("deviation").parse().unwrap())
    });
    rows.collect()
}

/// The counts of a series of fixed-point numbers, one per line.
pub(crate) fn series(file: &str) -> Vec<i32> {
    let text = text(file);
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.replace('.', "").parse().unwrap()).collect()
}

/// NIST SP 1065 1000-point suite.
pub(crate) fn nist1000() -> Vec<i32> {
    lehmer().take(1000).map(|state| i32::try_from(state).unwrap()).collect()
}

/// Nine-point suite of NBS Monograph 140.
pub(crate) const NBS14: [i32; 9] = [892, 809, 823, 798, 671, 644, 883, 903, 677];

pub(crate) const LONG_STREAM_SAMPLES: usize = 4_206_649;

/// The stream `acc` of `lcg_long.csv`.
pub(crate) fn long_acc() -> Vec<i32> {
    lehmer().take(LONG_STREAM_SAMPLES).map(|state| -9800 + (state % 61) as i32 - 30).collect()
}

/// The stream `gyro` of `lcg_long.csv`.
pub(crate) fn long_gyro() -> Vec<i32> {
    let mut walk = 0;
    let counts = lehmer().take(LONG_STREAM_SAMPLES).map(|state| {
        walk += (state / 1000 % 3) as i32 - 1;
        1200 + (state % 1001) as i32 - 500 + walk
    });
    counts.collect()
}

fn lehmer() -> impl Iterator<Item = u64> {
    std::iter::successors(Some(1_234_567_890), |state| Some(16807 * state % 2_147_483_647))
}

/// Ranges of `imu_a_gaps.csv` that are present, each with the number of missing samples before it.
pub(crate) fn with_gaps(counts: &[i32]) -> Vec<(u64, &[i32])> {
    const MISSING: [(usize, usize); 6] =
        [(137, 137), (1000, 1003), (2048, 2303), (4999, 5600), (8191, 8192), (9990, 9999)];
    let mut start = 0;
    let mut before = 0;
    let mut runs = Vec::new();
    for (first, last) in MISSING {
        runs.push((before, &counts[start..first]));
        before = (last - first + 1) as u64;
        start = last + 1;
    }
    runs
}

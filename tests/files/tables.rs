//! Tables of floats as other programs print them, and tables with holes.

use std::{fs, path::Path};

use serde_json::Value;

use crate::support::{channel, deviation, replay, warned};

const ROWS: i64 = 4096;

/// Rate, acceleration and temperature of a row.
fn row(row: i64) -> [f64; 3] {
    [
        ((row * 7919) % 1009 - 504) as f64 * 1e-4 / 7.0,
        9.8 + ((row * row * 31) % 997 - 498) as f64 * 1e-3 / 9.0,
        20.5 + 7.5 * row as f64 / ROWS as f64,
    ]
}

/// The results of allantools 2024.6 for these numbers: `oadev(x, rate=100, data_type="freq")` at
/// averaging factors 1, 2, 4, 8, 16.
const OADEV: [(&str, [f64; 5]); 3] = [
    ("gyro_x", [0.003655821054792, 0.003750786931431, 0.002428463884962, 0.0008580870895163, 0.0006994016238008]),
    ("accel_x", [0.03257967456841, 0.02341063006892, 0.01658393498407, 0.01118574538723, 0.007363112428224]),
    ("temperature", [0.001294751186255, 0.002589502372509, 0.005179004745019, 0.01035800949004, 0.02071601898007]),
];

/// Measures a file of these columns and rows.
fn measured(path: &Path, header: &str, separator: &str, print: impl Fn(i64, usize, f64) -> String) -> Value {
    let line = |at: i64| {
        let fields = row(at).into_iter().enumerate().map(|(column, value)| print(at, column, value));
        fields.collect::<Vec<_>>().join(separator) + "\n"
    };
    fs::write(path, format!("{header}\n{}", (0..ROWS).map(line).collect::<String>())).unwrap();
    let (document, exit) = replay(path, &["--rate", "100"]);
    assert_eq!(exit, 0, "{document}");
    document
}

#[test]
fn floats_of_any_program_have_the_deviations_of_allantools() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table");
    let csv = "gyro_x,accel_x,temperature";
    // plain numpy.savetxt; a data frame of pandas; a spreadsheet; eight decimals, with which 28 °C does not fit 32 bits
    let documents = [
        (measured(&path, "# gyro_x accel_x temperature", " ", |_, _, value| format!("{value:.18e}")), 1e-7),
        (measured(&path, csv, ",", |_, _, value| format!("{value}")), 1e-7),
        (measured(&path, &csv.replace(',', ";"), ";", |_, _, value| format!("{value}").replace('.', ",")), 1e-7),
        (measured(&path, csv, ",", |_, _, value| format!("{value:.8}")), 1e-5),
    ];
    for (document, tolerance) in documents {
        let csv = &document["source"]["csv"];
        assert_eq!(
            (&csv["rows"], &csv["odd"], &csv["absent"]),
            (&ROWS.into(), &Value::Array(vec![]), &Value::Array(vec![]))
        );
        for (name, expected) in OADEV {
            for (m, expected) in [1, 2, 4, 8, 16].into_iter().zip(expected) {
                let found = deviation(&document, name, m);
                assert!((found / expected - 1.0).abs() < tolerance, "{name} {m}: {found} {expected}");
            }
            assert_eq!(channel(&document, name)["statistics"]["count"], ROWS);
        }
        let resolution = channel(&document, "temperature")["statistics"]["resolution"].as_f64().unwrap();
        assert!(resolution <= 28.0 * 2_f64.powi(-27), "{resolution}");
    }
}

#[test]
fn a_hole_affects_only_its_own_channel() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let header = "gyro_x,accel_x,temperature";
    let whole = measured(&path, header, ",", |_, _, value| format!("{value}"));
    let hole = |at: i64, column| column == 1 && at % 100 == 7;
    let holed = measured(&path, header, ",", |at, column, value| {
        if hole(at, column) { ["", "nan", "-inf"][at as usize / 100 % 3].into() } else { format!("{value}") }
    });
    assert_eq!(holed["timing"]["samples"], ROWS);
    for name in ["gyro_x", "temperature"] {
        assert_eq!(channel(&holed, name), channel(&whole, name), "{name}");
    }
    let csv = &holed["source"]["csv"];
    let absent = r#"[{"channel":"accel_x","empty":14,"not_a_number":27,"out_of_range":0,"first_line":9}]"#;
    assert_eq!(csv["absent"], serde_json::from_str::<Value>(absent).unwrap());
    assert_eq!((&csv["rows"], &channel(&holed, "accel_x")["statistics"]["count"]), (&ROWS.into(), &(ROWS - 41).into()));
    assert!(warned(&holed, "gaps") && !warned(&whole, "gaps"));
    // a magnetometer at a tenth of the rate
    let sparse = measured(&path, "gyro_x,mag_x,temperature", ",", |at, column, value| {
        if column == 1 && at % 10 > 0 { String::new() } else { format!("{value}") }
    });
    let warnings = sparse["warnings"].as_array().unwrap();
    let warning = warnings.iter().find(|warning| warning["kind"] == "gaps").unwrap();
    assert!(warning["text"].as_str().unwrap().contains("belong in a file of their own"), "{warning}");
    assert_eq!(channel(&sparse, "gyro_x")["allan"], channel(&whole, "gyro_x")["allan"]);
}

#[test]
fn units_come_from_the_header_and_are_doubted_if_implausible() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let of = |header: &str| {
        let rows: String = (0..400)
            .map(|at| format!("0.001,{:.3},{:.3}\n", 0.01 * f64::from(at % 3), 1.0 - 0.001 * f64::from(at % 5)))
            .collect();
        fs::write(&path, format!("{header}\n{rows}")).unwrap();
        replay(&path, &["--rate", "100"]).0
    };
    let doubted = of("accel_x,accel_y,accel_z");
    let warnings = doubted["warnings"].as_array().unwrap();
    let warning = warnings.iter().find(|warning| warning["kind"] == "unit-doubtful").unwrap();
    let text = warning["text"].as_str().unwrap();
    assert!(text.contains("--columns 'accel_x=accel_x:g, accel_y=accel_y:g, accel_z=accel_z:g'"), "{text}");
    let (cured, _) =
        replay(&path, &["--rate", "100", "--columns", "accel_x=accel_x:g,accel_y=accel_y:g,accel_z=accel_z:g"]);
    assert!(!warned(&cured, "unit-doubtful"));
    let said = of("accel_x [g],accel_y [g],accel_z [g]");
    assert!(!warned(&said, "unit-doubtful"));
    assert_eq!(channel(&said, "accel_z")["statistics"], channel(&cured, "accel_z")["statistics"]);
}

#[test]
fn the_rate_of_a_table_is_that_of_all_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.csv");
    // rows up to 3 ms late, in a sequence that repeats after 97 rows
    let row =
        |row: u64| format!("{:.6},{:.4},9.8\n", row as f64 / 40.0005 + (row * 31 % 97) as f64 * 3e-3 / 97.0, row % 7);
    fs::write(&path, "time,gyro_x,accel_z\n".to_owned() + &(0..20_000).map(row).collect::<String>()).unwrap();
    let (document, _) = replay(&path, &[]);
    let rate_hz = document["timing"]["rate_hz"].as_f64().unwrap();
    // the first and the last row may be late by 3 ms of 500 s
    assert!((rate_hz / 40.0005 - 1.0).abs() < 6e-6, "{rate_hz}");
}

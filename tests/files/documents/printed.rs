//! The shown output in a document equals the output of the program.

use super::shown::documents;
use crate::{
    numbers::reference,
    support::{capture, channel, vn100, workspace},
};

/// How far the noise of two records of one emulated sensor may be apart: of one that is measured
/// live the first sample is a matter of chance.
const NEAR: f64 = 0.03;

/// Its words, with a `#` for each number.
fn words(line: &str) -> String {
    let is_number = |word: &&str| word.trim_start_matches(['+', '±']).trim_end_matches('%').parse::<f64>().is_ok();
    line.split_whitespace().map(|word| if is_number(&word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}

/// The noise density of each axis, if the line contains it.
fn densities(line: &str) -> Vec<f64> {
    let has_noise = ["ARW N", "VRW N", "Density N"].iter().any(|name| line.contains(name));
    let numbers = line.split_whitespace().filter_map(|word| word.parse().ok());
    numbers.filter(|_| has_noise).collect()
}

#[test]
fn the_summary_in_the_readme_is_that_of_five_hours_of_the_emulated_sensor() {
    let readme = documents().into_iter().find(|document| document.name == "README.md").unwrap();
    let shown = readme.blocks().into_iter().find(|block| block.language == "text").unwrap().lines;
    let folder = tempfile::tempdir().unwrap();
    let hours = capture(folder.path(), "hours.mcap", &["--message", "VNIMU", "--duration", "5h"]);
    // the window that the emulated sensor reports if it is asked
    let output = vn100().arg("replay").arg(hours).args(["--window", "4"]).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    // the first line names the source
    for (number, (shown, printed)) in shown.iter().zip(printed.lines()).enumerate().skip(1) {
        assert_eq!(words(shown), words(printed), "line {}", number + 1);
        for (shown, printed) in densities(shown).into_iter().zip(densities(printed)) {
            assert!((shown / printed - 1.0).abs() < NEAR, "line {}: {shown}, and {printed} is printed", number + 1);
        }
    }
    assert!(shown.len() > 20);
}

/// The field of a parameter in the JSON document, and SI units in one of each unit.
fn parameter(name: &str, unit: &str) -> (&'static str, f64) {
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    let field = match name {
        "N" => "white",
        "B" => "bias_instability",
        _ => "rate_random_walk",
    };
    let si = match unit {
        "deg/√h" => DEGREE / 60.0,
        "deg/h" => DEGREE / 3600.0,
        "deg/h/√h" => DEGREE / 3600.0 / 60.0,
        "m/s/√h" => 1.0 / 60.0,
        "mg" => 9.806_65e-3,
        "m/s/h/√h" => 1.0 / 3600.0 / 60.0,
        other => panic!("{other}"),
    };
    (field, si)
}

#[test]
fn the_reference_record_is_measured_as_documented() {
    let document = std::fs::read_to_string(workspace().join("docs/validation.md")).unwrap();
    let table = document.split("| axis | parameter | unit |").nth(1).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let measured = reference();
    let mut axis = String::new();
    for row in &rows {
        let [named, name, unit, _truth, shown] = row[..] else { panic!("{row:?}") };
        if let Some((sensor, letter)) = named.split(',').next().unwrap().split_once(' ') {
            axis = format!("{}_{letter}", if sensor == "gyro" { "gyro" } else { "accel" });
        }
        let (field, si) = parameter(name, unit);
        let noise = &channel(measured, &axis)["noise"][field];
        let fields = if shown.starts_with('≤') { &["upper"][..] } else { &["value", "lower", "upper"] };
        let numbers = shown.split([' ', '(', ')', '≤']).filter(|text| text.parse::<f64>().is_ok());
        let numbers: Vec<&str> = numbers.collect();
        assert_eq!(numbers.len(), fields.len(), "{row:?}");
        for (number, field) in numbers.iter().zip(fields) {
            let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let printed = noise[field].as_f64().map(|value| format!("{:.decimals$}", value / si));
            assert_eq!(printed.as_deref(), Some(*number), "{axis} {name} {field}: {noise}");
        }
    }
    assert!(rows.len() >= 8, "{rows:?}");
}

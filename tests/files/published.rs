//! Public records with the tables that were published with them. They are not part of the project:
//! without the folder `published` beside the captures these tests report this and pass.

use std::{fs, path::PathBuf};

use serde_json::Value;

use crate::support::{channel, deviation, real_captures, replay};

const COLUMNS: &str = "gyro_x=gx:deg/s,gyro_y=gy:deg/s,gyro_z=gz:deg/s,accel_x=ax:g,accel_y=ay:g,accel_z=az:g";

fn published() -> Option<PathBuf> {
    let folder = real_captures()?.join("../published");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no folder `published` beside the captures");
    None
}

/// The Allan variances of the R package `avar` and the wavelet variances of `wv`, which are half of
/// the Allan variance.
#[test]
fn the_tables_of_two_packages_are_reproduced() {
    let Some(folder) = published() else { return };
    let options = ["--columns", COLUMNS, "--rate", "100", "--estimator", "full"];
    let (document, _) = replay(&folder.join("adis16405_1.csv.xz"), &options);
    let table = fs::read_to_string(folder.join("adis16405_1_published.csv")).unwrap();
    let mut rows = 0;
    for line in table.lines().skip(2) {
        let cells: Vec<&str> = line.split(',').collect();
        let unit = if cells[0].starts_with("gyro") { 1_f64.to_radians() } else { 9.80665 };
        let ours = (deviation(&document, cells[0], cells[1].parse().unwrap()) / unit).powi(2);
        // one term less than ours, and the digits of a float sum
        for (cell, scale, tolerance) in [(cells[3], 1.0, 8e-6), (cells[4], 2.0, 1e-10)] {
            if let Ok(theirs) = cell.parse::<f64>() {
                assert!((ours / (scale * theirs) - 1.0).abs() < tolerance, "{line}: {ours}");
                rows += 1;
            }
        }
    }
    assert_eq!(rows, 216);
}

#[test]
fn each_axis_of_six_records_has_an_angle_random_walk_near_its_sheet() {
    let Some(folder) = published() else { return };
    for number in 1..=6 {
        let file = folder.join(format!("adis16405_{number}.csv.xz"));
        let (document, _) = replay(&file, &["--columns", COLUMNS, "--rate", "100"]);
        for axis in ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"] {
            let white = &channel(&document, axis)["noise"]["white"];
            assert_eq!(white["status"], "estimated", "{number} {axis}");
            if let (true, Some(value)) = (axis.starts_with("gyro"), Value::as_f64(&white["value"])) {
                // the sheet has 2.0 deg/sqrt(h) as typical
                let deg_sqrt_h = value.to_degrees() * 60.0;
                assert!((2.0..3.0).contains(&deg_sqrt_h), "{number} {axis}: {deg_sqrt_h}");
            }
        }
    }
}

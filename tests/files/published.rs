//! Public records with the tables that were published with them. They are not part of the project:
//! without the folder `published` beside the captures these tests report this and pass.

use std::{fs, path::PathBuf};

use serde_json::Value;

use crate::support::{channel, real_captures, replay, run, vn100};

const COLUMNS: &str = "gyro_x=gx:deg/s,gyro_y=gy:deg/s,gyro_z=gz:deg/s,accel_x=ax:g,accel_y=ay:g,accel_z=az:g";

fn published() -> Option<PathBuf> {
    let folder = real_captures()?.join("../published");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no folder `published` beside the captures");
    None
}

/// Allan variances of the R package `avar`, wavelet variances of `wv`.
#[test]
fn the_tables_of_two_packages_are_reproduced() {
    let Some(folder) = published() else { return };
    let output = run(vn100().args(["selftest", "--published"]).arg(folder));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{printed}");
    assert_eq!(printed.matches("    108 rows, agrees to ").count(), 2, "{printed}");
}

/// A file is known by its content alone.
#[test]
fn a_folder_without_a_known_record_has_nothing_to_compare() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("adis16405_1.csv"), "gx,gy,gz,ax,ay,az\n").unwrap();
    let output = run(vn100().args(["selftest", "--published"]).arg(folder.path()));
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8(output.stdout).unwrap().contains("nothing to compare"));
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

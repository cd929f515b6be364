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

/// The first half of a record foretells how the angle drifts in the second, after rests as long as the coast and others.
#[test]
fn the_first_half_of_each_record_foretells_the_drifts_of_the_second() {
    const COASTS: [(usize, usize); 5] = [(10, 10), (60, 60), (10, 60), (60, 10), (300, 60)];
    const RATE_HZ: usize = 100;
    let Some(folder) = published() else { return };
    let scratch = tempfile::tempdir().unwrap();
    let (mut inside, mut all) = ([0.0; COASTS.len()], [0.0; COASTS.len()]);
    for number in 1..=6 {
        let file = folder.join(format!("adis16405_{number}.csv.xz"));
        let samples = scratch.path().join("samples.csv");
        let read = ["--columns", COLUMNS, "--rate", "100"];
        run(vn100().arg("replay").arg(&file).args(read).arg("--quiet").arg("--samples").arg(&samples));
        let lengths = COASTS.map(|(rest, coast)| format!("{rest}+{coast}")).join(",");
        let half = [&read[..], &["--duration", "5000", "--coast", &lengths]].concat();
        let (document, _) = replay(&file, &half);
        let samples = fs::read_to_string(&samples).unwrap();
        for (column, axis) in [(3, "gyro_x"), (4, "gyro_y"), (5, "gyro_z")] {
            let rates = samples.lines().skip(1 + 5000 * RATE_HZ).map(|row| row.split(',').nth(column).unwrap());
            let angle_deg: Vec<f64> = std::iter::once(0.0)
                .chain(rates.scan(0.0, |sum, rate_rad_s| {
                    *sum += rate_rad_s.parse::<f64>().unwrap().to_degrees() / RATE_HZ as f64;
                    Some(*sum)
                }))
                .collect();
            for (place, (rest, coast)) in COASTS.into_iter().enumerate() {
                let is_it = |drift: &&Value| {
                    drift["axis"] == axis && drift["rest_s"] == rest as f64 && drift["coast_s"] == coast as f64
                };
                let drift = document["drift"].as_array().unwrap().iter().find(is_it).unwrap();
                let within_deg = drift["within"].as_f64().unwrap();
                for start in (0..angle_deg.len() - (rest + coast) * RATE_HZ).step_by((rest + coast) * RATE_HZ) {
                    let [begin, middle, end] = [0, rest, rest + coast].map(|s| angle_deg[start + s * RATE_HZ]);
                    let drifted_deg = end - middle - (middle - begin) * coast as f64 / rest as f64;
                    all[place] += 1.0;
                    inside[place] += f64::from(u8::from(drifted_deg.abs() <= within_deg));
                }
            }
        }
    }
    for (place, (rest, coast)) in COASTS.into_iter().enumerate() {
        let share = inside[place] / all[place];
        println!("rest {rest} s, coast {coast} s: {share:.3} of {}", all[place]);
        assert!(share >= 0.9, "rest {rest} s, coast {coast} s: {share} of {}", all[place]);
    }
    let share = inside.iter().sum::<f64>() / all.iter().sum::<f64>();
    assert!(share < 0.98, "{share}");
}

//! A disturbance added to a record of known noise is found, and distinguished from the record.

use super::*;

/// The angular rates of three hours of the uncompensated emulated sensor.
fn emulated_rates() -> &'static [[f64; 3]] {
    static ROWS: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let file = capture(folder.path(), "imu.vnymr", &["--message", "VNIMU", "--duration", "3h"]);
        let rates = |line: &str| {
            let mut fields = line.split(',').skip(7);
            [(); 3].map(|()| fields.next().unwrap().parse().unwrap())
        };
        fs::read_to_string(file).unwrap().lines().map(rates).collect()
    })
}

/// The same rates as a table of any sensor, each changed by `change(row, axis, rate)`.
fn rates(folder: &Path, change: &mut dyn FnMut(usize, usize, f64) -> f64) -> PathBuf {
    let mut table = String::from("t,wx,wy,wz\n");
    for (row, rates) in emulated_rates().iter().enumerate() {
        write!(table, "{}", row as f64 / 40.0).unwrap();
        for (axis, rate) in rates.iter().enumerate() {
            write!(table, ",{:.6}", change(row, axis, *rate)).unwrap();
        }
        table.push('\n');
    }
    let path = folder.join("rates.csv");
    fs::write(&path, table).unwrap();
    path
}

const COLUMNS: &str = "t=t:s,gyro_x=wx:rad/s,gyro_y=wy:rad/s,gyro_z=wz:rad/s";

#[test]
fn a_stream_whose_bias_is_tracked_is_found_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut bias = [0.0; 3];
    let path = rates(folder.path(), &mut |_, axis, rate| {
        let rest = rate - bias[axis];
        bias[axis] += rest / (30.0 * 40.0);
        rest
    });
    let (document, _) = replay(&path, &["--columns", COLUMNS]);
    assert_eq!(document["source"]["compensated"], Value::Null, "nothing in the file says so");
    assert!(warned(&document, "compensated-stream"), "{}", document["warnings"]);
    for name in ["gyro_x", "gyro_y", "gyro_z"] {
        assert_eq!(parameter(&document, name, "rate_random_walk")["status"], "not-measurable");
        assert_eq!(parameter(&document, name, "white")["status"], "estimated");
    }
    let path = rates(folder.path(), &mut |_, _, rate| rate);
    let (document, _) = replay(&path, &["--columns", COLUMNS]);
    for kind in ["compensated-stream", "vibration-line", "not-stationary", "warm-up"] {
        assert!(!warned(&document, kind), "{}", document["warnings"]);
    }
    assert_eq!(parameter(&document, "gyro_x", "bias_instability")["status"], "estimated");
}

#[test]
fn a_disturbance_is_reported_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    // the standard deviation is 8.6e-4 rad/s
    let path = rates(folder.path(), &mut |row, axis, rate| {
        let disturbance = match axis {
            0 => 1e-3 * (-(row as f64) / 12_000.0).exp(),
            1 => 4.3e-4 * (std::f64::consts::TAU * 7.3 * row as f64 / 40.0).sin(),
            _ => 0.0,
        };
        rate + disturbance
    });
    let (document, _) = replay(&path, &["--columns", COLUMNS]);
    let text = |kind: &str| {
        let warnings = document["warnings"].as_array().unwrap();
        let warning = warnings.iter().find(|warning| warning["kind"] == kind);
        warning.unwrap_or_else(|| panic!("no {kind} in {warnings:?}"))["text"].as_str().unwrap().to_owned()
    };
    let vibration = text("vibration-line");
    assert!(vibration.contains("gyro_y 7.30 Hz"), "{vibration}");
    let line = &channel(&document, "gyro_y")["spectrum"]["lines"][0];
    assert!((line["amplitude"].as_f64().unwrap() - 4.3e-4).abs() < 4e-5, "{line}");
    assert!((line["frequency_hz"].as_f64().unwrap() - 7.3).abs() < 0.01, "{line}");

    let warm_up = text("warm-up");
    assert!(warm_up.contains("gyro_x") && warm_up.contains("--skip"), "{warm_up}");
    let skip: String = warm_up.chars().skip(warm_up.find("--skip ").unwrap() + 7).take_while(|c| *c != '`').collect();
    let (cured, _) = replay(&path, &["--columns", COLUMNS, "--skip", &skip]);
    assert!(!warned(&cured, "warm-up"), "--skip {skip} does not cure it");
}

#[test]
fn a_ramp_is_found_and_the_hadamard_deviation_does_not_see_it() {
    let folder = tempfile::tempdir().unwrap();
    let ramp_rad_s2 = 1e-6;
    let path = rates(folder.path(), &mut |row, axis, rate| {
        rate + if axis == 0 { ramp_rad_s2 * row as f64 / 40.0 } else { 0.0 }
    });
    let (document, _) = replay(&path, &["--columns", COLUMNS]);
    let ramp = parameter(&document, "gyro_x", "rate_ramp");
    assert_eq!(ramp["status"], "estimated");
    assert!(holds(ramp, ramp_rad_s2), "{ramp}");
    assert_eq!(parameter(&document, "gyro_y", "rate_ramp")["status"], "bounded");
    let hadamard = |path: &Path| replay(path, &["--columns", COLUMNS, "--deviation", "hadamard"]).0;
    let ramp = hadamard(&path);
    let plain = hadamard(&rates(folder.path(), &mut |_, _, rate| rate));
    for m in [1, 1024, 16_384] {
        let ratio = deviation(&ramp, "gyro_x", m) / deviation(&plain, "gyro_x", m);
        assert!((ratio - 1.0).abs() < 2e-3, "{m}: {ratio}");
    }
}

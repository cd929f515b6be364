//! Tables of users, cut, with columns dropped and rows lost or doubled: each is read correctly, or
//! refused.

use std::{fmt::Write as _, fs, path::Path};

use serde_json::Value;

use crate::support::vn100;

/// The values of a sensor, in rad/s and m/s².
const GYRO: [f64; 3] = [0.0101, -0.0202, 0.0053];
const ACCEL: [f64; 3] = [0.05, -0.11, 9.79];

/// A form of table: its name, its header, and the factors from rad/s and m/s² to its units.
struct Form {
    file: &'static str,
    header: &'static str,
    row: fn(f64, [f64; 3], [f64; 3]) -> String,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const G: f64 = 9.80665;

const FORMS: [Form; 7] = [
    Form {
        file: "a.csv",
        header: "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z",
        row: |t, g, a| format!("{t:.3},{:.6},{:.6},{:.6},{:.5},{:.5},{:.5}", g[0], g[1], g[2], a[0], a[1], a[2]),
    },
    Form {
        file: "sdk.csv",
        header: "TimeStartup,GyroX,GyroY,GyroZ,UncompAccX,UncompAccY,UncompAccZ,UncompGyroX,UncompGyroY,UncompGyroZ",
        row: |t, g, a| {
            format!(
                "{:.0},0.9,0.9,0.9,{:.5},{:.5},{:.5},{:.6},{:.6},{:.6}",
                t * 1e9,
                a[0],
                a[1],
                a[2],
                g[0],
                g[1],
                g[2]
            )
        },
    },
    Form {
        file: "units.csv",
        header: "Time [ms];Gyro_X [deg/s];Gyro_Y [deg/s];Gyro_Z [deg/s];acc_x[mg];acc_y[mg];acc_z[mg]",
        row: |t, g, a| {
            let [gx, gy, gz] = g.map(|rate| rate / DEGREE);
            let [ax, ay, az] = a.map(|force| force / G * 1e3);
            format!("{:.0};{gx:.5};{gy:.5};{gz:.5};{ax:.3};{ay:.3};{az:.3}", t * 1e3)
        },
    },
    Form {
        file: "asl.csv",
        header: "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]",
        row: |t, g, a| joined((1_403_636_579_758_555_392_u64 + (t * 1e9) as u64).to_string(), g, a),
    },
    Form {
        file: "echo.csv",
        header: "%time,field.header.stamp,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z",
        row: |t, g, a| joined(format!("{:.0},{:.0}", 1.5e18 + 1.7e9 * t, 1.4e18 + 1e9 * t), g, a),
    },
    Form {
        file: "letters.txt",
        header: "# time tx ty tz wx wy wz",
        row: |t, g, a| format!("{t:.6} {:.6} {:.6} {:.6} {:.8} {:.8} {:.8}", a[0], a[1], a[2], g[0], g[1], g[2]),
    },
    Form {
        file: "px4.csv",
        header: "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2]",
        row: |t, g, a| format!("{:.0},{},{},{},4889,{},{},{}", 2e7 + t * 1e6, g[0], g[1], g[2], a[0], a[1], a[2]),
    },
];

fn joined(time: String, gyro: [f64; 3], accel: [f64; 3]) -> String {
    gyro.into_iter().chain(accel).fold(time, |line, number| format!("{line},{number}"))
}

/// Numbers drawn one after the other.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    fn noise(&mut self, deviation: f64) -> f64 {
        (self.next() + self.next() + self.next() - 1.5) * 2.0 * deviation
    }
}

fn table(form: &Form, draws: &mut Draws) -> Vec<String> {
    let mut lines = vec![form.header.to_owned()];
    for row in 0..1200 {
        let gyro = GYRO.map(|mean| mean + draws.noise(0.002));
        let accel = ACCEL.map(|mean| mean + draws.noise(0.02));
        lines.push((form.row)(f64::from(row) * 0.01, gyro, accel));
    }
    lines
}

/// Makes one typical change of a file. Returns the text.
fn changed(mut lines: Vec<String>, separator: char, draws: &mut Draws) -> String {
    let rows = lines.len() - 1;
    match draws.below(8) {
        // a column is dropped
        0 => {
            let place = draws.below(lines[0].split(separator).count());
            for line in &mut lines {
                let fields = line.split(separator).enumerate().filter(|(at, _)| *at != place).map(|(_, field)| field);
                *line = fields.collect::<Vec<_>>().join(&separator.to_string());
            }
        }
        // rows are lost, doubled, or in another order
        1 => {
            for _ in 0..5 {
                lines.remove(100 + draws.below(rows - 200));
            }
        }
        2 => {
            let at = 100 + draws.below(rows - 200);
            lines.insert(at, lines[at].clone());
        }
        3 => {
            let at = 100 + draws.below(rows - 200);
            lines.swap(at, at + 1);
        }
        // cut anywhere
        4 => {
            let text = lines.join("\n");
            let at = text.len() / 2 + draws.below(text.len() / 2);
            return text[..at].to_owned();
        }
        // a second header, a line of another kind, a number in words
        5 => {
            let header = lines[0].trim_start_matches(['#', ' ']).to_owned();
            lines.insert(100 + draws.below(rows - 200), header);
        }
        6 => lines.insert(0, "Logger 7, firmware 2".into()),
        _ => {
            let at = 100 + draws.below(rows - 200);
            lines[at] = lines[at].replacen('0', "nan", 1);
        }
    }
    lines.join("\n") + "\n"
}

/// The document of a table; `None` with the error if it is refused.
fn replayed(path: &Path, columns: Option<&str>) -> Result<Value, String> {
    let mut command = vn100();
    command.args(["replay", "--json"]).arg(path);
    if let Some(columns) = columns {
        command.args(["--columns", columns]);
    }
    let output = command.output().unwrap();
    let document: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let document = document.get(0).cloned().unwrap_or(document);
    match document["timing"]["samples"].as_u64() {
        Some(1..) => Ok(document),
        _ => Err(String::from_utf8(output.stderr).unwrap() + &document["source"]["error"].to_string()),
    }
}

/// Whether the means of the present channels are those of the sensor, unless their unit is doubtful.
fn is_right(document: &Value) -> Result<(), String> {
    let mut wrong = String::new();
    for channel in document["channels"].as_array().into_iter().flatten() {
        let name = channel["name"].as_str().unwrap();
        let axis = ["x", "y", "z"].iter().position(|axis| name.ends_with(axis)).unwrap();
        let (truth, tolerance) = if name.starts_with("gyro") { (GYRO[axis], 1e-3) } else { (ACCEL[axis], 1e-2) };
        let mean = channel["statistics"]["mean"].as_f64().unwrap();
        if (mean - truth).abs() > tolerance {
            write!(wrong, " {name} {mean} for {truth}").unwrap();
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong) }
}

/// The map in the text of a refusal.
fn printed_map(refusal: &str) -> Option<String> {
    let (_, rest) = refusal.split_once("--columns '")?;
    Some(rest.split_once('\'')?.0.to_owned())
}

/// `VN100_CHANGES` is the number of changes of each form.
#[test]
fn changed_tables_are_read_right_or_refused() {
    let changes: usize = std::env::var("VN100_CHANGES").ok().and_then(|count| count.parse().ok()).unwrap_or(4);
    let folder = tempfile::tempdir().unwrap();
    let mut draws = Draws(49);
    for form in &FORMS {
        let path = folder.path().join(form.file);
        let separator = [';', ',', ' '].into_iter().find(|separator| form.header.contains(*separator)).unwrap();
        for change in 0..=changes {
            let lines = table(form, &mut draws);
            let text = if change == 0 { lines.join("\n") } else { changed(lines, separator, &mut draws) };
            fs::write(&path, &text).unwrap();
            let mut outcome = replayed(&path, None);
            if let Some(map) = outcome.as_ref().err().and_then(|refusal| printed_map(refusal)) {
                outcome = replayed(&path, Some(&map));
                assert!(outcome.is_ok() || change > 0, "{}: {map}: {outcome:?}", form.file);
            }
            let head = || text.lines().take(3).collect::<Vec<_>>().join("\n");
            match outcome {
                Ok(document) => {
                    let right = is_right(&document);
                    assert_eq!(right, Ok(()), "{} change {change}:\n{}", form.file, head());
                }
                Err(refusal) => {
                    assert!(change > 0 && refusal.len() > 20, "{} change {change}: {refusal}\n{}", form.file, head())
                }
            }
        }
    }
}

/// The printed line for a doubtful unit corrects all units at once, with the names of the file, as
/// printed on a terminal.
#[test]
fn the_printed_line_of_a_doubtful_unit_gives_the_right_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bare.csv");
    let mut draws = Draws(7);
    let mut text = "sys time,Gyr X,Gyr Y,Gyr Z,acc_x,acc_y,acc_z,magx,magy,magz\n".to_owned();
    for row in 0..1200 {
        let [gx, gy, gz] = GYRO.map(|mean| (mean + draws.noise(0.002)) / DEGREE);
        let [ax, ay, az] = ACCEL.map(|mean| (mean + draws.noise(0.02)) / G);
        writeln!(
            text,
            "{:.2},{gx:.5},{gy:.5},{gz:.5},{ax:.6},{ay:.6},{az:.6},20.5,-3.1,-40.{}",
            f64::from(row) * 0.01,
            row % 7
        )
        .unwrap();
    }
    fs::write(&path, text).unwrap();
    let output = vn100().arg("replay").arg(&path).output().unwrap();
    let map = printed_map(&String::from_utf8(output.stdout).unwrap()).expect("a line");
    assert!(map.contains("gyro_x=Gyr X:deg/s") && map.contains("accel_x=acc_x:g"), "{map}");
    let document = replayed(&path, Some(&map)).unwrap();
    let kinds: Vec<_> =
        document["warnings"].as_array().unwrap().iter().map(|warning| warning["kind"].clone()).collect();
    assert!(!kinds.contains(&Value::from("unit-doubtful")), "{kinds:?}");
    let mag = document["channels"].as_array().unwrap().iter().find(|channel| channel["name"] == "mag_x").unwrap();
    assert!((mag["statistics"]["mean"].as_f64().unwrap() - 0.205).abs() < 1e-6, "{mag}");
    let mut inertial = document.clone();
    inertial["channels"].as_array_mut().unwrap().retain(|channel| channel["unit"] != "gauss");
    assert_eq!(is_right(&inertial), Ok(()));
}

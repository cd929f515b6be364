//! A twin of a measured sensor: what is measured of it covers the original.

use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::support::vn100;

/// A sensor of 20 Hz, as a document: N of each axis, and B and K that show in an hour, or not.
fn sensor(runner: &mut TestRunner) -> Value {
    let axes = "mag_x mag_y mag_z accel_x accel_y accel_z gyro_x gyro_y gyro_z";
    let mut draw = |from: f64, to: f64| (from..to).new_tree(runner).unwrap().current();
    let channels = axes.split(' ').map(|name| {
        let white = 10_f64.powf(draw(-3.3, -2.3));
        let noise = json!({
            "white": { "value": white },
            "bias_instability": { "value": white * draw(-0.2, 0.6).max(0.0) },
            "rate_random_walk": { "value": white * draw(-0.02, 0.05).max(0.0) },
        });
        json!({ "name": name, "statistics": { "mean": draw(-0.5, 0.5) }, "noise": noise })
    });
    let channels: Vec<Value> = channels.collect();
    json!({ "source": { "name": "drawn" }, "timing": { "rate_hz": 20.0 }, "channels": channels })
}

fn sim(folder: &TempDir, arguments: &[&str]) -> (bool, String) {
    let output = vn100().current_dir(folder.path()).arg("sim").args(arguments).output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The document of an hour of the sensor that is like this one.
fn measured(folder: &TempDir, like: &str, seed: u64) -> Value {
    let seed = seed.to_string();
    let options = ["-o", "hour.mcap", "-d", "1h", "--message", "VNIMU", "--force", "--seed", &seed, "--like", like];
    let (is_written, error) = sim(folder, &options);
    assert!(is_written, "{error}");
    let output = vn100().current_dir(folder.path()).args(["replay", "--json", "hour.mcap"]).output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

/// `VN100_TWINS=50` for more sensors.
#[test]
fn what_is_measured_of_a_twin_covers_the_original() {
    let folder = TempDir::new().unwrap();
    let mut runner = TestRunner::deterministic();
    let sensors = std::env::var("VN100_TWINS").map_or(2, |count| count.parse().unwrap());
    let (mut covered, mut tried) = (0, 0);
    for number in 0..sensors {
        let path = folder.path().join("drawn.json");
        std::fs::write(&path, sensor(&mut runner).to_string()).unwrap();
        let original = measured(&folder, "drawn.json", 2 * number);
        std::fs::write(folder.path().join("original.json"), original.to_string()).unwrap();
        // by the document, and once by the capture
        let like = if number == 1 { "hour.mcap" } else { "original.json" };
        std::fs::copy(folder.path().join("hour.mcap"), folder.path().join("original.mcap")).unwrap();
        let twin = measured(&folder, if like == "hour.mcap" { "original.mcap" } else { like }, 2 * number + 1);
        for channel in original["channels"].as_array().unwrap() {
            let name = &channel["name"];
            let same = twin["channels"].as_array().unwrap().iter().find(|other| other["name"] == *name).unwrap();
            for parameter in ["white", "bias_instability", "rate_random_walk"] {
                let Some(value) = channel["noise"][parameter]["value"].as_f64() else { continue };
                let found = &same["noise"][parameter];
                tried += 1;
                covered += u32::from(
                    found["upper"].as_f64().is_some_and(|upper| value <= upper)
                        && found["lower"].as_f64().unwrap_or(0.0) <= value,
                );
            }
        }
    }
    assert!(tried >= 9 * sensors as u32, "{tried}");
    // intervals of 95 %, and chance
    let tried = f64::from(tried);
    assert!(f64::from(covered) >= 0.95 * tried - 4.0 * (0.0475 * tried).sqrt(), "{covered} of {tried}");
}

#[test]
fn a_twin_of_what_does_not_show_the_sensor_is_refused() {
    let folder = TempDir::new().unwrap();
    assert!(sim(&folder, &["-o", "a.vnymr", "-d", "2min"]).0);
    std::fs::write(folder.path().join("b.json"), "{\"a\": 1}").unwrap();
    for (file, reason) in
        [("a.vnymr", "filter has removed the bias"), ("b.json", "no document"), ("none", "no twin of none")]
    {
        let (is_written, error) = sim(&folder, &["-o", "twin.vnimu", "--like", file]);
        assert!(!is_written && error.contains(reason), "{error}");
        assert!(!folder.path().join("twin.vnimu").exists());
    }
}

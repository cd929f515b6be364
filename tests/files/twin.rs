//! A twin of a measured sensor: what is measured of it covers the original.

use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::support::{document, vn100};

const AXES: &str = "mag_x mag_y mag_z accel_x accel_y accel_z gyro_x gyro_y gyro_z";
const SAMPLES: f64 = 72_000.0;

/// A sensor, as a document: on each axis N, and B, K, a process, lines and a resolution, or not.
fn sensor(runner: &mut TestRunner) -> (Value, f64) {
    let mut draw = |from: f64, to: f64| (from..to).new_tree(runner).unwrap().current();
    let rate_hz = [10.0, 20.0, 25.0, 40.0, 50.0, 100.0, 200.0][draw(0.0, 7.0) as usize];
    let channels = AXES.split(' ').map(|name| {
        let sigma = 10_f64.powf(draw(-2.3, -1.3));
        let time_s = 20.0 / rate_hz * (SAMPLES / 64.0 / 20.0).powf(draw(0.0, 1.0));
        let process = json!({ "correlation_time_s": time_s, "sigma": sigma * draw(0.1, 0.4) });
        let processes = if draw(0.0, 1.0) < 0.5 { vec![process] } else { vec![] };
        let step = 0.001 * (sigma * draw(0.2, 1.0) / 0.001).round().max(1.0);
        let resolution = if draw(0.0, 1.0) < 0.5 { step } else { 0.0 };
        let lines = (0..draw(0.0, 3.0) as u32).map(|_| {
            let frequency_hz = rate_hz * draw(0.03, 0.47);
            json!({ "frequency_hz": frequency_hz, "amplitude": sigma * draw(0.05, 1.0) })
        });
        let lines: Vec<Value> = lines.collect();
        let noise = json!({
            "white": { "value": sigma / rate_hz.sqrt() },
            "bias_instability": { "value": sigma * draw(-0.05, 0.13).max(0.0) },
            "rate_random_walk": { "value": sigma * rate_hz.sqrt() * draw(-2e-4, 5e-4).max(0.0) },
            "likeliest": { "processes": processes },
        });
        let statistics = json!({ "mean": draw(-0.5, 0.5), "resolution": resolution });
        json!({ "name": name, "statistics": statistics, "noise": noise, "spectrum": { "lines": lines } })
    });
    let mut channels: Vec<Value> = channels.collect();
    channels.push(json!({ "name": "temperature", "statistics": { "mean": 41.3 } }));
    (
        json!({ "source": { "name": "drawn" }, "timing": { "rate_hz": rate_hz }, "channels": channels }),
        SAMPLES / rate_hz,
    )
}

fn sim(folder: &TempDir, arguments: &[&str]) -> (bool, String) {
    let output = vn100().current_dir(folder.path()).arg("sim").args(arguments).output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The document of a record of the sensor that is like this one.
fn measured(folder: &TempDir, like: &str, length_s: f64, seed: u64) -> Value {
    let (length, seed) = (format!("{length_s}s"), seed.to_string());
    let options = ["-o", "run.mcap", "-d", &length, "--message", "VNIMU", "--force", "--seed", &seed, "--like", like];
    let (is_written, error) = sim(folder, &options);
    assert!(is_written, "{error}");
    let output = vn100().current_dir(folder.path()).args(["replay", "--json", "run.mcap"]).output().unwrap();
    document(&output)
}

fn channel<'a>(document: &'a Value, name: &str) -> &'a Value {
    document["channels"].as_array().unwrap().iter().find(|channel| channel["name"] == name).unwrap()
}

/// Of the values of N, B and K of the original, whether the interval of the twin covers each.
fn values_covered(original: &Value, twin: &Value) -> Vec<bool> {
    let covered = |parameter: &str| {
        let (value, found) = (original["noise"][parameter]["value"].as_f64()?, &twin["noise"][parameter]);
        let is_below_upper = found["upper"].as_f64().is_some_and(|upper| value <= upper);
        Some(is_below_upper && found["lower"].as_f64().unwrap_or(0.0) <= value)
    };
    ["white", "bias_instability", "rate_random_walk"].into_iter().filter_map(covered).collect()
}

/// Whether the intervals of both deviations overlap, at each octave that has two.
fn octaves_overlap(original: &Value, twin: &Value) -> Vec<bool> {
    let points = |of: &Value| of["allan"]["points"].as_array().unwrap().clone();
    let overlap = |(original, twin): (Value, Value)| {
        let end = |of: &Value, end: &str| of[end].as_f64();
        let is_below = |a: &Value, b: &Value| Some(end(a, "lower")? <= end(b, "upper")?);
        Some(is_below(&original, &twin)? && is_below(&twin, &original)?)
    };
    points(original).into_iter().zip(points(twin)).filter_map(overlap).collect()
}

fn share(covered: &[bool]) -> f64 {
    covered.iter().filter(|is_covered| **is_covered).count() as f64 / covered.len() as f64
}

/// `VN100_TWINS=50` for that many sensors, drawn anew.
#[test]
fn what_is_measured_of_a_twin_covers_the_original() {
    let folder = TempDir::new().unwrap();
    let asked = std::env::var("VN100_TWINS").ok().map(|count| count.parse::<u64>().unwrap());
    let mut runner = if asked.is_some() { TestRunner::default() } else { TestRunner::deterministic() };
    let (mut values, mut octaves) = (Vec::new(), Vec::new());
    for number in 0..asked.unwrap_or(2) {
        let [first, second] = [any::<u64>(), any::<u64>()].map(|seed| seed.new_tree(&mut runner).unwrap().current());
        let (drawn, length_s) = sensor(&mut runner);
        std::fs::write(folder.path().join("drawn.json"), drawn.to_string()).unwrap();
        let original = measured(&folder, "drawn.json", length_s, first);
        if !original["motion"].is_null() {
            // such slow noise has no twin
            continue;
        }
        std::fs::write(folder.path().join("original.json"), original.to_string()).unwrap();
        std::fs::copy(folder.path().join("run.mcap"), folder.path().join("original.mcap")).unwrap();
        // by the document, and once by the capture
        let like = if number == 1 { "original.mcap" } else { "original.json" };
        let twin = measured(&folder, like, length_s, second);
        for name in AXES.split(' ') {
            let (original, twin) = (channel(&original, name), channel(&twin, name));
            values.extend(values_covered(original, twin));
            octaves.extend(octaves_overlap(original, twin));
        }
        let temperature = channel(&twin, "temperature")["statistics"]["mean"].as_f64().unwrap();
        assert!((temperature - 41.3).abs() < 0.01, "{temperature}");
    }
    println!("values {:.3} of {}, octaves {:.3} of {}", share(&values), values.len(), share(&octaves), octaves.len());
    // intervals of 95 %, and chance
    let chance = 4.0 * (0.0475 / values.len() as f64).sqrt();
    assert!(values.len() >= 9 && share(&values) >= 0.95 - chance && share(&octaves) >= 0.9);
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

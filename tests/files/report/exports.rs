//! The files that are exported beside a report, as others read them.

use std::{fs, path::PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use super::{report, simulated, text, vn100};
use crate::support::real_captures;

#[test]
fn exports_are_read_by_others() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let forms = "csv,json,svg,png,mcap";
    let (page, _) = report(&folder, &[&capture], &["--export", forms]);
    let beside = |ending: &str| {
        let mut name = page.with_extension("").into_os_string();
        name.push(ending);
        PathBuf::from(name)
    };

    let document: Value = serde_json::from_str(&fs::read_to_string(beside(".json")).unwrap()).unwrap();
    let gyro = &document["channels"][10];
    assert_eq!((&gyro["name"], &document["schema"]), (&"gyro_y".into(), &"vn100.analysis/1".into()));

    let table = fs::read_to_string(beside(".allan.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|found| *found == name).unwrap();
    let of_gyro: Vec<_> = rows.filter(|row| row[column("channel")] == "gyro_y").collect();
    let points = gyro["allan"]["points"].as_array().unwrap();
    assert_eq!(of_gyro.len(), points.len());
    for (row, point) in of_gyro.iter().zip(points) {
        assert_eq!(row[column("deviation")].parse::<f64>().unwrap(), point["deviation"].as_f64().unwrap());
        assert_eq!(row.len(), header.len());
    }
    for ending in [
        ".metadata.csv",
        ".statistics.csv",
        ".parameters.csv",
        ".fit.csv",
        ".spectrum.csv",
        ".segments.csv",
        ".histogram.csv",
    ] {
        let table = fs::read_to_string(beside(ending)).unwrap();
        let columns = table.lines().next().unwrap().split(',').count();
        assert!(table.lines().count() > 8 && table.lines().all(|line| line.split(',').count() == columns), "{ending}");
    }

    let svg = fs::read_to_string(beside(".svg-figures").join("allan-gyro_y.svg")).unwrap();
    assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && svg.ends_with("</svg>"));
    let png = fs::read(beside(".png-figures").join("allan-gyro_y.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n") && png.len() > 10_000);
    let figures = |ending: &str| fs::read_dir(beside(ending)).unwrap().count();
    assert!(figures(".svg-figures") >= 24 + 12 + 3 && figures(".svg-figures") == figures(".png-figures"));

    let bytes = fs::read(beside(".ros2.mcap")).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let imu: Vec<_> = messages.iter().filter(|message| message.channel.topic == "/imu/data").collect();
    assert_eq!((imu.len(), messages.len()), (8 * 60 * 40, 2 * 8 * 60 * 40));
    let schema = imu[0].channel.schema.as_ref().unwrap();
    assert_eq!((&*schema.name, &*schema.encoding), ("sensor_msgs/msg/Imu", "ros2msg"));
    assert_eq!(imu[1].log_time, 25_000_000, "without arrival times, by number and rate");
    // encapsulation 4, stamp 8, frame 4 + 10, filled to 24; orientation 4, covariance 9, rate 3, covariance 9, acceleration
    let at = 4 + 24 + (4 + 9 + 3 + 9) * 8;
    let number = |at: usize| f64::from_le_bytes(imu[0].data[at..at + 8].try_into().unwrap());
    let up = (0..3).map(|axis| number(at + 8 * axis).powi(2)).sum::<f64>().sqrt();
    assert!((up - 9.8).abs() < 0.5, "{up} m/s^2");
}

#[test]
fn messages_turned_to_east_north_up_have_the_variance_of_the_white_noise() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.mcap", &["--message", "VNIMU"]);
    let (page, _) = report(&folder, &[&capture], &["--export", "mcap,json", "--ros-frame", "enu"]);
    let document: Value = serde_json::from_str(&fs::read_to_string(page.with_extension("json")).unwrap()).unwrap();
    let bytes = fs::read(page.with_extension("ros2.mcap")).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let of = |topic: &str| messages.iter().filter(|message| message.channel.topic == topic).collect::<Vec<_>>();
    let imu = of("/imu/data");
    assert_eq!(imu.len() as u64, document["timing"]["samples"].as_u64().unwrap());
    for topic in ["/imu/mag", "/imu/temperature", "/imu/pressure"] {
        assert_eq!(of(topic).len(), imu.len(), "{topic}");
    }
    assert_eq!(&imu[0].data[16..26], b"vn100_flu\0");
    let floats = |message: &mcap::Message<'_>| -> Vec<f64> {
        message.data[28..].chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect()
    };
    let values = floats(imu[0]);
    let [orientation_unknown, rate_variances, acceleration, variances] = [4, 16, 25, 28];
    assert_eq!(values[orientation_unknown], -1.0);
    assert!((values[acceleration + 2] - 9.8).abs() < 0.2, "level at rest: {values:?}");
    let channels = document["channels"].as_array().unwrap();
    for (prefix, at) in [("gyro", rate_variances), ("accel", variances)] {
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            let channel = channels.iter().find(|channel| channel["name"] == format!("{prefix}_{letter}")).unwrap();
            let density = channel["noise"]["white"]["value"].as_f64().unwrap();
            assert!((values[at + 4 * axis] / (density * density * 40.0) - 1.0).abs() < 1e-12, "{prefix}_{letter}");
        }
    }
    assert!((floats(of("/imu/pressure")[0])[0] - 101_325.0).abs() < 1000.0, "in pascals");
    let times: Vec<u64> = imu.iter().map(|message| message.log_time).collect();
    let steps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().max().unwrap() - steps.iter().min().unwrap() <= 1, "an even grid");
    let (page, _) = report(&folder, &[&capture], &["--export", "mcap", "--stamps", "arrival"]);
    let bytes = fs::read(page.with_extension("ros2.mcap")).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert!(metadata.metadata["stamps"].starts_with("arrival: "), "{metadata:?}");
}

/// What a ROS program reads is what the report was made of, and the warm-up before it.
#[test]
fn messages_end_where_the_measurement_ended() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.mcap", &["--message", "VNIMU"]);
    let options = ["--skip", "1min", "--duration", "3min", "--export", "mcap"];
    let (page, _) = report(&folder, &[&capture], &options);
    let bytes = fs::read(page.with_extension("ros2.mcap")).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    assert_eq!(messages.filter(|message| message.channel.topic == "/imu/data").count(), 3 * 60 * 40);
}

#[test]
fn messages_of_packets_without_arrival_times_have_the_time_of_the_sensor() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.bin", &["--message", "BINARY", "--duration", "1min"]);
    let mut bytes = fs::read(&capture).unwrap();
    let packet = bytes.len() / (60 * 40);
    bytes.drain(packet * 1000..packet * 1400);
    fs::write(&capture, &bytes).unwrap();
    let (page, _) = report(&folder, &[&capture], &["--export", "mcap"]);
    let bytes = fs::read(page.with_extension("ros2.mcap")).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let imu = messages.filter(|message| message.channel.topic == "/imu/data");
    let times: Vec<u64> = imu.map(|message| message.log_time).collect();
    // to a microsecond by the clock of the emulated sensor
    let ms = |place: usize| (times[place] as f64 / 1e6).round();
    assert_eq!((times.len(), ms(999), ms(1000)), (2000, 999.0 * 25.0, 1400.0 * 25.0));
}

#[test]
fn messages_have_the_dates_of_a_table() {
    let folder = TempDir::new().unwrap();
    let table = folder.path().join("a.csv");
    let row = |index: u32| {
        let noise = (index * 7919 % 101) as f64 * 1e-5;
        format!("{:.3},{noise},{noise},{noise}\n", 1_761_939_167.125 + 0.01 * f64::from(index))
    };
    fs::write(&table, "t,gyro_x,gyro_y,gyro_z\n".to_owned() + &(0..2000).map(row).collect::<String>()).unwrap();
    let (page, _) = report(&folder, &[&table], &["--export", "mcap"]);
    let bytes = fs::read(page.with_extension("ros2.mcap")).unwrap();
    let first = mcap::MessageStream::new(&bytes).unwrap().next().unwrap().unwrap();
    // as written, in doubles to a microsecond
    assert!(first.log_time.abs_diff(1_761_939_167_125_000_000) < 1000, "{}", first.log_time);
}

/// The values of imu.yaml, which are all that Kalibr reads of it.
fn kalibr_values(yaml: &str) -> Vec<(&str, f64)> {
    let lines = yaml.lines().filter(|line| !line.starts_with('#') && !line.starts_with("rostopic: "));
    let values = lines.map(|line| line.split_once(": ").unwrap());
    values.map(|(name, value)| (name, value.parse().unwrap())).collect()
}

#[test]
fn kalibr_gets_the_noisiest_axis_and_a_walk_that_covers_the_bias_instability() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnimu", &["--message", "VNIMU"]);
    let (page, html) = report(&folder, &[&capture], &["--export", "kalibr,json", "--kalibr-span", "100s"]);
    let yaml = fs::read_to_string(page.with_extension("imu.yaml")).unwrap();
    let document: Value = serde_json::from_str(&fs::read_to_string(page.with_extension("json")).unwrap()).unwrap();
    let channels = document["channels"].as_array().unwrap();
    let of_sensor = |prefix: &str, of: fn(&Value) -> f64| {
        let axes = channels.iter().filter(|channel| channel["name"].as_str().unwrap().starts_with(prefix));
        axes.map(|channel| of(&channel["noise"])).fold(0.0, f64::max)
    };
    let known = |parameter: &Value| parameter["value"].as_f64().or(parameter["upper"].as_f64()).unwrap();
    let density = |noise: &Value| noise["white"]["value"].as_f64().unwrap();
    let walk = |noise: &Value| {
        let (walk, flicker) = (&noise["rate_random_walk"], &noise["bias_instability"]);
        let known = |parameter: &Value| parameter["value"].as_f64().or(parameter["upper"].as_f64()).unwrap();
        let is_alone = walk["status"] == "estimated" && flicker["status"] != "estimated";
        known(walk).max(if is_alone { 0.0 } else { 1.15 * known(flicker) / 10.0 })
    };
    assert!(channels.iter().any(|channel| channel["name"] == "gyro_x" && known(&channel["noise"]["white"]) > 0.0));
    let expected = [
        ("accelerometer_noise_density", of_sensor("accel", density)),
        ("accelerometer_random_walk", of_sensor("accel", walk)),
        ("gyroscope_noise_density", of_sensor("gyro", density)),
        ("gyroscope_random_walk", of_sensor("gyro", walk)),
        ("update_rate", 40.0),
    ];
    let found = kalibr_values(&yaml);
    assert_eq!(found.len(), expected.len(), "{yaml}");
    for ((name, value), (expected_name, expected)) in found.into_iter().zip(expected) {
        assert!(name == expected_name && (value / expected - 1.0).abs() < 1e-4, "{name} {value}, {expected}\n{yaml}");
    }
    assert!(yaml.lines().all(|line| line.len() <= 100), "{yaml}");
    assert!(yaml.contains("N of ") && yaml.contains(": estimated") && yaml.contains("; upper bound"), "{yaml}");
    let printed = html.split("<pre>").nth(1).unwrap().split("</pre>").next().unwrap();
    assert_eq!(printed, yaml, "the page and the file differ");
}

#[test]
fn kalibr_gets_no_random_walk_of_a_compensated_gyroscope() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let page = folder.path().join("r.html");
    let export = |more: &[&str]| {
        let output = vn100(&[&["report", text(&capture), "-o", text(&page), "--export", "kalibr"], more].concat());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let refused = export(&["--require-estimated"]);
    assert_eq!(refused.0, Some(1), "{}", refused.1);
    let reason = "gyroscope_random_walk: B and K are not measurable in a bias-compensated message";
    assert!(refused.1.contains("not every value is estimated") && refused.1.contains(reason), "{}", refused.1);
    let file = folder.path().join("r.imu.yaml");
    assert!(page.exists() && !file.exists());
    let (code, told) = export(&["--force"]);
    assert!(code == Some(0) && told.contains(reason), "{code:?} {told}");
    let yaml = fs::read_to_string(&file).unwrap();
    let names: Vec<&str> = kalibr_values(&yaml).into_iter().map(|(name, _)| name).collect();
    let expected =
        ["accelerometer_noise_density", "accelerometer_random_walk", "gyroscope_noise_density", "update_rate"];
    assert_eq!(names, expected);
    assert!(yaml.contains("# gyroscope_random_walk: missing, and Kalibr needs it:\n#   B and K are"), "{yaml}");
}

#[test]
fn other_averaging_times_are_shown_and_change_no_figure_for_filters() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnimu", &["--message", "VNIMU"]);
    let exported = |taus: &str| {
        let options = ["--rate", "40", "--estimator", "full", "--taus", taus, "--export", "kalibr,csv"];
        let (page, _) = report(&folder, &[&capture], &options);
        let read = |ending: &str| fs::read_to_string(page.with_extension(ending)).unwrap();
        let yaml = read("imu.yaml");
        (yaml.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n"), read("allan.csv"))
    };
    let ((octaves, _), (listed, curve)) = (exported("octave"), exported("10,1"));
    assert_eq!(octaves, listed);
    assert!(octaves.contains("accelerometer_noise_density"), "{octaves}");
    let gyro: Vec<&str> = curve.lines().filter(|line| line.starts_with("gyro_x,")).collect();
    assert!(gyro.len() == 2 && gyro[0].contains(",40,1,") && gyro[1].contains(",400,10,"), "{gyro:?}");
}

#[test]
fn a_capture_of_motion_gives_no_figures_to_a_filter() {
    let Some(captures) = real_captures() else { return };
    let capture = captures.join("vn100-shake-iwale-153s.vnymr");
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("r.html");
    let output = vn100(&["report", text(&capture), "-o", text(&page), "--export", "kalibr"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && told.contains("the sensor was moved"), "{told}");
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("No: sensor moved") && html.contains("Nothing is compared: sensor moved"));
    let parameters = html.split("id=\"parameters\"").nth(1).unwrap().split("id=\"datasheet\"").next().unwrap();
    assert!(parameters.contains("Not given: the sensor was moved") && !parameters.contains("≤"), "{parameters}");
    assert!(
        !html.contains("figure-graphical-gyro_y") && !html.contains("fitted model</text>"),
        "no line of the motion"
    );
    assert!(!html.contains("noise_density: ") && !html.contains("Vibration detected"));
    assert!(!folder.path().join("r.imu.yaml").exists());
}

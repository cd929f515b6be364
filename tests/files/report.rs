//! What a report must hold, and what becomes of the files beside it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

const CHANNELS: [&str; 12] =
    ["yaw", "pitch", "roll", "mag_x", "mag_y", "mag_z", "accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"];

fn vn100(arguments: &[&str]) -> Output {
    crate::support::vn100().args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// An emulated capture.
fn simulated(folder: &TempDir, name: &str, more: &[&str]) -> PathBuf {
    let path = folder.path().join(name);
    let output = vn100(&[&["sim", "-o", text(&path), "--duration", "8min"], more].concat());
    assert!(output.status.success(), "{output:?}");
    path
}

/// A report of `captures`, with the file's path.
fn report(folder: &TempDir, captures: &[&Path], more: &[&str]) -> (PathBuf, String) {
    let page = folder.path().join("report.html");
    let files: Vec<&str> = captures.iter().map(|path| text(path)).collect();
    let output = vn100(&[&["report", "-o", text(&page), "--force"], &files[..], more].concat());
    assert!(output.status.success(), "{output:?}");
    let html = fs::read_to_string(&page).unwrap();
    (page, html)
}

/// Every figure and table of the lab.
#[track_caller]
fn holds_the_lab(html: &str) {
    let figure = |id: String| assert!(html.contains(&format!("id=\"figure-{id}\"")), "no figure {id}");
    for channel in CHANNELS {
        figure(format!("time-{channel}"));
        figure(format!("histogram-{channel}"));
        if !["yaw", "pitch", "roll"].contains(&channel) {
            figure(format!("allan-{channel}"));
        }
    }
    for sensor in ["gyro", "accel", "mag"] {
        figure(format!("allan-{sensor}"));
        figure(format!("spectrum-{sensor}"));
        figure(format!("segments-{sensor}"));
    }
    for row in ["gyro_norm", "accel_norm", "mag_norm", "yaw", "SHA-256", "Rate ramp", "register 85", "not recorded"] {
        let found = html.to_lowercase().contains(&row.to_lowercase());
        assert!(found, "no {row}");
    }
    for question in
        ["How noisy is the sensor?", "Can these numbers be trusted?", "data sheet", "What limits this record?"]
    {
        assert!(html.contains(question), "no {question}");
    }
    for table in ["N, white noise", "Beside the data sheet", "Read by rule"] {
        assert!(html.replace("<b>", "").replace("</b>", "").contains(table), "no {table}");
    }
}

#[test]
fn what_is_read_by_rule_is_read_off_the_allan_deviation() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--profile", "lab3", "--message", "VNIMU"]);
    let (_, html) = report(&folder, &[&capture], &[]);
    let by_rule = html.split("Read by rule").nth(1).unwrap().split("</table>").next().unwrap();
    for unit in ["rad/s/√Hz", "°/h", "rad/s/√s"] {
        assert!(by_rule.contains(&format!(">{unit}</td>")), "no {unit} in {by_rule}");
    }
    let (_, html) = report(&folder, &[&capture], &["--deviation", "hadamard"]);
    assert!(!html.contains("Read by rule"), "the rules are none of the Hadamard deviation");
}

#[test]
fn every_figure_and_table_of_the_lab_is_there_and_nothing_comes_from_elsewhere() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--profile", "lab3"]);
    let (_, html) = report(&folder, &[&capture], &["--compensated", "yes"]);
    holds_the_lab(&html);
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
    let html = html.replace("http://www.w3.org/2000/svg", "");
    for foreign in ["http:", "https:", "src=", "@import", "url(http", "<link"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    assert!(!html.contains(text(folder.path())), "no path of this machine");
    assert!(!html.contains("NaN") && !html.contains("inf "));
}

#[test]
fn the_same_capture_gives_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let (_, first) = report(&folder, &[&capture], &[]);
    let elsewhere = TempDir::new().unwrap();
    let copy = elsewhere.path().join("a.vnymr");
    fs::copy(&capture, &copy).unwrap();
    let (_, second) = report(&elsewhere, &[&copy], &[]);
    assert!(first == second, "the pages differ");
}

#[test]
fn names_are_text_and_no_markup() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "<img onerror=alert(1)>&\"\u{1b}[31m.vnymr", &[]);
    let (_, html) = report(&folder, &[&capture], &[]);
    assert!(!html.contains("<img"), "a name became an element");
    assert!(!html.contains('\u{1b}'), "a name commands a terminal");
    assert!(html.contains("&lt;img onerror=alert(1)&gt;&amp;"));
}

#[test]
fn what_a_recording_tells_of_the_sensor_is_in_the_report() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.mcap", &["--message", "VNIMU"]);
    let (_, html) = report(&folder, &[&capture], &[]);
    assert!(html.contains("figure-time-temperature"), "the temperature over time");
    assert!(html.contains("vn100 0.1.0"), "what made the recording");
}

#[test]
fn registers_told_within_the_stream_are_in_the_report() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let mut lines = fs::read_to_string(&capture).unwrap();
    for body in [
        "VNRRG,01,VN-100S-CR",
        "VNRRG,03,0100012345",
        "VNRRG,85,0,20,20,4,0,0,3,3,3,0",
        "VNRRG,35,1,0,1,1",
        "VNRRG,54,+00.2103,+00.0010,+00.4300,-00.012,-00.023,-09.806,-00.010537,+00.013973,+00.032961,+22.1,+00101.329",
    ] {
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        lines.push_str(&format!("${body}*{checksum:02X}\r\n"));
    }
    fs::write(&capture, lines).unwrap();
    let (_, html) = report(&folder, &[&capture], &["--rate", "40"]);
    for told in
        ["0100012345", "averages 20 refreshes of the gyroscope (both)", "on, heading absolute", "<b>consistent</b>"]
    {
        assert!(html.contains(told), "{told}");
    }
    assert!(html.contains("uncompensated_gyro_x"), "its mean");
    for untold in ["uncompensated_gyro_x: white noise", "histogram-uncompensated_gyro_x", "the worst known axis"] {
        assert!(!html.contains(untold), "{untold}: one value that was asked for has no noise");
    }
}

#[test]
fn exports_are_read_by_others() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let forms = "csv,json,svg,png,mcap";
    let (page, _) = report(&folder, &[&capture], &["--export", forms, "--export", "kalibr", "--filter-models"]);
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
    for ending in [".statistics.csv", ".parameters.csv", ".spectrum.csv", ".segments.csv", ".histogram.csv"] {
        let table = fs::read_to_string(beside(ending)).unwrap();
        let columns = table.lines().next().unwrap().split(',').count();
        assert!(table.lines().count() > 8 && table.lines().all(|line| line.split(',').count() == columns), "{ending}");
    }

    let yaml = fs::read_to_string(beside(".imu.yaml")).unwrap();
    let figures: Vec<(&str, &str)> =
        yaml.lines().filter(|line| !line.starts_with('#')).map(|line| line.split_once(": ").unwrap()).collect();
    let names: Vec<&str> = figures.iter().map(|(name, _)| *name).collect();
    let expected = [
        "accelerometer_noise_density",
        "accelerometer_random_walk",
        "gyroscope_noise_density",
        "gyroscope_random_walk",
        "rostopic",
        "update_rate",
    ];
    assert_eq!(names, expected);
    for (name, value) in figures.iter().filter(|(name, _)| *name != "rostopic") {
        assert!(value.parse::<f64>().unwrap() > 0.0 && value.contains('.'), "{name}: {value}");
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
    // encapsulation 4, stamp 8, frame 4 + 6, filled to 24; orientation 4, covariance 9, rate 3, covariance 9, acceleration
    let at = 4 + 24 + (4 + 9 + 3 + 9) * 8;
    let number = |at: usize| f64::from_le_bytes(imu[0].data[at..at + 8].try_into().unwrap());
    let up = (0..3).map(|axis| number(at + 8 * axis).powi(2)).sum::<f64>().sqrt();
    assert!((up - 9.8).abs() < 0.5, "{up} m/s^2");
}

#[test]
fn kalibr_gets_no_invented_random_walk() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let page = folder.path().join("r.html");
    let output = vn100(&["report", text(&capture), "-o", text(&page), "--export", "kalibr"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("gyroscope is not measurable") && told.contains("--filter-models"), "{told}");
    assert!(page.exists() && !folder.path().join("r.imu.yaml").exists());
}

#[test]
fn other_averaging_times_are_shown_and_change_no_figure_for_filters() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnimu", &["--message", "VNIMU"]);
    let exported = |taus: &str| {
        let options =
            ["--rate", "40", "--estimator", "full", "--taus", taus, "--filter-models", "--export", "kalibr,csv"];
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
fn existing_files_stay_unless_told_otherwise() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let page = folder.path().join("kept.html");
    fs::write(&page, "mine").unwrap();
    let refused = |arguments: &[&str], expected: &str| {
        let output = vn100(&[&["report", text(&capture)], arguments].concat());
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && told.contains(expected), "{told}");
    };
    refused(&["-o", text(&page)], "exists");
    assert_eq!(fs::read_to_string(&page).unwrap(), "mine");
    refused(&["-o", text(&folder.path().join("none/r.html"))], "no folder");
    refused(&["-o", text(&folder.path().join("stem"))], "does not end in .html");
    let own = folder.path().join("a.html");
    fs::rename(&capture, &own).unwrap();
    let output = vn100(&["report", text(&own), "-o", text(&own), "--force"]);
    assert!(!output.status.success(), "a capture is never replaced by its report");
}

#[test]
fn several_captures_are_laid_over_each_other_and_compared() {
    let folder = TempDir::new().unwrap();
    let a = simulated(&folder, "a.vnymr", &["--seed", "1"]);
    let b = simulated(&folder, "b.vnymr", &["--seed", "2"]);
    let (page, html) = report(&folder, &[&a, &b], &["--export", "json"]);
    assert!(html.contains("figure-records-gyro_y") && html.contains("figure-A-allan-gyro_y"));
    assert!(html.contains("figure-B-time-yaw") && html.contains("beyond chance"));
    let ids: Vec<&str> = html.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    let mut unique = ids.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), ids.len(), "an id stands twice");
    assert!(page.with_file_name("report-1.json").exists() && page.with_file_name("report-2.json").exists());
}

#[test]
fn a_capture_of_nothing_says_so() {
    let folder = TempDir::new().unwrap();
    let capture = folder.path().join("nothing.vnymr");
    fs::write(&capture, "$VNYMR,broken\r\n".repeat(50)).unwrap();
    let page = folder.path().join("r.html");
    let output = vn100(&["report", text(&capture), "-o", text(&page)]);
    assert_eq!(output.status.code(), Some(3));
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("no valid sample") && html.contains("nothing to conclude from"));
    assert!(!html.contains("would spoil these numbers") && !html.contains("noise_density"), "it has no numbers");
}

#[test]
fn a_capture_of_motion_gives_no_figures_to_a_filter() {
    let Some(captures) = crate::support::real_captures() else { return };
    let capture = captures.join("vn100-shake-iwale-153s.vnymr");
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("r.html");
    let output = vn100(&["report", text(&capture), "-o", text(&page), "--export", "kalibr", "--filter-models"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && told.contains("the sensor was moved"), "{told}");
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("No: the sensor was moved") && html.contains("Nothing is compared: the sensor was moved"));
    assert!(!html.contains("noise_density: ") && !html.contains("shook the sensor"));
    assert!(!folder.path().join("r.imu.yaml").exists());
}

#[test]
fn the_shared_static_record_is_told_as_it_is() {
    let Some(captures) = crate::support::real_captures() else { return };
    let capture = captures.join("vn100-static-kiran-330s.csv");
    let folder = TempDir::new().unwrap();
    let (_, html) = report(&folder, &[&capture], &["--compensated", "yes"]);
    holds_the_lab(&html);
    // the digest is as sha256sum prints it
    for told in [
        "gyro_y: white noise N = 1.2",
        "18.4 Hz",
        "not measurable",
        "consistent",
        "register 85 is at its factory default",
        "VNIMU",
        "966bf211894b7113c2c12b44ddbcb255b991dd6594a7755e0730406592d81b47",
    ] {
        assert!(html.contains(told), "{told}");
    }
}

/// In a browser, where there is one: no error, every figure made alive, a value under the pointer.
#[test]
fn a_browser_shows_it_without_complaint() {
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let found = browsers.iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    let Some(browser) = found else {
        eprintln!("skipped: no chromium on this machine");
        return;
    };
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--profile", "lab3"]);
    let (page, html) = report(&folder, &[&capture], &[]);
    let probe = r#"<script>
        window.addEventListener('load', () => {
            const figure = document.getElementById('figure-allan-gyro_y'), picture = figure.querySelector('svg');
            picture.scrollIntoView();
            const box = picture.getBoundingClientRect();
            const at = { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
            picture.dispatchEvent(new PointerEvent('pointermove', at));
            const read = figure.querySelector('.readout').textContent;
            picture.dispatchEvent(new MouseEvent('dblclick', at));
            const zoomed = !figure.querySelector('button').hidden;
            figure.querySelector('button').click();
            const box2 = document.querySelector('#figure-allan-gyro input');
            box2.click();
            const hidden = document.querySelector('#figure-allan-gyro g.s0').style.display;
            const outside = performance.getEntriesByType('resource').length;
            document.title = JSON.stringify({ read, zoomed, hidden, outside });
        });
    </script></body>"#;
    fs::write(&page, html.replace("</body>", probe)).unwrap();
    let profile = format!("--user-data-dir={}", text(&folder.path().join("profile")));
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--enable-logging=stderr",
            "--v=0",
            &profile,
            "--dump-dom",
        ])
        .arg(format!("file://{}", text(&page)))
        .output()
        .unwrap();
    let (dom, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "the browser itself failed: {:?}\n{log}", output.status);
    assert!(!log.contains("CONSOLE"), "{log}");
    let figures = html.matches("<figure ").count();
    assert!(dom.contains(&format!("data-ready=\"{figures}\"")), "{figures} figures, all made alive");
    let title = dom.split("<title>").nth(1).unwrap().split("</title>").next().unwrap();
    let told: Value = serde_json::from_str(title).unwrap();
    assert!(told["read"].as_str().unwrap().contains("rad/s"), "{told}");
    assert_eq!(
        (&told["zoomed"], &told["hidden"], &told["outside"]),
        (&true.into(), &"none".into(), &0.into()),
        "{told}"
    );
}

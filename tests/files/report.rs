//! The required content of the page of a report.

mod exports;

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

/// An emulated capture, of eight minutes unless `more` gives another length.
fn simulated(folder: &TempDir, name: &str, more: &[&str]) -> PathBuf {
    let path = folder.path().join(name);
    let length: &[&str] = if more.contains(&"--duration") { &[] } else { &["--duration", "8min"] };
    let output = vn100(&[&["sim", "-o", text(&path)], length, more].concat());
    assert!(output.status.success(), "{output:?}");
    path
}

fn report(folder: &TempDir, captures: &[&Path], more: &[&str]) -> (PathBuf, String) {
    let page = folder.path().join("report.html");
    let files: Vec<&str> = captures.iter().map(|path| text(path)).collect();
    let output = vn100(&[&["report", "-o", text(&page), "--force"], &files[..], more].concat());
    assert!(output.status.success(), "{output:?}");
    let html = fs::read_to_string(&page).unwrap();
    (page, html)
}

/// Checks for every figure and table of the lab.
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
    for table in ["Angle Random Walk N", "Comparison with the data sheet", "graphical slope method", "What to do"] {
        assert!(html.replace("<b>", "").replace("</b>", "").contains(table), "no {table}");
    }
}

#[test]
fn graphical_readings_come_from_the_allan_deviation() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--like", "lab3", "--message", "VNIMU"]);
    let (_, html) = report(&folder, &[&capture], &["--deviation", "hadamard"]);
    assert!(!html.contains("figure-graphical-"), "the rules are none of the Hadamard deviation");
}

fn without_scripts(html: &str) -> String {
    html.split("<script").map(|piece| piece.split_once("</script>").map_or(piece, |(_, rest)| rest)).collect()
}

/// The first screen of a report as a picture: its own elements and style within one SVG, except for
/// the checksum, which changes with the writer of recordings. Updated with `VN100_WRITE_STILLS=1`.
#[test]
fn the_picture_of_a_report_is_its_first_screen() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab3.mcap", &["--like", "lab3", "--message", "VNIMU", "--duration", "2h"]);
    let (_, html) = report(&folder, &[&capture], &[]);
    let between = |from: &str, to: &str| html.split(from).nth(1).unwrap().split(to).next().unwrap();
    let style = between("<style>", "</style>");
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"";
    let first = without_scripts(between("<body>", "<nav ")).replace("<svg", svg);
    // of the curves those of the gyroscope
    let (curves, rest) = first.split_once("<div class=\"grid\">").unwrap();
    let first = format!("{curves}</section>{}", rest.split_once("</section>").unwrap().1);
    let (before, after) = first.split_once("<div><dt>SHA-256</dt>").unwrap();
    let (_, after) = after.split_once("</div>").unwrap();
    let picture = format!(
        "{svg} width=\"1280\" height=\"1100\" viewBox=\"0 0 1280 1100\"><foreignObject width=\"100%\" height=\"100%\">\
         <html xmlns=\"http://www.w3.org/1999/xhtml\"><head><style>{}</style></head><body>{before}{after}</main></body></html></foreignObject></svg>\n",
        style.replace('&', "&amp;")
    );
    assert!(picture.len() < 100_000, "{} bytes", picture.len());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("stills/report.svg");
    if std::env::var_os("VN100_WRITE_STILLS").is_some() {
        fs::write(&file, &picture).unwrap();
    }
    assert!(
        fs::read_to_string(&file).unwrap_or_default() == picture,
        "{} is not the page: VN100_WRITE_STILLS=1 makes it anew",
        file.display()
    );
}

/// The rows of a CSV export of the report, as cells.
fn rows_of(page: &Path, ending: &str) -> Vec<Vec<String>> {
    let table = fs::read_to_string(page.with_extension(ending)).unwrap();
    table.lines().map(cells).collect()
}

#[test]
fn the_graphical_readings_are_drawn_tabled_and_exported_or_not_read_for_a_reason() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--like", "lab3", "--message", "VNIMU", "--duration", "2h"]);
    let (page, html) = report(&folder, &[&capture], &["--rate", "40", "--export", "csv,json"]);
    let lab = html.split("<section id=\"lab\">").nth(1).unwrap().split("</section>").next().unwrap();
    for part in ["figure-graphical-gyro_y", "figure-graphical-accel_y", "<b>Grade</b>"] {
        assert!(lab.contains(part), "no {part}");
    }
    assert!(lab.contains("href=\"#background\"") && html.contains("id=\"background-N\""));
    let rows = rows_of(&page, "parameters.csv");
    let row = |channel: &str, parameter: &str, unit: &str| {
        let found = rows.iter().find(|row| row[0] == channel && row[1] == parameter && row[6] == unit);
        found.unwrap_or_else(|| panic!("no {parameter} of {channel} in {unit}")).clone()
    };
    let graphical = row("gyro_y", "graphical_white", "deg/sqrt(h)");
    let value: f64 = graphical[3].parse().unwrap();
    assert!(graphical[2] == "graphical" && (0.34..0.38).contains(&value), "{graphical:?}");
    assert!(lab.contains(&format!("N {value:.4} °/√h")), "its value is in the figure");
    assert_eq!(row("gyro_y", "white", "deg/sqrt(h)")[7], "", "white noise has no test");
    let [density, of_sample] = [("white", "rad/s/sqrt(Hz)"), ("white_discrete", "rad/s")]
        .map(|(name, unit)| row("gyro_y", name, unit)[3].parse::<f64>().unwrap());
    assert!((of_sample / density / 40_f64.sqrt() - 1.0).abs() < 1e-9, "{of_sample} of {density}");
    let document: Value = serde_json::from_str(&fs::read_to_string(page.with_extension("json")).unwrap()).unwrap();
    let gyro = document["channels"].as_array().unwrap().iter().find(|channel| channel["name"] == "gyro_y").unwrap();
    let read = &gyro["noise"]["classical"]["white"];
    let in_si = &row("gyro_y", "graphical_white", "rad/s/sqrt(Hz)")[3];
    assert_eq!(read["value"].as_f64(), in_si.parse().ok(), "{read}");
    assert_eq!((&read["unit"], &read["not_read"]), (&"rad/s/sqrt(Hz)".into(), &Value::Null));
    assert!(gyro["noise"]["white"]["p"].is_null());

    let short = simulated(&folder, "short.vnymr", &["--message", "VNIMU", "--duration", "60s"]);
    let (page, html) = report(&folder, &[&short], &["--rate", "40", "--export", "csv"]);
    let lab = html.split("<section id=\"lab\">").nth(1).unwrap().split("</section>").next().unwrap();
    assert!(lab.contains("K not read: no slope +½ region"), "in the figure, instead of a line");
    let rows = rows_of(&page, "parameters.csv");
    let not_read = rows.iter().filter(|row| row[1] == "graphical_rate_random_walk" && row[2] == "no-slope");
    assert!(not_read.clone().count() > 0 && not_read.into_iter().all(|row| row[3].is_empty()));
}

#[test]
fn printed_pages_name_the_capture_for_any_name() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a\"}<b>\\.vnymr", &["--duration", "30s"]);
    let (_, html) = report(&folder, &[&capture], &[]);
    assert!(html.contains("@bottom-left { content: \"a\\22 }\\3c b\\3e \\5c .vnymr\"; }"));
}

#[test]
fn every_figure_and_table_of_the_lab_exists_without_external_content() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--like", "lab3"]);
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
fn facts_of_the_sensor_in_a_recording_are_in_the_report() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.mcap", &["--message", "VNIMU"]);
    let (_, html) = report(&folder, &[&capture], &[]);
    assert!(html.contains("figure-time-temperature"), "the temperature over time");
    assert!(html.contains(concat!("vn100 ", env!("CARGO_PKG_VERSION"))), "what made the recording");
}

/// At the sampling rate of the sensor there is no aliasing for any window.
#[test]
fn a_stream_of_all_samples_has_no_aliasing() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.bin", &["--message", "BINARY", "--rate", "800", "--duration", "1min"]);
    let (_, html) = report(&folder, &[&capture], &[]);
    assert!(html.contains("aliasing on board: none at this rate, with any averaging window."));
    for part in ["1 to 1.00 times", "nor entirely missing lines"] {
        assert!(!html.contains(part), "{part}");
    }
}

#[test]
fn the_deviation_per_segment_is_not_drawn_across_a_gap() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.bin", &["--message", "BINARY"]);
    let lines = |folder: &TempDir| {
        let (_, html) = report(folder, &[&capture], &[]);
        let figure = html.split("id=\"figure-segments-gyro\"").nth(1).unwrap().split("</figure>").next().unwrap();
        figure.matches("class=\"l c0\"").count()
    };
    let without_gap = lines(&folder);
    let mut bytes = fs::read(&capture).unwrap();
    bytes.drain(bytes.len() / 2..bytes.len() / 4 * 3);
    fs::write(&capture, bytes).unwrap();
    assert_eq!(lines(&folder), without_gap + 1);
}

#[test]
fn registers_reported_in_the_stream_are_in_the_report() {
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
    for told in ["0100012345", "averages 20 refreshes of the gyroscope", " x typical</b>"] {
        assert!(html.contains(told), "{told}");
    }
    assert!(html.contains("uncompensated_gyro_x"), "its mean");
    for untold in ["uncompensated_gyro_x: Angle", "histogram-uncompensated_gyro_x", "the worst known axis"] {
        assert!(!html.contains(untold), "{untold}: one value that was asked for has no noise");
    }
    // read once, they have no curve
    let figure = html.split("id=\"figure-allan-gyro\"").nth(1).unwrap().split("</figure>").next().unwrap();
    assert!(figure.contains(">gyro_x") && !figure.contains("uncompensated"), "{figure}");
}

/// The cells of CSV with quotes.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut is_quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            other => cells.last_mut().unwrap().push(other),
        }
    }
    cells
}

#[test]
fn tables_have_a_row_for_each_verdict_warning_and_unit() {
    let folder = TempDir::new().unwrap();
    let a = simulated(&folder, "a.vnimu", &["--seed", "1", "--message", "VNIMU"]);
    let b = simulated(&folder, "b.vnymr", &["--seed", "2"]);
    let (page, _) = report(&folder, &[&a, &b], &["--export", "csv,json,svg"]);
    let json = fs::read_to_string(page.with_file_name("report-1.json")).unwrap();
    let document: Value = serde_json::from_str(&json).unwrap();
    let gyro = document["channels"].as_array().unwrap().iter().find(|channel| channel["name"] == "gyro_y").unwrap();
    let density = gyro["noise"]["white"]["value"].as_f64().unwrap();
    let verdicts = fs::read_to_string(page.with_file_name("report-1.verdicts.csv")).unwrap();
    let rows: Vec<Vec<String>> = verdicts.lines().map(cells).collect();
    assert!(rows.len() > 6 && rows.iter().all(|row| row.len() == rows[0].len()), "{verdicts}");
    let warnings = fs::read_to_string(page.with_file_name("report-1.warnings.csv")).unwrap();
    let told = document["warnings"].as_array().unwrap().len();
    assert_eq!(warnings.lines().count(), 1 + told, "{warnings}");
    let units = fs::read_to_string(page.with_file_name("report-1.parameters.csv")).unwrap();
    let of_gyro = units.lines().map(cells).filter(|row| row[0] == "gyro_y" && row[1] == "white");
    let named: Vec<(String, f64)> = of_gyro.map(|row| (row[6].clone(), row[3].parse().unwrap())).collect();
    let in_sheets = named.iter().find(|(unit, _)| unit == "deg/sqrt(h)").unwrap().1;
    assert!(named.len() == 6 && (in_sheets / (density.to_degrees() * 60.0) - 1.0).abs() < 1e-12, "{named:?}");
    let figures = |name: &str| {
        let files = fs::read_dir(page.with_file_name(name)).unwrap();
        files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect::<Vec<_>>()
    };
    for name in ["run1-allan-gyro_y.svg", "run1-spectrum-accel.svg"] {
        assert!(figures("report-1.svg-figures").iter().any(|figure| figure == name), "{name}");
    }
}

#[test]
fn existing_files_stay_by_default() {
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
    let own = folder.path().join("a.html");
    fs::rename(&capture, &own).unwrap();
    let output = vn100(&["report", text(&own), "-o", text(&own), "--force"]);
    assert!(!output.status.success(), "a capture is never replaced by its report");
}

#[test]
fn the_page_has_a_name_of_its_own_and_every_file_is_listed() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "night.vnymr", &[]);
    let report = |arguments: &[&str]| {
        let output = crate::support::vn100().current_dir(folder.path()).arg("report").args(arguments).output().unwrap();
        let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (output.status.code(), stdout, stderr)
    };
    // a refused file, here because its name is taken, does not prevent the others
    let (code, stdout, stderr) = report(&[text(&capture)]);
    assert_eq!((code, &stdout[..], &stderr[..]), (Some(0), "wrote night.html\n", ""));
    let forms = ["--force", "--export", "kalibr,csv,json,svg"];
    let (code, stdout, stderr) = report(&[&["night.vnymr"], &forms[..]].concat());
    assert!(code == Some(1) && stderr.contains("night.imu.yaml not written"), "{code:?} {stderr}");
    let written: Vec<&str> = stdout.lines().map(|line| line.strip_prefix("wrote ").unwrap()).collect();
    assert!(written.len() > 8 && !written.contains(&"night.imu.yaml"), "{written:?}");
    for name in ["night.html", "night.parameters.csv", "night.json", "night.svg-figures"] {
        assert!(written.contains(&name), "{name} in {written:?}");
    }
    assert!(written.iter().all(|name| folder.path().join(name).exists()), "{written:?}");
}

#[test]
fn names_without_a_page_are_wrong_usage() {
    for (arguments, expected) in [
        (&["-o", "out.pdf"][..], "out.pdf does not end in .html, name a page, and print it as PDF"),
        (&["-o", "out.pdf", "--export", "csv"], "print it as PDF"),
        (&["-o", "stem"], "nothing is exported"),
    ] {
        let output = vn100(&[&["report", "none.vnymr"], arguments].concat());
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && stderr.contains(expected), "{arguments:?}: {stderr}");
    }
}

#[test]
fn several_captures_are_laid_over_each_other_and_compared() {
    let folder = TempDir::new().unwrap();
    let a = simulated(&folder, "a.vnymr", &["--seed", "1"]);
    let b = simulated(&folder, "b.vnymr", &["--seed", "2"]);
    let (page, html) = report(&folder, &[&a, &b], &["--export", "json"]);
    assert!(html.contains("figure-records-gyro_y") && html.contains("figure-run1-allan-gyro_y"));
    assert!(html.contains("figure-run2-time-yaw") && html.contains("ignificant"));
    let ids: Vec<&str> = html.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    let mut unique = ids.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), ids.len(), "an id stands twice");
    assert!(page.with_file_name("report-1.json").exists() && page.with_file_name("report-2.json").exists());
}

#[test]
fn an_empty_capture_is_reported() {
    let folder = TempDir::new().unwrap();
    let capture = folder.path().join("nothing.vnymr");
    fs::write(&capture, "$VNYMR,broken\r\n".repeat(50)).unwrap();
    let page = folder.path().join("r.html");
    let output = vn100(&["report", text(&capture), "-o", text(&page)]);
    assert_eq!(output.status.code(), Some(3));
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("no valid sample") && html.contains("There are no results"));
    assert!(!html.contains("section id=\"parameters\"") && !html.contains("noise_density"), "it has no numbers");
}

/// Numbers of the data sheet have the unit of their row, powers of ten are typeset, and a verdict
/// has the same word everywhere.
#[test]
fn a_page_uses_one_unit_one_notation_and_one_word_for_one_thing() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "units.vnymr", &["--like", "lab3", "--duration", "20min"]);
    let (_, html) = report(&folder, &[&capture], &["--rate", "40"]);
    assert!(html.contains("typically 0.2 °/√h</td>") && html.contains("= 0.14 mG/√Hz"));
    // but for what is typed into other programs
    let (before, after) = without_scripts(&html)
        .split_once("<section id=\"filters\">")
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .unwrap();
    let text = before + after.split_once("</section>").unwrap().1;
    let plain_power = text.match_indices('e').find(|(place, _)| {
        let (before, after) = (text[..*place].chars().next_back(), &text.as_bytes()[place + 1..]);
        before.is_some_and(|c| c.is_ascii_digit()) && after[0] == b'-' && after[1].is_ascii_digit()
    });
    let around = |place: usize| text.get(place.saturating_sub(40)..place + 20);
    assert_eq!(plain_power.map(|(place, _)| around(place)), None);
    assert!(html.contains(" x typical</b>") && html.contains("gyro_x: N 0.3") && html.contains("data sheet N typ"));
    // the last sheet of paper holds more than the line at the foot
    let end = html.split("<div class=\"end\">").nth(1).unwrap();
    assert!(end.contains("id=\"references\"") && end.contains("<footer>"), "{end}");
    let print = html.split("@media print {").last().unwrap();
    assert!(print.split("break-inside: avoid").any(|rule| rule.contains(", .end,")), "{print}");
}

#[test]
fn the_shared_static_record_is_reported_correctly() {
    let Some(captures) = crate::support::real_captures() else { return };
    let capture = captures.join("vn100-static-kiran-330s.csv");
    let folder = TempDir::new().unwrap();
    let (_, html) = report(&folder, &[&capture], &["--compensated", "yes"]);
    holds_the_lab(&html);
    // the digest equals that of sha256sum
    for told in [
        "<dt>Start</dt><dd>2025-10-31T19:32:47.192Z</dd>",
        "18.4 Hz",
        "not measurable",
        "x typical",
        "VNIMU",
        "966bf211894b7113c2c12b44ddbcb255b991dd6594a7755e0730406592d81b47",
    ] {
        assert!(html.contains(told), "{told}");
    }
}

/// In a browser, if there is one: no error, every figure is interactive, and the pointer shows a value.
#[test]
fn a_browser_shows_it_without_complaint() {
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let found = browsers.iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    let Some(browser) = found else {
        eprintln!("skipped: no chromium on this machine");
        return;
    };
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "lab.vnymr", &["--like", "lab3"]);
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
            const reset = [...figure.querySelectorAll('button')].find((button) => button.textContent === 'Reset zoom');
            const zoomed = !reset.hidden;
            reset.click();
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
    assert!(told["read"].as_str().unwrap().contains(" °/h ("), "{told}");
    assert_eq!(
        (&told["zoomed"], &told["hidden"], &told["outside"]),
        (&true.into(), &"none".into(), &0.into()),
        "{told}"
    );
}

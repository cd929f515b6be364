//! The summary at the beginning of every result: its size, its order, its words and colours.

use std::path::Path;

use crate::support::*;

fn summary(file: &Path, options: &[&str]) -> String {
    let output = vn100().arg("replay").arg(file).args(options).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// At most 36 lines of 80 columns, without blanks at their ends.
fn check_size(text: &str) {
    assert!(text.lines().count() <= 36, "{} lines:\n{text}", text.lines().count());
    for line in text.lines() {
        assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?} in\n{text}");
    }
}

/// The cells of the row that begins with `label`.
fn row<'a>(text: &'a str, label: &str) -> Vec<&'a str> {
    let line = text.lines().find(|line| line.starts_with(label)).unwrap_or_else(|| panic!("no {label} in\n{text}"));
    line[label.len()..].split_whitespace().collect()
}

#[test]
fn every_kind_of_record_fits_and_says_what_may_be_wrong_after_the_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let sims: [&[&str]; 5] = [
        &["--message", "VNIMU", "--duration", "2h"],
        &["--message", "VNIMU", "--duration", "10s"],
        &["--message", "VNYMR", "--duration", "10min"],
        &["--like", "lab3", "--message", "VNIMU", "--duration", "1h"],
        &["--message", "VNQMR", "--duration", "5min"],
    ];
    for (number, options) in sims.into_iter().enumerate() {
        let text = summary(&capture(folder.path(), &format!("{number}.txt"), options), &[]);
        check_size(&text);
        let place = |word: &str| text.find(word).unwrap_or_else(|| panic!("no {word} in\n{text}"));
        let parts = ["\nGyroscope ", "\nAccelerometer ", "\n  data ", "\n  time ", "\nOne sample "].map(place);
        assert!(parts.is_sorted(), "{text}");
        assert!(place("sample rate unknown: 40 Hz assumed") < place("[1] give the sample rate"), "{text}");
    }
    for log in ["clean-minute.vnymr", "corrupted.vnymr", "gaps.vnymr", "binary-between.bin"] {
        check_size(&summary(&replay_log(log), &[]));
    }
    let Some(folder) = real_captures() else { return };
    for entry in [folder.join("wire"), folder].into_iter().flat_map(|folder| std::fs::read_dir(folder).unwrap()) {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ["csv", "vnymr", "bin"].iter().any(|known| ending == *known)) {
            check_size(&summary(&path, &[]));
            check_size(&summary(&path, &["--rate", "40", "--window", "20"]));
        }
    }
}

#[test]
fn results_from_too_few_samples_are_untested() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "imu.txt", &["--message", "VNIMU", "--duration", "30s"]);
    let of = |options: &[&str]| {
        let text = summary(&file, options);
        let words = ["  data ", "  time ", "  at rest "].map(|aspect| {
            let line = text.lines().find(|line| line.starts_with(aspect))?;
            line[aspect.len()..].split_whitespace().next().map(str::to_owned)
        });
        (words, text)
    };
    let (words, text) = of(&["--rate", "40"]);
    assert_eq!(words[2].as_deref(), Some("ok"), "{text}");
    let (words, text) = of(&["--rate", "40", "--duration", "2s"]);
    assert_eq!(words[2].as_deref(), Some("untested"), "{text}");
    let (words, text) = of(&["--rate", "40", "--skip", "1min"]);
    assert_eq!(words.each_ref().map(Option::as_deref), [Some("untested"), None, None], "{text}");
    assert!(text.contains("warm-up excluded, 30 s of 1 min"), "{text}");
}

#[test]
fn the_parameters_are_those_of_the_document_in_the_units_of_data_sheets() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "imu.txt", &["--message", "VNIMU", "--duration", "1h"]);
    let (document, _) = replay(&file, &["--rate", "40"]);
    let text = summary(&file, &["--rate", "40"]);
    for (label, sensor, factor) in [
        ("ARW N      deg/√h", "gyro", 60.0_f64.to_degrees()),
        ("VRW N      mg/√Hz", "accel", 1e3 / 9.80665),
        ("Density N  mG/√Hz", "mag", 1e3),
    ] {
        let values = row(&text, label).into_iter().filter(|cell| !cell.starts_with('±'));
        for (axis, cell) in ["x", "y", "z"].into_iter().zip(values) {
            let white = &channel(&document, &format!("{sensor}_{axis}"))["noise"]["white"]["value"];
            let (shown, is) = (cell.parse::<f64>().unwrap(), white.as_f64().unwrap() * factor);
            assert!((shown / is - 1.0).abs() < 0.006, "{label}{axis}: {shown}, and not {is}");
        }
    }
    // typical and limit are separate
    assert!(text.contains("max 10 ") && text.contains("typ 5-7 ") && text.contains("max 0.04 "), "{text}");
    let window = summary(&file, &["--rate", "40", "--window", "20"]);
    // any averaging is possible as long as the window is not known
    assert_eq!(row(&text, "  own N")[0], "≤", "{text}");
    let known = summary(&file, &["--rate", "40", "--window", "4"]);
    assert!(row(&known, "  own N")[1].starts_with("±1") && !row(&window, "ARW N").is_empty(), "{known}");
    let gyro = &window[window.find("\nGyroscope").unwrap()..window.find("\nAccelerometer").unwrap()];
    assert!(!gyro.contains("own N"), "nothing is aliased: {window}");
}

#[test]
fn a_moved_sensor_has_means_and_no_noise() {
    let Some(folder) = real_captures() else { return };
    let text = summary(&folder.join("vn100-shake-iwale-153s.vnymr"), &["--rate", "40"]);
    assert!(text.contains("\n  at rest   MOVED    sensor moved: standard deviation of gyro_x 6.077 rad/s"), "{text}");
    assert!(
        !text.contains("Gyroscope")
            && text.contains("\ngyro ")
            && text.contains("[1] exclude the beginning of the record")
    );
}

#[test]
fn colours_are_for_terminals_or_on_request() {
    let log = replay_log("clean-minute.vnymr");
    let plain = summary(&log, &[]);
    assert!(!plain.contains('\u{1b}') && summary(&log, &["--color", "never"]) == plain);
    let coloured = summary(&log, &["--color", "always"]);
    assert!(coloured.contains("\u{1b}[33mCHECK"), "{coloured:?}");
    let mut rest = coloured.as_str();
    let mut stripped = String::new();
    while let Some((text, code)) = rest.split_once('\u{1b}') {
        stripped += text;
        rest = code.split_once('m').unwrap().1;
    }
    let lines = |text: &str| text.lines().map(|line| line.trim_end().to_owned()).collect::<Vec<_>>();
    assert_eq!(lines(&(stripped + rest)), lines(&plain));
}

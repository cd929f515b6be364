//! What a refusal or a doubt says to type is typed: the program takes it, and does not say it again.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use crate::support::{capture, vn100};

/// The cures that a text prints between quotes of code, with an example for each word of the reader.
fn cures(text: &str) -> Vec<String> {
    let unwrapped = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let quoted =
        unwrapped.split('`').skip(1).step_by(2).filter(|text| text.starts_with("--") || text.starts_with("vn100"));
    let words = [
        ("HZ", "100"),
        ("TIME", "30s"),
        ("yes|no", "yes"),
        ("SAMPLES", "20"),
        ("PPM", "500"),
        ("PORT", "no-such-port"),
        ("gyro_x=NAME:rad/s,...", "gyro_x=no-such:rad/s"),
        ("CONDITIONS.toml", "no-such-file.toml"),
        ("FILE.toml", "no-such-file.toml"),
        ("report FILE", "report no-such-file"),
    ];
    quoted.map(|cure| words.iter().fold(cure.to_owned(), |cure, (word, example)| cure.replace(word, example))).collect()
}

/// Runs `replay` with these words; returns its exit code and all that it says.
fn replay(words: &[&str]) -> (i32, String) {
    let output = vn100().arg("replay").args(words).output().unwrap();
    let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
    (output.status.code().unwrap(), said)
}

/// Types each cure that is printed for a file, and adds it to those that were typed; a command once.
fn typed(all: &mut Vec<String>, file: &Path, options: &[&str]) {
    let words: Vec<&str> = [file.to_str().unwrap()].into_iter().chain(options.iter().copied()).collect();
    let (refused, said) = replay(&words);
    let cures = cures(&said);
    assert!(!cures.is_empty(), "{said}");
    for cure in &cures {
        let cure_words: Vec<&str> = cure.split(' ').collect();
        if let ["vn100", command @ ..] = &cure_words[..] {
            if all.contains(cure) {
                continue;
            }
            let output = vn100().args(command).output().unwrap();
            let error = String::from_utf8(output.stderr).unwrap();
            // what a port or a file of the reader would answer is another matter than a wrong word
            assert!(output.status.success() || error.contains("no-such"), "{cure}: {error}");
            continue;
        }
        // a rate that was given and is doubted is replaced, not given twice
        let others: Vec<&str> = if cure_words[0] == "--rate" { words[..1].to_vec() } else { words.clone() };
        let (code, then) = replay(&[&others[..], &cure_words[..]].concat());
        assert!(code == 0 || cure.contains("no-such"), "{cure} of\n{said}\nsays\n{then}");
        assert!(refused != 0 || !then.contains(&format!("`{cure}`")), "{cure} is said again:\n{then}");
    }
    all.extend(cures);
}

/// A table of rates in rad/s and accelerations in m/s², by their function of the row.
fn table(path: PathBuf, header: &str, rows: usize, row: impl Fn(usize, f64) -> String) -> PathBuf {
    let mut text = format!("{header}\n");
    let mut state = 1_u64;
    for at in 0..rows {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise = (state >> 40) as f64 / f64::from(1 << 24) - 0.5;
        writeln!(text, "{}", row(at, noise)).unwrap();
    }
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn each_printed_cure_works_when_it_is_typed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut all = Vec::new();

    let untimed = table(path("untimed.csv"), "gyro_x", 3000, |_, noise| format!("{:.7}", 0.01 * noise));
    typed(&mut all, &untimed, &[]);
    let timed =
        table(path("timed.csv"), "t,gyro_x", 3000, |at, noise| format!("{:.2},{:.7}", at as f64 / 100.0, 0.01 * noise));
    typed(&mut all, &timed, &[]);
    typed(&mut all, &timed, &["--rate", "50"]);
    let moved = table(path("moved.csv"), "t,accel_x,accel_y,accel_z,gyro_x", 9000, |at, noise| {
        let turn = if at < 2000 { (at as f64 / 40.0).sin() } else { 0.0 };
        format!(
            "{:.2},{:.5},{:.5},9.81,{:.6}",
            at as f64 / 100.0,
            0.1 * noise + 3.0 * turn,
            0.1 * noise,
            0.01 * noise + 2.0 * turn
        )
    });
    typed(&mut all, &moved, &[]);

    let text = capture(folder.path(), "sensor.vnymr", &["--duration", "60s"]);
    typed(&mut all, &text, &[]);
    let sentences = fs::read_to_string(&text).unwrap();
    let unchecked: String = sentences.lines().map(|line| line.split('*').next().unwrap().to_owned() + "\r\n").collect();
    fs::write(path("unchecked.vnymr"), unchecked).unwrap();
    typed(&mut all, &path("unchecked.vnymr"), &[]);
    let packets =
        fs::read(capture(folder.path(), "packets.bin", &["--duration", "60s", "--message", "binary"])).unwrap();
    fs::write(path("both.raw"), [sentences.into_bytes(), packets].concat()).unwrap();
    typed(&mut all, &path("both.raw"), &[]);

    let kinds = ["--rate", "--compensated", "--skip", "--duration", "--accept-unchecked", "vn100 plan", "--window"];
    for kind in kinds {
        assert!(all.iter().any(|cure| cure.starts_with(kind)), "{kind} is in none of {all:#?}");
    }
}

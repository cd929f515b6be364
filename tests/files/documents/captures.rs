//! The files that the commands of the documents read, under the names used there.

use std::{fs, path::Path};

use crate::support::{capture, vn100, with_stdin};

/// Captures of emulated sensors, with the options that make them.
const CAPTURES: &[(&str, &str)] = &[
    ("FILE.mcap", "--message VNIMU"),
    ("lab.mcap", "--message VNIMU"),
    ("mon.mcap", "--message VNIMU --seed 1"),
    ("monday.mcap", "--message VNIMU --seed 2"),
    ("monday.vnymr", ""),
    ("night.mcap", "--message VNIMU"),
    // longer than the ten minutes at 200 Hz that are skipped
    ("run.vnymr", "--duration 51min"),
    ("tue.mcap", "--message VNIMU --seed 3"),
    ("tuesday.bin", "--message BINARY"),
    ("tuesday.mcap", "--message VNIMU --seed 4"),
    ("unit1.mcap", "--message VNIMU --seed 5"),
    ("unit2.mcap", "--message VNIMU --seed 6"),
    ("wed.mcap", "--message VNIMU --seed 7"),
    ("captures/a.mcap", ""),
    ("captures/b.vnymr", "--seed 2"),
];

pub(crate) fn make(folder: &Path) {
    fs::create_dir(folder.join("captures")).unwrap();
    for (name, options) in CAPTURES {
        capture(folder, name, &options.split_whitespace().collect::<Vec<_>>());
    }
    fs::write(folder.join("conditions.toml"), "place = \"bench\"\n").unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::copy(&mut &fs::read(folder.join("tuesday.bin")).unwrap()[..], &mut packed).unwrap();
    fs::write(folder.join("tuesday.bin.gz"), packed.finish().unwrap()).unwrap();
    // a night in three parts
    let mut record = vn100();
    record.args(["record", "-", "-q", "--rotate", "100kB", "-o"]).arg(folder.join("night.mcap"));
    let stream = fs::read(folder.join("monday.vnymr")).unwrap();
    assert!(with_stdin(&mut record, &stream).status.success());
    // tables of other sensors, and of the samples of a recording
    let row =
        |time: u64| (time * 25_000_000, (time * 7919 % 101) as f64 * 1e-3, 9.8 + (time * 104_729 % 103) as f64 * 1e-3);
    let rows = || (0..2400).map(row);
    let table: String = rows().map(|(stamp, rate, force)| format!("{stamp},{rate:.3},{force:.3}\n")).collect();
    fs::write(folder.join("other.csv"), format!("stamp,wx,az\n{table}")).unwrap();
    let series: String = rows().map(|(_, rate, _)| format!("{rate:.3}\n")).collect();
    fs::write(folder.join("clock.csv"), format!("y\n{series}")).unwrap();
    let mut samples = vn100();
    samples.arg("replay").arg(folder.join("night.mcap")).arg("--samples").arg(folder.join("FILE.csv"));
    assert!(samples.output().unwrap().status.success());
}

/// Gives another folder the same files, of recordings copies: one that is resumed is claimed for a while, under each
/// of its names.
pub(crate) fn link(made: &Path, folder: &Path) {
    for entry in fs::read_dir(made).unwrap().map(|entry| entry.unwrap()) {
        let place = folder.join(entry.file_name());
        if entry.path().is_dir() {
            fs::create_dir(&place).unwrap();
            link(&entry.path(), &place);
        } else if place.extension().is_some_and(|extension| extension == "mcap") {
            fs::copy(entry.path(), place).unwrap();
        } else {
            fs::hard_link(entry.path(), place).unwrap();
        }
    }
}

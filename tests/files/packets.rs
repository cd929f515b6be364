//! Binary packets of real sensors compared with other programs, and of the emulated sensor compared
//! with its truth.

use std::fs;

use serde_json::Value;
use vn100_protocol::stream::{ReadOptions, SampleReader};

use crate::support::{channel, real_captures, replay, vn100};

fn timing<'a>(document: &'a Value, name: &str) -> &'a Value {
    &document["timing"][name]
}

/// A logger's file of ten packets per second between its own sentences, and the same packets
/// decoded by another program: 14 of its 29 columns are measured.
#[test]
fn every_row_is_as_another_program_decoded_it() {
    let Some(folder) = real_captures().map(|folder| folder.join("binary")) else { return };
    let mut reader = SampleReader::new(ReadOptions::default());
    reader.push(&fs::read(folder.join("F00379")).unwrap(), None);
    let batches = [reader.take_batches(), reader.finish()].concat();
    let layout = batches[0].layout.clone().unwrap();
    let rows: Vec<&[i32]> = batches.iter().flat_map(|batch| batch.rows()).collect();
    let text = fs::read_to_string(folder.join("F00379_B")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').map(str::trim).collect();
    let decoded: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').filter_map(|cell| cell.trim().parse().ok()).collect::<Vec<f64>>())
        .filter(|cells| cells.len() == 29)
        .collect();
    assert_eq!((rows.len(), decoded.len()), (8895, 8895));
    let theirs = [
        ("yaw", "Yaw"),
        ("pitch", "Pitch"),
        ("roll", "Roll"),
        ("mag_x", "MagX"),
        ("mag_y", "MagY"),
        ("mag_z", "MagZ"),
        ("accel_x", "AccX"),
        ("accel_y", "AccY"),
        ("accel_z", "AccZ"),
        ("gyro_x", "GyroX"),
        ("gyro_y", "GyroY"),
        ("gyro_z", "GyroZ"),
        ("temperature", "Temp"),
        ("pressure", "Pres"),
    ];
    assert_eq!(layout.channels.len(), theirs.len());
    for (place, (channel, (ours, theirs))) in layout.channels.iter().zip(theirs).enumerate() {
        assert_eq!(channel.name, ours);
        let column = names.iter().position(|name| *name == theirs).unwrap();
        for (row, (counts, cells)) in rows.iter().zip(&decoded).enumerate() {
            let (value, expected) = (channel.value(counts[place]), cells[column]);
            // six digits after the point of the printed number, and half a count
            let tolerance = 5.1e-7 * expected.abs() + 0.51 * channel.scale;
            assert!((value - expected).abs() <= tolerance, "{ours} of row {row}: {value}, not {expected}");
        }
    }
}

#[test]
fn streams_of_a_real_sensor_have_its_rate_and_lose_nothing() {
    let Some(folder) = real_captures().map(|folder| folder.join("wire")) else { return };
    for (name, options, samples, rate_hz) in [
        ("binonly-95pct_clean.bin", &[][..], 800, 800.0),
        ("binary-only.bin", &[], 200, 200.0),
        ("mixed-50pct_clean.bin", &["--measure", "packets"], 199, 200.0),
    ] {
        let (document, exit) = replay(&folder.join(name), options);
        assert_eq!((exit, &document["source"]["message"]), (0, &"BINARY".into()), "{name}");
        assert_eq!(
            (timing(&document, "samples"), timing(&document, "missing")),
            (&samples.into(), &0.into()),
            "{name}"
        );
        assert_eq!(
            (timing(&document, "rate_hz"), timing(&document, "rate_from")),
            (&rate_hz.into(), &"device-time".into())
        );
        assert_eq!(timing(&document, "missing_from"), "device-time");
        assert_eq!(document["link"]["rejected_packets"], 0);
    }
    // by default, sentences are measured
    let (document, _) = replay(&folder.join("mixed-50pct_clean.bin"), &[]);
    assert_eq!((&document["source"]["message"], &document["link"]["binary_packets"]), (&"VNYMR".into(), &199.into()));
}

#[test]
fn at_800_hz_n_is_that_of_the_sensor_and_slower_channels_have_rates_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.bin");
    let made = vn100()
        .args(["sim", "--message", "BINARY+MAG", "--rate", "800", "--duration", "2m", "--like", "lab3", "-o"])
        .arg(&file)
        .status()
        .unwrap();
    assert!(made.success());
    let (document, exit) = replay(&file, &[]);
    assert_eq!((exit, timing(&document, "samples")), (0, &96_000.into()));
    let rates = |name: &str| channel(&document, name)["rate_hz"].as_f64().unwrap();
    assert_eq!(["gyro_y", "mag_x", "temperature", "pressure"].map(rates), [800.0, 200.0, 100.0, 100.0]);
    assert_eq!(channel(&document, "mag_x")["statistics"]["count"], 24_000);
    // aliased from 250 Hz to its own 200 Hz, not to that of the packets
    let factor = channel(&document, "mag_x")["noise"]["white"]["budget"]["aliasing"]["factor"].as_f64().unwrap();
    assert!((factor / (250.0_f64 / 200.0).sqrt() - 1.0).abs() < 1e-9, "{factor}");
    // the profile states 0.354 °/√h
    let truth = 0.354_f64.to_radians() / 60.0;
    let white = &channel(&document, "gyro_y")["noise"]["white"];
    let [lower, upper] = ["lower", "upper"].map(|end| white[end].as_f64().unwrap());
    assert!(lower < truth && truth < upper, "{lower} to {upper} without {truth}");
}

/// At one row per second, momentary values alias the noise up to 400 Hz, and integrals alias none.
#[test]
fn integrals_show_the_density_of_the_sensor_at_any_rate() {
    let folder = tempfile::tempdir().unwrap();
    // the profile states 0.0035 °/s/√Hz and 0.14 mg/√Hz
    let truths = [("gyro_y", 0.0035_f64.to_radians()), ("accel_z", 0.14e-3 * 9.80665)];
    let white = |message: &str| {
        let file = folder.path().join(message);
        let mut sim = vn100();
        sim.args(["sim", "--message", message, "--rate", "1", "--duration", "1h", "--seed", "7", "-o"]).arg(&file);
        assert!(sim.status().unwrap().success());
        let (document, exit) = replay(&file, &["--rate", "1"]);
        assert_eq!((exit, timing(&document, "samples")), (0, &3600.into()));
        truths.map(|(name, truth)| channel(&document, name)["noise"]["white"]["value"].as_f64().unwrap() / truth)
    };
    let (integrals, momentary) = (white("VNDTV"), white("VNIMU"));
    assert!(integrals.iter().all(|ratio| (ratio - 1.0).abs() < 0.1), "{integrals:?}");
    assert!(momentary.iter().all(|ratio| *ratio > 10.0), "{momentary:?}");
}

/// At 40 Hz the noise of the accelerometer is a fifth of a step of the printed change of velocity.
#[test]
fn printed_steps_of_short_integrals_hide_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.vnymr");
    let mut sim = vn100();
    sim.args(["sim", "--message", "VNDTV", "--rate", "40", "--duration", "2m", "-o"]).arg(&file);
    assert!(sim.status().unwrap().success());
    let (document, _) = replay(&file, &["--rate", "40"]);
    assert_eq!(channel(&document, "accel_x")["noise"]["white"]["status"], "not-measurable");
    assert_eq!(channel(&document, "accel_x")["statistics"]["resolution"], 0.04);
}

#[test]
fn the_summary_names_the_source_of_the_rate_of_packets() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.bin");
    let made =
        vn100().args(["sim", "--message", "BINARY", "--rate", "400", "--duration", "10s", "-o"]).arg(&file).status();
    assert!(made.unwrap().success());
    let text = String::from_utf8(vn100().arg("replay").arg(&file).output().unwrap().stdout).unwrap();
    assert!(text.contains("  time      ok       400 Hz, from device time in each packet\n"), "{text}");
}

#[test]
fn uncompensated_packets_with_an_attitude_are_measured_as_such() {
    let Some(folder) = real_captures().map(|folder| folder.join("binary")) else { return };
    let output = vn100().arg("replay").arg(folder.join("F00379")).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains("bias-compensated") && !text.contains("VNIMU"), "{text}");
    let (document, _) = replay(&folder.join("F00379"), &[]);
    assert_eq!(document["source"]["compensated"], false);
}

#[test]
fn lost_packets_are_counted_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.bin");
    let made = vn100()
        .args(["sim", "--message", "BINARY", "--rate", "400", "--duration", "10s", "-o"])
        .arg(&file)
        .status()
        .unwrap();
    assert!(made.success());
    let bytes = fs::read(&file).unwrap();
    let packets: Vec<&[u8]> = bytes.chunks(44).collect();
    assert_eq!(packets.len(), 4000);
    let kept = packets.iter().enumerate().filter(|(number, _)| !(1000..1700).contains(number) && number % 97 != 5);
    let mut damaged: Vec<u8> = kept.flat_map(|(_, packet)| packet.to_vec()).collect();
    // one more because of a wrong bit
    damaged[20 * 44 + 30] ^= 1;
    fs::write(&file, &damaged).unwrap();
    let (document, _) = replay(&file, &[]);
    let samples = damaged.len() / 44 - 1;
    assert_eq!(timing(&document, "samples"), samples);
    // the first and the last are present
    assert_eq!(timing(&document, "missing"), 4000 - samples);
    assert_eq!(timing(&document, "rate_hz"), 400.0);
    assert_eq!((&document["link"]["skipped_bytes"], &document["link"]["damaged_packets"]), (&44.into(), &1.into()));
    let text = String::from_utf8(vn100().arg("replay").arg(&file).output().unwrap().stdout).unwrap();
    assert!(text.contains("packets rejected: checksum mismatch"), "{text}");
}

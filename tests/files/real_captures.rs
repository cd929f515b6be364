//! Recordings of real sensors: the correct result for each. They are not part of the project;
//! without them these tests report this and pass.

use std::{fs, path::Path};

use serde_json::Value;
use vn100_protocol::{Check, Frame, Framer, Options};

use crate::support::{channel, deviation, real_captures, replay, warned};

fn bad(document: &Value) -> u64 {
    document["link"]["bad_frames"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum()
}

fn samples(document: &Value) -> u64 {
    document["timing"]["samples"].as_u64().unwrap()
}

/// Runs `check` on the document of a capture, if there are captures.
fn check(name: &str, options: &[&str], check: impl FnOnce(&Value, i32)) {
    if let Some(folder) = real_captures() {
        let (document, exit) = replay(&folder.join(name), options);
        assert_bytes_conserved(&folder.join(name), &document);
        check(&document, exit);
    }
}

fn assert_bytes_conserved(file: &Path, document: &Value) {
    assert_eq!(document["link"]["bytes"], fs::metadata(file).unwrap().len());
}

fn close(got: &Value, expected: f64, relative: f64) {
    let got = got.as_f64().unwrap();
    assert!((got - expected).abs() <= relative * expected.abs(), "{got} is not {expected}");
}

#[test]
fn a_static_record_reads_clean_and_right() {
    check("vn100-static-kiran-330s.vnymr", &["--rate", "40"], |document, exit| {
        assert_eq!((exit, samples(document), bad(document)), (0, 13_223, 0));
        assert_eq!(document["link"]["frames"], 13_223);
        let gyro_y = &channel(document, "gyro_y")["statistics"];
        close(&gyro_y["mean"], 7.670_800_9e-6, 1e-7);
        close(&gyro_y["std"], 0.001_102_01, 1e-5);
        let accel_z = &channel(document, "accel_z")["statistics"];
        close(&accel_z["mean"], -9.887_886_4, 1e-8);
        close(&accel_z["std"], 0.026_343_2, 1e-5);
    });
}

#[test]
fn the_overlapping_deviation_of_the_static_record_is_the_published_one() {
    check("vn100-static-kiran-330s.vnymr", &["--rate", "40", "--estimator", "full"], |document, _| {
        for (m, expected) in [(1, 0.001_338_06), (32, 0.000_144_304), (512, 3.842_68e-5)] {
            let got = deviation(document, "gyro_y", m);
            assert!((got - expected).abs() < 1e-5 * expected, "m = {m}: {got}");
        }
    });
}

#[test]
fn clean_moving_records_lose_nothing() {
    for (name, lines) in [
        ("vn100-donut-huang-155s.vnymr", 6_206),
        ("vn100-shake-iwale-153s.vnymr", 6_127),
        ("vn100-circles-qian-95s-GAPS.vnymr", 3_671),
        ("vn100-hand-thumatti-BADSTAMPS.vnymr", 12_114),
        ("vn100-static1hz-ramirez-run2-623s.vnymr", 623),
    ] {
        check(name, &[], |document, exit| {
            assert_eq!((exit, samples(document), bad(document)), (0, lines, 0), "{name}");
            assert!(!warned(document, "repeated-lines"), "{name}");
        });
    }
}

#[test]
fn a_sensor_that_only_warms_up_shows_no_temperature_coefficient() {
    let Some(captures) = real_captures() else { return };
    // ten samples per second of the binary output, as decoded by their logger: from 7.6 to 15.6 °C
    let decoded = fs::read_to_string(captures.join("binary/F00379_B")).unwrap();
    let mut table = String::from("ax,ay,az,gx,gy,gz,degrees\n");
    for line in decoded.lines() {
        let numbers: Option<Vec<f64>> =
            line.split(',').filter(|field| !field.trim().is_empty()).map(|field| field.trim().parse().ok()).collect();
        if let Some([_, _, _, values @ ..]) = numbers.as_deref().filter(|numbers| numbers.len() > 10) {
            let fields: Vec<String> = values[..7].iter().map(|value| format!("{value:.6}")).collect();
            table += &format!("{}\n", fields.join(","));
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("decoded.csv");
    fs::write(&path, table).unwrap();
    let columns = "accel_x=ax:m/s^2,accel_y=ay:m/s^2,accel_z=az:m/s^2,gyro_x=gx:rad/s,gyro_y=gy:rad/s,gyro_z=gz:rad/s,\
                   temperature=degrees:degC";
    // the sensor was put into its place at the beginning
    let (handled, _) = replay(&path, &["--rate", "10", "--columns", columns]);
    assert_eq!(channel(&handled, "accel_x")["noise"]["temperature"]["reason"], "moved");
    let (document, _) = replay(&path, &["--rate", "10", "--skip", "1min", "--columns", columns]);
    for name in ["accel_x", "accel_y", "accel_z"] {
        let found = &channel(&document, name)["noise"]["temperature"];
        assert_eq!(
            (&found["status"], &found["reason"]),
            (&"not-observable".into(), &"one-direction".into()),
            "{found}"
        );
    }
}

#[test]
fn a_moved_sensor_is_distinguished_from_one_at_rest_and_gets_no_verdict() {
    let judged = |document: &Value| {
        let channels = document["channels"].as_array().unwrap();
        channels
            .iter()
            .any(|channel| !channel["verdict"].is_null() || !channel["stationarity"]["level_change"].is_null())
    };
    let is_moved = |document: &Value| {
        let warnings = document["warnings"].as_array().unwrap();
        warnings.iter().any(|warning| {
            warning["kind"] == "not-stationary" && warning["text"].as_str().unwrap().starts_with("sensor moved: ")
        })
    };
    for name in [
        "vn100-donut-huang-155s.csv",
        "vn100-circles-qian-95s-GAPS.csv",
        "vn100-shake-iwale-153s.csv",
        "vn100-circles-rohx17-NOCHECKSUM.csv",
        "vn100-hand-thumatti-BADSTAMPS.csv",
        "vn100-walk-circle-sazgar-CORRUPT.csv",
    ] {
        let rate: &[_] = if name.contains("BADSTAMPS") { &["--rate", "40"] } else { &[] };
        check(name, &[&["--fail-on", "gyro N"], rate].concat(), |document, exit| {
            assert_eq!((exit, is_moved(document), judged(document)), (4, true, false), "{name}");
            for kind in ["vibration-line", "warm-up", "magnitude-off"] {
                assert!(!warned(document, kind), "{name}: {kind}");
            }
        });
    }
    for name in ["vn100-static-kiran-330s.csv", "vn100-static1hz-ramirez-run2-623s.csv"] {
        check(name, &[], |document, exit| {
            assert_eq!((exit, is_moved(document), judged(document)), (0, false, true), "{name}");
        });
    }
}

#[test]
fn spliced_lines_are_refused() {
    check("vn100-walk-circle-sazgar-CORRUPT.vnymr", &[], |document, _| {
        assert_eq!((samples(document), bad(document)), (3_875, 5));
        assert_eq!(document["link"]["bad_frames"]["checksum"], 5);
        assert_eq!(document["timing"]["missing_at_least"], 5);
    });
}

#[test]
fn lines_without_checksum_need_permission() {
    let name = "vn100-circles-rohx17-NOCHECKSUM.vnymr";
    check(name, &[], |document, exit| {
        assert_eq!((exit, samples(document)), (3, 0));
        assert_eq!(document["link"]["bad_frames"]["unchecked"], 3_991);
    });
    check(name, &["--accept-unchecked"], |document, exit| {
        assert_eq!((exit, samples(document), bad(document)), (0, 3_991, 0));
        assert!(warned(document, "bad-lines"));
    });
}

#[test]
fn a_loop_is_distinguished_from_a_sensor() {
    check("emulator-loop-pattala-449s.vnymr", &[], |document, _| {
        assert_eq!(samples(document), 449);
        assert!(warned(document, "repeated-lines"));
    });
}

#[test]
fn junk_before_the_first_line_is_skipped_and_counted() {
    check("wire/ascii-only.bin", &[], |document, exit| {
        assert_eq!((exit, samples(document), bad(document)), (0, 39, 0));
        assert_eq!(document["link"]["skipped_bytes"], 76);
    });
}

#[test]
fn binary_packets_between_lines_are_packets() {
    for name in
        ["wire/both-streams.bin", "wire/zero-parse__misframe-before.bin", "wire/zero-parse__timing-run-2__t1-after.bin"]
    {
        check(name, &[], |document, exit| {
            assert_eq!((exit, samples(document)), (0, 40), "{name}");
            assert!(document["link"]["binary_packets"].as_u64().unwrap() > 100, "{name}");
        });
    }
}

#[test]
fn flipped_bits_and_a_wrong_baud_rate_are_named() {
    for (name, words) in [
        ("wire/zero-parse__misframe-fail.bin", "without a valid line"),
        ("wire/zero-parse__stale-fail.bin", "wrong baud rate"),
    ] {
        check(name, &[], |document, exit| {
            assert_eq!((exit, samples(document)), (3, 0), "{name}");
            let text = document["warnings"].to_string();
            assert!(text.contains(words), "{name}: {text}");
        });
    }
}

/// Resolves the escapes of the list: `\r`, `\n`, `\xNN` and `\\`.
fn unescape(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'\\' => match rest.next().unwrap() {
                b'r' => b'\r',
                b'n' => b'\n',
                b'x' => {
                    let digits = [rest.next().unwrap(), rest.next().unwrap()];
                    u8::from_str_radix(std::str::from_utf8(&digits).unwrap(), 16).unwrap()
                }
                other => other,
            },
            other => other,
        });
    }
    bytes
}

#[test]
fn each_published_frame_is_valid_or_not_as_listed() {
    let Some(folder) = real_captures() else {
        return;
    };
    let list = fs::read_to_string(folder.join("frames-real.txt")).unwrap();
    let mut seen = 0;
    for line in list.lines().filter(|line| !line.starts_with('#')) {
        let [_, frame, valid] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let bytes = unescape(frame);
        let mut framer = Framer::new(Options::default());
        let mut input = &bytes[..];
        let mut valid_here = false;
        loop {
            let (consumed, frame) = framer.next(input, true);
            match frame {
                Some(Frame::Sentence(sentence)) => valid_here |= sentence.check != Check::None,
                Some(_) => {}
                None => break,
            }
            input = &input[consumed..];
        }
        assert_eq!(valid_here, valid == "yes", "{frame}");
        seen += 1;
    }
    assert_eq!(seen, 243);
}

/// Samples, missing ones that are known, and gaps of a recording with stamps.
fn placed(document: &Value) -> [u64; 3] {
    ["samples", "missing_at_least", "gaps"].map(|field| document["timing"][field].as_u64().unwrap())
}

#[test]
fn stamps_show_the_rate_and_the_missing_samples() {
    for (name, rate_hz, lines, missing, within) in [
        ("vn100-static-kiran-330s.csv", 40.0, 13_223, 0, 0),
        ("vn100-static1hz-ramirez-run2-623s.csv", 1.0, 623, 0, 0),
        ("vn100-donut-huang-155s.csv", 40.0, 6_206, 0, 0),
        ("vn100-shake-iwale-153s.csv", 40.0, 6_127, 0, 0),
        ("vn100-circles-qian-95s-GAPS.csv", 40.0, 3_671, 121, 2),
        ("vn100-walk-circle-sazgar-CORRUPT.csv", 40.0, 3_875, 1_240, 2),
        ("vn100-circles-rohx17-NOCHECKSUM.csv", 40.0, 3_991, 24, 0),
    ] {
        check(name, &[], |document, exit| {
            let [samples, found, _] = placed(document);
            assert_eq!((exit, samples), (0, lines), "{name}");
            assert_eq!(
                (&document["timing"]["rate_hz"], &document["timing"]["rate_from"]),
                (&rate_hz.into(), &"arrival".into())
            );
            assert!(found.abs_diff(missing) <= within, "{name}: {found} missing");
            assert!(warned(document, "bad-lines"), "{name}");
        });
    }
    check("vn100-circles-rohx17-NOCHECKSUM.csv", &[], |document, _| {
        assert_eq!(placed(document)[2], 1, "one gap of 622 ms")
    });
    check("vn100-donut-huang-155s.csv", &[], |document, _| assert!(warned(document, "stamps-doubtful")));
    check("wire/zero-parse__timing-run-2__t1-after.bin", &[], |document, _| {
        assert_eq!(document["timing"]["missing_from"], "arrival");
        assert_eq!(placed(document), [40, 0, 0]);
    });
}

#[test]
fn stamps_of_a_file_that_was_read_are_refused() {
    let name = "vn100-hand-thumatti-BADSTAMPS.csv";
    if let Some(folder) = real_captures() {
        let (document, exit) = replay(&folder.join(name), &[]);
        assert_eq!((exit, placed(&document)), (2, [0, 0, 0]));
        let error = document["source"]["error"].as_str().unwrap();
        assert!(error.contains("the sensor sends at most 200 Hz") && error.contains("--rate HZ"), "{error}");
    }
    check(name, &["--rate", "40"], |document, exit| {
        assert_eq!((exit, placed(document)), (0, [12_114, 0, 0]));
        assert!(warned(document, "stamps-doubtful"));
    });
}

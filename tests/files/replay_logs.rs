//! The captures of the project: the result of the program for each equals the expected one in the
//! same folder.

#[path = "../../crates/vn100-sim/examples/replay_logs/main.rs"]
#[allow(dead_code, reason = "the recipe's own main")]
mod recipe;

use std::{fs, path::Path};

use serde_json::Value;

use crate::support::{replay, replay_log};

const LOGS: &[&str] = &["clean-minute.vnymr", "corrupted.vnymr", "gaps.vnymr", "binary-between.bin"];

/// Everything in `expected` must be in `got`; `got` may contain more. Numbers are equal to the last
/// digit.
fn assert_contains(got: &Value, expected: &Value, place: &str) {
    match expected {
        Value::Object(fields) => {
            for (name, value) in fields {
                assert_contains(&got[name], value, &format!("{place}/{name}"));
            }
        }
        Value::Array(items) => {
            assert_eq!(got.as_array().map(Vec::len), Some(items.len()), "{place}");
            for (index, item) in items.iter().enumerate() {
                assert_contains(&got[index], item, &format!("{place}/{index}"));
            }
        }
        _ => assert_eq!(got, expected, "{place}"),
    }
}

#[test]
fn each_log_reads_as_expected() {
    for log in LOGS {
        let expected = fs::read_to_string(replay_log(&format!("{log}.expected.json"))).unwrap();
        let (document, exit) = replay(&replay_log(log), &[]);
        assert_eq!(exit, 0, "{log}");
        assert_contains(&document, &serde_json::from_str(&expected).unwrap(), log);
    }
}

#[test]
fn every_log_is_tested() {
    for entry in fs::read_dir(replay_log("")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known =
            name == "README.md" || LOGS.iter().any(|log| name == *log || name == format!("{log}.expected.json"));
        assert!(known, "{name} is not in the list of this test");
        assert!(Path::new(&name).extension().is_some());
    }
}

#[test]
fn the_captures_equal_the_output_of_the_example_that_writes_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../replay-logs");
    for recipe::Log { name, bytes } in recipe::logs().unwrap() {
        let shipped = fs::read(folder.join(name)).unwrap();
        assert!(shipped == bytes, "{name} differs: run the example replay_logs, or undo the change");
    }
}

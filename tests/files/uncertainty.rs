//! The uncertainty of a result is stated equally in documents, tables and page.

use std::fs;

use serde_json::Value;

use crate::support::{capture, channel, replay, vn100};

#[test]
fn no_deviation_has_an_interval_below_two_degrees_of_freedom() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "a.txt", &["--message", "VNIMU", "--duration", "2min"]);
    let (document, _) = replay(&file, &["--rate", "40"]);
    let (mut without, mut with) = (0, 0);
    for found in document["channels"].as_array().unwrap() {
        for point in found["allan"]["points"].as_array().unwrap() {
            assert!(point["deviation"].is_number(), "{point}");
            match point["edf"].as_f64() {
                Some(edf) => {
                    assert!(edf >= 2.0 && point["lower"].is_number() && point["upper"].is_number(), "{point}");
                    with += 1;
                }
                None => {
                    assert!(point["lower"].is_null() && point["upper"].is_null(), "{point}");
                    without += 1;
                }
            }
        }
    }
    assert!(without >= 9 && with > 9 * without, "{without} of {with}");
    let page = folder.path().join("a.html");
    let output = vn100().arg("report").arg(&file).args(["--rate", "40", "--export", "csv", "-o"]).arg(&page).output();
    assert!(output.unwrap().status.success());
    let table = fs::read_to_string(page.with_extension("allan.csv")).unwrap();
    let empty = table.lines().skip(1).filter(|row| row.split(',').skip(5).take(3).all(str::is_empty)).count();
    let partly = table.lines().skip(1).filter(|row| row.split(',').skip(5).take(3).any(str::is_empty)).count();
    assert_eq!((empty, partly), (without, without));
}

#[test]
fn each_estimated_slow_term_has_its_p_and_b_has_the_minimum() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "a.txt", &["--message", "VNIMU", "--duration", "2h"]);
    let options = ["--rate", "40", "--window", "4"];
    let (document, _) = replay(&file, &options);
    let noise = &channel(&document, "gyro_x")["noise"];
    let bias = &noise["bias_instability"];
    assert_eq!(bias["status"], "estimated");
    assert!((0.0..0.05).contains(&bias["p"].as_f64().unwrap()), "{bias}");
    // 0.664 B plus the contribution of white noise and a walk
    let minimum = &noise["curve_minimum"];
    let ratio = minimum["value"].as_f64().unwrap() / bias["value"].as_f64().unwrap();
    assert!((0.66..0.9).contains(&ratio), "{ratio}");
    let page = folder.path().join("a.html");
    let output = vn100().arg("report").arg(&file).args(options).args(["--export", "csv", "-o"]).arg(&page).output();
    assert!(output.unwrap().status.success());
    let html = fs::read_to_string(&page).unwrap();
    for told in ["p without B", "minimum of the curve", "Further uncertainty of N"] {
        assert!(html.contains(told), "{told}");
    }
    let table = fs::read_to_string(page.with_extension("parameters.csv")).unwrap();
    assert!(table.starts_with("channel,parameter,status,value,lower,upper,unit,p,sides,is_si\n"), "{table}");
    let row = |name: &str| table.lines().find(|row| row.starts_with(&format!("gyro_x,{name},"))).unwrap().to_owned();
    let cell = |name: &str, place: usize| row(name).split(',').nth(place).unwrap().to_owned();
    assert_eq!(cell("bias_instability", 7).parse::<f64>().ok(), bias["p"].as_f64());
    assert_eq!([cell("curve_minimum", 6), cell("curve_minimum", 7)], ["rad/s", ""], "{}", row("curve_minimum"));
}

#[test]
fn the_budget_of_n_contains_rate_and_aliasing() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "a.txt", &["--duration", "2min"]);
    let budget = |options: &[&str]| replay(&file, options).0;
    let of = |document: &Value| channel(document, "gyro_y")["noise"]["white"]["budget"].clone();
    let assumed = of(&budget(&[]));
    assert_eq!([&assumed["rate"]["from"], &assumed["rate"]["relative"]], [&Value::from("assumed"), &Value::Null]);
    assert_eq!(
        [&assumed["aliasing"]["window_from"], &assumed["aliasing"]["relative"]],
        [&Value::from("default"), &Value::Null]
    );
    assert_eq!(assumed["unaliased"]["status"], "bounded");
    let document = budget(&["--rate", "40", "--window", "4"]);
    let known = of(&document);
    assert_eq!(
        [&known["aliasing"]["window_from"], &known["aliasing"]["relative"]],
        [&Value::from("option"), &Value::from(0.1)]
    );
    let white = &channel(&document, "gyro_y")["noise"]["white"];
    let own = known["unaliased"]["value"].as_f64().unwrap();
    assert!((white["value"].as_f64().unwrap() / own - 5_f64.sqrt()).abs() < 1e-9);
    let above = white["upper"].as_f64().unwrap() / white["value"].as_f64().unwrap() - 1.0;
    assert!((known["sampling"][1].as_f64().unwrap() - above).abs() < 1e-12, "no arrival times widen it");
    // the recording was made at 40 Hz: at 41 the interval of N holds that it may be off by half of that
    let timed = capture(folder.path(), "a.mcap", &["--duration", "2min"]);
    let (document, _) = replay(&timed, &["--rate", "41"]);
    let white = &channel(&document, "gyro_y")["noise"]["white"];
    let rate = &white["budget"]["rate"];
    let relative = rate["relative"].as_f64().unwrap();
    assert!((relative - 0.5 / 41.0).abs() < 1e-3, "{relative}");
    let above = white["upper"].as_f64().unwrap() / white["value"].as_f64().unwrap() - 1.0;
    assert!(above > white["budget"]["sampling"][1].as_f64().unwrap() + relative, "{white}");
}

//! The truth of the emulated sensor's temperature is found.

use super::*;

const THERMAL: &str = "gyro=0.002 accel=0.1 lag=30 heating=6 warm-up=400 cycle=1.5 period=500";

#[test]
fn the_emulated_residual_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(
        folder.path(),
        "warm.vnymr",
        &["--message", "VNIMU", "--duration", "1h", "--seed", "3", "--thermal", THERMAL],
    );
    let (document, _) = replay(&path, &["--rate", "40"]);
    let noise = |document: &Value, name: &str| channel(document, name)["noise"].clone();
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value}"));
    for (name, unit, truth) in [("gyro_x", "deg/s/degC", 0.002), ("accel_y", "mg/degC", 0.1)] {
        let found = &noise(&document, name)["temperature"];
        assert_eq!(
            (&found["status"], &found["proved"], &found["from"]),
            (&"estimated".into(), &true.into(), &"stream".into())
        );
        let conventions = found["conventions"].as_array().unwrap();
        let of = conventions.iter().find(|of| of["unit"] == unit).unwrap();
        assert!(number(&of["lower"]) < truth && truth < number(&of["upper"]), "{name} {of}");
        assert!(number(&found["lag_lower_s"]) <= 30.0 && 30.0 <= number(&found["lag_upper_s"]), "{found}");
        assert_ne!(noise(&document, name)["bias_instability"]["status"], "estimated");
    }
    assert!(warned(&document, "follows-temperature"));
    assert!((0.1..1.0).contains(&number(&noise(&document, "accel_y")["temperature"]["largest_share"])));
    assert_eq!(noise(&document, "gyro_x")["withheld"], "temperature");
}

#[test]
fn a_constant_temperature_shows_no_residual_and_gives_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), "even.vnymr", &["--message", "VNIMU", "--duration", "10min"]);
    let (document, _) = replay(&path, &["--rate", "40"]);
    let found = &channel(&document, "gyro_z")["noise"]["temperature"];
    assert_eq!((&found["status"], &found["reason"]), (&"not-observable".into(), &"excursion".into()));
    assert!(found["value"].is_null());
}

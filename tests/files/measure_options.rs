//! What an option of a measurement changes in its result, and what it leaves as it was.

use std::fs;

use serde_json::Value;

use crate::support::{channel, deviation, document, replay, replay_log, vn100, warned, with_stdin};

const CLEAN: &str = "clean-minute.vnymr";

#[test]
fn skip_leaves_out_and_counts() {
    let (document, _) = replay(&replay_log(CLEAN), &["--skip", "10s"]);
    assert_eq!(document["timing"]["samples"], 2000);
    assert_eq!(document["timing"]["left_out"], 400);
    assert_eq!(document["link"]["frames"], 2400);
    let (nothing, exit) = replay(&replay_log(CLEAN), &["--skip", "1h"]);
    assert_eq!((&nothing["timing"]["samples"], exit), (&0.into(), 3));
}

#[test]
fn duration_ends_the_same_however_the_bytes_arrive() {
    let log = replay_log(CLEAN);
    let (mut from_file, exit) = replay(&log, &["--duration", "20s"]);
    assert_eq!((&from_file["timing"]["samples"], &from_file["link"]["frames"], exit), (&800.into(), &800.into(), 0));
    let options = ["replay", "-", "--json", "--duration", "20s"];
    let mut from_stdin = document(&with_stdin(vn100().args(options), &fs::read(&log).unwrap()));
    from_file["source"] = Value::Null;
    from_stdin["source"] = Value::Null;
    assert_eq!(from_file, from_stdin);
    assert_eq!(replay(&log, &["--duration", "1h"]).0["timing"]["samples"], 2400);
}

#[test]
fn the_rate_scales_tau_and_nothing_else() {
    let (assumed, _) = replay(&replay_log(CLEAN), &[]);
    assert!(warned(&assumed, "rate-assumed"));
    let (asked, _) = replay(&replay_log(CLEAN), &["--rate", "200"]);
    assert!(!warned(&asked, "rate-assumed"));
    assert_eq!(asked["timing"]["rate_from"], "option");
    assert_eq!(asked["timing"]["duration_s"], 12.0);
    assert_eq!(channel(&asked, "yaw")["allan"]["points"][3]["tau_s"], 0.04);
    assert_eq!(deviation(&asked, "gyro_x", 8), deviation(&assumed, "gyro_x", 8));
}

#[test]
fn estimators_agree_where_they_must() {
    let (strided, _) = replay(&replay_log(CLEAN), &[]);
    let (full, _) = replay(&replay_log(CLEAN), &["--estimator", "full"]);
    let (plain, _) = replay(&replay_log(CLEAN), &["--estimator", "plain"]);
    for m in [1, 2, 4, 8, 16] {
        assert_eq!(deviation(&strided, "accel_z", m), deviation(&full, "accel_z", m));
    }
    assert_eq!(deviation(&plain, "accel_z", 1), deviation(&full, "accel_z", 1));
    assert_ne!(deviation(&plain, "accel_z", 2), deviation(&full, "accel_z", 2));
    let (hadamard, _) = replay(&replay_log(CLEAN), &["--deviation", "hadamard"]);
    assert_eq!(channel(&hadamard, "yaw")["allan"]["deviation"], "hadamard");
    assert_ne!(deviation(&hadamard, "accel_z", 1), deviation(&full, "accel_z", 1));
}

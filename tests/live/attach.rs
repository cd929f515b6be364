//! Live sources that need no device: a serial server, standard input, and sources that cannot be opened.

use std::{
    fs,
    io::{Read, Write},
    net::{Shutdown, TcpListener},
    thread,
};

use serde_json::Value;

use crate::support::{Running, document, replay, replay_log, run, vn100, with_stdin};

const CLEAN: &str = "clean-minute.vnymr";

/// The statistics and deviations of a document, without results that depend on arrival times.
fn numbers(document: &Value) -> Vec<Value> {
    let channels = document["channels"].as_array().unwrap();
    channels.iter().map(|channel| Value::from(vec![channel["name"].clone(), channel["statistics"].clone()])).collect()
}

#[test]
fn standard_input_is_measured_like_the_file() {
    let log = replay_log(CLEAN);
    let output = with_stdin(vn100().args(["attach", "-", "--json"]), &fs::read(&log).unwrap());
    let live = document(&output);
    let (file, _) = replay(&log, &[]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(live["source"]["kind"], "stdin");
    assert_eq!(live["timing"]["samples"], file["timing"]["samples"]);
    assert_eq!(live["link"]["bytes"], file["link"]["bytes"]);
    assert_eq!(numbers(&live), numbers(&file));
}

#[test]
fn a_server_that_disconnects_is_reconnected_and_the_measurement_continues() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp://{}", server.local_addr().unwrap());
    let log = fs::read(replay_log(CLEAN)).unwrap();
    let serving = thread::spawn(move || {
        // 100 lines and a half, then another 700
        for bytes in [&log[..100 * 122 + 60], &log[100 * 122..800 * 122]] {
            let (mut stream, _) = server.accept().unwrap();
            stream.write_all(bytes).unwrap();
            stream.shutdown(Shutdown::Write).unwrap();
            let _ = stream.read_to_end(&mut Vec::new());
        }
    });
    // the lines come as fast as possible, so the rate in their stamps is random
    let output = run(vn100().args(["attach", &source, "--rate", "40", "--duration", "20s", "--json"]));
    let document = document(&output);
    assert_eq!(document["timing"]["samples"], 800);
    assert_eq!(document["timing"]["segments"], 2);
    assert_eq!(document["link"]["reconnects"], 1);
    assert_eq!(document["link"]["bad_frames"]["truncated"], 1);
    assert_eq!(document["link"]["frames"], 800);
    serving.join().unwrap();
}

#[test]
fn the_wall_time_ends_a_stream_that_stalls_and_a_stop_before_the_duration_fails() {
    let log = fs::read(replay_log(CLEAN)).unwrap();
    let attach = |options: &[&str]| {
        let output = with_stdin(vn100().args(["attach", "-", "--json"]).args(options), &log);
        (document(&output), output.status.code().unwrap())
    };
    let (whole, code) = attach(&["--wall", "1h", "--give-up", "1h", "-d", "50s"]);
    assert_eq!((&whole["end_reason"], code), (&"duration".into(), 0));
    let (short, code) = attach(&["-d", "2min"]);
    assert_eq!((&short["end_reason"], code), (&"end-of-input".into(), 1));
    assert!(short["source"]["error"].as_str().unwrap().ends_with("after 1 min of data of the 2 min asked for"));
    // a capture has no more data, so its result is complete
    let (file, code) = replay(&replay_log(CLEAN), &["-d", "2min"]);
    assert_eq!((&file["source"]["error"], code), (&Value::Null, 0));
    let early = file["warnings"].as_array().unwrap().iter().find(|warning| warning["kind"] == "incomplete");
    assert_eq!(early.unwrap()["severity"], "note");
}

#[test]
fn several_sources_get_a_result_each() {
    let log = fs::read(replay_log(CLEAN)).unwrap();
    let output = with_stdin(vn100().args(["attach", "-", "/nowhere/ttyUSB7", "tcp://nothing", "--json"]), &log);
    let documents = document(&output);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(documents[0]["timing"]["samples"], 2400);
    for (index, expected) in [(1, "no such port"), (2, "tcp://host:port")] {
        assert_eq!(documents[index]["timing"]["samples"], 0);
        let error = documents[index]["source"]["error"].as_str().unwrap();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_lost_sensor_gives_a_heartbeat_each_second() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp://{}", server.local_addr().unwrap());
    let serving = thread::spawn(move || {
        let (mut stream, _) = server.accept().unwrap();
        stream.write_all(&fs::read(replay_log(CLEAN)).unwrap()[..100 * 122]).unwrap();
        stream.shutdown(Shutdown::Write).unwrap();
        let _ = stream.read_to_end(&mut Vec::new());
    });
    let mut attached = Running::start(vn100().args(["attach", &source, "--rate", "40", "--ndjson=thin"]));
    let lines = attached.lines.by_ref().map(|line| serde_json::from_str::<Value>(&line).unwrap());
    let lines = lines.inspect(crate::support::schema::check);
    let beats = lines.filter(|line| line["type"] == "heartbeat" && line["samples"] == 100);
    for (second, beat) in (1..=3).zip(beats) {
        assert!(beat["silent_s"].as_f64().unwrap() >= f64::from(second), "{beat}");
        assert!(beat["since"].as_str().unwrap().ends_with('Z'), "{beat}");
        // or the next attempt is in progress
        if beat["link"] != "opening" {
            assert_eq!(beat["link"], "lost");
            assert!(beat["cause"].is_string() && beat["tries"].as_u64().unwrap() > 0, "{beat}");
        }
    }
    drop(attached);
    serving.join().unwrap();
}

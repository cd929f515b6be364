//! What a live command leaves behind: the sensor as it was found, however the command ends.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking and says so when it skips")]

#[path = "support/sensor.rs"]
mod sensor;
mod support;

use std::{
    io::Read,
    net::TcpListener,
    process::{Child, Command, Output, Stdio},
    thread,
};

use rustix::process::{Pid, Signal, kill_process};
use sensor::Sensor;
use serde_json::Value;
use support::{Lines, document, vn100};

const SIGNALS: [Signal; 2] = [Signal::INT, Signal::TERM];

/// Starts a command whose output is looked at when it has ended.
fn start(command: &mut Command) -> Child {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn send(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// The exit code, the document, and what of it says why it ended.
fn told(output: &Output) -> (Option<i32>, Value, Value) {
    let document = document(output);
    (output.status.code(), document["timing"]["samples"].clone(), document["source"]["error"].clone())
}

/// What is told of an interrupt while the sensor is looked for.
fn interrupted_while_looking(options: &[&str], signal: Signal) -> (Option<i32>, Value, Value) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap();
    let attached = start(vn100().args(["attach", &format!("tcp://{address}"), "--json"]).args(options));
    let (mut silent, _) = server.accept().unwrap();
    send(&attached, signal);
    // until it hangs up
    let reading = thread::spawn(move || silent.read_to_end(&mut Vec::new()));
    let (exit, samples, error) = told(&attached.wait_with_output().unwrap());
    let _ = reading.join().unwrap();
    let error = error.as_str().unwrap().replace(&address.to_string(), "");
    (exit, samples, error.into())
}

#[test]
fn an_interrupt_while_the_sensor_is_looked_for_is_an_end_without_samples_whatever_was_to_be_set() {
    for signal in SIGNALS {
        let plain = interrupted_while_looking(&[], signal);
        assert_eq!((plain.0, &plain.1), (Some(3), &0.into()));
        assert_eq!(interrupted_while_looking(&["--set-rate", "20"], signal), plain);
    }
}

#[test]
fn an_interrupt_while_the_sensor_is_set_puts_it_back_and_ends_without_samples() {
    for signal in SIGNALS {
        let sensor = Sensor::start(&[]);
        let recording = sensor.file("nothing.mcap");
        let options = ["--set-rate", "20", "--json", "-v", "--record"];
        let mut attached = start(sensor.command("attach", &options).arg(&recording));
        let mut stderr = Lines::of(attached.stderr.take().unwrap());
        // what comes is counted for two seconds behind it
        assert!(stderr.any(|line| line.contains("sent $VNWRG,07,20")));
        send(&attached, signal);
        let port = sensor.port().display().to_string();
        let (exit, samples, error) = told(&attached.wait_with_output().unwrap());
        assert_eq!((exit, samples, error), (Some(3), 0.into(), format!("{port}: no valid sample in 0 bytes").into()));
        let told: Vec<String> = stderr.collect();
        let put_back = format!("vn100: {port}: put back as it was");
        assert_eq!(told.iter().filter(|line| **line == put_back).count(), 1, "{told:#?}");
        assert_eq!(document(&sensor.run("info", &["--json"]))["rate_hz"], 40);
        assert!(!recording.exists(), "an empty one stands in the way of the next");
    }
}

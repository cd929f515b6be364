//! What a live command leaves behind: the sensor as it was found, however the command ends.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpListener,
    process::{Child, Command, Output, Stdio},
    thread,
    time::Duration,
};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::sensor::Sensor;
use crate::support::{Lines, document, replay, run, vn100};

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

/// Pauses the output, as a program does that breaks off in the middle of its work.
fn pause(sensor: &Sensor) {
    let name = sensor.port().display().to_string();
    let mut port = serialport::new(name, 115_200).timeout(Duration::from_secs(10)).open().unwrap();
    let mut lines = BufReader::new(port.try_clone().unwrap()).split(b'\n').map(Result::unwrap);
    // while it boots it hears nothing
    assert!(lines.any(|line| line.starts_with(b"$VNYMR,")));
    port.write_all(b"$VNASY,0*4F\r\n").unwrap();
    assert!(lines.any(|line| line.starts_with(b"$VNASY,0*4F")));
}

/// A sensor whose output is paused says nothing to whoever only listens; it is told that this may
/// be so.
fn assert_paused(sensor: &Sensor) {
    let heard = sensor.run("attach", &["--listen-only", "--baud", "115200", "--duration", "1s", "--json"]);
    let error = String::from_utf8(heard.stderr).unwrap();
    assert_eq!(heard.status.code(), Some(3), "{error}");
    assert!(error.contains("no data received; its output may be paused"), "{error}");
}

#[test]
fn an_output_that_was_found_paused_is_reported_and_paused_again() {
    let sensor = Sensor::start(&[]);
    let recording = sensor.file("resumed.mcap");
    pause(&sensor);
    let attached = run(sensor.command("attach", &["--duration", "1s", "--json", "--record"]).arg(&recording));
    let error = String::from_utf8(attached.stderr.clone()).unwrap();
    let measured = document(&attached);
    assert_eq!((attached.status.code(), &measured["link"]["outputs_resumed"]), (Some(0), &1.into()), "{error}");
    let port = sensor.port().display().to_string();
    for told in
        ["the sensor's output was paused; it is resumed", "its output is paused again, as before the measurement"]
    {
        assert_eq!(error.matches(&format!("{port}: {told}")).count(), 1, "{error}");
    }
    let (recorded, _) = replay(&recording, &[]);
    assert_eq!(recorded["link"], measured["link"]);
    assert_paused(&sensor);
}

#[test]
fn an_output_that_was_found_paused_and_set_is_left_so_by_attach_and_on_by_configure() {
    let sensor = Sensor::start(&[]);
    pause(&sensor);
    let attached = sensor.run("attach", &["--set-rate", "20", "--duration", "1s", "--json"]);
    let error = String::from_utf8(attached.stderr.clone()).unwrap();
    assert_eq!((attached.status.code(), &document(&attached)["timing"]["rate_hz"]), (Some(0), &20.0.into()), "{error}");
    assert!(error.contains("its output was paused and is on now"), "{error}");
    assert!(error.contains("settings restored, with its output paused"), "{error}");
    assert_eq!(document(&sensor.run("info", &["--json"]))["rate_hz"], 40);
    assert_paused(&sensor);
    let configured = sensor.run("configure", &["--set-rate", "20"]);
    assert_eq!(configured.status.code(), Some(0), "{configured:?}");
    assert_eq!(document(&sensor.run("attach", &["--duration", "1s", "--json"]))["link"]["outputs_resumed"], 0);
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
        let put_back = format!("vn100: {port}: settings restored");
        assert_eq!(told.iter().filter(|line| **line == put_back).count(), 1, "{told:#?}");
        assert_eq!(document(&sensor.run("info", &["--json"]))["rate_hz"], 40);
        assert!(!recording.exists(), "an empty one stands in the way of the next");
    }
}

/// A process number comes round again, and with it the name of a link that a killed process left.
#[test]
fn a_link_left_by_an_earlier_process_of_this_number_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("port");
    std::fs::write(&port, "of another program").unwrap();
    // the shell becomes the program, with its number
    let script = "ln -s \"$0\" \"$TMPDIR/vn100-sim-$$-1\" && exec \"$VN100\" attach sim -d 1s --json";
    let mut shell = Command::new("sh");
    let shell = shell.args(["-c", script]).arg(&port);
    let output = run(shell.env("TMPDIR", folder.path()).env("VN100", env!("CARGO_BIN_EXE_vn100")));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(document(&output)["timing"]["samples"], 40);
    assert!(port.exists());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "its own link is gone");
}

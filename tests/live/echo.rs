//! The whole program on a port whose line hands back what is sent, as a loopback plug does.

use std::{
    fs::{File, OpenOptions},
    io::{Read, Write},
    thread,
};

use rustix::{
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{OptionalActions, tcgetattr, tcsetattr},
};

use crate::support::{run, vn100};

/// A port with a loopback plug: its name, and what keeps it there.
fn loopback() -> (String, File) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let line = OpenOptions::new().read(true).write(true).open(&name).unwrap();
    let mut modes = tcgetattr(&line).unwrap();
    modes.make_raw();
    tcsetattr(&line, OptionalActions::Now, &modes).unwrap();
    let mut plug = File::from(master);
    thread::spawn(move || {
        let mut buffer = [0; 256];
        while let Ok(n @ 1..) = plug.read(&mut buffer) {
            plug.write_all(&buffer[..n]).unwrap();
        }
    });
    (name, line)
}

#[test]
fn a_port_that_only_hands_back_what_is_sent_is_named_with_what_to_do() {
    let commands = [&["attach"][..], &["info"], &["configure", "--set-rate", "20"]];
    let running = commands.map(|arguments| {
        thread::spawn(move || {
            let (name, _line) = loopback();
            let output = run(vn100().args(arguments).arg(&name));
            let error = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(3), "{arguments:?}: {error}");
            let told = format!(
                "no sensor found on {name} at 9 baud rates: the line echoes, and only the sent bytes were received"
            );
            assert!(error.contains(&told) && error.contains("loopback plug"), "{arguments:?}: {error}");
            assert!(!error.contains("connected"), "{error}");
        })
    });
    for command in running {
        command.join().unwrap();
    }
}
